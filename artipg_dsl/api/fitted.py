"""Objects fitted to real ones, with what is known of each: ``apg.fit_objects("Chair", meshes)``."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..arguments import read_flag, read_path, read_paths, read_whole
from ..errors import NoObject, UserError
from ..run.job import Job, open_program
from ..run.request import read_request
from ..run.sharing import MOST
from .files import count_objects, read_picture
from .progress import Told, find_stage, telling
from .real import read_map, read_real
from .samples import Object, Samples

if TYPE_CHECKING:
    from ..details.binding import Real
    from ..fit.sources import Item
    from .bound import Bound

_REASONS = 3  # that an error tells
_MOST_POINTS = 100_000_000
_INNER = ("file", "options", "kept")  # of a record, which tell what is there already


class NothingFits(NoObject):
    """No real object was fitted; ``records`` say of each how far off it is, or why it could not be read."""

    def __init__(self, message: str, hint: str | None = None, records: Sequence[dict[str, Any]] = ()):
        super().__init__(message, hint)
        self.records = records

    def __reduce__(self) -> tuple[Any, Any]:
        return type(self), (self.message, self.hint, self.records)


def fit_objects(
    category: str | Path,
    real: Any,
    *,
    seed: int = 0,
    up: str = "auto",
    front: str = "auto",
    unit: str = "auto",
    normalised: bool = False,
    map: Mapping[str, str] | None = None,
    set: Mapping[str, Any] | None = None,
    facts: Mapping[str, Mapping[str, Any]] | str | Path | None = None,
    checked: bool = True,
    at_rest: bool = False,
    workers: int = 1,
    progress: Told = False,
    folder: str | Path | None = None,
) -> Fitted:
    """Find the objects of a category that are closest to real ones, as ``apgc fit`` does.

    A real object is a file or a folder of files; a mesh, scene or point cloud of trimesh; ``(vertices, faces)``; points (n, 3); or
    a dictionary of arrays, ``{"points": (n, 3), "normals": (n, 3), "label": (n,), "label_names": [...]}`` or ``{"vertices": ...,
    "faces": ..., "label": (f,), ...}``, all but the first optional. ``real`` is one of these, a list, or a dictionary of names,
    ``{"antique": mesh}``. Arrays give what a file of them gives, and nothing is written.

    ``up`` and ``front`` are axes such as "z" or "-y" ("any" tries all for ``up``), ``unit`` is "m", "cm", "mm", "in" or "ft"; what is not
    given is found. In memory z is up if nothing is said, and other axes are tried where nothing fits well. ``normalised``: the scale
    means nothing. ``map`` maps names of labels to words of ``semantic``, which are kept apart: ``{"Seat_01": "seat"}``. ``set`` is
    what is known of all objects, ``facts`` what is known of each, by its name, or a file of it, ``{"door_03": {"leaves": 2}}``: only
    objects of which that is true are looked for. ``checked``: without links that collide. Joints are moved where nothing fits at rest,
    unless ``at_rest``. ``workers`` processes share groups of six objects. ``progress``: True for a line on stderr, as the command has
    it, or a function that is called with (done, total).
    ``folder`` is written as ``save`` writes it, group by group while they are fitted; objects that it has from an earlier call with the same
    options, even one that was ended, are not fitted again.

    What cannot be read or does not fit is in ``records`` with the reason, and not among the objects. Raises NothingFits if that is all
    of them, and CompileError, UsageError, UserError.
    """
    from ..run.facts import read_facts
    from ..run.fits import Folder, write_fits
    from ..run.fitting import Asked, find_unmatched, fit_all, good_ones, prepare_fitted

    request = read_request(category, seed=seed, checked=checked)
    out = None if folder is None else read_path("a folder", folder, '"fitted"')
    at_rest, workers = read_flag("at_rest", at_rest), read_whole("workers", workers, 1, MOST)
    told: list[str] = []
    items, frame = read_real(real, up, front, unit, normalised, told.append)
    sampler, source = open_program(request.source)
    words = read_map(map, sampler.program)
    known = read_facts(set or {}, facts, sampler.program, [item.name for item in items])
    asked = Asked(source, frame, request.seed, request.checked, words, not at_rest, known)
    with telling(progress, sampler.program.name, "fitting") as tell:
        doing = find_stage(tell, "fitting")
        if out is None:
            records = fit_all(sampler, asked, items, workers, tell, doing)
            job = prepare_fitted(sampler, source, records) if good_ones(records) else None
        else:
            _, records, job = write_fits(
                sampler, asked, Folder(out), items, workers=workers, progress=tell, doing=doing
            )
    for text in filter(None, [*told, find_unmatched(words, records, "map")]):
        warnings.warn(text, stacklevel=2)
    if job is None:
        raise _nothing(sampler.program.name, records)
    return Fitted(job.fresh(), records, items)


def open_fitted(folder: str | Path, real: str | Path | Sequence[str | Path] = ()) -> Fitted:
    """The objects of a folder that ``apgc fit``, or ``save``, has written. ``real``: the files that were fitted, or folders of them, if they
    have moved. Raises UserError, UsageError."""
    from ..fit.finding import find_files
    from ..run.bindings import open_fits

    place = read_path("a folder", folder, '"fitted"')
    files = find_files(read_paths("real", real, 'open_fitted("fitted", "scans/")'))
    job, records, items = open_fits(place, files)
    return Fitted(job, records, items)


def _nothing(category: str, records: Sequence[dict[str, Any]]) -> NothingFits:
    what = f"{records[0]['name']} was not" if len(records) == 1 else f"none of {len(records)} objects was"
    reasons = [r.get("failed") or f"{r['name']}: {_off(r)}" for r in records]
    more = f"; and {len(reasons) - _REASONS} more" if reasons[_REASONS:] else ""
    return NothingFits(f"{what} fitted by {category}", "; ".join(reasons[:_REASONS]) + more, records)


def _off(record: dict[str, Any]) -> str:
    return f"{record['verdict']}, {record['distance']['both']:.1f} %" + ("" if record["valid"] else ", not valid")


class Fitted(Samples):
    """Objects of a category that come closest to real ones: all that fit and are valid, numbered from 0 in the order of these.

    They are as ``apg.sample(values=...)`` makes them, and so are their mutants.
    """

    def __init__(self, job: Job, records: Sequence[dict[str, Any]], items: Sequence[Item]):
        from ..run.fitting import good_ones

        super().__init__(job)
        self._records, self._items = records, {item.name: item for item in items}
        self._good = good_ones(records)

    def _title(self) -> str:
        lost = len(self._records) - len(self._good)
        return f"{self.category}: {count_objects(len(self))} fitted" + (f", {lost} not" if lost else "")

    @cached_property
    def records(self) -> list[dict[str, Any]]:
        """What is known of each real object, in their order, as in ``fits/NAME.json``, and its ``object``: the number among these, None
        for one that does not fit, is not valid, or could not be read, which ``failed`` gives the reason of."""
        number = {record["name"]: k for k, record in enumerate(self._good)}
        return [
            {"object": number.get(r["name"])} | {key: deepcopy(value) for key, value in r.items() if key not in _INNER}
            for r in self._records
        ]

    @property
    def summary(self) -> dict[str, Any]:
        """What ``fit.json`` says: ``objects`` with verdict and distance, ``failed`` with the reasons, ``median`` of the distances."""
        from ..run.fitting import summarize

        return summarize(self.category, deepcopy(self._records[0]["options"]), self._records)

    def __iter__(self) -> Iterator[FittedObject]:
        return (self.object(number) for number in self.numbers.tolist())

    def object(self, number: int) -> FittedObject:
        """The object with the given number. Raises UserError where there is none."""
        if not 0 <= read_whole("number", number) < len(self._good):
            raise UserError(f"there is no object {number}: {len(self._good)} were fitted, numbered from 0")
        record = self._good[number]
        return FittedObject(self.job.of([number]), record, self._items[record["name"]])

    def bind(
        self,
        points: int = 8192,
        *,
        assignment: str = "mutual",
        completed: bool = True,
        workers: int = 1,
        progress: Told = False,
        folder: str | Path | None = None,
    ) -> Bound:
        """The surfaces of the real objects as details of these, as ``apgc bind`` binds them; they are read again for that.

        ``points`` of the structure, and of the real surface, are assigned to one another: "mutual", "both", "project", "aware",
        "transport" or "nearest". ``completed``: hidden surface takes what symmetries of its primitive tell of it. ``progress`` and
        ``folder`` are as in ``fit_objects``; the folder is that of ``apgc bind``. What could not be
        bound is in ``summary["failed"]`` with the reason. Raises UserError if that is all of them, and UsageError.
        """
        from ..run.binding import Binding, Fit, bind_all, read_assignment, summarize
        from ..run.bindings import bind_into, read_bound
        from .bound import Bound

        how = Binding(
            read_whole("points", points, 1, _MOST_POINTS),
            read_assignment(assignment),
            read_flag("completed", completed),
        )
        fits = [Fit(n, self._good[n], self._items[self._good[n]["name"]].real) for n in self.numbers.tolist()]
        out = None if folder is None else read_path("a folder", folder, '"bound"')
        workers = read_whole("workers", workers, 1, MOST)
        with telling(progress, self.category, "binding") as tell:
            if out is None:
                found = bind_all(self.job, how, fits, workers, tell)
                options = how.plain(self.job.program.hash)
                told = summarize(self.category, options, [record for record, _ in found], self.summary["objects"])
            else:
                told, records = bind_into(out, self.job, how, fits, self.summary, workers=workers, progress=tell)
                found = [(record, read_bound(out, record)) for record in records]
        if not told["objects"]:
            failed = told["failed"][0]
            raise UserError(
                f"no details could be bound of {count_objects(len(fits))}", f"{failed['name']}: {failed['reason']}"
            )
        return Bound(self.job, told, found, out)

    def save(self, folder: str | Path, *, force: bool = False) -> Path:
        """Write the folder that ``apgc fit --plain`` writes, which the other commands take and ``open_fitted`` opens.

        What was fitted from memory is kept there, too, as arrays in ``kept/NAME.npz``, so that it can be bound later. Other fits that
        are there are replaced only with ``force``. Raises UserError, also where arrays have changed since they were fitted.
        """
        from ..run.fits import save_fits

        out, force = read_path("a folder", folder, '"fitted"'), read_flag("force", force)
        save_fits(self.job, out, self._records, self._items, force=force)
        return out


class FittedObject(Object):
    """An object and the real one that it was fitted to. Frames are its own; see ``to_object``."""

    def __init__(self, job: Job, record: dict[str, Any], item: Item):
        super().__init__(job)
        self._record, self._item = record, item

    def _title(self) -> str:
        return f"{self.category} {self.number}: {self.name}, {self.verdict}, {self.distance:.2f} %"

    @property
    def name(self) -> str:
        """What the real object is called."""
        return str(self._record["name"])

    @cached_property
    def record(self) -> dict[str, Any]:
        """All that is known of the fit, as in ``fits/NAME.json``."""
        return {key: deepcopy(value) for key, value in self._record.items() if key not in _INNER}

    @property
    def verdict(self) -> str:
        """``fits`` or ``rough``."""
        return str(self._record["verdict"])

    @property
    def distance(self) -> float:
        """How far the two surfaces are apart, both ways, in percent of the diagonal; ``record["distance"]`` has more."""
        return float(self._record["distance"]["both"])

    @property
    def to_object(self) -> np.ndarray:
        """The matrix (4, 4) that brings points as they were given into the frame of the object: ``p @ m[:3, :3].T + m[:3, 3]``."""
        return np.array(self._record["to_object"])

    @property
    def lost(self) -> str:
        """What of the real object was left out, such as points that are no numbers; "" for nothing."""
        return str(self._record.get("lost", ""))

    def posed(self) -> np.ndarray:
        """Joint values (J,) in which the real object stands, to be passed on: ``one.mesh(one.posed())``."""
        from ..fit.real import posed_as

        return posed_as(self.batch, self._record.get("joints") or {}, self.name)

    def real(self) -> Real:
        """The outer surface of the real object in the frame of this one: ``points``, ``normals`` (n, 3), ``label`` (n,) indexing ``labels``.

        It is read again for that. Raises UserError where it has changed since.
        """
        from ..fit.real import read_real

        self._item.real.require(self._record["file"])
        return read_real(self._item.real, self._record)

    def overlay(self, path: str | Path, *, tile: int = 320) -> Path:
        """Draw the real object as points, this one, and both, side by side, as ``apgc fit`` does. Raises UserError, UsageError."""
        from ..export.write import write_bytes
        from ..view.overlay import overlay
        from ..view.png import png_bytes
        from ..view.sheet import Painter, read_tile

        file = read_picture(path)
        painter = Painter("auto", read_tile(tile))
        image = overlay(self.batch, 0, self.real().points, painter, states=self.posed())
        write_bytes(file, png_bytes(image), force=True)
        return file
