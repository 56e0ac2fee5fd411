"""``manifest.json``: what made a folder of objects, and what every array in it means."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NotRequired, TypedDict, cast

import numpy as np

from ..export.meanings import list_vocabularies, point_arrays, table_arrays, view_arrays
from ..export.mutants import MEANINGS
from ..export.registry import FORMATS, TABLES, kinds
from ..export.remote import Place, Remote, place_of
from ..export.write import ExportError
from ..robot.dressed import BARE, NOTE
from ..shapes import Misfit, Rule, fit, hints, show_value
from ..version import __version__
from .counts import Counts
from .output import Output, Shown, Written
from .request import Drawn, Fixed, Made, Objects, Request, is_file
from .schema import Count, Title, count_numbers, read_titles

if TYPE_CHECKING:
    from ..graph.program import Program

NAME = "manifest.json"
_VERSION: Literal[2] = 2
WANTED = "give the folder that samples were written to"
_FRAME = "right-handed, x front, y left, z up; metres, radians, kilograms; quaternions w x y z"


class Versions(TypedDict):
    artipg_dsl: Annotated[str, Title("the version of artipg_dsl")]
    numpy: Annotated[str, Title("the version of NumPy")]


class Identity(Objects, Written, Fixed, Versions):
    """What a folder must have been made with for its files to be kept by a later run, in the order of the file."""


class Computer(TypedDict):
    path: str
    primitive: str


def _is_path(text: str) -> bool:
    """Whether a text can be a path at all."""
    short = len(text) <= 2048 and all(len(piece.encode()) <= 255 for piece in text.split("/"))
    return short and text.strip() != "" and "\0" not in text


class Manifest(TypedDict):
    """The whole file."""

    manifest: Literal[2]
    category: str
    source: Annotated[str, Rule("the name or the file of a program", _is_path)]
    about: str
    identity: Identity
    objects: Count
    shards: list[str]
    python: str
    cpu: str
    frame: str
    vocabularies: dict[str, list[str]]
    sites: list[Computer]
    arrays: NotRequired[dict[str, dict[str, Any]]]
    views: NotRequired[dict[str, dict[str, Any]]]
    tables: NotRequired[dict[str, Any]]
    correspondence: NotRequired[dict[str, str]]
    surfaces: NotRequired[dict[str, str]]
    shown: NotRequired[dict[str, Shown]]
    counts: NotRequired[Counts]


def build_manifest(
    program: Program, request: Request, output: Output, *, out: Place | str = ".", counts: Counts | None = None
) -> Manifest:
    """The manifest of a folder ``out``; ``counts`` is what the run has counted, once it is over."""
    size, content = count_numbers(request.numbers), output.content
    turned = f"; objects turned by {request.turned} degrees about z" if request.turned else ""
    versions = {"artipg_dsl": __version__, "numpy": np.__version__}
    found: dict[str, Any] = {**request.to_manifest(), **output.to_manifest(), **versions}
    if content.details is not None:
        found["details"] |= {"folder": _relative_folder(content.details.folder, out)}
    manifest: Manifest = {
        "manifest": _VERSION,
        "category": program.name,
        "source": make_relative(request.source, out),
        "about": program.doc,
        "identity": cast(Identity, {key: found[key] for key in hints(Identity) if key in found}),
        "objects": size,
        "shards": _name_shards(size, output.shard),
        "python": platform.python_version(),
        "cpu": _find_cpu_class(),
        "frame": _FRAME + turned,
        "vocabularies": list_vocabularies(program),
        "sites": [{"path": site.path, "primitive": site.primitive} for site in program.sites],
    }
    if "points" in output.kinds:
        manifest["arrays"] = point_arrays(program, content)
    if content.cameras is not None:
        manifest["views"] = view_arrays(program, content)
    if TABLES in output.kinds:
        manifest["tables"] = table_arrays(program)
    if "correspondence" in output.kinds:
        manifest["correspondence"] = dict(MEANINGS)
    if content.details is not None and (said := name_surfaces(output.formats, worn=True)):
        manifest["surfaces"] = said
    if counts is not None:
        manifest["counts"] = counts
    return manifest


def name_surfaces(formats: Iterable[str], *, worn: bool) -> dict[str, str]:
    """What the meshes are of that are to be seen in files per object, by format; ``worn``: they wear details."""
    return {name: NOTE if worn else BARE for name in formats if FORMATS[name].per_object}


def _name_shards(size: int, each: int) -> list[str]:
    """The numbers of shards as the names of their files have them."""
    return [f"{at // each:05d}" for at in range(0, size, each)]


def _relative_folder(folder: str, out: Place | str) -> str:
    """The same for a folder, by its name where it is not there any more."""
    if not Path(folder).is_dir() or isinstance(place_of(folder), Remote):
        return folder
    if isinstance(place_of(out), Remote):
        return str(Path(folder).resolve())
    return see_from(str(out), Path(folder).resolve())


def make_relative(source: str, out: Place | str) -> str:
    """A file as seen from the folder of samples, so that both can be moved together; a name stays as it is."""
    if not is_file(source):
        return source
    if isinstance(place_of(out), Remote):
        return str(Path(source).resolve())
    return see_from(str(out), Path(source).resolve())


def see_from(folder: Path | str, place: Path | str) -> str:
    """A whole path as seen from a folder of this machine; as it is where nothing leads from one to the other, as between drives."""
    try:
        return Path(os.path.relpath(place, os.path.realpath(folder))).as_posix()
    except ValueError:
        return Path(place).as_posix()


def _find_cpu_class() -> str:
    """The machine and the widest vector instructions NumPy uses on it: results are equal to the bit within a class."""
    enabled = np.show_config(mode="dicts")["SIMD Extensions"].get("found", [])
    return " ".join([platform.machine(), *enabled[-1:]])


def to_text(manifest: Manifest) -> bytes:
    return (json.dumps(manifest, indent=1, ensure_ascii=False) + "\n").encode("utf-8")


def read_manifest(folder: Place | str) -> Manifest | None:
    """The manifest in a folder, None where there is none. Raises ExportError."""
    path = place_of(folder) / NAME
    try:
        found = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except NotADirectoryError:
        raise ExportError(f"{folder} is a file, but a folder is expected", WANTED) from None
    except (ValueError, OSError) as error:
        raise ExportError(f"cannot read {path}: {error}", WANTED) from error
    except RecursionError:
        raise ExportError(f"cannot read {path}: it is nested too deeply", WANTED) from None
    if not isinstance(found, dict) or "manifest" not in found:
        raise ExportError(f"{path} is not a manifest of this program", "choose another folder")
    try:
        _check(found)
    except Misfit as wrong:
        raise ExportError(f"{path}: {wrong}", "give another folder, or sample this one again in a new place") from None
    return cast(Manifest, found)


def _check(found: dict[str, Any]) -> None:
    """Raises Misfit with the key, what is there and what was expected."""
    if isinstance(found["manifest"], int) and found["manifest"] != _VERSION:
        raise Misfit(
            "manifest", f"version {_VERSION}, the one that this artipg_dsl writes,", show_value(found["manifest"])
        )
    fit(found, Manifest)
    identity = found["identity"]
    size = count_numbers(identity["numbers"])
    if found["objects"] != size:
        raise Misfit("objects", f"the {size} of identity.numbers", show_value(found["objects"]))
    names = _name_shards(size, identity["shard"])
    if found["shards"] != names:
        raise Misfit("shards", f"the {len(names)} shards of {identity['shard']} objects each", "another list")
    if ("views" in kinds(identity["formats"])) != (identity["views"] is not None):
        raise Misfit("identity.views", "cameras, where there are views,", show_value(identity["views"]))
    Output.from_manifest(identity)


def describe_difference(old: Manifest, new: Manifest) -> str | None:
    """What sets two manifests apart so that their files do not belong together, in words; None if they do."""
    return _describe(Identity, old["identity"], new["identity"])


def expect_added(old: Manifest, new: Manifest) -> Manifest:
    """The manifest of a run with the formats that `apgc export` has added to its folder since it ended, if those are all."""
    there = old["identity"]["formats"]
    added = [name for name in there if name not in new["identity"]["formats"]]
    if "counts" not in old or len(there) - len(added) < len(new["identity"]["formats"]):
        return new
    if not all(FORMATS[name].per_object for name in added if name in FORMATS):
        return new
    return {**new, "identity": {**new["identity"], "formats": there}}


def describe_strangers(old: Manifest, request: Request) -> str | None:
    """What sets the objects of a folder apart from those of a request, whichever numbers they have, in words; None if nothing does."""
    asked = request.to_manifest()
    return _describe(Drawn, old["identity"], {**asked, "numbers": old["identity"]["numbers"]})


def _describe(record: Any, old: Mapping[str, Any], new: Mapping[str, Any]) -> str | None:
    pairs = ((record, old, new), (Made, old["made"], new["made"]))
    found = [describe_changes(read_titles(kind), before, after) for kind, before, after in pairs]
    return " and ".join(filter(None, found)) or None


def describe_changes(titles: Mapping[str, str], old: Mapping[str, Any], new: Mapping[str, Any]) -> str:
    """Which of the entries that have ``titles`` differ, in words; nothing where none does."""
    return " and ".join(
        f"{title} ({_short(key, old.get(key))}, now {_short(key, new.get(key))})"
        for key, title in titles.items()
        if _compared(key, old.get(key)) != _compared(key, new.get(key))
    )


def _compared(key: str, value: Any) -> Any:
    """What two manifests are compared by: of details, what they are, not where."""
    if key == "details" and isinstance(value, dict):
        return {name: said for name, said in value.items() if name != "folder"}
    return value


def _short(key: str, value: Any) -> str:
    if key == "numbers" and isinstance(value, list):
        shown = ", ".join(f"{first}" if first == last else f"{first}..{last}" for first, last in value)
    else:
        shown = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return shown if len(shown) <= 40 else shown[:37] + "..."
