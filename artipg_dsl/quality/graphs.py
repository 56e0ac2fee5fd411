"""Kinematic graphs: the tree of an object's links, each with its semantic part and the type of the joint above it.

Children are not ordered: two objects have the same graph when their trees are equal after the children of every node
are sorted. Equal subtrees get equal codes, from the leaves upwards, over all objects at once (the tree isomorphism of
Aho, Hopcroft and Ullman, "The Design and Analysis of Computer Algorithms", 1974, section 3.2).
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..graph.reference import definitions_of
from ..records import dataclass
from ..runtime.batch import Batch

_ROOT = "root"  # in place of the joint above the root


@dataclass(frozen=True, slots=True)
class Subtree:
    """A kind of subtree: the joint above, the semantic part, the codes of the children, ascending."""

    joint: str
    part: str
    children: tuple[int, ...]


@dataclass(frozen=True, eq=False)
class Graphs:
    """``code`` (B,) is an index into ``nodes`` per object: the subtree at its root. ``joints`` (B,) counts its joints."""

    nodes: tuple[Subtree, ...]
    code: np.ndarray
    joints: np.ndarray

    @cached_property
    def kinds(self) -> tuple[np.ndarray, np.ndarray]:
        """The distinct graphs by their codes, the most frequent first, and how many objects have each."""
        code, count = np.unique(self.code, return_counts=True)
        order = np.lexsort((code, -count))
        return code[order], count[order]

    @cached_property
    def text(self) -> tuple[str, ...]:
        """Each kind of subtree in words, the children in the order of their own text: ``body(revolute door)``."""
        found: list[str] = []
        for node in self.nodes:  # children come before their parents
            inner = sorted(found[c] for c in node.children)
            above = "" if node.joint == _ROOT else f"{node.joint} "
            found.append(f"{above}{node.part}" + (f"({', '.join(inner)})" if inner else ""))
        return tuple(found)

    @property
    def perplexity(self) -> float:
        """exp of the entropy of the graphs: how many equally frequent ones would be as varied."""
        _, count = self.kinds
        share = count / count.sum()
        return float(np.exp(-(share * np.log(share)).sum()))


def _part_words(batch: Batch) -> list[str]:
    """For each definition of a link the word for what moves: the semantic label of the part that it is named after, or of
    one around that; else, but for the root, of the first part that it carries; else the name of the part."""
    program = batch.program
    named = {part.path: number for number, part in reversed(list(enumerate(program.parts)))}
    carried: dict[int, str] = {}
    for part in program.parts:
        for carrier in definitions_of(part.link) if part.semantic else ():
            carried.setdefault(carrier, part.word)
    found = []
    for number, link in enumerate(program.links):
        at, word = named.get(link.path, link.part), ""
        while at >= 0 and not word:
            word, at = program.parts[at].word, program.parts[at].parent
        found.append(word or (carried.get(number, "") if number else "") or link.path.rsplit(".", 1)[-1])
    return found


def find_graphs(batch: Batch) -> Graphs:
    """The kinematic graph of each object of a batch."""
    links, joints = batch.links(), batch.joints()
    first = np.searchsorted(links.owner, np.arange(len(batch)))
    size = len(links.owner)
    above = np.full(size, -1)
    child = first[joints.owner] + joints.child
    above[child] = first[joints.owner] + joints.parent
    kinds = [_ROOT, *sorted(set(joints.kind))]
    kind = np.zeros(size, dtype=np.int64)
    kind[child] = [kinds.index(k) for k in joints.kind]
    words = _part_words(batch)
    known = sorted(set(words))
    label = np.array([known.index(w) for w in words], dtype=np.int64)[links.definition]

    nodes: list[Subtree] = []
    code = np.full(size, -1)
    height = _heights(above)
    for level in range(int(height.max(initial=-1)) + 1):
        rows = np.flatnonzero(height == level)
        children = _children(rows, above, code, height < level)
        cells = np.column_stack([kind[rows], label[rows], children])
        distinct, place = np.unique(cells, axis=0, return_inverse=True)
        code[rows] = len(nodes) + place.reshape(-1)
        for row in distinct.tolist():
            nodes.append(Subtree(kinds[row[0]], known[row[1]], tuple(c for c in row[2:] if c >= 0)))
    counts = np.bincount(joints.owner, minlength=len(batch))
    return Graphs(tuple(nodes), code[first], counts)


def _heights(above: np.ndarray) -> np.ndarray:
    """(N,) the height of the subtree at each node: 0 for leaves."""
    height = np.zeros(len(above), dtype=np.int64)
    rows = np.flatnonzero(above >= 0)
    while len(rows):
        before = height.copy()
        np.maximum.at(height, above[rows], height[rows] + 1)
        if np.array_equal(before, height):
            break
    return height


def _children(rows: np.ndarray, above: np.ndarray, code: np.ndarray, done: np.ndarray) -> np.ndarray:
    """(len(rows), most children) codes of the children of some nodes, ascending, -1 where there are fewer."""
    place = np.full(len(above), -1)
    place[rows] = np.arange(len(rows))
    child = np.flatnonzero(done & (above >= 0))
    child = child[place[above[child]] >= 0]
    parent = place[above[child]]
    order = np.lexsort((code[child], parent))
    child, parent = child[order], parent[order]
    start = np.searchsorted(parent, np.arange(len(rows)))
    rank = np.arange(len(child)) - start[parent]
    found = np.full((len(rows), int(rank.max(initial=-1)) + 1), -1)
    found[parent, rank] = code[child]
    return found
