"""Point clouds in the binary form of PCD 0.7."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import UserError

_FIELDS = (
    "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
    "WIDTH {n}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {n}\nDATA binary\n"
)


def pcd_bytes(points: np.ndarray) -> bytes:
    """Points (n, 3)."""
    return _FIELDS.format(n=len(points)).encode() + np.ascontiguousarray(points, dtype="<f4").tobytes()


def read_pcd(path: Path) -> np.ndarray:
    """The points (n, 3) of a file that ``pcd_bytes`` has made. Raises UserError."""
    data = path.read_bytes()
    head, mark, body = data.partition(b"DATA binary\n")
    named = dict(line.split(" ", 1) for line in head.decode("ascii", "replace").splitlines() if " " in line)
    count = int(named.get("POINTS", "-1"))
    if not mark or named.get("FIELDS") != "x y z" or len(body) != 12 * count:
        raise UserError(f"{path} is not a binary PCD file of x y z", "write the folder again with --force")
    return np.frombuffer(body, dtype="<f4").reshape(-1, 3)
