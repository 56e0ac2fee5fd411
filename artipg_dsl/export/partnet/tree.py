"""Links and their pieces on the way into the folder, and the part tree of ``result.json``: in the words of PartNet, so that tools
that merge its classes find their paths.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import lru_cache
from importlib import resources
from typing import TYPE_CHECKING, Any

import numpy as np

from ...records import dataclass

if TYPE_CHECKING:
    from ...robot.model import RobotJoint
    from ...runtime.batch import Batch


@dataclass(slots=True)
class Leaf:
    """What of one part belongs to one link: the finest piece that the data set names. ``path`` is its place in the part
    tree of PartNet, below what stands above all; for a category that PartNet has not, the name."""

    id: int
    name: str
    text: str
    stems: list[str]
    path: str


@dataclass(slots=True)
class FolderLink:
    """A link on its way into the folder. ``number`` is ours; ``joint`` is None for the root.

    ``limit`` is in radians or the data set's unit, None for joints without.
    """

    id: int
    number: int
    word: str
    type: str
    label: str
    node: int
    pivot: np.ndarray
    joint: RobotJoint | None
    limit: tuple[float, float] | None
    parent: int | None
    leaves: dict[int, Leaf]


@dataclass(frozen=True, slots=True)
class CategoryWords:
    """The part names of a category: what stands above all, and the path below it for each of our words."""

    root: str
    paths: dict[str, str]

    def path(self, leaf: str, link: str, text: str) -> str:
        """The path of a leaf that bears a word (or a name of its own) on a link that is called so.

        ``text`` is its name in our tables, of which the last part counts.
        """
        own = f"{leaf}.{text.rpartition('.')[2]}"
        return self.paths.get(f"{link}/{leaf}") or self.paths.get(own) or self.paths.get(leaf) or leaf


@lru_cache(maxsize=1)
def _table() -> dict[str, Any]:
    return json.loads(resources.files("artipg_dsl.export.partnet").joinpath("paths.json").read_text(encoding="utf-8"))


def said_of(batch: Batch, i: int, semantic: np.ndarray) -> set[str]:
    """What object ``i`` has that cases may need: the words with the numbers ``semantic`` of its parts, and each choice that was drawn for
    the whole, as ``kind=spot``."""
    words = batch.program.vocabularies.get("semantic", ("",))
    chosen = {f"{name}={value}" for name, value in batch.drawn(i).items() if isinstance(value, str)}
    return chosen | {words[k] for k in np.unique(semantic).tolist() if k}


def words_of(category: str, said: set[str]) -> CategoryWords | None:
    """The words of a category of PartNet for an object that has what ``said_of`` says; None for a category that it has not."""
    for case in _table().get(category, ()):
        if said.issuperset(case["needs"]):
            return CategoryWords(case["root"], case["paths"])
    return None


def build_tree(words: CategoryWords, members: Sequence[FolderLink], first: int) -> dict[str, Any]:
    """The nodes from the object down to the leaves. A leaf keeps its id, others are numbered from ``first`` on; the
    object is 0.

    Leaves of one link stand together below the node that each link has for itself, which a link shares with what it
    carries.
    """
    nodes: dict[tuple[str, int], dict[str, Any]] = {}
    number = first

    def node(path: str, owner: int) -> dict[str, Any]:
        nonlocal number
        if (path, owner) not in nodes:
            above, _, name = path.rpartition("/")
            parent = None if not above else nodes.get((above, owner)) or node(above, _SHARED)
            made = {"id": 0 if parent is None else number, "name": name, "text": name, "children": []}
            nodes[path, owner] = made
            if parent is not None:
                number += 1
                parent["children"].append(made)
        return nodes[path, owner]

    by_id = {member.id: member for member in members}
    for member in sorted(members, key=lambda m: (_depth(m, by_id), m.id)):
        for leaf in member.leaves.values():
            path = f"{words.root}/{leaf.path}"
            own, bar, inner = path.partition("|")
            if not bar:
                own, inner = path.rpartition("/")[::2]
                holder = node(own, _SHARED)
            else:
                at: FolderLink | None = member
                while at is not None and (own, at.id) not in nodes:
                    at = None if at.parent is None else by_id[at.parent]
                owner = member.id if at is None else at.id
                node(own, owner)
                between = inner.rpartition("/")[0]
                holder = _below(own, between, owner, node)
            holder["children"].append(to_entry(leaf))
    return node(words.root.partition("/")[0], _SHARED)


_SHARED = -1  # owner of a node that all links share


def _below(own: str, between: str, owner: int, node: Any) -> dict[str, Any]:
    """The node at a path below one that belongs to a link."""
    path = own
    for name in filter(None, between.split("/")):
        path = f"{path}/{name}"
        node(path, owner)
    return node(path, owner)


def _depth(member: FolderLink, by_id: dict[int, FolderLink]) -> int:
    depth = 0
    while member.parent is not None:
        member, depth = by_id[member.parent], depth + 1
    return depth


def to_entry(leaf: Leaf) -> dict[str, Any]:
    return {"id": leaf.id, "name": leaf.name, "text": leaf.text, "objs": leaf.stems}
