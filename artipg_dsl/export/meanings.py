"""What the arrays of shards hold, in words, as the manifest repeats it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..annotate.points import field_kinds
from ..records import dataclass

if TYPE_CHECKING:
    from ..graph.program import Program
    from .content import Content


@dataclass(frozen=True, slots=True)
class _ArrayMeaning:
    """What an array holds: its shape in words, frame and unit, and type."""

    text: str
    shape: str
    frame: str = ""
    unit: str = ""
    dtype: str = "uint16"


_OBJECT = _ArrayMeaning("number of the object", "objects", dtype="int64")
_STATE = _ArrayMeaning(
    "joint values in the order of the annotation, then nan", "objects, states, joints", unit="rad or m", dtype="float64"
)
_POINTS = {
    "points": _ArrayMeaning("points on the visible surface at rest", "objects, points, 3", "object", "m", "float32"),
    "normals": _ArrayMeaning("outward unit normals of the surface", "objects, points, 3", "object", "1", "float32"),
    "semantic": _ArrayMeaning(
        "class of the part, an index into vocabularies.semantic; 0: unlabelled", "objects, points"
    ),
    "instance": _ArrayMeaning("part instance, its `number` in the annotation", "objects, points"),
    "link": _ArrayMeaning("link, its `number` in the annotation", "objects, points"),
    "material": _ArrayMeaning("material, an index into vocabularies.materials; 65535: none", "objects, points"),
    "npcs": _ArrayMeaning(
        "place in the box of the instance, its diagonal 1 and its centre 0",
        "objects, points, 3",
        "part",
        "1",
        "float32",
    ),
    "primitive": _ArrayMeaning("index into sites: which primitive of the program", "objects, points"),
    "element": _ArrayMeaning("which of the object's primitives of that site, from 0", "objects, points"),
    "patch": _ArrayMeaning("surface patch of the primitive, from 0", "objects, points"),
    "u": _ArrayMeaning("first patch coordinate, a fraction 0 .. 1", "objects, points", "patch", "1", "float32"),
    "v": _ArrayMeaning("second patch coordinate, a fraction 0 .. 1", "objects, points", "patch", "1", "float32"),
}
_ACTING = _ArrayMeaning(
    "joint that the label is for, its place in the annotation's list `joints`; 65535: none, or it does not hold",
    "objects, points",
)
_AREA = {"area": _ArrayMeaning("surface that the point stands for", "objects, points", unit="m2", dtype="float32")}
_MOTIONS = {
    "motion": _ArrayMeaning(
        "velocity of the point per unit of the next joint above its link",
        "objects, points, 3",
        "object",
        "m per rad, or m per m",
        "float32",
    ),
    "drivers": _ArrayMeaning(
        "joints that move the point, places in the annotation's list `joints`; 65535: no more",
        "objects, points, drivers",
    ),
    "velocities": _ArrayMeaning(
        "velocity of the point per unit of each of its drivers, with all that follows it",
        "objects, points, drivers, 3",
        "object",
        "m per rad, or m per m",
        "float32",
    ),
}
_WORN = {
    "worn": _ArrayMeaning("whether the point wears a detail of the donor", "objects, points", dtype="bool"),
    "completed": _ArrayMeaning(
        "whether that detail was hidden in the original and follows from the symmetries of the primitive",
        "objects, points",
        dtype="bool",
    ),
    "real_label": _ArrayMeaning(
        "what the file of the donor calls the point, an index into `details.labels` of the annotation; -1: nothing",
        "objects, points",
        dtype="int16",
    ),
}
_MOVING = ("points", "normals", "motion", "velocities")  # what depends on the state

_SHOT, _IMAGE, _CLOUD = ("objects, views" + more for more in ("", ", height, width", ", cloud"))
_VIEWS = {
    "intrinsics": _ArrayMeaning(
        "camera matrix; the first pixel's centre is (0.5, 0.5)", f"{_SHOT}, 3, 3", dtype="float64"
    ),
    "extrinsics": _ArrayMeaning(
        "object's frame to the camera's: x right, y down, z forward", f"{_SHOT}, 4, 4", "camera", "m", "float64"
    ),
    "depth": _ArrayMeaning("distance along the camera's z, 0: nothing seen", _IMAGE, "camera", "m", "float32"),
    "normal": _ArrayMeaning("outward unit normal, 0: nothing seen", f"{_IMAGE}, 3", "object", "1", "float32"),
    "npcs": _ArrayMeaning(
        "place in the box of the instance, its diagonal 1 and its centre 0; 0: nothing seen",
        f"{_IMAGE}, 3",
        "part",
        "1",
        "float32",
    ),
    "semantic": _ArrayMeaning("class, an index into vocabularies.semantic; 0: unlabelled, 65535: nothing seen", _IMAGE),
    "instance": _ArrayMeaning("part instance, its `number` in the annotation; 65535: nothing seen", _IMAGE),
    "link": _ArrayMeaning("link, its `number` in the annotation; 65535: nothing seen", _IMAGE),
    "cloud_points": _ArrayMeaning("points that the camera sees", f"{_CLOUD}, 3", "object", "m", "float32"),
    "cloud_camera": _ArrayMeaning("the same points", f"{_CLOUD}, 3", "camera", "m", "float32"),
    "cloud_normals": _ArrayMeaning("outward unit normals", f"{_CLOUD}, 3", "object", "1", "float32"),
    "cloud_pixel": _ArrayMeaning("row and column of the pixel that shows the point", f"{_CLOUD}, 2"),
    "cloud_npcs": _ArrayMeaning("as npcs", f"{_CLOUD}, 3", "part", "1", "float32"),
    "cloud_semantic": _ArrayMeaning("as semantic", _CLOUD),
    "cloud_instance": _ArrayMeaning("as instance", _CLOUD),
    "cloud_link": _ArrayMeaning("as link", _CLOUD),
}

_TABLES = {
    "object": "object number",
    "drawn": "the number that its random values are addressed by, with seed, attempt, lane and salt",
    "attempt": "attempts before this one",
    "lane": "of a mutant, which one it is",
    "salt": "of a mutant, what its random values are of",
    "rows": "objects, draws: how many values it has of each draw",
    "values": "the values, object by object, draw by draw: metres, radians, counts, indices of options",
    "repairs": "what was moved to make it valid, as the annotation has it (JSON); empty for nothing",
}

_KINDS = {
    "mask": "the label holds",
    "grade": "how far the label holds, 0 .. 1",
    "field": "value, nan where undefined",
    "vectors": "vector, nan where undefined",
}


def list_vocabularies(program: Program) -> dict[str, list[str]]:
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


def point_arrays(program: Program, content: Content) -> dict[str, dict[str, Any]]:
    """Meaning, dtype, shape, frame and unit of every array of a points shard."""
    points = content.points
    meant = _POINTS | {"object": _OBJECT} | (_AREA if points.uneven else {}) | (_MOTIONS if content.motion else {})
    meant |= _WORN if content.details is not None else {}
    meant |= {name: _label(kind, "objects, points") for name, kind in field_kinds(program.labels).items()}
    if content.motion:
        meant |= {
            f"{name}.joint": _ACTING
            for name, kind in field_kinds(program.labels).items()
            if not name.startswith("field.")
        }
    lengths: dict[str, int | str] = {"points": points.count}
    if points.per != "object":  # a row for each of them, whose object `object` tells
        lengths["objects"] = "classes" if points.per == "semantic" else f"{points.per}s"
    moving = {*_MOVING, *(name for name, kind in field_kinds(program.labels).items() if kind == "vectors")}
    return {name: _entry(m, content, lengths, name in moving) for name, m in _with_states(meant, content).items()}


def table_arrays(program: Program) -> dict[str, Any]:
    """What the arrays of a tables shard hold, and the draws in the order of ``rows`` and ``values``."""
    draws = [{"name": d.column.name, "kind": d.kind, "unit": d.unit, "options": list(d.options)} for d in program.draws]
    return {**_TABLES, "draws": draws}


def view_arrays(program: Program, content: Content) -> dict[str, dict[str, Any]]:
    """The same of a views shard."""
    cameras = content.cameras
    assert cameras is not None
    meant = {"object": _OBJECT} | _VIEWS
    kinds = field_kinds(program.labels)
    meant |= {f"cloud_{name}": _label(kind, "objects, views, cloud") for name, kind in kinds.items()}
    lengths = {"views": cameras.count, "height": cameras.height, "width": cameras.width, "cloud": cameras.points}
    return {name: _entry(m, content, lengths, name != "object") for name, m in _with_states(meant, content).items()}


def _with_states(meant: dict[str, _ArrayMeaning], content: Content) -> dict[str, _ArrayMeaning]:
    return meant if content.states.only_rest else meant | {"state": _STATE}


def _label(kind: str, shape: str) -> _ArrayMeaning:
    if kind == "vectors":
        return _ArrayMeaning(_KINDS[kind], f"{shape}, 3", "object", dtype="float32")
    return _ArrayMeaning(_KINDS[kind], shape, dtype="bool" if kind == "mask" else "float32")


def _entry(meaning: _ArrayMeaning, content: Content, lengths: Mapping[str, int | str], moving: bool) -> dict[str, Any]:
    """A meaning as plain data, its shape with the lengths known: one more axis where an array depends on the state."""
    axes = meaning.shape.split(", ")
    if moving and not content.states.only_rest and "states" not in axes:
        axes.insert(1, "states")
    known = {**lengths, "states": content.states.count}
    described = {"dtype": meaning.dtype} | asdict(meaning)
    return described | {"shape": ", ".join(str(known.get(axis, axis)) for axis in axes)}
