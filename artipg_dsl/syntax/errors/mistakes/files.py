"""Mistakes in imports, materials and vocabularies."""

from .base import Mistake

FILES = (
    Mistake(
        "the names imported by `use` must be in braces",
        "for example `use handles { Handle, BarHandle }`",
        ("top:use handles BarHandle", "top:use handles\nuse doors { A }", "top:use handles : A"),
    ),
    Mistake(
        "a `use` names what it imports",
        "for example `use handles { Handle, BarHandle }`; without a name, leave it out",
        ("top:use handles { }",),
    ),
    Mistake(
        "`use` names a module, without path or quotes",
        "for example `use primitives { Cuboid }`: a file `my.apg` beside this one is the module `my`",
        ('top:use "primitives.apg" { Cuboid }',),
    ),
    Mistake(
        "each name must be imported by itself",
        "for example `use primitives { Cuboid, Cylinder }`; the library page lists what a module declares",
        ("top:use primitives { * }", "top:use primitives { Cuboid, * }"),
    ),
    Mistake(
        "a property is followed by its value alone",
        "for example `colour [0.6, 0.4, 0.2]`, with a space between",
        (
            "top:material a { colour = [1, 0, 0] }",
            "top:material a { colour : [1, 0, 0] }",
            "top:material a { density 5 colour = 1 }",
        ),
    ),
    Mistake(
        "the value of a property is missing before the end of the line",
        "`#` begins a comment; a colour is written `colour [red, green, blue]`, each from 0 to 1",
        ("top:material a { colour\n", "top:material a { density 5kg/m3 colour\n"),
    ),
    Mistake(
        "properties stand side by side, without commas",
        "for example `roughness 0.5  metalness 0`, or each on a line of its own",
        (
            "top:material a { roughness 0.5, metalness 0 }",
            "top:material a { density 5kg/m3, metalness 0 }",
            "top:material a { colour [1, 0, 0], metalness 0 }",
        ),
    ),
    Mistake(
        "how a word moves is told by `along` or `about`",
        "`slide : along` is a word for joints that slide, `turn : about` one for joints that turn",
        ("top:vocabulary a { b : c }",),
    ),
)
