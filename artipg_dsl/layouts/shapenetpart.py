"""ShapeNetPart: points with normals and the number of a part, as text, or 2,048 of them in HDF5."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from colorsys import hsv_to_rgb
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

import numpy as np

from .clouds import classify, draw, fit_diagonal, shapenet_axes
from .entry import SPLITS, Entry
from .findings import Findings, read_table
from .hdf5 import join_rows, open_h5, read_row, rows_h5, spread
from .words import Term, vocabulary

if TYPE_CHECKING:
    from ..runtime.batch import Batch

POINTS, H5_POINTS = 2500, 2048
_H5_MOST = 2048  # objects in one file of the data set
_OBJECTS = "objects"
_LISTS = "train_test_split/shuffled_{split}_file_list.json"
_H5 = "hdf5_data"
_SETS: dict[str, tuple[str, np.ndarray]] = {
    "data": ("data", np.zeros((0, H5_POINTS, 3), np.float32)),
    "normal": ("normal", np.zeros((0, H5_POINTS, 3), np.float32)),
    "pid": ("pid", np.zeros((0, H5_POINTS), np.uint8)),
}
_Row = tuple[Path, int, str, int]  # where an object is: file and row; its name, and the number of its class


def _part_number(term: Term, part: str) -> int:
    """The number of a part among the 50 of all classes."""
    return int(term.data["first"] + term.data["parts"].index(part))


def check_term(term: Term) -> str | None:
    """What is wrong with a map, if anything: it names a part that the class has not."""
    unknown = [part for part in term.parts.values() if part not in term.data["parts"]]
    known = ", ".join(term.data["parts"])
    return f"the class {term.name} has no part `{unknown[0]}`: its parts are {known}" if unknown else None


def arrays(batch: Batch, entry: Entry, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points and normals (B, n, 3) in ShapeNet's axes, and numbers of parts (B, n)."""
    assert entry.term is not None
    term, points = entry.term, draw(batch, count)
    place = shapenet_axes(fit_diagonal(points.position).apply(points.position))
    return place, shapenet_axes(points.normal), classify(batch, points, term, lambda part: _part_number(term, part))


def text_files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """A file per object: rows ``x y z nx ny nz part``."""
    assert entry.term is not None
    place, normal, part = arrays(batch, entry, POINTS)
    rows = np.concatenate([place, normal, part[..., None]], axis=-1) + 0.0
    form = "%.6f %.6f %.6f %.6f %.6f %.6f %.6f\n" * POINTS
    for number, own in zip(batch.numbers.tolist(), rows, strict=True):
        yield f"{entry.term.data['synset']}/{entry.token(number)}.txt", (form % tuple(own.ravel().tolist())).encode()


def text_index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """Lists of all categories; every class has its folder, because loaders look into all of them."""
    classes = vocabulary("shapenetpart").classes
    names = "".join(f"{name}\t{data['synset']}\n" for name, data in classes.items())
    files = {"synsetoffset2category.txt": names.encode()}
    for split in SPLITS:
        listed = [f"shape_data/{e.term.data['synset']}/{token}" for e in entries if e.term for token in e.tokens(split)]
        files[_LISTS.format(split=split)] = json.dumps(listed).encode()
    return files | {f"{data['synset']}/": b"" for data in classes.values()}


def h5_files(batch: Batch, entry: Entry, shard: int) -> Iterator[tuple[str, bytes]]:
    """A file of objects that are made together: ``data``, ``normal`` (n, 2048, 3), ``pid`` (n, 2048) of the parts."""
    place, normal, part = arrays(batch, entry, H5_POINTS)
    held: dict[str, np.ndarray] = {
        "data": place.astype(np.float32),
        "normal": normal.astype(np.float32),
        "pid": part.astype(np.uint8),
    }
    yield _piece(entry, shard), rows_h5(held)


def _piece(entry: Entry, shard: int) -> str:
    return f"{_OBJECTS}/{entry.category}-{shard}.h5"


def _label(entry: Entry) -> int:
    """The number of the class."""
    assert entry.term is not None
    return list(vocabulary("shapenetpart").classes).index(entry.term.name)


def h5_index(entries: Sequence[Entry], folder: Path) -> dict[str, bytes | Callable[[BinaryIO], None]]:
    """The files of each split, which hold objects of all classes; lists of them, the classes, their parts and colours for these.

    Beside the arrays of the data set there is ``name`` (n,), the names of the objects.
    """
    classes = vocabulary("shapenetpart").classes
    names = "".join(f"{name}\t{data['synset']}\n" for name, data in classes.items())
    every = [[data["synset"], k + 1] for data in classes.values() for k in range(len(data["parts"]))]
    colours = [[round(float(c), 2) for c in hsv_to_rgb(0.618 * k % 1.0, 0.7, 0.9)] for k in range(len(every))]
    files: dict[str, bytes | Callable[[BinaryIO], None]] = {
        f"{_H5}/all_object_categories.txt": names.encode(),
        f"{_H5}/overallid_to_catid_partid.json": json.dumps(every).encode(),
        f"{_H5}/catid_partid_to_overallid.json": json.dumps({f"{c}_{k}": n for n, (c, k) in enumerate(every)}).encode(),
        f"{_H5}/part_color_mapping.json": json.dumps(colours).encode(),
    }
    rows: dict[str, list[_Row]] = {split: [] for split in SPLITS}
    for entry in entries:
        for shard, numbers in enumerate(entry.chunks()):
            for row, number in enumerate(numbers.tolist()):
                at = folder / _piece(entry, shard), row, entry.token(number), _label(entry)
                rows[entry.split(number)].append(at)
    for split, own in rows.items():
        listed = []
        for k, held in enumerate(spread(own, _H5_MOST)):
            listed.append(f"ply_data_{split}{k}.h5")
            files[f"{_H5}/{listed[-1]}"] = partial(_join, held)
        files[f"{_H5}/{split}_hdf5_file_list.txt"] = "".join(f"{name}\n" for name in listed).encode()
    return files


def _join(rows: Sequence[_Row], stream: BinaryIO) -> None:
    more = {
        "label": np.array([[label] for *_, label in rows], dtype=np.uint8),
        "name": np.array([token for *_, token, _ in rows], dtype="S"),
    }
    join_rows(stream, _SETS, [(path, row) for path, row, *_ in rows], more)


# ---------------------------------------------------------------- reading back


def check_text(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    assert entry.term is not None
    place, normal, part = arrays(batch, entry, POINTS)
    listed = {s: set(json.loads((folder / _LISTS.format(split=s)).read_text("utf-8"))) for s in SPLITS}
    for i, number in enumerate(batch.numbers.tolist()):
        name = f"{entry.term.data['synset']}/{entry.token(number)}"
        rows = read_table(folder / f"{name}.txt", np.float32)
        if found.of(name, rows.shape == (POINTS, 7), f"{rows.shape} numbers, not {(POINTS, 7)}"):
            found.of(name, set(np.unique(rows[:, 6])) <= _numbers(entry.term), "numbers of parts of another class")
            found.near(name, "points", rows[:, :3], place[i], 1e-6)
            found.near(name, "normals", rows[:, 3:6], normal[i], 1e-6)
            found.same(name, "numbers of parts", rows[:, 6].astype(int), part[i])
        found.of(name, f"shape_data/{name}" in listed[entry.split(number)], "not in the list of its split")
    for data in vocabulary("shapenetpart").classes.values():
        found.of(data["synset"], (folder / data["synset"]).is_dir(), "the folder of a class is missing")


def check_h5(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    assert entry.term is not None
    place, normal, part = arrays(batch, entry, H5_POINTS)
    for split, at in entry.splits(batch.numbers).items():
        known = _places(folder / _H5, split, found)
        for i in at.tolist():
            token = entry.token(int(batch.numbers[i]))
            if not found.of(token, token in known, f"not in the files of {split}"):
                continue
            path, row = known[token]
            name, held = f"{_H5}/{path.name} {token}", read_row(path, row)
            found.of(name, set(np.unique(held["pid"])) <= _numbers(entry.term), "numbers of parts of another class")
            found.near(name, "points", held["data"], place[i], 1e-6)
            found.near(name, "normals", held["normal"], normal[i], 1e-6)
            found.same(name, "numbers of parts", held["pid"], part[i])
            found.same(name, "classes", held["label"], np.array([_label(entry)]))


def _places(folder: Path, split: str, found: Findings) -> dict[str, tuple[Path, int]]:
    """Where the objects of a split are: file and row. Files that are in no list are found as well: some loaders read what there is."""
    listed = (folder / f"{split}_hdf5_file_list.txt").read_text("utf-8").split()
    for path in sorted(folder.glob(f"*{split}*.h5")):
        found.of(f"{_H5}/{path.name}", path.name in listed, "in no list, and some loaders read it all the same")
    places: dict[str, tuple[Path, int]] = {}
    for name in listed:
        with open_h5(folder / name) as file:
            own = file["name"][()].astype(str).tolist()
        found.of(f"{_H5}/{name}", len(own) <= _H5_MOST, f"more than {_H5_MOST} objects")
        places |= {token: (folder / name, row) for row, token in enumerate(own)}
    return places


def _numbers(term: Term) -> set[int]:
    return {term.data["first"] + k for k in range(len(term.data["parts"]))}
