"""What the labels of real objects say of the draws of a category: how often parts are there, and how many of them.

A word of the vocabulary ``semantic`` belongs to a draw if it is in exactly those samples in which the draw has some of its options, and that
draw decides whether the primitives that bear the word are there. A share is (count + 1/2) / (objects + 1) (Krichevsky and Trofimov 1981),
so that a few objects without a part do not rule it out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any

import numpy as np

from ..errors import UserError
from ..graph.depend import draws_behind
from ..graph.expr import TRUE, Expr, Scope
from ..graph.program import Draw, Program
from ..records import dataclass
from ..runtime.batch import Batch

_NONE = "none"
_MOST = 50  # values of a count
_HALF = 0.5


@dataclass(slots=True)
class Presence:
    """``draws`` as a prior has them, ``evidence`` of each, and in words what could not be used."""

    objects: int
    draws: dict[str, Any] = field(default_factory=dict)
    evidence: dict[str, dict[str, Any]] = field(default_factory=dict)
    unmatched: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class _Word:
    """A word in our samples: ``rows`` (B,) of each of the primitives that bear it, and the draws that decide whether these are there."""

    name: str
    rows: list[np.ndarray]
    behind: tuple[int, ...]

    @property
    def there(self) -> np.ndarray:
        return np.any([row > 0 for row in self.rows], axis=0)


def measure_presence(batch: Batch, seen: Sequence[frozenset[str]], words: Mapping[str, str]) -> Presence:
    """Of real objects that have the labels ``seen``, in their own names; ``words``: what these mean. Raises UserError."""
    labelled = [names & words.keys() for names in seen if names & words.keys()]
    asked = list(dict.fromkeys(words.values()))
    if not labelled:
        raise UserError("no real object has a label that the map names", "name labels of theirs in the map")
    if len(asked) < 2:
        raise UserError(
            f"the map names `{asked[0]}` alone: objects without it look like objects without labels",
            "map a label that every object has, too, such as the body",
        )
    found = Presence(len(labelled))
    groups: dict[int, list[tuple[frozenset[int], float]]] = {}
    for name in asked:
        count = np.array([sum(words[own] == name for own in names) for names in labelled])
        word = _find_word(batch, name)
        if not word.rows or not word.there.any():
            found.unmatched.append(
                f"`{name}` is in no sample, and in {int((count > 0).sum())} of {found.objects} objects"
            )
            continue
        _take_share(batch, word, count, found, groups)
        if (count > 1).any():
            _take_count(batch, word, count, found)
    return found


def _find_word(batch: Batch, name: str) -> _Word:
    """Where a word may be said at all: what it says at single points, and words of deeper parts, are left out of account."""
    program = batch.program
    rows: dict[Scope, np.ndarray] = {}
    roots: dict[Expr, None] = {}
    for label in program.labels:
        if (label.vocabulary, label.name) != ("semantic", name):
            continue
        said = [expr for expr in (label.guard, label.value) if expr is not TRUE and not expr.reads]
        for scope in dict.fromkeys(program.sites[target.site].scope for target in label.targets):
            holds = np.ones(len(batch.owner(scope)), dtype=bool)
            for values in batch.read(said, scope):
                holds &= np.broadcast_to(values, holds.shape).astype(bool)
            found = np.bincount(batch.owner(scope)[holds], minlength=len(batch))
            rows[scope] = np.maximum(rows[scope], found) if scope in rows else found
            roots |= dict.fromkeys(s.count for s in scope.ancestors() if s.count is not None) | dict.fromkeys(said)
    return _Word(name, list(rows.values()), tuple(draws_behind(program, roots)))


# ---------------------------------------------------------------- shares


def _take_share(
    batch: Batch, word: _Word, count: np.ndarray, found: Presence, groups: dict[int, list[tuple[frozenset[int], float]]]
) -> None:
    """How often a word is there, said of the draw that it belongs to, or told why not."""
    program, there = batch.program, int((count > 0).sum())
    told = f"`{word.name}` is in {there} of {found.objects} objects"
    if word.there.all():
        if there < found.objects:
            found.unmatched.append(f"{told}, and in every sample: no draw leaves it out")
        return
    matches = [(k, group) for k in word.behind if (group := _options_with(batch, k, word.there))]
    if not matches:
        found.unmatched.append(f"{told}: {_why_none(program, word)}")
        return
    number, group = min(matches, key=lambda match: _NONE not in program.draws[match[0]].options)
    draw, taken = program.draws[number], groups.setdefault(number, [])
    if any(group & other for other, _ in taken):
        found.unmatched.append(f"{told}: another word has settled `{draw.column.name}`")
        return
    share = (there + _HALF) / (found.objects + 1)
    rest = len(draw.options) - sum(len(other) for other, _ in taken) - len(group)
    if not rest or sum(part for _, part in taken) + share > 1.0:
        found.unmatched.append(f"{told}: what is left of `{draw.column.name}` follows from other words")
        return
    taken.append((group, share))
    found.draws[draw.column.name] = _entry(draw, taken)
    note = found.evidence.setdefault(draw.column.name, {"objects": found.objects, "with": {}})
    note["with"][word.name] = there


def _options_with(batch: Batch, number: int, there: np.ndarray) -> frozenset[int]:
    """The options of a choice with which a word is there, if it is there always or never with each; else none."""
    draw = batch.program.draws[number]
    if draw.kind != "choice" or draw.column.scope.parent is not None:
        return frozenset()
    value = batch.state.values[number].astype(np.int64)
    seen = np.bincount(value, minlength=len(draw.options))
    with_it = np.bincount(value[there], minlength=len(draw.options))
    if ((with_it > 0) & (with_it < seen)).any():
        return frozenset()
    return frozenset(np.flatnonzero(with_it).tolist())


def _entry(draw: Draw, taken: Sequence[tuple[frozenset[int], float]]) -> Any:
    group, share = taken[0]
    if len(taken) == 1 and group == {k for k, option in enumerate(draw.options) if option != _NONE} != set(
        range(len(draw.options))
    ):
        return round(share, 4)
    return {" | ".join(draw.options[k] for k in sorted(group)): f"{100 * share:.4g}%" for group, share in taken}


def _why_none(program: Program, word: _Word) -> str:
    choices = [program.draws[k] for k in word.behind if program.draws[k].kind == "choice"]
    several = [d for d in choices if any(s.kind == "repeat" for s in d.column.scope.ancestors())]
    names = " and ".join(f"`{name}`" for name in dict.fromkeys(d.column.name for d in several or choices))
    if several:
        return f"it is there by {names}, of which an object has several"
    return f"it is there by {names}, and by other values" if names else "it follows from numbers, not from a choice"


# ---------------------------------------------------------------- counts


def _take_count(batch: Batch, word: _Word, count: np.ndarray, found: Presence) -> None:
    """How many of a word there are, where each has a name of its own."""
    for number in word.behind:
        draw = batch.program.draws[number]
        if draw.kind != "count" or draw.column.scope.parent is not None:
            continue
        value, there = batch.state.values[number], word.there
        if not any((row[there] == value[there]).all() for row in word.rows) or len(np.unique(value[there])) < 2:
            continue
        legal = _legal(draw)
        if not legal:
            continue
        met = count[count > 0]
        beyond = sorted({int(c) for c in met.tolist()} - set(legal))
        if beyond:
            found.unmatched.append(
                f"{int(np.isin(met, beyond).sum())} of {len(met)} objects have {', '.join(map(str, beyond))} of `{word.name}`: "
                f"`{draw.column.name}` lies in {legal[0]} .. {legal[-1]}"
            )
        seen = {c: int((met == c).sum()) for c in legal}
        found.draws[draw.column.name] = {str(c): seen[c] + _HALF for c in legal}
        counted = {str(c): n for c, n in seen.items() if n}
        found.evidence[draw.column.name] = {"objects": len(met), "counted": counted, "word": word.name}
        return
    found.unmatched.append(f"no count of the program is the number of `{word.name}`")


def _legal(draw: Draw) -> list[int]:
    """The values that a count can have, where they are known and few."""
    low, high = (end.constant for end in draw.ends)
    if low is None or high is None or high - low >= _MOST:
        return []
    whole = list(range(int(np.ceil(low)), int(np.floor(high)) + 1))
    if draw.distribution == "uniform":
        return whole if not draw.arguments else []
    if draw.distribution == "values":
        known = {argument.constant for argument in draw.arguments}
        return [c for c in whole if float(c) in known]
    return whole
