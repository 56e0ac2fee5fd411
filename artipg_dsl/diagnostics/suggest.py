"""Did you mean ...?"""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def suggest(name: str, candidates: Iterable[str]) -> str | None:
    """The candidate that resembles ``name`` most, or None where none does."""
    from difflib import get_close_matches  # start-up: most programs have no mistakes

    known = sorted(set(candidates) - {name})
    by_lower = {c.lower(): c for c in reversed(known)}
    if name.lower() in by_lower:
        return by_lower[name.lower()]
    close = [*get_close_matches(name, known, n=3, cutoff=0.7)]
    close += [c for c in get_close_matches(name, known, n=3, cutoff=0.6) if c[0] == name[0]]
    # letters exchanged are likelier than others in their place, and the first letter is seldom wrong
    return min(close, key=lambda c: (sorted(c) != sorted(name), c[0] != name[0]), default=None)


def did_you_mean(name: str, candidates: Iterable[str]) -> str | None:
    """A hint with the nearest candidate: ``did you mean `width`?``."""
    found = suggest(name, candidates)
    return f"did you mean `{found}`?" if found is not None else None


def given(count: int) -> str:
    """How many there are: ``1 is given``."""
    return f"{count} {'is' if count == 1 else 'are'} given"


def any_of(words: Sequence[str], last: str = "or") -> str:
    """The words in a sentence: each in backquotes, `or` before the last."""
    quoted = [f"`{word}`" for word in words]
    return f" {last} ".join([", ".join(quoted[:-1]), quoted[-1]] if len(quoted) > 1 else quoted)
