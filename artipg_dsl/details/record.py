"""Details as they are kept: where points of real surfaces are bound, and how far they lie off there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import UserError
from ..records import dataclass
from .elements import Elements

VERSION = 1
DIRECT, MIRRORED, TURNED, SHIFTED = range(4)


@dataclass(frozen=True, slots=True, eq=False)
class Details:
    """E bound points of D donors.

    ``element`` (E,) of the ``elements`` they are on, ``patch``, and fractions ``u``, ``v``. ``offset`` (E, 3) metres and ``facing`` (E, 3), the
    normal of the real surface, by their parts along the normal, the tangent and the second axis of the structure there (see
    ``geometry.frames``). ``label`` (E,) indexes ``labels``, the words of the file of each point, -1 for none. ``how`` (E,): 0 of a point
    of the cloud; of surface that was hidden, lent by a mirror image (1), a turn (2) or a shift (3) of the primitive. ``names`` of the
    donors, ``diagonal`` (D,) of their clouds.
    """

    elements: Elements
    element: np.ndarray
    patch: np.ndarray
    u: np.ndarray
    v: np.ndarray
    offset: np.ndarray
    facing: np.ndarray
    label: np.ndarray
    how: np.ndarray
    names: tuple[str, ...]
    labels: tuple[str, ...]
    diagonal: np.ndarray

    def __len__(self) -> int:
        return len(self.element)

    @property
    def owner(self) -> np.ndarray:
        """(E,) the donor of each point."""
        return self.elements.owner[self.element]

    def take(self, at: np.ndarray) -> Details:
        """Some of the points."""
        taken: dict[str, Any] = {name: getattr(self, name)[at] for name in _POINTS}
        return replace(self, **taken)

    def extended(self, columns: Mapping[str, np.ndarray]) -> Details:
        """These and further points of the same elements."""
        added: dict[str, Any] = {name: np.concatenate([getattr(self, name), columns[name]]) for name in _POINTS}
        return replace(self, **added)


_POINTS = {"element": np.int32, "patch": np.int16, "u": np.float32, "v": np.float32, "offset": np.float32}
_POINTS |= {"facing": np.float32, "label": np.int16, "how": np.uint8}
_TABLE = {"site": np.int32, "rank": np.int32, "params": np.float64, "rotation": np.float64}
_TABLE |= {"translation": np.float64, "mirror": np.float64}


def to_arrays(details: Details, program: str) -> dict[str, np.ndarray]:
    """The arrays of a file of one donor; ``program`` is the hash of its program."""
    elements = {f"element_{name}": getattr(details.elements, name).astype(kind) for name, kind in _TABLE.items()}
    return {
        "version": np.array([VERSION], dtype=np.int32),
        "program": np.array([program]),
        "name": np.array([details.names[0]]),
        "diagonal": details.diagonal.astype(np.float64),
        **{name: getattr(details, name).astype(kind) for name, kind in _POINTS.items()},
        "labels": np.array(details.labels, dtype=np.str_) if details.labels else np.zeros(0, dtype="<U1"),
        **elements,
    }


def of_arrays(held: Mapping[str, np.ndarray], place: str, program: str | None = None) -> Details:
    """The details of a file's arrays. Raises UserError where they are not such, or not of the program of that hash."""
    missing = [
        n
        for n in ("version", "program", "name", "diagonal", *_POINTS, "labels", *(f"element_{n}" for n in _TABLE))
        if n not in held
    ]
    if missing:
        raise UserError(
            f"{place} holds no bound details: it has no array `{missing[0]}`", "apgc bind writes such files"
        )
    version, made_for, name = (held[key].reshape(-1).tolist()[0] for key in ("version", "program", "name"))
    if version != VERSION:
        raise UserError(f"{place} is of version {version}, not {VERSION}", "bind the details again")
    if program is not None and made_for != program:
        raise _of_another(f"{place} is")
    table = {
        name: held[f"element_{name}"].astype(np.int64 if kind == np.int32 else kind) for name, kind in _TABLE.items()
    }
    points = {n: held[n].astype(np.float64 if kind == np.float32 else np.int64) for n, kind in _POINTS.items()}
    if not _belong_together(points, table, len(held["labels"])):
        raise UserError(f"{place} is damaged: its arrays do not belong together", "bind the details again")
    if not all(np.isfinite(points[name]).all() for name in ("u", "v", "offset", "facing")):
        raise UserError(f"{place} is damaged: it holds what is no number", "bind the details again")
    return Details(
        Elements(np.zeros(len(table["site"]), dtype=np.int64), **table),
        **points,
        names=(str(name),),
        labels=tuple(map(str, held["labels"])),
        diagonal=held["diagonal"].astype(np.float64),
    )


def _belong_together(points: Mapping[str, np.ndarray], table: Mapping[str, np.ndarray], labels: int) -> bool:
    """Whether the columns of points and of elements are as long as each other, and what indexes others lies in these."""
    count, many = len(table["site"]), len(points["element"])
    wide = {
        "offset": (3,),
        "facing": (3,),
        "rotation": (3, 3),
        "translation": (3,),
        "params": table["params"].shape[1:],
    }
    if not all(column.shape == (many, *wide.get(name, ())) for name, column in points.items()):
        return False
    if not all(column.shape == (count, *wide.get(name, ())) for name, column in table.items()):
        return False
    within = {"element": (0, count - 1), "label": (-1, labels - 1), "how": (DIRECT, SHIFTED), "u": (0, 1), "v": (0, 1)}
    return all(not ((points[n] < low) | (points[n] > high)).any() for n, (low, high) in within.items())


def join(several: Sequence[Details]) -> Details:
    """The details of several donors, in their order, as one."""
    elements, shift = several[0].elements, [0]
    words = list(dict.fromkeys(word for one in several for word in one.labels))
    donors = np.cumsum([0, *(len(one.names) for one in several)])
    for number, one in enumerate(several[1:], 1):
        shift.append(len(elements))
        moved = replace(one.elements, owner=one.elements.owner + donors[number])
        elements = elements.join(moved)
    columns = {
        name: np.concatenate([getattr(one, name) for one in several])
        for name in ("patch", "u", "v", "offset", "facing", "how")
    }
    element = np.concatenate([one.element + first for one, first in zip(several, shift, strict=True)])
    label = np.concatenate(
        [np.array([*(words.index(word) for word in one.labels), -1], dtype=np.int64)[one.label] for one in several]
    )
    return Details(
        elements,
        element,
        label=label,
        **columns,
        names=tuple(name for one in several for name in one.names),
        labels=tuple(words),
        diagonal=np.concatenate([one.diagonal for one in several]),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Donors:
    """The ``details`` of all donors of a ``category``, bound to the ``program`` of that hash, and the ``numbers`` (D,) of the fitted objects
    that these are."""

    category: str
    program: str
    details: Details
    numbers: np.ndarray

    @staticmethod
    def of(category: str, program: str, several: Sequence[tuple[int, Details]]) -> Donors:
        """Those of some files, each with the number of its object."""
        numbers = np.array([number for number, _ in several], dtype=np.int64)
        return Donors(category, program, join([details for _, details in several]), numbers)

    def require(self, program: str) -> None:
        """Raises UserError where they are not bound to the program of that hash."""
        if program != self.program:
            raise _of_another("the details are")


def _of_another(what: str) -> UserError:
    return UserError(f"{what} bound to another program, or to this one before it changed", "fit and bind again")
