"""What authors bring along from other languages and tools, and what to write here: hints for names that nothing declares."""

from __future__ import annotations


def _each(words: str, hint: str) -> dict[str, str]:
    return dict.fromkeys(words.split(), hint)


_ALONE = "names stand alone: what is declared here, `width`, or of a part, `seat.size.x`"
_ABSENT = "what may be absent has the alternative `none`: `part door : Door = SlabDoor | none`"
_FRAME = "x is to the front, y to the left, z up"

NAMES = {
    **_each("self this", _ALONE),
    **_each("None null nil nothing", _ABSENT),
    **_each(
        "mm cm m m2 cm2 m3 cm3 mm3 deg rad kg g", "a unit stands right behind its number, as in `5cm` or `700kg/m3`"
    ),
    **_each("X Y Z vertical horizontal up down upwards downwards forward forwards backward backwards sideways", _FRAME),
}

UNITS = {
    **_each("inch inches in ft feet foot", "lengths are in mm, cm or m: an inch is 25.4mm, a foot 30.48cm"),
    **_each("degree degrees grad", "angles are in deg, rad or turn"),
    **_each("px pt em", "lengths are in mm, cm or m"),
}

TYPES = {
    **_each(
        "float double real number num scalar",
        "numbers are of type `length`, `angle`, `ratio`, `mass` ...; whole ones of `count`",
    ),
    **_each("int integer uint", "a whole number is drawn by `count legs in 3 .. 5`"),
    **_each("boolean flag", "did you mean `bool`?"),
    **_each("str text", "did you mean `string`?"),
    **_each("enum option options", "one of some words is `choice round | square`"),
    **_each("vector vec3 array list tuple", "three lengths are `length[3]`, three plain numbers `vec`"),
    **_each("distance width height size metre meter", "did you mean `length`?"),
}

JOINTS = {
    **_each("hinge hinged rotary rotate turn swing pivot", "revolute"),
    **_each("slide slider sliding linear translate drawer", "prismatic"),
    **_each("wheel spin", "continuous"),
    **_each("rigid weld glue", "fixed"),
    **_each("spherical socket", "ball"),
    **_each("helical thread", "screw"),
}

MEMBERS = {
    **_each("depth length", "how far it reaches to the front is `size.x`"),
    **_each("width", "how far it reaches to the left is `size.y`"),
    **_each("height", "how far it reaches up is `size.z`"),
    **_each("position origin location pos", "where it stands is `center`, or one of its faces"),
    **_each("upper up", "did you mean `top`?"),
    **_each("lower down under", "did you mean `bottom`?"),
    **_each("rear", "did you mean `back`?"),
    **_each("x y z", "how long it is along an axis is `size.x`, where it stands `center.x`"),
}
