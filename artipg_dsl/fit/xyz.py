"""Clouds as text: a point a line, its normal and whatever else behind it."""

from __future__ import annotations

import re
from io import StringIO
from pathlib import Path

import numpy as np

from ..errors import UserError, plural

_COMMENTS = ("#", "//")
_NEARLY, _MOSTLY = 0.05, 0.95  # numbers are normals where so many are 1 long, but for so much


def read_table(path: Path) -> tuple[np.ndarray, np.ndarray | None, str]:
    """The points (n, 3) of a file, their normals (n, 3) if it has any, and what of it is left out, in words. Raises UserError."""
    text = path.read_text(encoding="utf-8-sig", errors="replace")
    mark = "," if "," in text else None
    try:
        table = np.loadtxt(StringIO(text), ndmin=2, comments=_COMMENTS, delimiter=mark)
    except ValueError:
        table = np.zeros((0, 0))
    if table.shape[1] < 3:
        raise UserError(
            f"{path.name}{_first_wrong(text, mark)}", "each line needs x y z of a point, as numbers, or x y z nx ny nz"
        )
    points, more = table[:, :3], table[:, 3:]
    if more.shape[1] < 3:
        return points, None, ""
    normals = next(filter(_are_normals, (more[:, :3], more[:, -3:])), None)
    return points, normals, "" if normals is not None else "the numbers behind x y z are no normals"  # but a colour


def _are_normals(three: np.ndarray) -> bool:
    length = np.sqrt((three**2).sum(axis=1))
    return bool((np.abs(length - 1.0) < _NEARLY).mean() > _MOSTLY)


def _first_wrong(text: str, mark: str | None) -> str:
    """Where a table of points goes wrong, and how; ``mark``: what stands between its numbers."""
    known = 0
    for number, line in enumerate(text.splitlines(), 1):
        line = re.split("|".join(_COMMENTS), line)[0].strip()
        words = line.split(mark)
        if not line:
            continue
        try:
            count = len([float(word) for word in words])
        except ValueError:
            return f", line {number}: `{line[:40]}` is not numbers"
        if count < 3 or count != (known or count):
            above = f", those above {known}" if known else ""
            return f", line {number}: `{line[:40]}` has {plural(count, 'number')}{above}"
        known = count
    return " has no points"
