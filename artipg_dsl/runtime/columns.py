"""How tables and sets of arrays show themselves: what they hold, not all of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from typing import Any

import numpy as np


class Columns:
    """A dataclass of arrays, lists and tables of these. Its text has a line for each: the shape and the type of an array."""

    __slots__ = ()

    def __repr__(self) -> str:
        told: dict[str, str] = {}
        for field in fields(self):  # type: ignore[arg-type]
            told |= _tell(field.name, getattr(self, field.name))
        width = max(map(len, told), default=0)
        return "\n".join([type(self).__name__, *(f"    {name:{width}}  {what}" for name, what in told.items())])


def _tell(name: str, value: Any) -> dict[str, str]:
    if isinstance(value, np.ndarray):
        return {name: f"{value.shape} {value.dtype}"}
    if isinstance(value, Mapping) and value:
        return {key: what for inner, held in value.items() for key, what in _tell(f"{name}[{inner!r}]", held).items()}
    if isinstance(value, list | tuple | Mapping):
        return {name: f"{type(value).__name__} of {len(value)}"}
    return {name: repr(value)}
