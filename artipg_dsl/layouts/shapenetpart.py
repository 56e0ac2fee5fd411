"""ShapeNetPart: points with normals and the number of a part, as text, or 2,048 of them in HDF5."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..export.containers import hdf5_bytes
from .clouds import classify, draw, fit_diagonal, shapenet_axes
from .entry import SPLITS, Entry
from .findings import Findings
from .hdf5 import read_h5
from .words import Term, vocabulary

if TYPE_CHECKING:
    from ..runtime.batch import Batch

POINTS, H5_POINTS = 2500, 2048
_LISTS = "train_test_split/shuffled_{split}_file_list.json"
_H5 = "hdf5_data"


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
    """A file per split: ``data``, ``normal`` (n, 2048, 3), ``label`` (n, 1) of the class, ``pid`` (n, 2048) of the parts."""
    assert entry.term is not None
    place, normal, part = arrays(batch, entry, H5_POINTS)
    label = list(vocabulary("shapenetpart").classes).index(entry.term.name)
    for split, at in entry.splits(batch.numbers).items():
        if len(at):
            held = {
                "data": place[at].astype(np.float32),
                "normal": normal[at].astype(np.float32),
                "label": np.full((len(at), 1), label, dtype=np.uint8),
                "pid": part[at].astype(np.uint8),
            }
            yield f"{_H5}/{_h5_name(entry, split, shard)}", hdf5_bytes(held, pack=True)


def _h5_name(entry: Entry, split: str, shard: int) -> str:
    return f"ply_data_{split}_{entry.category.lower()}{shard}.h5"


def h5_index(entries: Sequence[Entry]) -> dict[str, bytes]:
    """Lists of the files, the classes, and which part of which class each number is."""
    classes = vocabulary("shapenetpart").classes
    names = "".join(f"{name}\t{data['synset']}\n" for name, data in classes.items())
    every = [[data["synset"], k + 1] for data in classes.values() for k in range(len(data["parts"]))]
    files = {
        f"{_H5}/all_object_categories.txt": names.encode(),
        f"{_H5}/overallid_to_catid_partid.json": json.dumps(every).encode(),
    }
    for split in SPLITS:
        listed = [_h5_name(e, split, shard) for e in entries for shard in e.shards(split)]
        files[f"{_H5}/{split}_hdf5_file_list.txt"] = "".join(f"{name}\n" for name in listed).encode()
    return files


# ---------------------------------------------------------------- reading back


def check_text(folder: Path, entry: Entry, batch: Batch, shard: int, found: Findings) -> None:
    """Read as loaders do, and compare with the model."""
    assert entry.term is not None
    place, normal, part = arrays(batch, entry, POINTS)
    listed = {s: set(json.loads((folder / _LISTS.format(split=s)).read_text())) for s in SPLITS}
    for i, number in enumerate(batch.numbers.tolist()):
        name = f"{entry.term.data['synset']}/{entry.token(number)}"
        rows = np.loadtxt(folder / f"{name}.txt", dtype=np.float32)
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
    label = list(vocabulary("shapenetpart").classes).index(entry.term.name)
    for split, at in entry.splits(batch.numbers).items():
        if not len(at):
            continue
        name = _h5_name(entry, split, shard)
        listed = (folder / _H5 / f"{split}_hdf5_file_list.txt").read_text().split()
        found.of(name, name in listed, "not in the list of its split")
        held = read_h5(folder / _H5 / name)
        found.of(name, set(np.unique(held["pid"])) <= _numbers(entry.term), "numbers of parts of another class")
        found.near(name, "points", held["data"], place[at], 1e-6)
        found.near(name, "normals", held["normal"], normal[at], 1e-6)
        found.same(name, "numbers of parts", held["pid"], part[at])
        found.same(name, "classes", held["label"], np.full((len(at), 1), label))


def _numbers(term: Term) -> set[int]:
    return {term.data["first"] + k for k in range(len(term.data["parts"]))}
