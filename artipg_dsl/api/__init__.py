"""The Python interface: ``apg.sample("Microwave", n=1000, seed=7)`` gives objects as arrays, meshes and files.

In: names, numbers and arrays. Out: objects, and files of them. Begin with ``sample`` below.

    samples     objects as tables, points, views, meshes; one object
    files       writing objects: data sets, robots, pictures
    fitted      fitting real objects
    bound       their details, and which details objects wear
    real        real objects as arguments
    progress    how far long work is
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError, UserError
from ..run.job import open_job, prepare
from ..run.request import read_numbers, read_request
from ..run.resume import reopen
from ..run.schema import expand
from ..run.settings import Value
from ..session import Session, categories
from .bound import Bound
from .fitted import Fitted, FittedObject, NothingFits, fit_objects, open_fitted
from .samples import Object, Samples


def sample(
    category: str | Path,
    n: int | None = None,
    seed: int = 0,
    *,
    numbers: Sequence[int] | np.ndarray | None = None,
    set: Mapping[str, Value] | None = None,
    checked: bool = True,
    sampling: str = "sequential",
    repair: bool = False,
    values: str | Path | Iterable[Mapping[str, Any]] | None = None,
    prior: str | Path | Mapping[str, Any] | None = None,
    frame: str | Path | None = None,
) -> Samples:
    """Sample objects of a category, which is a shipped one (by name) or a file.

    Makes ``n`` objects, 0 .. n - 1 (default 1), or those of the given ``numbers``, a sequence or an array of whole numbers from 0
    on, which the result has ascending and each once. For one ``seed``, a whole number, a number always means the same object,
    whatever else is made with it. ``set`` fixes parameters: text with a unit, ``{"width": "45cm", "handle": "none"}``, or
    numbers in metres and radians. Objects whose links collide, at rest or while a joint moves, are drawn again unless
    ``checked`` is false. ``sampling="prior"`` resamples to the declared distributions, which sequential drawing
    shifts (``"prior:128"``: from 128 attempts per object). With ``repair``, invalid objects are corrected by the
    smallest change instead of drawn again. ``values`` gives the objects by their values, as a file or a dictionary for
    each, ``[{"width": 0.52, "handle": "BowHandle"}]``; omitted values are drawn, and invalid objects are corrected.
    ``repairs`` lists the changed values. ``prior`` draws by other weights and narrower ranges: the name of a shipped one
    ("partnet"), a file, or a dictionary, ``{"tray": 0.23, "handle": {"BarHandle": 3, "none": 1}}``. ``frame`` turns the objects
    to lie as those of another collection: the name of a shipped one ("partnet"), or a file. Raises CompileError, SettingError,
    NoObject, UsageError, UserError.
    """
    request = read_request(
        category,
        seed=seed,
        n=n,
        numbers=numbers,
        settings=set,
        checked=checked,
        sampling=sampling,
        repair=repair,
        values=values,
        prior=prior,
        frame=frame,
    )
    return Samples(open_job(request, values=str(values) if isinstance(values, str | Path) else "values"))


def load(
    text: str,
    n: int = 1,
    seed: int = 0,
    *,
    set: Mapping[str, Value] | None = None,
    checked: bool = True,
    prior: str | Path | Mapping[str, Any] | None = None,
    frame: str | Path | None = None,
) -> Samples:
    """Sample objects of a category given as program text; the arguments are those of ``sample``.

    What is wrong with the text is told with its line and column in ``<text>``. A folder that ``to`` writes keeps the objects, but
    not the text: ``open_samples`` can read folders of programs in files only. Raises CompileError, SettingError, NoObject,
    UsageError, UserError.
    """
    if not isinstance(text, str):
        raise UsageError(f"`load` takes the text of a program, not {text!r}", "a name or a file goes to `sample`")
    name = text.strip()
    if name.isidentifier() or name.endswith((".apg", ".apgc")) and "\n" not in name:
        raise UsageError(f"`load` takes the text of a program, not its name {name}", f'write sample("{name}")')
    sampler = Session.of_text(text).sampler
    request = read_request(
        sampler.program.name, seed=seed, n=n, settings=set, checked=checked, prior=prior, frame=frame
    )
    return Samples(prepare(sampler, request))


def open_samples(folder: str | Path, *, numbers: Sequence[int] | np.ndarray | None = None) -> Samples:
    """Make the objects of a folder written by ``apgc sample`` again: all, or those of the given ``numbers``.

    If the folder has tables, the objects are made from these. Raises ExportError, UserError, UsageError.
    """
    job = reopen(folder)
    if numbers is None:
        return Samples(job)
    asked = expand(read_numbers(None, numbers))
    absent = np.setdiff1d(asked, job.request.objects)
    if len(absent):
        raise UserError(f"there is no object {absent[0]} in {folder}", "its manifest lists the numbers")
    return Samples(job.of(asked))


__all__ = [
    "Bound",
    "Fitted",
    "FittedObject",
    "NothingFits",
    "Object",
    "Samples",
    "categories",
    "fit_objects",
    "load",
    "open_fitted",
    "open_samples",
    "sample",
]
