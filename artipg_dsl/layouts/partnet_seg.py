"""PartNet's segmentation: 10,000 points with the classes of each level, with the parts of each object, and its trees."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..export.containers import hdf5_bytes
from ..export.robot import Robots
from .clouds import draw, fit_radius, partnet_axes
from .entry import SPLITS, Entry
from .findings import Findings
from .hdf5 import read_h5
from .partnet_parts import Levels, Parts, children, object_parts, part_list, part_tree

if TYPE_CHECKING:
    from ..annotate.cloud import Points
    from ..graph.program import Program
    from ..runtime.batch import Batch

POINTS = 10000
MOST = 1024  # shapes in one file of the data set


def words(program: Program) -> dict[str, Any]:
    """What the index needs of a program: the name of its category, and its classes by level."""
    levels = Levels.of(program)
    return {"name": levels.name, "levels": {level: list(names) for level, names in levels.classes.items()}}


class _Shapes:
    """The points of a batch in PartNet's form."""

    def __init__(self, batch: Batch):
        self.levels = Levels.of(batch.program)
        self.points = draw(batch, POINTS)
        fit = fit_radius(self.points.position)
        self.place = partnet_axes(fit.apply(self.points.position)).astype(np.float32)
        self.normal = partnet_axes(self.points.normal).astype(np.float32)
        self.parts = list(object_parts(batch, self.points, self.levels))
        above = children(batch)
        self.trees = [part_tree(own, above[i]) for i, own in enumerate(self.parts)]

    def classes(self, level: str) -> np.ndarray:
        """Numbers (B, n) of classes."""
        return np.stack([self._classes(own, level) for own in self.parts]).astype(np.uint8)

    def _classes(self, own: Parts, level: str) -> np.ndarray:
        numbers = [self.levels.number(level, own.words.root, path) for path in own.paths]
        return np.array(numbers)[own.leaf]

    def semantic(self, level: str, at: np.ndarray) -> dict[str, np.ndarray]:
        """The arrays of ``sem_seg_h5``."""
        return {
            "data": self.place[at],
            "data_num": np.full(len(at), POINTS, dtype=np.int32),
            "label_seg": self.classes(level)[at],
        }

    def instances(self, at: np.ndarray, colour: np.ndarray, opacity: np.ndarray) -> dict[str, np.ndarray]:
        """The arrays of ``ins_seg_h5``."""
        ids = np.stack([self.parts[i].ids() for i in at.tolist()]).astype(np.int32)
        return {"pts": self.place[at], "nor": self.normal[at], "rgb": colour[at], "opacity": opacity[at], "label": ids}


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """``sem_seg_h5/<category>-<level>``, ``ins_seg_h5/<category>``, and the trees in ``data_v0/<object>``."""
    shapes, name = _Shapes(batch), entry.words["name"]
    colour, opacity = _looks(batch, shapes.points)
    for split, at in entry.splits(batch.numbers).items():
        if not len(at):
            continue
        for level in shapes.levels.classes:
            yield f"sem_seg_h5/{name}-{level}/{split}-{shard:02d}.h5", hdf5_bytes(shapes.semantic(level, at), pack=True)
        yield f"ins_seg_h5/{name}/{split}-{shard:02d}.h5", hdf5_bytes(shapes.instances(at, colour, opacity), pack=True)
        tokens = [entry.token(int(batch.numbers[i])) for i in at.tolist()]
        told = [_shape(token, shapes.trees[i]) for token, i in zip(tokens, at.tolist(), strict=True)]
        yield f"ins_seg_h5/{name}/{split}-{shard:02d}.json", json.dumps(told).encode()
    for number, tree in zip(batch.numbers.tolist(), shapes.trees, strict=True):
        token = entry.token(number)
        yield f"data_v0/{token}/result_after_merging.json", json.dumps([tree]).encode()
        meta = {"model_id": token, "anno_id": token, "user_id": "artipg_dsl", "version": "1", "model_cat": name}
        yield f"data_v0/{token}/meta.json", json.dumps(meta).encode()


def _shape(token: str, tree: Mapping[str, Any]) -> dict[str, Any]:
    return {"anno_id": token, "model_id": token, "ins_seg": part_list(tree)}


def _looks(batch: Batch, points: Points) -> tuple[np.ndarray, np.ndarray]:
    """Colours (B, n, 3) in 0 .. 255 and opacities (B, n) of points."""
    looks = Robots(batch, physics=False).looks
    colour = np.array([[look.colour for look in own] for own in looks])
    opacity = np.array([[look.opacity for look in own] for own in looks])
    material, row = points.material + 1, np.arange(len(batch))[:, None]
    return np.round(255 * colour[material, row]).astype(np.uint8), opacity[material, row].astype(np.float32)


def index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """The lists of files, the classes of each level, and the objects of each split."""
    made: dict[str, bytes] = {}
    for entry in entries:
        name = entry.words["name"]
        for level, classes in entry.words["levels"].items():
            rows = "".join(f"{k + 1} {path} leaf\n" for k, path in enumerate(classes))
            made[f"stats/after_merging_label_ids/{name}-level-{level}.txt"] = rows.encode()
        for split in SPLITS:
            listed = "".join(f"{split}-{shard:02d}.h5\n" for shard in entry.shards(split)).encode()
            for level in entry.words["levels"]:
                made[f"sem_seg_h5/{name}-{level}/{split}_files.txt"] = listed
            made[f"ins_seg_h5/{name}/{split}_files.txt"] = listed
            split_of = [{"anno_id": token, "model_id": token} for token in entry.tokens(split)]
            made[f"stats/train_val_test_split/{name}.{split}.json"] = json.dumps(split_of).encode()
    return made


# ---------------------------------------------------------------- reading back


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    shapes, name = _Shapes(batch), entry.words["name"]
    colour, opacity = _looks(batch, shapes.points)
    for split, at in entry.splits(batch.numbers).items():
        if not len(at):
            continue
        for level, classes in shapes.levels.classes.items():
            place = f"sem_seg_h5/{name}-{level}/{split}-{shard:02d}.h5"
            listed = (folder / place).with_name(f"{split}_files.txt").read_text().split()
            found.of(place, Path(place).name in listed, "not in the list of its split")
            rows = (folder / f"stats/after_merging_label_ids/{name}-level-{level}.txt").read_text().splitlines()
            found.of(place, [row.split()[1] for row in rows] == list(classes), "the classes of its level are others")
            held = read_h5(folder / place)
            found.of(place, int(held["label_seg"].max()) <= len(rows), "a class that its level has not")
            found.of(place, len(held["data"]) <= MOST, f"more than {MOST} shapes")
            radius = np.linalg.norm(held["data"], axis=-1).max(axis=-1)
            found.near(place, "radii", radius, np.ones(len(at)), 1e-5)
            for key, array in shapes.semantic(level, at).items():
                found.near(place, key, held[key], array, 1e-6)
        place = f"ins_seg_h5/{name}/{split}-{shard:02d}.h5"
        held, told = read_h5(folder / place), json.loads((folder / place).with_suffix(".json").read_text())
        for key, array in shapes.instances(at, colour, opacity).items():
            found.near(place, key, held[key], array, 1e-6)
        for label, shape in zip(held["label"], told, strict=True):
            whole = set(shape["ins_seg"][0]["leaf_id_list"])
            found.of(place, set(np.unique(label).tolist()) <= whole, "points on leaves that its tree has not")
            stored = json.loads((folder / f"data_v0/{shape['anno_id']}/result_after_merging.json").read_text())
            found.of(place, part_list(stored[0]) == shape["ins_seg"], "parts that are not those of the tree")
