"""Details of fitted objects in memory, and which details objects wear."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from functools import cached_property, partial
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..arguments import read_flag, read_path, read_whole
from ..errors import UsageError, UserError
from ..export.remote import Remote, place_of

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..details.placed import BoundPoints
    from ..details.record import Details, Donors
    from ..graph.program import Program
    from ..run.binding import Arrays
    from ..run.job import Job

Worn: TypeAlias = "str | Path | Bound | None"  # a folder that `apgc bind` has written, or details that are at hand


class Bound:
    """The surfaces of real objects as details of the objects that were fitted to them: what ``apgc bind`` writes, in memory.

    Objects wear them where ``details`` are taken: ``mutants.points(2048, details=bound)``. Made by ``bind`` of fitted objects.
    """

    def __init__(
        self,
        job: Job,
        told: dict[str, Any],
        bound: Sequence[tuple[dict[str, Any], Arrays | None]],
        folder: Path | None = None,
    ):
        self.job, self._told, self._bound = job, told, bound
        self._arrays = {record["object"]: arrays for record, arrays in bound if arrays is not None}
        self.folder = folder  # where they are saved

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        count = "1 object" if len(self) == 1 else f"{len(self)} objects"
        return f"<{self.job.program.name}: details of {count}>"

    @property
    def numbers(self) -> np.ndarray:
        """The numbers (D,) int64 of the fitted objects whose details these are, ascending."""
        return np.array(sorted(self._arrays), dtype=np.int64)

    @property
    def summary(self) -> dict[str, Any]:
        """What ``bind.json`` says: the objects with their figures, and ``failed`` with the reasons."""
        return deepcopy(self._told)

    def arrays(self, number: int) -> dict[str, np.ndarray]:
        """The bound points of the object of this number, as in its ``.npz``. Raises UserError."""
        return {name: array.copy() for name, array in self._arrays[self._known(number)].items()}

    def points(self, number: int) -> BoundPoints:
        """The bound points of the object of this number in its frame, with the labels of the original. Raises UserError."""
        from ..details.elements import Solids
        from ..details.placed import place

        known = self._known(number)
        return place(self._details[known], Solids.of(self.job.batch([known]).sites()))

    def save(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the folder that ``apgc bind`` writes; other details that are there are replaced only with ``force``. Raises UserError."""
        from ..run.bindings import save_bindings

        out, force = read_path("a folder", folder, '"bound"'), read_flag("force", force)
        save_bindings(out, self._told, self._bound, force=force)
        self.folder = out
        return out

    def _known(self, number: int) -> int:
        if read_whole("number", number, 0) in self._arrays:
            return int(number)
        raise UserError(
            f"there are no details of object {number}",
            f"there are those of {', '.join(map(str, self.numbers.tolist()))}",
        )

    @cached_property
    def _details(self) -> dict[int, Details]:
        from ..details.record import of_arrays

        return {number: of_arrays(arrays, f"object {number}") for number, arrays in self._arrays.items()}

    @cached_property
    def _donors(self) -> Donors:
        """All details together, in the order of their objects."""
        from ..details.record import Donors

        return Donors.of(self.job.program.name, self.job.program.hash, list(self._details.items()))

    def _lent(self, strength: float, program: Program) -> Dressing:
        """These for any objects of the program to borrow. Raises UsageError, UserError."""
        from ..details.store import require_donors

        dressing = self._dressing(strength, borrowed=True)
        require_donors(dressing, program)
        return dressing

    def _worn(self, strength: float, job: Job) -> Dressing:
        """How the objects of a job wear these. Raises UsageError, UserError."""
        from ..run.wearing import dress_as

        bound = {r["object"]: r.get("drawn") for r, arrays in self._bound if arrays is not None}
        return dress_as(job, self._dressing(strength), bound)

    def _dressing(self, strength: float, *, borrowed: bool = False) -> Dressing:
        from ..arguments import read_amount
        from ..details.dressing import MEMORY, Dressing
        from ..run.fitting import to_text

        strength = read_amount("the strength of details", strength, 0.0, 1.0)
        mark = blake2b(to_text(self._told), digest_size=16).hexdigest()
        return Dressing(str(self.folder or MEMORY), mark, strength, borrowed, held=self._donors)

    def _beside(self, out: Path, force: bool) -> tuple[Path, Callable[[], None]]:
        """The folder in ``out`` that these go to, and what writes it. Raises UserError where others are there."""
        from ..details.dressing import BESIDE, SUMMARY
        from ..run.bindings import save_bindings
        from ..run.fits import refuse_other

        folder = out / BESIDE
        refuse_other(folder / SUMMARY, self._told, force)
        return folder, partial(save_bindings, folder, self._told, self._bound, force=True)


def choose_details(details: Worn, strength: float, job: Job) -> Dressing | None:
    """The details that objects of a job wear, if any: their own, if these were bound to them or to what they were made from, else borrowed
    ones. Raises UsageError, UserError."""
    from ..details.dressing import refuse_idle_strength

    refuse_idle_strength(details, strength)
    if details is None or isinstance(details, Bound):
        return None if details is None else details._worn(strength, job)
    from ..run.wearing import dress

    return dress(job, _read_folder(details), strength)


def lend_details(details: Worn, strength: float, program: Program) -> Dressing | None:
    """The details that any objects of a program borrow, if there are any. Raises UsageError, UserError."""
    if details is None or isinstance(details, Bound):
        return None if details is None else details._lent(strength, program)
    from ..details.store import borrow

    return borrow(_read_folder(details), strength, program)


def _read_folder(details: str | Path) -> Path:
    """A folder of details. Raises UsageError."""
    if not isinstance(details, str | Path):
        raise UsageError(
            f"details is {details!r:.80}", 'give a folder, such as "bound", or what `bind` of fitted objects gives'
        )
    return read_path("a folder of details", details, '"bound"')


def place_details(
    details: Worn, dressing: Dressing, out: str | Path, force: bool
) -> tuple[Dressing, Callable[[], None] | None]:
    """Details as the manifest of a folder ``out`` can name them: those that are in no folder go into one beside it, which the function
    writes. Raises UsageError, UserError."""
    if not isinstance(details, Bound) or (details.folder is not None and details.folder.is_dir()):
        return dressing, None
    if isinstance(place_of(out), Remote):
        raise UsageError(
            "these details are in no folder of this machine that the manifest of another could name",
            'bound.save("bound") writes one; then they are taken as before',
        )
    folder, write = details._beside(Path(out), force)
    return replace(dressing, folder=str(folder)), write


def find_stale_details(out: Path, worn: Mapping[str, Any] | None) -> Path | None:
    """Details in a folder of objects that wear others, or none: what the objects that were there before wore. A run removes what it has
    written itself alone, and whoever bound these may need them. ``worn``: those that the manifest names."""
    from ..details.dressing import BESIDE, SUMMARY

    beside = out / BESIDE
    return beside if (beside / SUMMARY).exists() and (worn is None or worn["folder"] != BESIDE) else None
