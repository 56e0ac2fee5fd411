"""A folder of bound details, as objects of its program wear them."""

from __future__ import annotations

import io
import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import random
from ..arguments import read_amount, read_path
from ..errors import UserError
from ..files import read_arrays
from ..geometry import points as geometry
from ..geometry.nearest import Nearest
from ..geometry.pointset import PointSet
from ..records import dataclass
from .calm import calm
from .displace import displace
from .dressing import SUMMARY, Dressing
from .elements import Elements, Solids, elements_of
from .record import DIRECT, Details, Donors, of_arrays
from .skin import Grid
from .suits import Suits, borrowed_suits, origin, own_suits
from .trim import trim
from .wear import Wardrobe, Worn, wear

if TYPE_CHECKING:
    from ..geometry.sites import SiteTable
    from ..graph.program import Program
    from ..runtime.batch import Batch

_COMPARED = 1024  # points of a mutant and of its donor that tell how far they are apart
_APART = 100.0  # diagonals between objects that are compared together


def read_dressing(folder: str | Path, strength: float = 1.0) -> Dressing:
    """The details in a folder. Raises UserError, UsageError."""
    strength = read_amount("the strength of details", strength, 0.0, 1.0)
    _, mark = _summary(read_path("a folder of details", folder, '"bound"'))
    return Dressing(str(folder), mark, strength)


def _summary(folder: Path) -> tuple[dict[str, Any], str]:
    if not folder.is_dir():
        raise UserError(
            f"there is no folder {folder} of details",
            "apgc bind FITTED -o bound writes one; --details says where it is",
        )
    try:
        text = (folder / SUMMARY).read_bytes()
        found = json.loads(text)
        objects = [(one["object"], one["details"]) for one in found["objects"]]
        if not all(type(number) is int and isinstance(name, str) for number, name in objects):
            raise TypeError
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise UserError(f"{folder} is not a folder of details", "apgc bind FITTED -o bound writes one") from None
    if not objects:
        raise UserError(f"{folder} has no details: nothing in it could be bound", f"see {SUMMARY} for the reasons")
    return found, blake2b(text, digest_size=16).hexdigest()


@lru_cache(maxsize=4)
def _open(dressing: Dressing, program: str) -> Donors:
    """The details of all donors, of the program of that hash. Raises UserError."""
    if dressing.held is not None:
        dressing.held.require(program)
        return dressing.held
    folder = Path(dressing.folder)
    found, mark = _summary(folder)
    if mark != dressing.mark:
        raise UserError(
            f"the details in {folder} have changed since these objects wore them", "make them again, with --force"
        )
    donors = []
    for one in found["objects"]:
        path = folder / one["details"]
        try:
            held = read_arrays(io.BytesIO(path.read_bytes()))
            donors.append((int(one["object"]), of_arrays(held, str(path), program)))
        except (OSError, ValueError) as wrong:
            reason = getattr(wrong, "strerror", None) or wrong
            raise UserError(f"{path} cannot be read: {reason}", "bind the details again") from None
    return Donors.of(str(found.get("category")), program, donors)


def require_donors(dressing: Dressing, program: Program, numbers: np.ndarray | None = None) -> None:
    """Raises UserError where the details are not of objects of the program, or, but where they are borrowed, of none of the ``numbers``."""
    category = dressing.held.category if dressing.held else _summary(Path(dressing.folder))[0].get("category")
    if category != program.name:
        raise UserError(
            f"the details in {dressing.folder} are of objects of {category}, not of {program.name}",
            f"apgc fit {program.name} FILES -o fitted, then apgc bind fitted -o bound",
        )
    known = _open(dressing, program.hash).numbers
    if numbers is not None and not np.isin(known, numbers).any():
        raise UserError(f"none of the objects has details in {dressing.folder}", "bind the folder that is mutated")


def find_bare(dressing: Dressing, program: Program, numbers: np.ndarray) -> np.ndarray:
    """The objects of these numbers that have no details of their own. Raises UserError."""
    return np.setdiff1d(numbers, _open(dressing, program.hash).numbers)


def borrow(folder: str | Path, strength: float, program: Program) -> Dressing:
    """The details in a folder for any objects of the program to borrow. Raises UserError, UsageError."""
    dressing = replace(read_dressing(folder, strength), borrowed=True)
    require_donors(dressing, program)
    return dressing


@dataclass(frozen=True, eq=False)
class _Stock:
    """What the objects of a program wear; ``surface`` (m, 3), points of the real surfaces, and ``whose`` (m,) each is, ascending."""

    wardrobe: Wardrobe
    surface: np.ndarray
    whose: np.ndarray

    @cached_property
    def smooth(self) -> Wardrobe:
        """What their meshes wear."""
        return Wardrobe(calm(self.wardrobe), self.wardrobe.solids)


_stocks: dict[tuple[str, str, bool, str], _Stock] = {}  # of the last program: trees are built once


def _stock(batch: Batch, dressing: Dressing) -> _Stock:
    """What the objects of a batch wear."""
    key = dressing.folder, dressing.mark, dressing.borrowed, batch.program.hash
    if key not in _stocks:
        _stocks.clear()
        details, solids = _open(dressing, batch.program.hash).details, Solids.of(batch.sites())
        if not solids.have(details.elements, details.element, details.patch):
            raise UserError(
                f"the details in {dressing.folder} are damaged: {batch.program.name} has no such surfaces",
                "bind the details again",
            )
        worn = trim(details, solids) if dressing.borrowed else details
        _stocks[key] = _Stock(Wardrobe(worn, solids), *_surfaces(details, solids))
    return _stocks[key]


def _suits(batch: Batch, dressing: Dressing, details: Details) -> Suits:
    """Which details each element of a batch wears."""
    if dressing.borrowed:
        return borrowed_suits(batch, details)
    donor = _own_donors(batch, dressing)
    _require_bound_to(origin(batch), details.elements, donor, dressing)
    return own_suits(batch, details.elements, donor)


def _require_bound_to(originals: Batch, bound: Elements, donor: np.ndarray, dressing: Dressing) -> None:
    """Raises UserError where the details of an object's number were bound to an object of other parts or sizes."""
    own = elements_of(originals)
    found = bound.find(donor[own.owner], own.site, own.rank)
    width = min(own.params.shape[1], bound.params.shape[1])
    same = np.isclose(own.params[:, :width], bound.params[found, :width], rtol=1e-9, atol=1e-12, equal_nan=True)
    other = np.unique(own.owner[(donor[own.owner] >= 0) & ((found < 0) | ~same.all(axis=1))])
    if len(other):
        raise UserError(
            f"the details in {dressing.folder} were bound to another {originals.program.name}"
            f" {originals.numbers[other[0]]} than the one that is mutated",
            "bind the folder that is mutated: apgc bind FITTED -o bound",
        )


def _own_donors(batch: Batch, dressing: Dressing) -> np.ndarray:
    """The donor (B,) that is the object which each was made from, -1 for none."""
    numbers = _open(dressing, batch.program.hash).numbers
    before = origin(batch).numbers
    order = np.argsort(numbers, kind="stable")
    place = np.minimum(np.searchsorted(numbers[order], before), len(numbers) - 1)
    return np.where(numbers[order][place] == before, order[place], -1)


def dress(batch: Batch, points: PointSet, owner: np.ndarray, dressing: Dressing) -> Worn:
    """Points (P, n) of the objects ``owner`` (P,) in the details of their donors. Raises UserError."""
    wardrobe = _stock(batch, dressing).wardrobe
    return wear(batch, points, owner, wardrobe, _suits(batch, dressing, wardrobe.details), dressing.strength)


@dataclass(frozen=True, slots=True, eq=False)
class MeshDress:
    """What the meshes of a batch wear: of a wardrobe, by ``suits``, which name no element that has nothing to wear."""

    wardrobe: Wardrobe
    suits: Suits
    strength: float

    @staticmethod
    def of(wardrobe: Wardrobe, suits: Suits, strength: float) -> MeshDress:
        """Suits of which some may name elements that have no details."""
        held = np.bincount(wardrobe.details.element, minlength=len(wardrobe.details.elements)) > 0
        match = np.where((suits.match >= 0) & held[suits.match], suits.match, -1)
        return MeshDress(wardrobe, replace(suits, match=match), strength)

    def wears(self, table: SiteTable) -> np.ndarray:
        """(k,) which instances of a table of the batch wear details."""
        site = np.full(len(table.owner), table.number)
        return self.suits.match[self.suits.elements.find(table.owner, site, table.rank)] >= 0

    def displaced(self, grids: Sequence[Grid], scale: np.ndarray) -> list[np.ndarray]:
        """The vertices (k, V, 3) of meshes of the objects in details; ``scale`` (B,): the diagonals of the objects."""
        return displace(grids, self.wardrobe, self.suits, scale, self.strength)


def dress_meshes(batch: Batch, dressing: Dressing) -> MeshDress:
    """What the meshes of a batch wear. Raises UserError."""
    wardrobe = _stock(batch, dressing).smooth
    return MeshDress.of(wardrobe, _suits(batch, dressing, wardrobe.details), dressing.strength)


def origins(batch: Batch, bound: np.ndarray, dressing: Dressing) -> tuple[np.ndarray, np.ndarray]:
    """For points (P, n) what the file of the donor calls each, an index into the labels of all donors, -1 for none; and which wear what
    was completed by symmetries."""
    details = _stock(batch, dressing).wardrobe.details
    return np.where(bound >= 0, details.label[bound], -1), (bound >= 0) & (details.how[bound] != DIRECT)


def tell(batch: Batch, dressing: Dressing) -> list[dict[str, Any] | None]:
    """For each object the ``donor``, the ``distance`` of the two surfaces, both ways, in percent of the donor's diagonal, the share of the
    surface that is ``worn``, and the words of ``labels``; None where there is no donor. Where details are borrowed, ``donors`` is the share
    of the surface that wears each, and ``donor`` the one with the largest."""
    stock, every = _stock(batch, dressing), np.arange(len(batch))
    details = stock.wardrobe.details
    address = batch.numbers.astype(np.uint64)
    made = geometry.sample(
        batch.sites(), len(batch), _COMPARED, random.key(batch.seed, "compared"), address, outside=True
    )
    worn = dress(batch, made, every, dressing)
    shares = _shares(worn.bound, details)
    if dressing.borrowed:
        donor = np.where(shares.any(axis=1), np.argmax(shares, axis=1), -1)
    else:
        donor = _own_donors(batch, dressing)
    apart = _distances(worn.position, donor, stock)
    share = (worn.bound >= 0).mean(axis=1)
    told: list[dict[str, Any] | None] = []
    for one, x, y, each in zip(donor.tolist(), apart.tolist(), share.tolist(), shares, strict=True):
        if one < 0:
            told.append(None)
            continue
        entry: dict[str, Any] = {"donor": details.names[one], "distance": round(x, 4), "worn": round(y, 4)}
        if dressing.borrowed:
            entry["donors"] = {details.names[k]: round(float(each[k]), 4) for k in np.flatnonzero(each).tolist()}
        told.append(entry | {"labels": list(details.labels)})
    return told


def _shares(bound: np.ndarray, details: Details) -> np.ndarray:
    """(B, D) the share of the points (B, n) of each object that wear each donor."""
    objects, several = len(bound), len(details.names)
    cell = np.repeat(np.arange(objects), bound.shape[1])[bound.ravel() >= 0] * several
    cell += details.owner[bound.ravel()[bound.ravel() >= 0]]
    return np.bincount(cell, minlength=objects * several).reshape(objects, several) / bound.shape[1]


def _distances(worn: np.ndarray, donor: np.ndarray, stock: _Stock) -> np.ndarray:
    """(B,) how far points (B, n, 3) and the real surface of each one's donor lie apart, both ways, in percent of its diagonal."""
    details, every, many = stock.wardrobe.details, np.arange(len(worn)), worn.shape[1]
    real, whose = stock.surface, stock.whose
    scale = details.diagonal[donor]
    own = np.repeat(every, many)
    mine = worn.reshape(-1, 3) / scale[own, None]
    theirs = Nearest(real / details.diagonal[whose, None], whose, _APART)
    there = theirs.find(mine, donor[own])[0].reshape(len(worn), -1).mean(axis=1)
    first, count = np.searchsorted(whose, donor), np.bincount(whose, minlength=len(details.names))[donor]
    count = np.where(donor < 0, 0, count)
    asked = np.repeat(first, count) + np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    of = np.repeat(every, count)
    back = Nearest(mine, own, _APART).find(real[asked] / scale[of, None], of)[0] if len(of) else None
    total = np.bincount(of, back, minlength=len(worn))
    return np.asarray(100.0 * (there + total / np.maximum(count, 1)) / 2.0)


def _surfaces(details: Details, solids: Solids) -> tuple[np.ndarray, np.ndarray]:
    """Points of the real surfaces of the donors in the frames of their objects, and whose each is, ascending."""
    details = details.take(np.flatnonzero(details.how == DIRECT))
    elements, own = details.elements, details.owner
    rank = np.arange(len(own)) - np.searchsorted(own, own)
    many = np.bincount(own, minlength=len(details.names))[own]
    some = details.take(np.flatnonzero(rank * _COMPARED // many != (rank - 1) * _COMPARED // many))  # spread evenly
    frames = solids.frames(elements, some.element, some.patch, some.u, some.v)
    return elements.placed(some.element, frames.place + frames.out_of(some.offset)), some.owner
