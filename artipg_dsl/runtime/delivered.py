"""The last check before objects are handed out: that what they are made of are numbers.

The requirements of a program see to it (``lower.legal``); a compiled file that somebody has edited may lack them.
"""

from __future__ import annotations

import numpy as np

from ..errors import UserError
from .batch import Batch

COLUMNS = {
    "parts": ("rotation", "translation", "low", "high"),
    "joints": ("origin", "axis", "rest", "multiplier", "offset"),
    "links": ("rotation", "translation"),
}


def refuse_nan(batch: Batch) -> None:
    """Raise UserError where a table of a batch holds what is no finite number."""
    for table, columns in COLUMNS.items():
        rows = getattr(batch, table)()
        for column in columns:
            _finite(batch, rows.owner, getattr(rows, column), f"the {column} of a {table[:-1]}")
    for site in batch.sites():
        for name, values in (*site.params.items(), ("place", site.translation), ("direction", site.rotation)):
            _finite(batch, site.owner, values, f"the {name} of `{site.path}`")


def _finite(batch: Batch, owner: np.ndarray, values: np.ndarray, what: str) -> None:
    bad = ~np.isfinite(values)
    if bad.any():
        first = np.flatnonzero(bad.reshape(len(bad), -1).any(axis=1))[0]
        raise UserError(
            f"{batch.program.name}: {what} of object {batch.numbers[owner[first]]} is no number",
            "the compiled program asks for less than its text does: compile it again",
        )
