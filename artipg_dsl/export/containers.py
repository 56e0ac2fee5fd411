"""What arrays of a shard are kept in: NumPy's npz, or HDF5, Zarr, Parquet. The bytes depend on the arrays alone.

Every container holds the same arrays, by name and in their order, with their types and shapes. Those of others than npz need a package
that is imported when it is used.
"""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

_STAMP = (1980, 1, 1, 0, 0, 0)  # zip has no "no date"
Arrays = dict[str, np.ndarray]
_FILLED = {"state": np.nan, "drivers": 0xFFFF, "velocities": 0.0}
"""Arrays with an axis as long as some object needs, and what stands there for the others."""


def join(parts: Sequence[Mapping[str, np.ndarray]]) -> Mapping[str, np.ndarray]:
    """The arrays of objects that were made in several parts, which follow one another along the first axis."""
    return parts[0] if len(parts) == 1 else {name: _joined(name, [part[name] for part in parts]) for name in parts[0]}


def _joined(name: str, arrays: list[np.ndarray]) -> np.ndarray:
    if name in _FILLED:
        size = np.max([array.shape for array in arrays], axis=0)
        arrays = [
            np.pad(
                a,
                [(0, 0), *((0, int(most) - own) for most, own in zip(size[1:], a.shape[1:], strict=True))],
                constant_values=_FILLED[name],
            )
            for a in arrays
        ]
    return np.concatenate(arrays)


def npz_bytes(arrays: Mapping[str, np.ndarray], *, pack: bool = False) -> bytes:
    """The arrays as an .npz, packed if asked for."""

    def members() -> Iterable[tuple[str, list[Any]]]:
        for name, array in arrays.items():
            head, plain = io.BytesIO(), np.asarray(array, order="C")
            np.lib.format.write_array_header_1_0(head, np.lib.format.header_data_from_array_1_0(plain))
            yield f"{name}.npy", [head.getvalue(), plain.reshape(-1).view(np.uint8).data]

    return _zip_bytes(members(), pack=pack)


def _zip_bytes(members: Iterable[tuple[str, list[Any]]], *, pack: bool = False) -> bytes:
    """A zip archive whose bytes depend on the names, order and contents of its members alone, which are told in pieces."""
    stream = io.BytesIO()
    method, level = (zipfile.ZIP_DEFLATED, 1) if pack else (zipfile.ZIP_STORED, None)
    with zipfile.ZipFile(stream, "w", method, compresslevel=level) as archive:
        for name, pieces in members:
            entry = zipfile.ZipInfo(name, _STAMP)
            entry.create_system, entry.external_attr, entry.compress_type = 3, 0o644 << 16, method
            if pack:
                archive.writestr(entry, b"".join(pieces), compresslevel=level)
                continue
            entry.file_size = sum(map(len, pieces))  # large arrays are written as they lie
            with archive.open(entry, "w") as file:
                for piece in pieces:
                    file.write(piece)
    return stream.getvalue()


def hdf5_bytes(arrays: Mapping[str, np.ndarray], *, pack: bool = False) -> bytes:
    """A data set per array."""
    import h5py

    stream = io.BytesIO()
    with h5py.File(stream, "w", track_order=True) as file:
        for name, array in arrays.items():
            packed = {"compression": "gzip", "compression_opts": 1} if pack and array.size else {}
            file.create_dataset(name, data=np.ascontiguousarray(array), track_times=False, **packed)
    return stream.getvalue()


def zarr_bytes(arrays: Mapping[str, np.ndarray], *, pack: bool = False) -> bytes:
    """A group with an array each, as one zip archive, which Zarr reads in place."""
    import zarr

    del pack  # Zarr packs as a rule
    found: dict[str, Any] = {}
    group = zarr.create_group(store=zarr.storage.MemoryStore(found), attributes={"order": list(arrays)})
    for name, array in arrays.items():
        chunks = tuple(max(1, n) for n in array.shape)
        group.create_array(name, data=np.ascontiguousarray(array), chunks=chunks)
    return _zip_bytes((name, [found[name].to_bytes()]) for name in sorted(found))


def parquet_bytes(arrays: Mapping[str, np.ndarray], *, pack: bool = False) -> bytes:
    """A column per array, a row per entry of their first axis: further axes are lists of fixed size.

    An array without entries in a further axis is a column of nulls. Type and shape of each are kept with its column.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    del pack
    fields, columns = [], []
    for name, array in arrays.items():
        column = pa.array(np.ascontiguousarray(array).reshape(-1)) if array.size or array.ndim == 1 else None
        for size in array.shape[:0:-1] if column is not None else ():
            column = pa.FixedSizeListArray.from_arrays(column, size)
        column = pa.nulls(len(array)) if column is None else column
        kept = {"dtype": array.dtype.str, "shape": json.dumps(array.shape[1:])}
        fields.append(pa.field(name, column.type, metadata=kept))
        columns.append(column)
    stream = io.BytesIO()
    pq.write_table(pa.table(columns, schema=pa.schema(fields)), stream, use_dictionary=False)
    return stream.getvalue()
