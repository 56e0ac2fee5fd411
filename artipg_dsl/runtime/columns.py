"""Tables and sets of arrays: how they show what they hold, and how they are handed out to be read alone."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from dataclasses import fields
from typing import Any, TypeVar

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


Table = TypeVar("Table")


def read_only(table: Table) -> Table:
    """The same columns of a dataclass, of which arrays cannot be written to and lists are copies: a table that others read, too."""
    found = copy(table)
    for name in (field.name for field in fields(table)):  # type: ignore[arg-type]
        value = getattr(table, name)
        if isinstance(value, np.ndarray):
            value = value.view()
            value.flags.writeable = False
        elif isinstance(value, list):
            value = list(value)
        object.__setattr__(found, name, value)
    return found


def _tell(name: str, value: Any) -> dict[str, str]:
    if isinstance(value, np.ndarray):
        return {name: f"{value.shape} {value.dtype}"}
    if isinstance(value, Mapping) and value:
        return {key: what for inner, held in value.items() for key, what in _tell(f"{name}[{inner!r}]", held).items()}
    if isinstance(value, list | tuple | Mapping):
        return {name: f"{type(value).__name__} of {len(value)}"}
    return {name: repr(value)}
