"""The elementary primitives of fitted objects, as tables: what details are bound to."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.box import bounds
from ..geometry.frames import Frames, frames_at
from ..geometry.patches import surfaces
from ..geometry.sites import SiteTable
from ..records import dataclass

if TYPE_CHECKING:
    from ..graph.primitive import Primitive
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True, eq=False)
class Elements:
    """N elementary primitives, sorted by ``owner`` (the object), ``site``, ``rank``. ``params`` (N, p): their parameters in the order of
    the primitive's, nan beyond these. A local point (x, y, z) lies at ``rotation @ (x, mirror * y, z) + translation`` of the object."""

    owner: np.ndarray
    site: np.ndarray
    rank: np.ndarray
    params: np.ndarray
    rotation: np.ndarray
    translation: np.ndarray
    mirror: np.ndarray

    def __len__(self) -> int:
        return len(self.owner)

    def placed(self, element: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Points (m, 3) in the own frames of elements, in those of their objects."""
        return self.turned(element, points) + self.translation[element]

    def turned(self, element: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        """The same for vectors."""
        columns = np.ascontiguousarray(self.rotation.reshape(-1, 9).T)
        x, z = (np.ascontiguousarray(vectors[:, k]) for k in (0, 2))
        y, out = vectors[:, 1] * self.mirror[element], np.empty(vectors.shape)
        for k in range(3):  # column by column: no matrix is gathered for each vector
            a, b, c = (columns[3 * k + j][element] for j in range(3))
            out[:, k] = a * x + b * y + c * z
        return out

    def local(self, element: np.ndarray, vectors: np.ndarray) -> np.ndarray:
        """Vectors (m, 3) of objects in the own frames of elements."""
        matrix = self.rotation[element]
        cells = [
            matrix[:, 0, k] * vectors[:, 0] + matrix[:, 1, k] * vectors[:, 1] + matrix[:, 2, k] * vectors[:, 2]
            for k in range(3)
        ]
        cells[1] = cells[1] * self.mirror[element]
        return np.stack(cells, axis=-1)

    def find(self, owner: np.ndarray, site: np.ndarray, rank: np.ndarray) -> np.ndarray:
        """The element of each triple (m,), -1 where there is none."""
        if not len(self):
            return np.full(len(owner), -1)
        sites = int(max(self.site.max(), site.max(initial=0))) + 1
        ranks = int(max(self.rank.max(), rank.max(initial=0))) + 1
        have, asked = (
            (o.astype(np.int64) * sites + s) * ranks + r
            for o, s, r in ((self.owner, self.site, self.rank), (owner, site, rank))
        )
        place = np.minimum(np.searchsorted(have, asked), len(have) - 1)
        return np.where((have[place] == asked) & (owner >= 0) & (site >= 0) & (rank >= 0), place, -1)

    def join(self, others: Elements) -> Elements:
        """Those of further objects, whose numbers follow."""
        width = max(self.params.shape[1], others.params.shape[1])

        def wide(params: np.ndarray) -> np.ndarray:
            return np.pad(params, [(0, 0), (0, width - params.shape[1])], constant_values=np.nan)

        names = ("owner", "site", "rank", "params", "rotation", "translation", "mirror")
        pairs = (
            (wide(a), wide(b)) if n == "params" else (a, b)
            for n in names
            for a, b in [(getattr(self, n), getattr(others, n))]
        )
        return Elements(*(np.concatenate(pair) for pair in pairs))


@dataclass(frozen=True, slots=True, eq=False)
class Solids:
    """What the elements of a program are made of: ``primitive`` of each site, by its number."""

    primitives: tuple[Primitive, ...]

    @staticmethod
    def of(tables: list[SiteTable]) -> Solids:
        return Solids(tuple(table.primitive for table in tables))

    def kind(self, site: np.ndarray) -> np.ndarray:
        """(m,) which primitive a site is of: the number of the first site that is of it."""
        first: dict[int, int] = {}
        numbers = [first.setdefault(id(primitive), k) for k, primitive in enumerate(self.primitives)]
        return np.array([*numbers, -1])[site]

    def have(self, elements: Elements, element: np.ndarray, patch: np.ndarray) -> bool:
        """Whether these are patches that the elements have."""
        counts = np.array([len(surfaces(primitive)) for primitive in self.primitives])
        known = (elements.site >= 0) & (elements.site < len(counts))
        return bool(known.all() and ((patch >= 0) & (patch < counts[elements.site][element])).all())

    def params(self, elements: Elements, number: int, at: np.ndarray) -> Mapping[str, np.ndarray]:
        """The parameters of the elements ``at``, which are of the primitive of that number, by name."""
        names = self.primitives[number].parameters
        return {name: elements.params[at, k] for k, name in enumerate(names)} or {"": np.zeros(len(at))}

    def frames(
        self, elements: Elements, element: np.ndarray, patch: np.ndarray, u: np.ndarray, v: np.ndarray
    ) -> Frames:
        """The frames of the surface at m points of elements."""
        kind = self.kind(elements.site)
        place = np.empty(len(elements), dtype=np.int64)
        stock = []
        for number in np.unique(kind).tolist():
            at = np.flatnonzero(kind == number)
            place[at] = np.arange(len(at))
            stock.append((self.primitives[number], dict(self.params(elements, number, at))))
        which = np.searchsorted(np.unique(kind), kind)
        return frames_at(stock, which[element], place[element], patch, u, v)

    def boxes(self, elements: Elements) -> tuple[np.ndarray, np.ndarray]:
        """Low and high corners (N, 3) of elements in their own frames."""
        low, high = np.empty((len(elements), 3)), np.empty((len(elements), 3))
        kind = self.kind(elements.site)
        for number in np.unique(kind).tolist():
            at = np.flatnonzero(kind == number)
            low[at], high[at] = bounds(self.primitives[number], dict(self.params(elements, number, at)))
        return low, high


def elements_of(batch: Batch) -> Elements:
    """All elementary primitives of the objects of a batch."""
    tables = batch.sites()
    most = max((len(table.primitive.parameters) for table in tables), default=0)
    columns: list[list[np.ndarray]] = [[] for _ in range(7)]
    for table in tables:
        params = np.full((len(table), most), np.nan)
        for k, name in enumerate(table.primitive.parameters):
            params[:, k] = table.params[name]
        told = (
            table.owner,
            np.full(len(table), table.number),
            table.rank,
            params,
            table.rotation,
            table.translation,
            table.mirror,
        )
        for column, values in zip(columns, told, strict=True):
            column.append(values)
    made = [np.concatenate(column) for column in columns]
    order = np.lexsort((made[2], made[1], made[0]))
    return Elements(*(column[order] for column in made))
