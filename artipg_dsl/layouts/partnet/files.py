"""PartNet's segmentation: 10,000 points with the classes of each level, with the parts of each object, and its trees."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, BinaryIO

import numpy as np

from ...robot.robots import Robots
from ..clouds import draw, fit_radius, norms, partnet_axes
from ..entry import SPLITS, Entry
from ..findings import Findings
from ..hdf5 import join_rows, read_row, rows_h5, spread
from .parts import Levels, Parts, children, object_parts, part_list, part_tree

if TYPE_CHECKING:
    from ...annotate.cloud import Points
    from ...graph.program import Program
    from ...runtime.batch import Batch

POINTS = 10000
MOST = 1024  # shapes in one file of the data set
_OBJECTS = "objects"
_EMPTY: dict[str, np.ndarray] = {
    "pts": np.zeros((0, POINTS, 3), np.float32),
    "nor": np.zeros((0, POINTS, 3), np.float32),
    "rgb": np.zeros((0, POINTS, 3), np.uint8),
    "opacity": np.zeros((0, POINTS), np.float32),
    "label": np.zeros((0, POINTS), np.int32),
}
_NAMED = {name: (name, empty) for name, empty in _EMPTY.items()}
_CLASSES = np.zeros((0, POINTS), np.uint8)


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

    def arrays(self, colour: np.ndarray, opacity: np.ndarray) -> dict[str, np.ndarray]:
        """The points of ``ins_seg_h5``, and their classes by level."""
        ids = np.stack([own.ids() for own in self.parts]).astype(np.int32)
        held = {"pts": self.place, "nor": self.normal, "rgb": colour, "opacity": opacity, "label": ids}
        return held | {_level(level): self.classes(level) for level in self.levels.classes}


def _level(level: str) -> str:
    return f"level_{level}"


def _piece(entry: Entry, shard: int) -> str:
    return f"{_OBJECTS}/{entry.category}-{shard}"


def files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """The points of objects that are made together with their parts, and the trees in ``data_v0/<object>``."""
    shapes, name = _Shapes(batch), entry.words["name"]
    tokens = [entry.token(number) for number in batch.numbers.tolist()]
    yield f"{_piece(entry, shard)}.h5", rows_h5(shapes.arrays(*_looks(batch, shapes.points)))
    told = [_shape(token, tree) for token, tree in zip(tokens, shapes.trees, strict=True)]
    yield f"{_piece(entry, shard)}.json", json.dumps(told).encode()
    for token, tree in zip(tokens, shapes.trees, strict=True):
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


def index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes | Callable[[BinaryIO], None]]:
    """``sem_seg_h5/<category>-<level>``, ``ins_seg_h5/<category>``, lists of their files, the classes of each level, and the objects
    of each split."""
    made: dict[str, bytes | Callable[[BinaryIO], None]] = {}
    for entry in entries:
        name = entry.words["name"]
        for level, classes in entry.words["levels"].items():
            rows = "".join(f"{k + 1} {path} leaf\n" for k, path in enumerate(classes))
            made[f"stats/after_merging_label_ids/{name}-level-{level}.txt"] = rows.encode()
        for split in SPLITS:
            groups = spread(_rows(entry, split, folder), MOST)
            listed = "".join(f"{split}-{k:02d}.h5\n" for k in range(len(groups))).encode()
            for k, group in enumerate(groups):
                place = f"ins_seg_h5/{name}/{split}-{k:02d}"
                made[f"{place}.h5"] = partial(_join, group, _NAMED, {})
                made[f"{place}.json"] = partial(_tell, group)
                for level in entry.words["levels"]:
                    sets = {"data": _NAMED["pts"], "label_seg": (_level(level), _CLASSES)}
                    more = {"data_num": np.full(len(group), POINTS, dtype=np.int32)}
                    made[f"sem_seg_h5/{name}-{level}/{split}-{k:02d}.h5"] = partial(_join, group, sets, more)
            for level in entry.words["levels"]:
                made[f"sem_seg_h5/{name}-{level}/{split}_files.txt"] = listed
            made[f"ins_seg_h5/{name}/{split}_files.txt"] = listed
            split_of = [{"anno_id": token, "model_id": token} for token in entry.tokens(split)]
            made[f"stats/train_val_test_split/{name}.{split}.json"] = json.dumps(split_of).encode()
    return made


def _rows(entry: Entry, split: str, folder: Path) -> list[tuple[Path, int]]:
    """Where the points of the objects of a split are: the name of a file without its ending, and the row."""
    return [
        (folder / _piece(entry, shard), row)
        for shard, numbers in enumerate(entry.chunks())
        for row, number in enumerate(numbers.tolist())
        if entry.split(number) == split
    ]


def _join(
    rows: Sequence[tuple[Path, int]],
    sets: Mapping[str, tuple[str, np.ndarray]],
    more: Mapping[str, np.ndarray],
    stream: BinaryIO,
) -> None:
    join_rows(stream, sets, [(path.with_suffix(".h5"), row) for path, row in rows], more)


def _tell(rows: Sequence[tuple[Path, int]], stream: BinaryIO) -> None:
    """The parts of each object."""
    told = {
        path: json.loads(path.with_suffix(".json").read_bytes()) for path in dict.fromkeys(path for path, _ in rows)
    }
    stream.write(json.dumps([told[path][row] for path, row in rows]).encode())


# ---------------------------------------------------------------- reading back


def check(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    shapes, name = _Shapes(batch), entry.words["name"]
    model = shapes.arrays(*_looks(batch, shapes.points))
    for level, classes in shapes.levels.classes.items():
        listed = f"stats/after_merging_label_ids/{name}-level-{level}.txt"
        known = [row.split()[1] for row in (folder / listed).read_text("utf-8").splitlines()]
        found.of(listed, known == list(classes), "the classes of its level are others")
    for split, at in entry.splits(batch.numbers).items():
        places = _places(folder, name, shapes.levels.classes, split, found)
        for i in at.tolist():
            token = entry.token(int(batch.numbers[i]))
            if not found.of(token, token in places, f"not in the files of {split}"):
                continue
            file, row, told = places[token]
            for level, classes in shapes.levels.classes.items():
                place = f"sem_seg_h5/{name}-{level}/{file}.h5"
                held, place = read_row(folder / place, row), f"{place} {token}"
                found.of(place, int(held["label_seg"].max()) <= len(classes), "a class that its level has not")
                found.near(place, "data_num", held["data_num"], np.array(POINTS), 0)
                found.near(place, "radius", norms(held["data"].astype(float)).max(), np.array(1.0), 1e-5)
                found.near(place, "data", held["data"], model["pts"][i], 1e-6)
                found.same(place, "label_seg", held["label_seg"], model[_level(level)][i])
            place = f"ins_seg_h5/{name}/{file}.h5"
            held, place = read_row(folder / place, row), f"{place} {token}"
            for key in _EMPTY:
                found.near(place, key, held[key], model[key][i], 1e-6)
            whole = set(told["ins_seg"][0]["leaf_id_list"])
            found.of(place, set(np.unique(held["label"]).tolist()) <= whole, "points on leaves that its tree has not")
            stored = json.loads((folder / f"data_v0/{token}/result_after_merging.json").read_text("utf-8"))
            found.of(place, part_list(stored[0]) == told["ins_seg"], "parts that are not those of the tree")


def _places(
    folder: Path, name: str, levels: Iterable[str], split: str, found: Findings
) -> dict[str, tuple[str, int, dict[str, Any]]]:
    """Where the objects of a split are, file and row, and what is told of their parts. Instance segmentation reads all files that there
    are, whatever the list says."""
    own = folder / f"ins_seg_h5/{name}"
    listed = (own / f"{split}_files.txt").read_text("utf-8").split()
    for path in sorted(own.glob(f"{split}-*.h5")):
        place = f"ins_seg_h5/{name}/{path.name}"
        found.of(place, path.name in listed, "in no list, and some loaders read it all the same")
    for level in levels:
        again = f"sem_seg_h5/{name}-{level}/{split}_files.txt"
        found.of(
            again, (folder / again).read_text("utf-8").split() == listed, "lists other files than that of ins_seg_h5"
        )
    places: dict[str, tuple[str, int, dict[str, Any]]] = {}
    for file in (file.removesuffix(".h5") for file in listed):
        told = json.loads((own / f"{file}.json").read_text("utf-8"))
        found.of(f"ins_seg_h5/{name}/{file}.h5", len(told) <= MOST, f"more than {MOST} shapes")
        places |= {shape["anno_id"]: (file, row, shape) for row, shape in enumerate(told)}
    return places
