"""HDF5 files: read back as arrays by name; rows in many files, put together in one without unpacking them."""

from __future__ import annotations

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, BinaryIO, TypeVar

import numpy as np

Row = TypeVar("Row")


def open_h5(path: Path) -> Any:
    """A file to read from. Raises OSError, which names it."""
    import h5py  # extra: HDF5 layouts alone need it

    if not path.exists():
        raise FileNotFoundError(f"{path} is missing")
    try:
        return h5py.File(path, "r")
    except OSError:
        raise OSError(f"{path} is no HDF5 file, or not a whole one") from None


def read_h5(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file, ``gt_points/0`` for one of a group."""
    import h5py

    found: dict[str, np.ndarray] = {}

    def keep(name: str, node: object) -> None:
        if isinstance(node, h5py.Dataset):
            found[name] = node[()]

    with open_h5(path) as file:
        file.visititems(keep)
    return found


def read_row(path: Path, row: int) -> dict[str, np.ndarray]:
    """What the arrays of a file have in one row."""
    with open_h5(path) as file:
        return {name: np.asarray(held[row]) for name, held in file.items() if row < len(held)}


def spread(rows: Sequence[Row], most: int) -> list[Sequence[Row]]:
    """Rows in as few groups of at most ``most`` as it takes, groups of one size, each with some of all that lie together."""
    count = -(-len(rows) // most)
    return [rows[k::count] for k in range(count)]


def _packed(file: Any, name: str, shape: Sequence[int], kind: np.dtype[Any]) -> Any:
    """A data set (n, ...) that is packed row by row, as loaders read it."""
    chunks = (1, *shape[1:]) if shape[0] else None
    packed = {"compression": "gzip", "compression_opts": 1, "shuffle": True} if shape[0] else {}
    return file.create_dataset(name, shape=tuple(shape), dtype=kind, chunks=chunks, track_times=False, **packed)


def rows_h5(arrays: Mapping[str, np.ndarray]) -> bytes:
    """A file of arrays (n, ...) by name, of which ``join_rows`` can take rows."""
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w", track_order=True) as file:
        for name, array in arrays.items():
            made = _packed(file, name, array.shape, array.dtype)
            for k, row in enumerate(array):
                made[k] = row
    return stream.getvalue()


def join_rows(
    stream: BinaryIO,
    sets: Mapping[str, tuple[str, np.ndarray]],
    sources: Sequence[tuple[Path, int]],
    more: Mapping[str, np.ndarray],
) -> None:
    """A file with rows that lie in others, (file, row) in their order, and ``more`` arrays.

    ``sets``: by name, what the array is called there, and (0, ...) of its shape and kind. Rows are copied as they are packed, one at
    a time.
    """
    import h5py

    places: dict[Path, list[tuple[int, int]]] = {}
    for at, (path, row) in enumerate(sources):
        places.setdefault(path, []).append((at, row))
    with h5py.File(stream, "w", track_order=True) as file:
        made = {
            name: _packed(file, name, (len(sources), *empty.shape[1:]), empty.dtype)
            for name, (_, empty) in sets.items()
        }
        for path, rows in places.items():
            with open_h5(path) as source:
                for name, (own, _) in sets.items():
                    held, rest = source[own], (0,) * (source[own].ndim - 1)
                    for at, row in rows:
                        mask, data = held.id.read_direct_chunk((row, *rest))
                        made[name].id.write_direct_chunk((at, *rest), data, mask)
        for key, array in more.items():
            file.create_dataset(key, data=array, track_times=False)
