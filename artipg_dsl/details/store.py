"""A folder of bound details, as objects of its program wear them."""

from __future__ import annotations

import io
import json
import zipfile
from functools import lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .. import random
from ..errors import UsageError, UserError
from ..geometry import points as geometry
from ..geometry.nearest import Nearest
from ..geometry.pointset import PointSet
from .dressing import Dressing
from .elements import Solids
from .record import Details, join, of_arrays
from .wear import Wardrobe, Worn, wear

if TYPE_CHECKING:
    from ..runtime.batch import Batch

SUMMARY = "bind.json"
_COMPARED = 1024  # points of a mutant and of its donor that tell how far they are apart
_APART = 100.0  # diagonals between objects that are compared together


def read_dressing(folder: str | Path, strength: float = 1.0) -> Dressing:
    """The details in a folder. Raises UserError, UsageError."""
    if not 0.0 <= strength <= 1.0:
        raise UsageError(f"the strength of details is {strength}", "give a number from 0 (the structure) to 1")
    _, mark = _summary(Path(folder))
    return Dressing(str(folder), mark, float(strength))


def _summary(folder: Path) -> tuple[dict[str, Any], str]:
    try:
        text = (folder / SUMMARY).read_bytes()
        found = json.loads(text)
        objects = [(one["object"], one["details"]) for one in found["objects"]]
    except (OSError, ValueError, KeyError, TypeError):
        raise UserError(f"{folder} is not a folder of details", "apgc bind FITTED -o bound writes one") from None
    if not objects:
        raise UserError(f"{folder} has no details: nothing in it could be bound", f"see {SUMMARY} for the reasons")
    return found, blake2b(text, digest_size=16).hexdigest()


@lru_cache(maxsize=4)
def _open(dressing: Dressing, program: str) -> tuple[Details, np.ndarray]:
    """The details of all donors, and the number of the fitted object of each. Raises UserError."""
    folder = Path(dressing.folder)
    found, mark = _summary(folder)
    if mark != dressing.mark:
        raise UserError(
            f"the details in {folder} have changed since these objects wore them", "mutate again, with --force"
        )
    donors, numbers = [], []
    for one in found["objects"]:
        path = folder / one["details"]
        try:
            with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as held:
                donors.append(of_arrays(dict(held), str(path), program))
        except (OSError, ValueError, zipfile.BadZipFile) as wrong:
            raise UserError(f"{path} cannot be read: {wrong}", "bind the details again") from None
        numbers.append(int(one["object"]))
    return join(donors), np.array(numbers, dtype=np.int64)


def require_donors(dressing: Dressing, program: str, numbers: np.ndarray) -> None:
    """Raises UserError where no object of the numbers, of the program of that hash, has details."""
    if not np.isin(_open(dressing, program)[1], numbers).any():
        raise UserError(f"none of the objects has details in {dressing.folder}", "bind the folder that is mutated")


_wardrobes: dict[tuple[Dressing, str], Wardrobe] = {}  # of the last program: trees are built once


def _wardrobe(batch: Batch, dressing: Dressing) -> tuple[Wardrobe, np.ndarray]:
    """What the objects of a batch wear, and the donor (B,) of each: that of the object which it was made from, -1 for none."""
    details, numbers = _open(dressing, batch.program.hash)
    key = dressing, batch.program.hash
    if key not in _wardrobes:
        _wardrobes.clear()
        _wardrobes[key] = Wardrobe(details, Solids.of(batch.sites()))
    before = batch.history[0].before if batch.history else batch
    order = np.argsort(numbers, kind="stable")
    place = np.minimum(np.searchsorted(numbers[order], before.numbers), len(numbers) - 1)
    return _wardrobes[key], np.where(numbers[order][place] == before.numbers, order[place], -1)


def dress(batch: Batch, points: PointSet, owner: np.ndarray, dressing: Dressing) -> Worn:
    """Points (P, n) of the objects ``owner`` (P,) in the details of their originals. Raises UserError."""
    wardrobe, donor = _wardrobe(batch, dressing)
    return wear(batch, points, owner, wardrobe, donor, dressing.strength)


def real_labels(batch: Batch, bound: np.ndarray, dressing: Dressing) -> np.ndarray:
    """(P, n) what the file of the donor calls each point, an index into the labels of all donors; -1 for none."""
    details = _open(dressing, batch.program.hash)[0]
    return np.where(bound >= 0, details.label[bound], -1)


def tell(batch: Batch, dressing: Dressing) -> list[dict[str, Any] | None]:
    """For each object the ``donor``, the ``distance`` of the two surfaces, both ways, in percent of the donor's diagonal, the share of the
    surface that is ``worn``, and the words of ``labels``; None where there is no donor."""
    wardrobe, donor = _wardrobe(batch, dressing)
    details, every = wardrobe.details, np.arange(len(batch))
    address = batch.numbers.astype(np.uint64)
    made = geometry.sample(
        batch.sites(), len(batch), _COMPARED, random.key(batch.seed, "compared"), address, outside=True
    )
    worn = wear(batch, made, every, wardrobe, donor, dressing.strength)
    real, whose = _surfaces(wardrobe)
    scale = details.diagonal[donor]
    own = np.repeat(every, _COMPARED)
    mine = worn.position.reshape(-1, 3) / scale[own, None]
    theirs = Nearest(real / details.diagonal[whose, None], whose, _APART)
    there = theirs.find(mine, donor[own])[0].reshape(len(batch), -1).mean(axis=1)
    first, count = np.searchsorted(whose, donor), np.bincount(whose, minlength=len(details.names))[donor]
    count = np.where(donor < 0, 0, count)
    asked = np.repeat(first, count) + np.arange(int(count.sum())) - np.repeat(np.cumsum(count) - count, count)
    of = np.repeat(every, count)
    back = Nearest(mine, own, _APART).find(real[asked] / scale[of, None], of)[0] if len(of) else None
    total = np.bincount(of, back, minlength=len(batch))
    apart = 100.0 * (there + total / np.maximum(count, 1)) / 2.0
    share = (worn.bound >= 0).mean(axis=1)
    return [
        None
        if one < 0
        else {"donor": details.names[one], "distance": round(x, 4), "worn": round(y, 4), "labels": list(details.labels)}
        for one, x, y in zip(donor.tolist(), apart.tolist(), share.tolist(), strict=True)
    ]


def _surfaces(wardrobe: Wardrobe) -> tuple[np.ndarray, np.ndarray]:
    """Points of the real surfaces of the donors in the frames of their objects, and whose each is, ascending."""
    details, elements = wardrobe.details, wardrobe.details.elements
    own = details.owner
    rank = np.arange(len(own)) - np.searchsorted(own, own)
    many = np.bincount(own, minlength=len(details.names))[own]
    at = np.flatnonzero(rank * _COMPARED // many != (rank - 1) * _COMPARED // many)  # spread evenly
    element = details.element[at]
    local = wardrobe.frames.place[at] + wardrobe.frames.out_of(details.offset)[at]
    return elements.placed(element, local), own[at]
