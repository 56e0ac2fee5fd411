"""Writing objects: data sets, files per object, pictures."""

from __future__ import annotations

import base64
import warnings
from collections.abc import Iterable, Mapping
from dataclasses import fields, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import read_flag, read_path
from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError
from ..run.job import Job
from .bound import Worn, choose_details, find_stale_details, place_details

_PICTURED = 8  # objects on the picture in a notebook


class Files:
    """Objects of one category, as files and pictures."""

    def __init__(self, job: Job):
        self.job = job
        self.batch = job.batch()

    def __len__(self) -> int:
        return len(self.batch)

    def __repr__(self) -> str:
        return f"<{self._title()}>"

    def _title(self) -> str:
        return f"{self.category}: {count_objects(len(self))}, seed {self.seed}"

    @property
    def category(self) -> str:
        return self.batch.program.name

    @property
    def seed(self) -> int:
        return self.job.request.seed

    @property
    def numbers(self) -> np.ndarray:
        """(B,) int64, the object numbers, ascending and each once, in whatever order they were asked for; read-only."""
        numbers = self.batch.numbers.view()
        numbers.flags.writeable = False
        return numbers

    def to(
        self,
        folder: str | Path,
        formats: str | Iterable[str] | None = None,
        *,
        points: int = 2048,
        states: str = "rest",
        motion: bool = False,
        views: int | str | Path | Mapping[str, Any] | None = None,
        surface: str = "boundary",
        spread: str = "random",
        per: str = "object",
        balance: str = "",
        weights: str | Mapping[str, float] | None = None,
        tolerance: float | None = None,
        triangles: int | None = None,
        details: Worn = None,
        detail_strength: float = 1.0,
        force: bool = False,
    ) -> Path:
        """Write a folder like ``apgc sample``: shards, a folder per object for formats that need it, the manifest.

        The options are those of the command, of ``points`` and of ``meshes``; ``states`` is text such as "open,random:4",
        ``views`` a number or cameras. ``details``, a folder written by ``apgc bind`` or bound ones, are worn by points
        and by meshes; bound ones that are not saved are written beside them, into the folder ``details``.
        """
        from ..export.registry import choose_formats
        from ..run.dataset import write_dataset
        from ..run.output import Output, read_content, refuse_idle

        out, force = _read_folder(folder), read_flag("force", force)
        names = None if formats is None else _read_names(formats)
        content = read_content(
            points=points,
            surface=surface,
            spread=spread,
            per=per,
            balance=balance,
            weights=weights,
            states=states,
            motion=read_flag("motion", motion),
            views=views,
            tolerance=tolerance,
            triangles=triangles,
        )
        output = Output.of(choose_formats(names, views=views is not None), content)
        refuse_idle(output)
        write_details = None
        if (worn := choose_details(details, detail_strength, self.job)) is not None:
            if not output.wearable:
                raise UsageError("details are worn by points and meshes: none of the formats has any", "add points")
            worn, write_details = place_details(details, worn, folder, force)
            output = replace(output, content=replace(content, details=worn))
        manifest = write_dataset(self.job.fresh(), folder, output, force=force, begin=write_details)
        if force and (left := find_stale_details(out, manifest["identity"]["details"] if worn else None)) is not None:
            said = f"{left} holds details that these objects do not wear: remove it, unless something else needs it"
            warnings.warn(said, stacklevel=2)
        return out

    def export(
        self,
        folder: str | Path,
        formats: str | Iterable[str],
        *,
        tolerance: float | None = None,
        triangles: int | None = None,
        details: Worn = None,
        detail_strength: float = 1.0,
        force: bool = False,
    ) -> list[Path]:
        """Files per object, ``batch.export("robots", "urdf,glb")``; returns the folders ``objects/<number>``.

        Formats are those of ``apgc export``; ``tolerance``, ``triangles`` and ``details`` are as in ``meshes``. Existing files are
        replaced only with ``force``, and a folder that samples of other objects were written to is refused. Raises ExportError.
        """
        from ..export.objects import object_folder, write_objects
        from ..export.registry import find_formats, object_formats
        from ..export.remote import Remote, place_of
        from ..export.write import ExportError
        from ..geometry.resolution import Resolution
        from ..run.manifest import describe_strangers, read_manifest

        out, force, chosen = _read_folder(folder), read_flag("force", force), find_formats(_read_names(formats))
        if isinstance(place_of(folder), Remote):
            raise UsageError(
                f"`export` writes into folders of this machine, not to {folder}", "`to` writes elsewhere, too"
            )
        for entry in chosen:
            if not entry.per_object:
                raise UsageError(f"{entry.name} is written by `to`", f"`export` writes {', '.join(object_formats())}")
        fine = Resolution(tolerance=tolerance, triangles=triangles)
        if (there := read_manifest(folder)) is not None and (other := describe_strangers(there, self.job.request)):
            raise ExportError(f"{folder} holds samples of other objects: {other}", "choose another folder")
        worn = choose_details(details, detail_strength, self.job)
        write_objects(self.batch, out, chosen, force=force, resolution=fine, details=worn)
        return [Path(str(object_folder(out, n))) for n in self.numbers.tolist()]

    def lay_out(
        self,
        folder: str | Path,
        layout: str,
        *,
        split: str = "8,1,1",
        map: Mapping[str, Mapping[str, Any]] | None = None,
        frame: str | Path | None = None,
        force: bool = False,
    ) -> Path:
        """Write a folder as the field's training code reads it, ``batch.lay_out("parts", "shapenetpart")``.

        Categories can be added to an existing folder. The layouts are those of ``apgc export``; ``split`` sets the
        proportions of train, val and test. ``map`` translates the category and its words into the layout's vocabulary:
        ``{"Kettle": {"class": "Mug", "parts": {"*": "cup"}}}``.
        Objects are turned to lie as those of the layout's data set, or, with ``frame``, as that says ("own": as declared).
        Raises UsageError, ExportError, UserError.
        """
        from ..layouts.entry import read_shares
        from ..layouts.registry import LAYOUTS
        from ..layouts.words import require_map
        from ..run.laying import write_layout

        out, force = _read_folder(folder), read_flag("force", force)
        if not isinstance(layout, str):
            raise UsageError(f"a layout is named by a text, not {layout!r}", f"the layouts are {', '.join(LAYOUTS)}")
        if layout not in LAYOUTS:
            raise UsageError(
                f"there is no layout {layout!r}",
                did_you_mean(layout, LAYOUTS) or f"the layouts are {', '.join(LAYOUTS)}",
            )
        own = None if map is None else require_map(map, "map")
        write_layout(self.job, folder, LAYOUTS[layout], shares=read_shares(split), own=own, force=force, frame=frame)
        return out

    def to_urdf(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """A robot description with its meshes per object; returns the paths of ``object.urdf``."""
        return self._objects(folder, "urdf", force)

    def to_glb(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """A binary glTF per object; returns the paths of ``object.glb``."""
        return self._objects(folder, "glb", force)

    def to_usd(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """OpenUSD with a physics articulation per object; returns the paths of ``object.usda``."""
        return self._objects(folder, "usd", force)

    def to_mjcf(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """MuJoCo's own format per object; returns the paths of ``object.xml``."""
        return self._objects(folder, "mjcf", force)

    def to_sdf(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """SDFormat per object; returns the paths of ``model.sdf``."""
        return self._objects(folder, "sdf", force)

    def to_obj(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """A Wavefront OBJ per link with the object's materials; returns the paths of ``obj/object.mtl``."""
        return self._objects(folder, "obj", force)

    def to_partnet_mobility(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """The folder of PartNet-Mobility per object; returns the paths of ``mobility.urdf``."""
        return self._objects(folder, "partnet-mobility", force)

    def _objects(self, folder: str | Path, name: str, force: bool) -> list[Path]:
        from ..export.registry import FORMATS

        return [made / FORMATS[name].file for made in self.export(folder, name, force=force)]

    # ------------------------------------------------------------ pictures

    def sheet(self, path: str | Path, *, details: Worn = None, detail_strength: float = 1.0, **options: Any) -> Path:
        """Draw all objects to a PNG; the options are those of ``view.sheet.Sheet`` (colour, tile, columns, states, view).

        ``details`` are worn as in ``meshes``.
        """
        from ..view.sheet import Sheet, write_sheet

        file = read_picture(path)
        worn = choose_details(details, detail_strength, self.job)
        known = [field.name for field in fields(Sheet)]
        if unknown := sorted(options.keys() - known):
            hint = did_you_mean(unknown[0], known) or f"give {', '.join(known)}"
            raise UsageError(f"a picture has no {unknown[0]!r}", hint)
        write_sheet(self.batch, path, Sheet(details=worn, **options), force=True)
        return file

    @cached_property
    def _picture(self) -> bytes:
        from ..view.png import png_bytes
        from ..view.sheet import Sheet, draw_sheet

        return png_bytes(draw_sheet(self.job.batch(self.numbers[:_PICTURED]), Sheet(tile=220)))

    def _repr_png_(self) -> bytes:
        return self._picture

    def _repr_html_(self) -> str:
        picture = base64.b64encode(self._picture).decode("ascii")
        more = f", the first {_PICTURED} shown" if len(self) > _PICTURED else ""
        title = escape(self._title())
        return f'<img alt="{title}" src="data:image/png;base64,{picture}"><p>{title}{more}</p>'


def count_objects(count: int) -> str:
    return "1 object" if count == 1 else f"{count} objects"


def read_picture(path: str | Path) -> Path:
    """The file of a picture. Raises UsageError."""
    file = read_path("a picture", path, '"sheet.png"')
    if file.suffix.lower() != ".png":
        raise UsageError(f"pictures are written as PNG, not as {path}", "choose a name that ends in .png")
    return file


def _read_folder(folder: str | Path) -> Path:
    return read_path("a folder", folder, '"microwaves"')


def _read_names(formats: str | Iterable[str]) -> str | list[str]:
    """Names of formats as text or as a list. Raises UsageError."""
    if isinstance(formats, str):
        return formats
    names = list(formats) if isinstance(formats, Iterable) else [formats]
    if not all(isinstance(name, str) for name in names):
        raise UsageError(f"formats is {formats!r}", 'it is text or a list: "points,urdf" or ["points", "urdf"]')
    return names
