"""Shards of points and annotations, the same bytes for the same objects."""

from __future__ import annotations

import io
import zipfile
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..annotate.annotation import describe, line
from ..annotate.cloud import sample_points

if TYPE_CHECKING:
    from ..runtime.batch import Batch

STAMP = (1980, 1, 1, 0, 0, 0)  # zip has no "no date"


@dataclass(frozen=True, slots=True)
class Meaning:
    """What an array of a shard holds: its shape in words, frame and unit."""

    text: str
    shape: str
    frame: str = ""
    unit: str = ""


MEANINGS = {
    "points": Meaning("points on the visible surface at rest", "objects, points, 3", "object", "m"),
    "normals": Meaning("outward unit normals of the surface", "objects, points, 3", "object", "1"),
    "semantic": Meaning("class of the part, an index into vocabularies.semantic", "objects, points"),
    "instance": Meaning("part instance, its `number` in the annotation", "objects, points"),
    "link": Meaning("link, its `number` in the annotation", "objects, points"),
    "primitive": Meaning("index into sites; with `instance` it names one primitive", "objects, points"),
    "patch": Meaning("surface patch of the primitive, from 0", "objects, points"),
    "u": Meaning("first patch coordinate, a fraction 0 .. 1", "objects, points", "patch", "1"),
    "v": Meaning("second patch coordinate, a fraction 0 .. 1", "objects, points", "patch", "1"),
    "object": Meaning("number of the object", "objects"),
}


def point_arrays(batch: Batch, n_points: int) -> dict[str, np.ndarray]:
    """The arrays of a points shard, by name: those of ``MEANINGS``, then one per label."""
    points = sample_points(batch, n_points)
    arrays = {
        "object": np.asarray(batch.numbers, dtype=np.int64),
        "points": points.position.astype(np.float32),
        "normals": points.normal.astype(np.float32),
        "semantic": narrow(points.semantic),
        "instance": narrow(points.instance),
        "link": narrow(points.link),
        "primitive": narrow(points.primitive, np.uint16),
        "patch": narrow(points.patch, np.uint16),
        "u": points.u.astype(np.float32),
        "v": points.v.astype(np.float32),
    }
    labels = {name: a if a.dtype == bool else a.astype(np.float32) for name, a in sorted(points.labels.items())}
    return arrays | labels


def narrow(values: np.ndarray, dtype: type = np.uint16) -> np.ndarray:
    """Small numbers in a type that does not depend on what a shard happens to hold."""
    values = np.asarray(values)
    if values.size and int(values.max()) > np.iinfo(dtype).max:
        raise OverflowError(f"{int(values.max())} does not fit {np.dtype(dtype).name}")
    return values.astype(dtype)


def npz_bytes(arrays: dict[str, np.ndarray]) -> bytes:
    """The arrays as an uncompressed .npz whose bytes depend on them alone (names, order and contents)."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_STORED) as archive:
        for name, array in arrays.items():
            entry = zipfile.ZipInfo(f"{name}.npy", STAMP)
            entry.create_system, entry.external_attr = 3, 0o644 << 16
            content = io.BytesIO()
            np.lib.format.write_array(content, np.ascontiguousarray(array), version=(1, 0), allow_pickle=False)
            archive.writestr(entry, content.getbuffer())
    return stream.getvalue()


def points_shard(batch: Batch, n_points: int) -> bytes:
    """The bytes of ``points-<shard>.npz``."""
    return npz_bytes(point_arrays(batch, n_points))


def annotation_shard(batch: Batch, n_points: int) -> bytes:
    """The bytes of ``annotation-<shard>.jsonl``: one object per line."""
    return "".join(line(annotation) + "\n" for annotation in describe(batch)).encode("utf-8")
