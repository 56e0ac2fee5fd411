"""Facts about primitives that took long to find and follow from their formulas alone, kept between runs (see ``cache``).

An entry holds the facts about one primitive, as JSON, by name. Whoever asks for one verifies what it says; a fact that is
missing or false is found anew. What was found is written once a piece of work is done.
"""

from __future__ import annotations

import atexit
import json
from collections import Counter
from collections.abc import Callable
from functools import lru_cache
from threading import Lock
from typing import Any, TypeVar

from .. import cache
from ..graph.primitive import Primitive
from ..graph.writing import primitive_digest

Fact = TypeVar("Fact")
_LOCK = Lock()
_changed: dict[str, _Facts] = {}
_told: dict[Primitive, str] = {}  # digests of primitives that nobody has asked about yet


class _Facts:
    """The facts about a primitive of a ``digest``; ``entry`` names their file, None where nothing is kept."""

    def __init__(self, primitive: Primitive):
        self.held: dict[str, Any] = {}
        self.count: Counter[str] = Counter()  # how many there are of names that differ in the last word
        self.digest = _told.pop(primitive, "") or primitive_digest(primitive)
        self.entry: str | None = None
        if cache.folder() is None:
            return
        self.entry = cache.key("facts", self.digest)
        found = cache.read(self.entry)
        if found is not None:
            try:
                held = json.loads(found)
            except (ValueError, RecursionError):
                held = None
            self.held = held if isinstance(held, dict) else {}
            self.count.update(map(_kind, self.held))


def digest_of(primitive: Primitive) -> str:
    """What tells a primitive from any other, by its formulas."""
    return _facts(primitive).digest


def tell_digest(primitive: Primitive, known: str) -> None:
    """Says what is known of a primitive: to find it takes as long as to write it."""
    _told[primitive] = known


def _kind(name: str) -> str:
    return name.rpartition(" ")[0]


@lru_cache(maxsize=512)
def _facts(primitive: Primitive) -> _Facts:
    made = _Facts(primitive)
    with _LOCK:
        return _changed.get(made.entry or "", made)


def recall_fact(
    primitive: Primitive,
    name: str,
    find: Callable[[], Fact],
    to_data: Callable[[Fact], Any],
    of_data: Callable[[Any], Fact],
    most: int | None = None,
) -> Fact:
    """A fact as it was kept, or else as ``find`` gives it. ``of_data`` raises ValueError, TypeError, KeyError or IndexError
    where data is no such fact. ``most`` limits how many are kept whose names differ in the last word."""
    facts = _facts(primitive)
    if facts.entry is None:
        return find()
    if name in facts.held:
        try:
            return of_data(facts.held[name])
        except (ValueError, TypeError, KeyError, IndexError, OverflowError):
            pass
    found = find()
    kind = _kind(name)
    if most is not None and facts.count[kind] >= most:
        return found
    with _LOCK:
        facts.count[kind] += name not in facts.held
        facts.held[name] = to_data(found)
        _changed[facts.entry] = facts
    return found


def flush() -> None:
    """Write what was found since the last time. Of two processes that write at once one is heard: the other's facts are found
    again."""
    with _LOCK:
        changed = dict(_changed)
        _changed.clear()
        texts = {entry: json.dumps(facts.held) for entry, facts in changed.items()}
    for entry, text in texts.items():
        cache.write(entry, text.encode())


atexit.register(flush)  # what no chunk of a data set has written: of `validate`, `report`, `render`
