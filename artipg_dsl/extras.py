"""Packages that some work alone needs: an extra of this one installs each of them."""

from __future__ import annotations

from importlib.util import find_spec
from typing import NamedTuple

from .errors import UserError


class Package(NamedTuple):
    """``module`` is what is imported, ``name`` what people call it, ``extra`` what installs it."""

    module: str
    name: str
    extra: str

    def missing(self, user: object) -> UserError:
        """What to raise where ``user`` needs it and it is not there."""
        return UserError(
            f"{user} needs {self.name}, which is not installed", f"pip install 'artipg_dsl[{self.extra}]' installs it"
        )

    def require(self, user: object) -> None:
        """Raise UserError where it is not installed."""
        if find_spec(self.module) is None:
            raise self.missing(user)


DASK = Package("distributed", "Dask", "cluster")
EMBREE = Package("embreex", "embreex", "rays")
FSSPEC = Package("fsspec", "fsspec", "remote")
H5PY = Package("h5py", "h5py", "hdf5")
MANIFOLD = Package("manifold3d", "manifold3d", "collide")
PYARROW = Package("pyarrow", "pyarrow", "parquet")
PYGLS = Package("pygls", "pygls", "editor")
SAPIEN = Package("sapien", "SAPIEN", "sim")
TORCH = Package("torch", "PyTorch", "torch")
ZARR = Package("zarr", "Zarr", "zarr")
