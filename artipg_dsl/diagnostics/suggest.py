"""Suggestions for misspelt names."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


def suggest(name: str, candidates: Iterable[str]) -> str | None:
    """The candidate nearest to a name, or None when none is near."""
    pool = sorted(set(candidates))
    found = get_close_matches(name, pool, n=1, cutoff=0.6)
    if not found:
        lowered = {c.lower(): c for c in pool}
        found = [lowered[c] for c in get_close_matches(name.lower(), lowered, n=1, cutoff=0.6)]
    return found[0] if found else None


def did_you_mean(name: str, candidates: Iterable[str]) -> str | None:
    """``did you mean `x`?``, for a hint; None when nothing is near."""
    found = suggest(name, candidates)
    return None if found is None else f"did you mean `{found}`?"
