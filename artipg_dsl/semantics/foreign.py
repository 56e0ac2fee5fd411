"""What authors bring along from other languages and tools, and what to write here: hints for names that nothing declares."""

from __future__ import annotations


def _each(words: str, hint: str) -> dict[str, str]:
    return dict.fromkeys(words.split(), hint)


_ALONE = "use the name itself: `width` for what is declared here, `seat.size.x` for a member of a part"
_ABSENT = "for a part that may be absent, use the alternative `none`: `part door : Door = SlabDoor | none`"
_FRAME = "x points to the front, y to the left, z up"

ABSENT = _each("None null nil nothing Nothing", _ABSENT)

NAMES = {
    **_each("self this", _ALONE),
    **ABSENT,
    **_each("mm cm m m2 cm2 m3 cm3 mm3 deg rad kg g", "a unit directly follows its number, as in `5cm` or `700kg/m3`"),
    **_each("centre centred middle centered", "did you mean `center`?"),
    **_each("X Y Z vertical horizontal up down upwards downwards forward forwards backward backwards sideways", _FRAME),
}

UNITS = {
    **_each("inch inches in ft feet foot", "use mm, cm or m: an inch is 25.4mm, a foot 30.48cm"),
    **_each("degree degrees grad", "use deg, rad or turn for angles"),
    **_each("px pt em", "use mm, cm or m for lengths"),
}

TYPES = {
    **_each(
        "float double real number num scalar",
        "use `length`, `angle`, `ratio`, `mass` ... for numbers, `count` for whole numbers",
    ),
    **_each("int integer uint", "for a whole number, write `count legs in 3 .. 5`"),
    **_each("boolean flag", "did you mean `bool`?"),
    **_each("str text", "did you mean `string`?"),
    **_each("enum option options", "for one of several options, write `choice round | square`"),
    **_each("vector vec3 array list tuple", "use `length[3]` for three lengths, `vec` for three plain numbers"),
    **_each("distance width height size metre meter", "did you mean `length`?"),
}

_DRAWN = "a value is drawn by a parameter: `param lip : length in 1cm .. 2cm`, with `~ normal(15mm, 2mm)` if it is not uniform"

OPERATORS = {
    **_each("rotate_extrude revolve revolution spin turn", "lathe"),
    **_each("linear_extrude prism pad extrusion", "extrude"),
    **_each("pipe tube path_extrude follow", "sweep"),
    **_each("skin blend hull", "loft"),
}

FUNCTIONS = {
    **_each("random rand uniform normal gauss gaussian choose pick sample", _DRAWN),
    **_each("clamp clip limit", "write `min(max(a, low), high)`"),
    **_each("lerp mix interpolate", "write `a + t * (b - a)`"),
    **_each("len length_of size count_of", "`number(row)` counts the elements of a repeat; a number has no length"),
    **_each("radians degrees deg rad", "an angle is a number with its unit, such as `30deg`, or a number times `1deg`"),
    **_each("pow power", "a power is written with `^`: `r ^ 2`"),
    **_each("average mean", "write `sum(row.wide) / number(row)`"),
    **_each("vec vec3 point vector", "a vector is written in square brackets: `[x, y, z]`"),
}

MATERIALS = {
    **_each("wood wooden timber plywood beech birch maple ash cherry mahogany spruce bamboo", "oak pine walnut"),
    **_each("metal metallic alloy", "steel aluminium brass copper"),
    **_each("aluminum", "aluminium"),
    **_each("iron", "cast_iron steel"),
    **_each("gold golden bronze", "brass copper"),
    **_each("cloth textile canvas cotton linen wool felt velvet", "blue_fabric grey_fabric"),
    **_each("porcelain china stoneware clay terracotta stone marble concrete", "ceramic"),
    **_each(
        "nylon abs polymer resin polypropylene acrylic plexiglass",
        "white_plastic grey_plastic black_plastic clear_plastic",
    ),
    **_each("vinyl", "white_pvc"),
    **_each("silicone foam elastomer tpu", "rubber"),
    **_each("cardboard carton", "kraft_board white_board"),
    **_each("hide suede", "black_leather"),
}
"""Materials by names that the library has not, and its nearest."""

_MADE = "a part takes its looks from a statement of its own: `material oak on NAME`"
_PLACED = "a part is placed by statements of its own: `connect`, `joint` or `align NAME.center = [x, y, z]`"
_TURNED = "a part is turned behind its template: `part post : Cylinder(...) turned 20deg about y`"
_HALVED = "give the `radius`, half of it"

ARGUMENTS = {
    **_each("colour color material mat texture", _MADE),
    **_each("at pos position xyz origin center centre location translate offset parent", _PLACED),
    **_each("rpy rot rotate rotation orientation turned along axis", _TURNED),
}
"""Arguments that no template takes, unless it says so itself."""

SIZES = {
    "r": ("radius", "did you mean `radius`?"),
    "rad": ("radius", "did you mean `radius`?"),
    "h": ("height", "did you mean `height`?"),
    "length": ("height", "did you mean `height`? it goes along z, unless the part lies `along x`"),
    **dict.fromkeys(("d", "diam", "diameter"), ("radius", _HALVED)),
    **dict.fromkeys(
        "width height depth dimensions dims extents x y z".split(),
        ("size", "write `size = [depth, width, height]`: its extents along x, y and z"),
    ),
}
"""Arguments by names of other tools: which parameter is meant, and what to write."""

JOINTS = {
    **_each("hinge hinged rotary rotate turn swing pivot", "revolute"),
    **_each("slide slider sliding linear translate drawer", "prismatic"),
    **_each("wheel spin", "continuous"),
    **_each("rigid weld glue", "fixed"),
    **_each("spherical socket", "ball"),
    **_each("helical thread", "screw"),
}

MEMBERS = {
    **_each("depth length", "its depth is `size.x`"),
    **_each("width", "its width is `size.y`"),
    **_each("height", "its height is `size.z`"),
    **_each("position origin location pos", "use `center`, or one of its faces"),
    **_each("upper up", "did you mean `top`?"),
    **_each("lower down under", "did you mean `bottom`?"),
    **_each("rear", "did you mean `back`?"),
    **_each(
        "exists exist present is_present there valid",
        "a part by itself tells whether it is there: `when handle { }`, `not handle`",
    ),
    "axis": "write the axis: an edge, such as `part.left.back`, or `line(at = part.center, along = z)`",
    **_each("x y z", "use `size.x` for its length along x, `center.x` for its position"),
}
