"""What stands after a dot and is the language's own: a face of a box, the coordinate of a point, the direction of a line."""

from __future__ import annotations

from ..records import dataclass

FACES = ("front", "back", "left", "right", "top", "bottom")
"""The six faces of a box: +x -x +y -y +z -z."""

OWN = ("size", "center", "box")
"""Members that every box has besides its faces."""


@dataclass(frozen=True, slots=True)
class Member:
    """A member of what is of type ``of``; ``type`` is its own."""

    of: str
    name: str
    type: str
    about: str


def _table() -> tuple[Member, ...]:
    normals = dict(zip(FACES, ("x", "-x", "y", "-y", "z", "-z"), strict=True))
    return (
        *(Member("box", face, "plane", f"its face towards {axis}") for face, axis in normals.items()),
        Member("box", "center", "point", "its centre"),
        Member("box", "size", "length[3]", "its extents along x, y and z"),
        Member("box", "box", "box", "the box itself"),
        *(Member("plane", face, "edge", f"its edge with the face towards {axis}") for face, axis in normals.items()),
        Member("plane", "center", "point", "its centre"),
        Member("plane", "origin", "point", "its centre"),
        Member("plane", "out", "direction", "its normal"),
        Member("plane", "up", "direction", "z, or x for top and bottom"),
        *(Member("edge", face, "point", f"its end at the face towards {axis}") for face, axis in normals.items()),
        Member("edge", "center", "point", "its centre"),
        Member("edge", "origin", "point", "the beginning of the line"),
        Member("edge", "along", "direction", "normal of the first face x normal of the second"),
        *(Member("point", axis, "length", f"its coordinate along {axis}") for axis in "xyz"),
        Member("frame", "origin", "point", "its position"),
        Member("frame", "out", "direction", "its first direction"),
        Member("frame", "up", "direction", "its second direction"),
        Member("line", "origin", "point", "its beginning"),
        Member("line", "along", "direction", "its direction"),
    )


MEMBERS: dict[str, dict[str, Member]] = {}
"""By type and name. What has a box - a part, a slot, an element of a repeat - has the members of one."""

for _member in _table():
    MEMBERS.setdefault(_member.of, {})[_member.name] = _member
