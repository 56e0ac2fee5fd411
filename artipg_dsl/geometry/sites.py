"""The instances of one primitive site of a program, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from ..graph.primitive import Primitive
from ..records import dataclass
from . import pieces as convex
from .box import bounds, turn_boxes
from .quadrature import volume_inertia

_COLUMNS = ("owner", "rotation", "translation", "mirror", "link", "instance", "semantic", "rank")


@dataclass(frozen=True, eq=False)
class SiteTable:
    """All instances of one site in a batch, k rows sorted by ``owner`` and then ``rank``.

    A local point (x, y, z) of row r lies at ``rotation[r] @ (x, mirror[r] * y, z) + translation[r]`` of its object.
    """

    number: int  # of the site in the program
    path: str
    primitive: Primitive
    params: dict[str, np.ndarray]  # (k,) float64 each; where a primitive has none, a column "" of zeros
    owner: np.ndarray  # (k,) int64 object index within the batch, ascending
    rotation: np.ndarray  # (k, 3, 3) proper
    translation: np.ndarray  # (k, 3) metres
    mirror: np.ndarray  # (k,) +1.0 or -1.0
    link: np.ndarray  # (k,) int64 link instance number within its object
    instance: np.ndarray  # (k,) int64 part instance number within its object
    semantic: np.ndarray  # (k,) int64 semantic id of the whole site
    rank: np.ndarray  # (k,) int64 rank of the row among the rows of this site in its object

    def __len__(self) -> int:
        return len(self.owner)

    def take(self, at: np.ndarray) -> SiteTable:
        """Some of the rows, ascending."""
        params = {name: value[at] for name, value in self.params.items()}
        return replace(self, params=params, **{name: getattr(self, name)[at] for name in _COLUMNS})

    def singles(self) -> Sequence[SiteTable]:
        """The tables of single sites whose rows it has."""
        return (self,)

    @cached_property
    def site(self) -> np.ndarray:
        """(k,) the number of the site of each row."""
        return np.repeat([table.number for table in self.singles()], [len(table) for table in self.singles()])

    @cached_property
    def row(self) -> np.ndarray:
        """(k,) which row of its site each is."""
        return np.concatenate([np.arange(len(table)) for table in self.singles()])

    @cached_property
    def clouds(self) -> list[convex.Cloud]:
        """The points of the convex pieces, before their faces are looked for."""
        return convex.clouds(self.primitive, self.params) if len(self) else []

    @cached_property
    def moments(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Volume (k,) m3, centre (k, 3) m and inertia about it per unit density (k, 3, 3) m5 of the rows, in their own frames."""
        return volume_inertia(self.primitive, self.params)

    def boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Low and high corners (k, 3) of boxes along the axes of the object that hold those of the rows."""
        low, high = bounds(self.primitive, self.params)
        turned = self.mirror < 0
        low[turned, 1], high[turned, 1] = -high[turned, 1], -low[turned, 1]
        return turn_boxes(self.rotation, self.translation, low, high)

    @property
    def weights(self) -> tuple[np.ndarray, np.ndarray]:
        """Volume and centre alone."""
        return self.moments[:2] if "moments" in self.__dict__ else self._weights

    @cached_property
    def _weights(self) -> tuple[np.ndarray, np.ndarray]:
        return volume_inertia(self.primitive, self.params, inertia=False)[:2]


@dataclass(frozen=True, eq=False)
class _JoinedTable(SiteTable):
    """The rows of all sites of one primitive, one site after the other; ``number`` and ``path`` are those of the first. What is made of
    shapes is made of these at once."""

    tables: tuple[SiteTable, ...]

    def singles(self) -> Sequence[SiteTable]:
        return self.tables

    @cached_property
    def clouds(self) -> list[convex.Cloud]:
        """Of all rows; those that single tables have are not made again."""
        if all("clouds" in table.__dict__ for table in self.tables):
            starts = np.cumsum([0, *(len(table) for table in self.tables[:-1])]).tolist()
            return convex.join_clouds([table.clouds for table in self.tables], starts)
        return convex.clouds(self.primitive, self.params)


def join_tables(tables: list[SiteTable]) -> list[SiteTable]:
    """The tables with rows, those of one primitive as one."""
    found: list[SiteTable] = []
    for group, params in _of_one_primitive(tables):
        joined = {name: np.concatenate([getattr(table, name) for table in group]) for name in _COLUMNS}
        found.append(
            _JoinedTable(group[0].number, group[0].path, group[0].primitive, params, **joined, tables=tuple(group))
            if len(group) > 1
            else group[0]
        )
    return found


def object_boxes(tables: list[SiteTable], count: int) -> tuple[np.ndarray, np.ndarray]:
    """Low and high corners (count, 3) of the boxes around objects, of those of their primitives; inf and -inf where there are none."""
    return _boxes_around(tables, [table.owner for table in tables], count)


def boxes_of_links(tables: list[SiteTable], first: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The same of links, at joint values 0; ``first`` (B,) is the row of the first link of each object."""
    return _boxes_around(tables, [first[table.owner] + table.link for table in tables], count)


def _boxes_around(tables: list[SiteTable], rows: list[np.ndarray], count: int) -> tuple[np.ndarray, np.ndarray]:
    low, high = np.full((count, 3), np.inf), np.full((count, 3), -np.inf)
    for table, row in zip(tables, rows, strict=True):
        if not len(table):
            continue
        first, last = table.boxes()
        np.minimum.at(low, row, first)
        np.maximum.at(high, row, last)
    return low, high


def weigh(tables: list[SiteTable], inertia: bool = True) -> None:
    """Work out the moments of tables that lack them, or volumes and centres alone: all rows of one primitive together."""
    name = "moments" if inertia else "_weights"
    for group, params in _of_one_primitive(
        [table for table in tables if not {"moments", name} & table.__dict__.keys()]
    ):
        chosen, same = _distinct(params)
        found = volume_inertia(group[0].primitive, {key: column[chosen] for key, column in params.items()}, inertia)
        start = 0
        for table in group:
            part = same[start : start + len(table)]
            start += len(table)
            table.__dict__[name] = tuple(column[part] for column in found[: 3 if inertia else 2])


def scatter(tables: list[SiteTable]) -> None:
    """Work out the clouds of tables that lack them, likewise."""
    for group, params in _of_one_primitive([table for table in tables if "clouds" not in table.__dict__]):
        found, start = convex.clouds(group[0].primitive, params), 0
        for table in group:
            own = [np.flatnonzero((cloud.rows >= start) & (cloud.rows < start + len(table))) for cloud in found]
            table.__dict__["clouds"] = [cloud.at(at, start) for cloud, at in zip(found, own, strict=True) if len(at)]
            start += len(table)


def _distinct(params: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """One row of each set of alike rows, as the keys of a keyboard are, and for each row (k,) which of these it is like."""
    columns = np.stack([np.asarray(column, dtype=np.float64) for column in params.values()], axis=1)
    rows = columns.view(f"V{columns.itemsize * columns.shape[1]}").ravel()
    _, chosen, same = np.unique(rows, return_index=True, return_inverse=True)
    return chosen, same


def _of_one_primitive(tables: list[SiteTable]) -> list[tuple[list[SiteTable], dict[str, np.ndarray]]]:
    """The tables with rows, in groups, and the parameters of each group, one table after the other."""
    alike: dict[int, list[SiteTable]] = {}
    for table in tables:
        if len(table):
            alike.setdefault(id(table.primitive), []).append(table)
    return [
        (group, {name: np.concatenate([table.params[name] for table in group]) for name in group[0].params})
        for group in alike.values()
    ]
