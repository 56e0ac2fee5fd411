"""HDF5 files: read back as arrays by name; pictures in many files, put together in one without unpacking them."""

from __future__ import annotations

import io
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np


def read_h5(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file, ``gt_points/0`` for one of a group."""
    import h5py  # extra: HDF5 layouts alone need it

    found: dict[str, np.ndarray] = {}

    def keep(name: str, node: object) -> None:
        if isinstance(node, h5py.Dataset):
            found[name] = node[()]

    with h5py.File(path, "r") as file:
        file.visititems(keep)
    return found


def _pictures(file: Any, name: str, shape: Sequence[int], kind: np.dtype[Any]) -> Any:
    """A data set (n, ...) that is packed picture by picture, as loaders read them."""
    chunks = (1, *shape[1:]) if shape[0] else None
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if shape[0] else {}
    return file.create_dataset(name, shape=tuple(shape), dtype=kind, chunks=chunks, track_times=False, **packed)


def pictures_h5(arrays: Mapping[str, np.ndarray]) -> bytes:
    """A file of pictures (n, ...) by name."""
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w", track_order=True) as file:
        for name, array in arrays.items():
            made = _pictures(file, name, array.shape, array.dtype)
            for k, picture in enumerate(array):
                made[k] = picture
    return stream.getvalue()


def join_pictures(
    stream: BinaryIO,
    name: str,
    empty: np.ndarray,
    sources: Iterable[tuple[Path, str, Sequence[int]]],
    more: Mapping[str, np.ndarray],
) -> None:
    """A file with the pictures ``name`` that lie in others, (file, data set, rows) in their order, and ``more`` arrays.

    ``empty`` (0, ...) is what there is where no source has a row. Pictures are copied as they are packed, one at a time.
    """
    import h5py

    known = [(path, own, list(rows)) for path, own, rows in sources]
    count = sum(len(rows) for _, _, rows in known)
    with h5py.File(stream, "w", track_order=True) as file:
        made, at = _pictures(file, name, (count, *empty.shape[1:]), empty.dtype), 0
        for path, own, rows in known:
            with h5py.File(path, "r") as source:
                pictures = source[own]
                for row in rows:
                    place = (0,) * (pictures.ndim - 1)
                    mask, data = pictures.id.read_direct_chunk((row, *place))
                    made.id.write_direct_chunk((at, *place), data, mask)
                    at += 1
        for key, array in more.items():
            file.create_dataset(key, data=array, track_times=False)
