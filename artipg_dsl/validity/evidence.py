"""What is known of the validity of some objects: what is wrong with them, and which links block one another.

Two links block one another when they meet only while joints of several chains are moved at once: two doors on one
divider. That is no failure; it is found in random configurations of all joints together, and counted.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np

from ..geometry.runs import distinct
from ..random import key, mix, uniform
from ..records import dataclass
from ..runtime.batch import Batch
from .bodies import gather
from .contact import Contact, describe_contact
from .faults import find_faults
from .tree import Tree
from .validate import find_meetings_in_states, split_blocks

STATES = 64  # random configurations per object


@dataclass(frozen=True, slots=True)
class LinkPair:
    """Two links, by path, of ``objects`` objects; ``joint`` makes them meet ("" at rest), at the least at ``value``.

    ``example``: the parts of one of these objects that meet, and where.
    """

    first: str
    second: str
    joint: str
    objects: int
    value: float
    example: Contact | None = None


@dataclass(frozen=True, slots=True)
class Evidence:
    """Pairs that collide and pairs that block one another, and what else is wrong, by how many objects have it and with an
    example of one of them, the most frequent first; how many objects are ``invalid``, how many of them have links that
    collide, and how many have links that block one another; joints seen."""

    objects: int
    invalid: int
    colliding: int
    faults: tuple[tuple[str, int, str], ...]
    pairs: tuple[LinkPair, ...]
    blocking: tuple[LinkPair, ...]
    blocked: int
    joints: int
    states: int


def find_evidence(batch: Batch, states: int = STATES) -> Evidence:
    """What is wrong with a batch at rest and joint by joint, and which links meet in ``states`` random
    configurations of all joints."""
    wrong = find_faults(batch)
    found, tree = wrong.collisions, wrong.tree
    pairs = []
    for (first, second, joint), rows in tree.named(found).items():
        value = float(found.value[rows].min())
        row = int(rows[np.argmin(found.value[rows])])
        example = describe_contact(tree, wrong.body, found, row)
        pairs.append(LinkPair(first, second, joint, len(distinct(found.owner[rows])), value, example))
    known = _codes(tree, found.owner, found.first, found.second)
    blocking, blocked = _blocking(tree, states, known) if states else ([], 0)
    count = len(tree.joints.owner)
    others = sorted(((f.words, len(f.objects), f.example) for f in wrong.others), key=lambda f: (-f[1], f[0]))
    invalid, colliding = len(wrong.objects()), len(found.objects())
    return Evidence(
        len(batch), invalid, colliding, tuple(others), _sorted(pairs), _sorted(blocking), blocked, count, states
    )


def join_evidence(found: Sequence[Evidence]) -> Evidence:
    """What is known of all objects, out of what is known of some of them each."""
    counted = ("objects", "invalid", "colliding", "blocked", "joints")
    sums = {name: sum(getattr(f, name) for f in found) for name in counted}
    faults: dict[str, tuple[str, int, str]] = {}
    for words, count, example in (fault for f in found for fault in f.faults):
        _, before, first = faults.get(words, (words, 0, example))
        faults[words] = words, before + count, first
    return Evidence(
        faults=tuple(sorted(faults.values(), key=lambda f: (-f[1], f[0]))),
        pairs=_joined(pair for f in found for pair in f.pairs),
        blocking=_joined(pair for f in found for pair in f.blocking),
        states=max((f.states for f in found), default=0),
        **sums,
    )


def _joined(pairs: Iterable[LinkPair]) -> tuple[LinkPair, ...]:
    """Each pair once; of equal values that of the first."""
    known: dict[tuple[str, str, str], LinkPair] = {}
    for pair in pairs:
        key = pair.first, pair.second, pair.joint
        before = known.get(key, pair)
        least = pair if pair.value < before.value else before
        known[key] = replace(least, objects=pair.objects + (before.objects if key in known else 0))
    return _sorted(list(known.values()))


def _sorted(pairs: list[LinkPair]) -> tuple[LinkPair, ...]:
    return tuple(sorted(pairs, key=lambda p: (-p.objects, p.first, p.second, p.joint)))


def _codes(tree: Tree, owner: np.ndarray, first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """One number per pair of links of an object."""
    one, two = tree.first[owner] + first, tree.first[owner] + second
    return np.minimum(one, two) * len(tree.links.owner) + np.maximum(one, two)


def random_states(batch: Batch, number: int) -> np.ndarray:
    """Joint values (J,), uniform within the range of each; the same for an object whatever else is in the batch."""
    return _anywhere(Tree(batch), number)


def _anywhere(tree: Tree, number: int) -> np.ndarray:
    batch = tree.batch
    address = mix(batch.numbers[tree.joints.owner].astype(np.uint64), tree.joints.number)
    lot = uniform(key(batch.seed, "configuration"), address, number, np.zeros(len(address), dtype=np.int64))
    return tree.low + lot * (tree.high - tree.low)


def _blocking(tree: Tree, states: int, known: np.ndarray) -> tuple[list[LinkPair], int]:
    """Pairs of links that meet in random states alone, and how many objects have any."""
    batch, count = tree.batch, len(tree.links.owner)
    body = gather(batch, tree.first, tree.turn, tree.shift)
    met: list[np.ndarray] = [np.zeros(0, dtype=np.int64)]
    values = np.array([_anywhere(tree, number) for number in range(states if len(tree.joints.owner) else 0)])
    for part in split_blocks(body):
        for first, second in find_meetings_in_states(tree, part, values):
            met.append(distinct(np.minimum(first, second) * count + np.maximum(first, second)))
    pair = np.setdiff1d(np.concatenate(met), known)
    paths = [link.path for link in batch.program.links]
    found: dict[tuple[str, str], set[int]] = {}
    for low, high in zip((pair // count).tolist(), (pair % count).tolist(), strict=True):
        names = sorted(paths[tree.links.definition[link]] for link in (low, high))
        found.setdefault((names[0], names[1]), set()).add(int(tree.links.owner[low]))
    pairs = [LinkPair(first, second, "", len(owners), 0.0) for (first, second), owners in found.items()]
    return pairs, len(set().union(*found.values()))
