"""HDF5 files read back, as arrays by name."""

from __future__ import annotations

from pathlib import Path

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
