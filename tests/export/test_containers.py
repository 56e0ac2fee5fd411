"""The arrays of a shard are the same in every container, read back by the libraries that others wrote."""

from __future__ import annotations

import io
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from artipg_dsl.annotate.cameras import Cameras
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.annotate.states import read_states
from artipg_dsl.errors import UserError
from artipg_dsl.export.content import Content
from artipg_dsl.export.registry import FORMATS, OTHERS, find_formats
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session

CONTENT = Content(Sampling(40), read_states("rest,open"), True, Cameras(count=2, width=24, height=18, points=30))


def read_npz(data: bytes) -> dict[str, np.ndarray]:
    with np.load(io.BytesIO(data)) as found:
        return dict(found)


def read_hdf5(data: bytes) -> dict[str, np.ndarray]:
    h5py = pytest.importorskip("h5py")
    with h5py.File(io.BytesIO(data)) as found:
        return {name: found[name][()] for name in found}


def read_zarr(data: bytes, folder: Path) -> dict[str, np.ndarray]:
    zarr = pytest.importorskip("zarr")
    (folder / "shard.zarr.zip").write_bytes(data)
    with zarr.storage.ZipStore(folder / "shard.zarr.zip", mode="r") as store:
        found = zarr.open_group(store, mode="r")
        return {name: found[name][...] for name in found.attrs["order"]}


def read_parquet(data: bytes) -> dict[str, np.ndarray]:
    found = pytest.importorskip("pyarrow.parquet").read_table(io.BytesIO(data))

    def array(field: Any) -> np.ndarray:
        shape, column = json.loads(field.metadata[b"shape"]), found[field.name].combine_chunks()
        for _ in shape if 0 not in shape else ():
            column = column.flatten()
        kind = np.dtype(field.metadata[b"dtype"].decode())
        values = np.zeros(0) if 0 in shape else column.to_numpy(zero_copy_only=False)
        return values.reshape(len(found), *shape).astype(kind)

    return {field.name: array(field) for field in found.schema}


@cache
def plainly(kind: str) -> tuple[Batch, dict[str, np.ndarray]]:
    """Three laptops, and the arrays of their NumPy file."""
    batch = Session.of("Laptop").sampler.batch(np.arange(3), 5)
    return batch, read_npz(FORMATS[kind].shard_bytes(batch, CONTENT))


@pytest.mark.parametrize("container", OTHERS)
@pytest.mark.parametrize("kind", ["points", "views", "correspondence"])
def test_every_container_holds_the_same_arrays(tmp_path: Path, container: str, kind: str) -> None:
    pytest.importorskip(OTHERS[container].needs[0])  # type: ignore[index]
    batch, plain = plainly(kind)
    data = FORMATS[f"{kind}.{container}"].shard_bytes(batch, CONTENT)
    assert data == FORMATS[f"{kind}.{container}"].shard_bytes(batch, CONTENT)
    readers = {"hdf5": read_hdf5, "parquet": read_parquet, "zarr": lambda data: read_zarr(data, tmp_path)}
    found = readers[container](data)
    assert list(found) == list(plain)
    for name, array in plain.items():
        assert found[name].dtype == array.dtype and found[name].shape == array.shape, name
        assert found[name].tobytes() == array.tobytes(), name


def test_arrays_without_entries_are_kept(tmp_path: Path) -> None:
    arrays = {"a": np.zeros((3, 4, 0), dtype=np.uint16), "b": np.zeros((0, 2), dtype=np.float32), "c": np.arange(2) > 0}
    from artipg_dsl.export import containers

    for found in (read_hdf5(containers.hdf5_bytes(arrays)), read_zarr(containers.zarr_bytes(arrays), tmp_path)):
        assert {n: (a.shape, a.dtype) for n, a in found.items()} == {n: (a.shape, a.dtype) for n, a in arrays.items()}


def test_parts_are_joined_to_what_is_made_at_once() -> None:
    sampler = Session.of("Laptop").sampler
    for name in ("points", "views", "annotation", "correspondence"):
        entry = FORMATS[name]
        parts = [entry.part(sampler.batch(np.arange(*ends), 5), CONTENT) for ends in ((0, 2), (2, 3))]
        assert entry.joined(parts) == entry.shard_bytes(sampler.batch(np.arange(3), 5), CONTENT)


def test_a_container_alone_is_that_of_points() -> None:
    assert [entry.name for entry in find_formats("hdf5,annotation")] == ["points.hdf5", "annotation"]


def test_a_container_whose_package_is_missing_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("artipg_dsl.extras.find_spec", lambda name: None)
    with pytest.raises(UserError, match="points.zarr needs Zarr") as caught:
        find_formats("points.zarr")
    assert "artipg_dsl[zarr]" in caught.value.hint
