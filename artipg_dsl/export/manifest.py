"""``manifest.json``: what made a folder of objects and what every array in it means."""

from __future__ import annotations

import json
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..annotate.points import field_kinds
from ..shapes import Misfit
from ..version import __version__
from . import schema
from .content import Content
from .meanings import ACTING, AREA, MOTIONS, MOVING, OBJECT, POINTS, STATE, VIEWS, Meaning
from .mutants import MEANINGS
from .write import ExportError

if TYPE_CHECKING:
    from ..graph.program import Program

NAME = "manifest.json"
# what a folder must have been made with for its files to be kept by a later run
IDENTITY = {
    "program": "the compiled program",
    "seed": "the seed",
    "numbers": "the objects asked for",
    "points": "the number of points",
    "surface": "the surface that points lie on",
    "spread": "how points are spread",
    "per": "what the number of points is of",
    "balance": "what points are shared out over",
    "weights": "the weights of points",
    "states": "the joint states",
    "motion": "velocities of points",
    "views": "the cameras",
    "gripper": "the gripper",
    "meshes": "the resolution of meshes",
    "formats": "the formats",
    "shard": "the number of objects per shard",
    "settings": "the parameters that were set",
    "made": "how objects are made",
    "artipg_dsl": "the version of artipg_dsl",
    "numpy": "the version of NumPy",
}

PLAINLY: dict[str, Any] = {"checked": True, "sampling": "sequential", "repair": False, "mutations": [], "values": None}
MADE = {
    "checked": "the check of collisions",
    "sampling": "the sampling",
    "repair": "the repair",
    "mutations": "the mutations",
    "values": "the values given",
}
WANTED = "give the folder that samples were written to"
KINDS = {
    "mask": "the label holds",
    "grade": "how far the label holds, 0 .. 1",
    "field": "value, nan where undefined",
    "vectors": "vector, nan where undefined",
}


def cpu_class() -> str:
    """The machine and the widest vector instructions NumPy uses on it: results are equal to the bit within a class."""
    from numpy._core import _multiarray_umath as core  # type: ignore[attr-defined]

    enabled = [name for name in core.__cpu_dispatch__ if core.__cpu_features__.get(name)]
    return " ".join([platform.machine(), *enabled[-1:]])


def spans(numbers: Sequence[int] | np.ndarray) -> list[list[int]]:
    """Object numbers as runs ``[first, last]``."""
    numbers = np.asarray(numbers, dtype=np.int64)
    if not len(numbers):
        return []
    breaks = np.flatnonzero(np.diff(numbers) != 1) + 1
    return [[int(run[0]), int(run[-1])] for run in np.split(numbers, breaks)]


def build(
    program: Program,
    *,
    seed: int,
    numbers: np.ndarray,
    content: Content,
    formats: Sequence[str],
    shard: int,
    settings: dict[str, Any] | None = None,
    made: dict[str, Any] | None = None,
    source: str = "",
    counts: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """The manifest of a data set. ``made`` says how objects are made (``Job.made``),
    apart from the parameters that were set, which may have any name. ``source`` is the name or, as seen
    from the folder, the file of the program;
    ``counts`` what the run has counted (repaired, rejected, ...), once it is over.
    """
    size = len(numbers)
    manifest: dict[str, Any] = {
        "manifest": schema.FORMAT,
        "category": program.name,
        "source": source or program.name,
        "about": program.doc,
        "identity": {
            "program": program.hash,
            "seed": int(seed),
            "numbers": spans(numbers),
            **content.identity(),
            "formats": list(formats),
            "shard": int(shard),
            "settings": {key: (settings or {})[key] for key in sorted(settings or {})},
            "made": PLAINLY | (made or {}),
            "artipg_dsl": __version__,
            "numpy": np.__version__,
        },
        "objects": size,
        "shards": schema.shards(size, int(shard)),
        "python": platform.python_version(),
        "cpu": cpu_class(),
        "frame": "right-handed, x front, y left, z up; metres, radians, kilograms; quaternions w x y z",
        "vocabularies": vocabularies(program),
        "sites": [{"path": site.path, "primitive": site.primitive} for site in program.sites],
    }
    if "points" in formats:
        manifest["arrays"] = arrays(program, content)
    if content.cameras is not None:
        manifest["views"] = view_arrays(program, content)
    if "correspondence" in formats:
        manifest["correspondence"] = dict(MEANINGS)
    if counts is not None:
        manifest["counts"] = counts
    return manifest


def vocabularies(program: Program) -> dict[str, list[str]]:
    """Words by vocabulary: the program's, those its labels use, and the names of its joints, grasps and materials."""
    words = {name: list(entries) for name, entries in program.vocabularies.items()}
    for label in program.labels:
        known = words.setdefault(label.vocabulary, [])
        if label.name not in known:
            known.append(label.name)
    words["joints"] = list(dict.fromkeys(joint.name for joint in program.joints))
    words["grasps"] = list(dict.fromkeys(grasp.name for grasp in program.grasps))
    words["materials"] = list(program.materials)
    return words


def arrays(program: Program, content: Content) -> dict[str, Any]:
    """Meaning, dtype, shape, frame and unit of every array of a points shard."""
    meant = (
        POINTS | {"object": OBJECT} | (AREA if content.sampling.uneven else {}) | (MOTIONS if content.motion else {})
    )
    meant |= {name: label_meaning(kind, "objects, points") for name, kind in field_kinds(program.labels).items()}
    if content.motion:
        meant |= {
            f"{name}.joint": ACTING
            for name, kind in field_kinds(program.labels).items()
            if not name.startswith("field.")
        }
    lengths: dict[str, int | str] = {"points": content.points}
    if content.per != "object":  # a row for each of them, whose object `object` tells
        lengths["objects"] = "classes" if content.per == "semantic" else f"{content.per}s"
    moving = {*MOVING, *(name for name, kind in field_kinds(program.labels).items() if kind == "vectors")}
    return {name: entry(m, content, lengths, name in moving) for name, m in with_states(meant, content).items()}


def view_arrays(program: Program, content: Content) -> dict[str, Any]:
    """The same of a views shard."""
    cameras = content.cameras
    assert cameras is not None
    meant = {"object": OBJECT} | VIEWS
    kinds = field_kinds(program.labels)
    meant |= {f"cloud_{name}": label_meaning(kind, "objects, views, cloud") for name, kind in kinds.items()}
    lengths = {"views": cameras.count, "height": cameras.height, "width": cameras.width, "cloud": cameras.points}
    return {name: entry(m, content, lengths, name != "object") for name, m in with_states(meant, content).items()}


def with_states(meant: dict[str, Meaning], content: Content) -> dict[str, Meaning]:
    return meant if content.states.only_rest else meant | {"state": STATE}


def label_meaning(kind: str, shape: str) -> Meaning:
    if kind == "vectors":
        return Meaning(KINDS[kind], f"{shape}, 3", "object", dtype="float32")
    return Meaning(KINDS[kind], shape, dtype="bool" if kind == "mask" else "float32")


def entry(meaning: Meaning, content: Content, lengths: Mapping[str, int | str], moving: bool) -> dict[str, Any]:
    """A meaning as plain data, its shape with the lengths known: one more axis where an array depends on the state."""
    axes = meaning.shape.split(", ")
    if moving and not content.states.only_rest and "states" not in axes:
        axes.insert(1, "states")
    known = {**lengths, "states": content.states.count}
    described = {"dtype": meaning.dtype} | asdict(meaning)
    return described | {"shape": ", ".join(str(known.get(axis, axis)) for axis in axes)}


def text(manifest: dict[str, Any]) -> bytes:
    return (json.dumps(manifest, indent=1, ensure_ascii=False) + "\n").encode("utf-8")


def read(folder: Path | str) -> dict[str, Any] | None:
    """The manifest in a folder, None where there is none."""
    path = Path(folder) / NAME
    try:
        found = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except NotADirectoryError:
        raise ExportError(f"{folder} is a file, a folder was expected", WANTED) from None
    except (ValueError, OSError) as error:
        raise ExportError(f"cannot read {path}: {error}", WANTED) from error
    except RecursionError:
        raise ExportError(f"cannot read {path}: it is nested too deeply", WANTED) from None
    if not isinstance(found, dict) or "manifest" not in found:
        raise ExportError(f"{path} is not a manifest of this program", "choose another folder")
    try:
        schema.check(found)
    except Misfit as wrong:
        raise ExportError(f"{path}: {wrong}", "give another folder, or make this one anew in an empty place") from None
    return found


def difference(old: dict[str, Any], new: dict[str, Any]) -> str | None:
    """What sets two manifests apart so that their files do not belong together, in words; None if they do."""
    before, after = old["identity"], new["identity"]
    titles = {("identity", key): title for key, title in IDENTITY.items() if key != "made"}
    titles |= {("made", key): title for key, title in MADE.items()}
    groups = {"identity": (before, after), "made": (before["made"], after["made"])}
    words = []
    for (group, key), title in titles.items():
        one, other = (entries.get(key) for entries in groups[group])
        if one != other:
            words.append(f"{title} ({_short(one)}, now {_short(other)})")
    return " and ".join(words) or None


def _short(value: Any) -> str:
    shown = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return shown if len(shown) <= 40 else shown[:37] + "..."
