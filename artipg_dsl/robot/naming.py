"""Names of files and of what stands in them: each once in its object."""

from __future__ import annotations

from collections.abc import Iterable

_KEPT = frozenset({"con", "prn", "aux", "nul", *(f"{port}{k}" for port in ("com", "lpt") for k in range(1, 10))})


class Names:
    """Gives every name once: also where the case of letters does not count, and none that some systems keep for themselves.
    ``taken``: names that are given already."""

    def __init__(self, taken: Iterable[str] = ()) -> None:
        self.taken = {name.casefold() for name in taken}

    def __call__(self, name: str) -> str:
        stem, dot, rest = name.partition(".")
        kept = stem.casefold() in _KEPT  # with any ending
        found, count = name, 1
        while found.casefold() in self.taken or kept and count == 1:
            count += 1
            found = f"{stem}_{count}{dot}{rest}" if kept else f"{name}_{count}"
        self.taken.add(found.casefold())
        return found
