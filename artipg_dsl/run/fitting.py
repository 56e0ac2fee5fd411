"""Real objects fitted: a record of each, in files or in memory.

They are fitted in groups of a fixed order, so that a group gives the same whoever works on it.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, field
from functools import cache
from typing import Any

import numpy as np

from ..diagnostics.suggest import any_of, did_you_mean
from ..errors import UsageError, UserError
from ..fit.finding import ROBOT
from ..fit.fitting import TOGETHER, Fitted, fit, usual_size
from ..fit.model import Model
from ..fit.pose import Frame, Posed, pose
from ..fit.sources import Item
from ..fit.states import can_open
from ..records import dataclass
from ..sampling.sample import Sampler
from .facts import Facts, apply_facts
from .job import Job, prepare
from .manifest import describe_changes
from .request import read_request
from .sharing import LONG, share
from .workers import map_each

_VERSION = 6  # of what the search finds, so that nothing that another one found is kept
_TITLES = {
    "version": "the version of the search",
    "program": "the compiled program",
    "up": "the upward axis",
    "front": "the front",
    "unit": "the unit",
    "normalised": "objects without a scale",
    "seed": "the seed",
    "checked": "the check of collisions",
    "words": "the map",
    "opened": "joints that are moved",
}
_NO_MATCH = "does not fit"
_SHOWN = 8  # labels of files

Record = dict[str, Any]
Group = Sequence[Item]


@dataclass(frozen=True, slots=True)
class Asked:
    """How objects are fitted: ``source`` names the program; ``words`` maps names of labels to words of ``semantic``; ``facts`` are what is
    known of each object, by its name."""

    source: str
    frame: Frame
    seed: int = 0
    checked: bool = True
    words: tuple[tuple[str, str], ...] = ()
    opened: bool = True  # joints are moved where nothing at rest fits
    facts: Mapping[str, Facts] = field(default_factory=dict)

    def plain(self, program: str) -> Record:
        return {
            "version": _VERSION,
            "program": program,
            "frame": asdict(self.frame),
            "seed": self.seed,
            "checked": self.checked,
            "words": [list(pair) for pair in self.words],
            "opened": self.opened,
        }


def describe_options(old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """What sets the options of two fits apart, in words; nothing where they are the same."""

    def flat(told: Mapping[str, Any]) -> Record:
        frame = told.get("frame")
        return {**told, **(frame if isinstance(frame, dict) else {})}  # should it have been edited

    return describe_changes(_TITLES, flat(old), flat(new))


def check_words(words: Mapping[str, str], known: tuple[str, ...], name: str) -> tuple[tuple[str, str], ...]:
    """The pairs of a map: their name, our word. Raises UsageError for a word that is not ``known``."""
    for theirs, word in words.items():
        if word not in known:
            raise UsageError(
                f"{name}: `{theirs}` is to be `{word}`, which is no word of `semantic`", did_you_mean(word, known)
            )
    return tuple(words.items())


def find_unmatched(words: Sequence[tuple[str, str]], records: Sequence[Record], name: str) -> str:
    """Which of the names in a map are those of no label of what was fitted; nothing where all are."""
    told = [record["labels"] for record in records if "labels" in record]
    labels = sorted({label for one in told for label in one})
    return tell_unmatched([theirs for theirs, _ in words], labels, name) if told else ""


def tell_unmatched(words: Iterable[str], labels: Sequence[str], name: str, of: str = "object") -> str:
    """The same of given ``labels``, and of files or whatever they are ``of``."""
    missing = [theirs for theirs in words if theirs not in labels]
    if not missing:
        return ""
    shown = any_of(labels[:_SHOWN], "and") + (f" and {len(labels) - _SHOWN} more" if labels[_SHOWN:] else "")
    has = f"their labels are {shown}" if labels else "they have none"
    return f"no {of} has a label {any_of(missing)}, as {name} says: {has}"


def groups_of(items: Group, facts: Mapping[str, Facts]) -> list[Group]:
    """What is searched together: a few objects of which the same is known, joints too."""
    alike: dict[str, list[Item]] = {}
    for item in items:
        known = facts.get(item.name, {}), _jointed(item)
        alike.setdefault(json.dumps(known, sort_keys=True), []).append(item)
    return [some[at : at + TOGETHER] for some in alike.values() for at in range(0, len(some), TOGETHER)]


def _jointed(item: Item) -> bool:
    return item.real.suffix == ROBOT


# ---------------------------------------------------------------- one group


@dataclass(frozen=True, slots=True, eq=False)
class _Models:
    """What is fitted to objects of which the same is known. ``usual``: how large such objects are."""

    still: Model
    opened: Model | None
    usual: float

    @staticmethod
    def of(sampler: Sampler, asked: Asked, facts: Facts, jointed: bool) -> _Models:
        """``jointed``: with joints, as those of some files are known. Raises UserError where facts leave nothing."""
        own = Sampler(apply_facts(sampler.program, facts, "what is known")) if facts else sampler
        model = Model(own, jointed=jointed)
        movable = asked.opened and can_open(own.program)
        opened = Model(own, opened=True, jointed=jointed) if movable else None
        return _Models(model, opened, usual_size(model))


@dataclass(slots=True, eq=False)
class Work:
    """What a process fits with."""

    sampler: Sampler
    asked: Asked
    doing: Callable[[str], None] = lambda _: None
    models: dict[str, _Models] = field(default_factory=dict)  # those of the last facts

    def _models(self, facts: Facts, jointed: bool) -> _Models:
        known = json.dumps([facts, jointed], sort_keys=True)
        if known not in self.models:
            self.models = {known: _Models.of(self.sampler, self.asked, facts, jointed)}
        return self.models[known]

    def fit(self, group: Group) -> list[tuple[Record, Fitted | None]]:
        """The record of each object of a group, and what was found of those that could be read."""
        asked, facts = self.asked, self.asked.facts.get(group[0].name, {})
        jointed = _jointed(group[0])
        marks = [item.real.mark() for item in group]  # of what is read: files may change while they are fitted
        read: dict[str, tuple[Posed, Record]] = {}
        told: dict[str, tuple[Record, Fitted | None]] = {}
        for item in group:
            try:
                models = self._models(facts, jointed)
                cloud = item.real.read()
                posed = pose(cloud, asked.frame, item.real.suffix, models.usual)
                remarks = {"lost": cloud.lost, "doubt": posed.doubt}
                read[item.name] = posed, {key: text for key, text in remarks.items() if text}
            except UserError as wrong:
                told[item.name] = {"failed": explain(wrong)}, None
        try:
            found = self._find([posed for posed, _ in read.values()], self._models(facts, jointed))
        except UserError as wrong:
            told |= {name: ({"failed": explain(wrong)}, None) for name in read}
            found, read = [], {}
        for (name, (posed, remarks)), one in zip(read.items(), found, strict=True):
            labels = {"labels": sorted(set(posed.names))} if asked.words else {}
            told[name] = {**one.told, **labels, **remarks, "drawn": one.values}, one
        records: list[tuple[Record, Fitted | None]] = []
        for item, file in zip(group, marks, strict=True):
            said, one_found = told[item.name]
            record = {"name": item.name, "source": str(item.real), **({"facts": facts} if facts else {}), **said}
            more = {"file": file, "options": asked.plain(self.sampler.program.hash)}
            records.append((record | more, one_found))
        return records

    def _find(self, read: list[Posed], models: _Models) -> list[Fitted]:
        if not read:
            return []
        asked, words = self.asked, dict(self.asked.words)
        return fit(
            models.still,
            read,
            seed=asked.seed,
            checked=asked.checked,
            words=words,
            opened=models.opened,
            doing=self.doing,
        )


def explain(wrong: UserError) -> str:
    """What is wrong, and what to try, in one line of a record."""
    return wrong.message + (f" ({wrong.hint})" if wrong.hint else "")


def to_text(record: Mapping[str, Any]) -> bytes:
    """A record or a summary as a file has it."""
    return (json.dumps(record, indent=1, ensure_ascii=False) + "\n").encode()


# ---------------------------------------------------------------- several groups


_theirs: Work | None = None  # what this worker works with


def _take(sampler: Sampler, asked: Asked) -> None:
    global _theirs
    _theirs = Work(sampler, asked)


def _fit_theirs(group: Group) -> list[Record]:
    assert _theirs is not None
    return [record for record, _ in _theirs.fit(group)]


def fit_all(
    sampler: Sampler,
    asked: Asked,
    items: Group,
    workers: int = 1,
    progress: Callable[[int, int], None] = lambda *_: None,
    doing: Callable[[str], None] = lambda _: None,
) -> list[Record]:
    """The records of all objects, in their order. ``progress(done, total)`` hears of objects as their groups are finished, ``doing`` of
    what this process does with a group."""
    own = cache(lambda: Work(sampler, asked, doing))

    def alone(group: Group) -> list[Record]:
        return [record for record, _ in own().fit(group)]

    def others(rest: Sequence[Group], many: int) -> Iterator[list[Record]]:
        return map_each(_fit_theirs, rest, many, _take, sampler, asked, here=alone)

    records: list[Record] = []
    progress(0, len(items))
    for found in share(groups_of(items, asked.facts), workers, alone, others, pace=LONG):
        records += found
        progress(len(records), len(items))
    return records


# ---------------------------------------------------------------- all that was found


def good_ones(records: Sequence[Record]) -> list[Record]:
    """The records of objects that fit and are valid: those that are samples, in their order."""
    return [r for r in records if "drawn" in r and r["verdict"] != _NO_MATCH and r["valid"]]


def summarize(category: str, options: Mapping[str, Any], records: Sequence[Record]) -> Record:
    """What is said of all objects together."""
    number = {r["name"]: k for k, r in enumerate(good_ones(records))}
    objects = [
        {
            "object": number.get(r["name"]),
            "name": r["name"],
            "source": r["source"],
            "verdict": r["verdict"],
            "distance": r["distance"]["both"],
            "valid": r["valid"],
            **{key: r[key] for key in ("facts", "lost", "doubt") if r.get(key)},
        }
        for r in records
        if "drawn" in r
    ]
    failed = [{"name": r["name"], "source": r["source"], "reason": r["failed"]} for r in records if "failed" in r]
    shares = [one["distance"] for one in objects]
    summary = {
        "category": category,
        "options": options,
        "median": None if not shares else round(float(np.median(shares)), 4),
        "objects": objects,
        "failed": failed,
    }
    if options["words"] and all("labels" in r for r in records if "drawn" in r):
        summary["labels"] = sorted({name for r in records for name in r.get("labels", ())})
    return summary


def prepare_fitted(sampler: Sampler, source: str, records: Sequence[Record], values: str = "values") -> Job:
    """The job of the objects that were fitted, some of which are good; ``values``: what messages call their values."""
    drawn, options = [record["drawn"] for record in good_ones(records)], records[0]["options"]
    request = read_request(source, seed=options["seed"], checked=options["checked"], values=drawn)
    return prepare(sampler, request, values=values)
