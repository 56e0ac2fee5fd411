"""What the arrays of shards hold, in words, as the manifest repeats it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Meaning:
    """What an array holds: its shape in words, frame and unit, and type."""

    text: str
    shape: str
    frame: str = ""
    unit: str = ""
    dtype: str = "uint16"


OBJECT = Meaning("number of the object", "objects", dtype="int64")
STATE = Meaning(
    "joint values in the order of the annotation, then nan", "objects, states, joints", unit="rad or m", dtype="float64"
)
POINTS = {
    "points": Meaning("points on the visible surface at rest", "objects, points, 3", "object", "m", "float32"),
    "normals": Meaning("outward unit normals of the surface", "objects, points, 3", "object", "1", "float32"),
    "semantic": Meaning("class of the part, an index into vocabularies.semantic; 0: unlabelled", "objects, points"),
    "instance": Meaning("part instance, its `number` in the annotation", "objects, points"),
    "link": Meaning("link, its `number` in the annotation", "objects, points"),
    "material": Meaning("material, an index into vocabularies.materials; 65535: none", "objects, points"),
    "npcs": Meaning(
        "place in the box of the instance, its diagonal 1 and its centre 0",
        "objects, points, 3",
        "part",
        "1",
        "float32",
    ),
    "primitive": Meaning("index into sites: which primitive of the program", "objects, points"),
    "element": Meaning("which of the object's primitives of that site, from 0", "objects, points"),
    "patch": Meaning("surface patch of the primitive, from 0", "objects, points"),
    "u": Meaning("first patch coordinate, a fraction 0 .. 1", "objects, points", "patch", "1", "float32"),
    "v": Meaning("second patch coordinate, a fraction 0 .. 1", "objects, points", "patch", "1", "float32"),
}
ACTING = Meaning(
    "joint that the label is for, its place in the annotation's list `joints`; 65535: none, or it does not hold",
    "objects, points",
)
AREA = {"area": Meaning("surface that the point stands for", "objects, points", unit="m2", dtype="float32")}
MOTIONS = {
    "motion": Meaning(
        "velocity of the point per unit of the next joint above its link", "objects, points, 3", "object",
        "m per rad, or m per m", "float32",
    ),
    "drivers": Meaning(
        "joints that move the point, places in the annotation's list `joints`; 65535: no more", "objects, points, drivers"
    ),
    "velocities": Meaning(
        "velocity of the point per unit of each of its drivers, with all that follows it", "objects, points, drivers, 3",
        "object", "m per rad, or m per m", "float32",
    ),
}  # fmt: skip
MOVING = ("points", "normals", "motion", "velocities")  # what depends on the state

_SHOT, _IMAGE, _CLOUD = ("objects, views" + more for more in ("", ", height, width", ", cloud"))
VIEWS = {
    "intrinsics": Meaning("camera matrix; the first pixel's centre is (0.5, 0.5)", f"{_SHOT}, 3, 3", dtype="float64"),
    "extrinsics": Meaning(
        "object's frame to the camera's: x right, y down, z forward", f"{_SHOT}, 4, 4", "camera", "m", "float64"
    ),
    "depth": Meaning("distance along the camera's z, 0: nothing seen", _IMAGE, "camera", "m", "float32"),
    "normal": Meaning("outward unit normal, 0: nothing seen", f"{_IMAGE}, 3", "object", "1", "float32"),
    "npcs": Meaning(
        "place in the box of the instance, its diagonal 1 and its centre 0; 0: nothing seen", f"{_IMAGE}, 3", "part",
        "1", "float32",
    ),
    "semantic": Meaning("class, an index into vocabularies.semantic; 0: unlabelled, 65535: nothing seen", _IMAGE),
    "instance": Meaning("part instance, its `number` in the annotation; 65535: nothing seen", _IMAGE),
    "link": Meaning("link, its `number` in the annotation; 65535: nothing seen", _IMAGE),
    "cloud_points": Meaning("points that the camera sees", f"{_CLOUD}, 3", "object", "m", "float32"),
    "cloud_camera": Meaning("the same points", f"{_CLOUD}, 3", "camera", "m", "float32"),
    "cloud_normals": Meaning("outward unit normals", f"{_CLOUD}, 3", "object", "1", "float32"),
    "cloud_pixel": Meaning("row and column of the pixel that shows the point", f"{_CLOUD}, 2"),
    "cloud_npcs": Meaning("as npcs", f"{_CLOUD}, 3", "part", "1", "float32"),
    "cloud_semantic": Meaning("as semantic", _CLOUD),
    "cloud_instance": Meaning("as instance", _CLOUD),
    "cloud_link": Meaning("as link", _CLOUD),
}  # fmt: skip
