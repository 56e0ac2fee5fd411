"""The parts of an object as PartNet's trees have them, and the numbers that its levels give to points."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ...export.partnet.tree import CategoryWords, FolderLink, Leaf, build_tree, said_of, words_of
from ...export.partnet.words import spell_category, to_snake_case
from ...records import dataclass
from ..words import REST, vocabulary

if TYPE_CHECKING:
    from ...annotate.cloud import Points
    from ...graph.program import Program
    from ...runtime.batch import Batch

OWN = "1"  # the level of a category that PartNet lacks


@dataclass(frozen=True, slots=True)
class Levels:
    """``classes`` by level, their numbers being their places from 1 on; ``finer``: what a path becomes, by primitive;
    ``whole``: paths of which an object, or a link where they have a ``|``, has one."""

    name: str
    classes: Mapping[str, Sequence[str]]
    finer: Mapping[str, Mapping[str, str]]
    whole: Sequence[str]

    @staticmethod
    def of(program: Program) -> Levels:
        """PartNet's levels of a category; for one that it lacks a level of the words that the program says."""
        name = spell_category(program.name)
        known = vocabulary("partnet").classes.get(name)
        if known is not None:
            return Levels(name, known["levels"], known["finer"], known["whole"])
        said = {label.name for label in program.labels if label.vocabulary == "semantic"}
        words = [word for word in program.vocabularies.get("semantic", ()) if word in said]
        return Levels(name, {OWN: [f"{to_snake_case(program.name)}/{to_snake_case(word)}" for word in words]}, {}, ())

    def number(self, level: str, root: str, path: str) -> int:
        """The number of the class that a path lies in, 0 for other."""
        full = f"{root}/{path}/".replace("|", "/")
        places = (k + 1 for k, name in enumerate(self.classes[level]) if full.startswith(f"{name}/"))
        return next(places, 0)

    def refine(self, path: str, primitive: str) -> str:
        """A path as the finest level has it, on a primitive of that name."""
        cases = self.finer.get(path, {})
        return cases.get(primitive) or cases.get(REST) or path


@dataclass(frozen=True, slots=True)
class Parts:
    """What the points (n,) of an object lie on: ``leaf`` (n,) a row of ``paths``, ``links`` and ``texts``; ``words`` of
    the object."""

    words: CategoryWords
    leaf: np.ndarray
    paths: list[str]
    links: list[int]
    texts: list[str]

    def ids(self) -> np.ndarray:
        """Numbers (n,) of the leaves as the tree has them: from 1 on."""
        return self.leaf + 1


def object_parts(batch: Batch, points: Points, levels: Levels) -> Iterator[Parts]:
    """The parts of each object of a batch. A leaf is what of one part, on one link, the finest level calls the same; where it
    is called so for its primitive, each of these is one."""
    program, parts, links = batch.program, batch.parts(), batch.links()
    semantic = program.vocabularies.get("semantic", ("",))
    part_start = np.searchsorted(parts.owner, np.arange(len(batch) + 1))
    link_start = np.searchsorted(links.owner, np.arange(len(batch) + 1))
    above = children(batch)
    last = [site.path.rpartition(".")[2] for site in program.sites]
    for i in range(len(batch)):
        said = said_of(batch, i, parts.semantic[part_start[i] : part_start[i + 1]])
        words = words_of(levels.name, said) or CategoryWords(to_snake_case(program.name), {})
        told = points.link, points.instance, points.element, points.semantic, points.primitive
        rows, place = _distinct([array[i] for array in told])
        found: dict[tuple[int, int, tuple[int, ...], str], int] = {}
        held: list[tuple[int, str]] = []
        leaf = np.zeros(len(rows), dtype=np.int64)
        for k, (link, instance, element, word, site) in enumerate(rows.tolist()):
            on = to_snake_case(batch.link_words[link_start[i] + link]) if link in above[i] else ""
            text = parts.name[part_start[i] + instance]
            coarse = words.path(to_snake_case(semantic[word] if word else text.split(".")[-1]), on, text)
            path = levels.refine(coarse, last[site])
            own = (site, element) if last[site] in levels.finer.get(coarse, {}) else ()
            key = (link, instance, own, path)
            if path in levels.whole:
                key = (link if "|" in path else -1, -1, (), path)
            if key not in found:
                held.append((link, text))
            leaf[k] = found.setdefault(key, len(found))
        yield Parts(
            words, leaf[place], [path for *_, path in found], [link for link, _ in held], [text for _, text in held]
        )


def _distinct(columns: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """The distinct rows (k, C) of columns (n,) of small whole numbers, in their order, and which of them each row is. One number stands
    for a row: NumPy compares rows byte by byte."""
    number = np.zeros(len(columns[0]), dtype=np.int64)
    for column in columns:
        low = column.min(initial=0)
        number = number * (column.max(initial=0) - low + 1) + (column - low)
    _, first, place = np.unique(number, return_index=True, return_inverse=True)
    return np.stack([column[first] for column in columns], axis=1), place


def children(batch: Batch) -> list[dict[int, int]]:
    """For each object, the link above each link that a joint holds."""
    joints = batch.joints()
    found: list[dict[int, int]] = [{} for _ in range(len(batch))]
    for owner, parent, child in zip(joints.owner.tolist(), joints.parent.tolist(), joints.child.tolist(), strict=True):
        found[owner][child] = parent
    return found


def part_tree(own: Parts, above: Mapping[int, int]) -> dict[str, Any]:
    """The tree of ``result_after_merging.json``. Leaves have the ids of ``Parts.ids``, the object 0."""
    members = {}
    for link in sorted({*own.links, *above, *above.values()}):
        at = [k for k, held in enumerate(own.links) if held == link]
        leaves = {
            k: Leaf(k + 1, own.paths[k].replace("|", "/").rpartition("/")[2], own.texts[k], [], own.paths[k])
            for k in at
        }
        members[link] = FolderLink(link, link, "", "", "", 0, np.zeros(3), None, None, above.get(link), leaves)
    return build_tree(own.words, list(members.values()), len(own.paths) + 1)


def part_list(node: Mapping[str, Any], above: str = "") -> list[dict[str, Any]]:
    """Every node of a tree with its path and the leaves below it."""
    name = f"{above}/{node['name']}" if above else node["name"]
    below = [entry for child in node.get("children", ()) for entry in part_list(child, name)]
    leaves = [node["id"]] if not node.get("children") else sorted({k for e in below for k in e["leaf_id_list"]})
    return [{"part_name": name, "leaf_id_list": leaves}, *below]
