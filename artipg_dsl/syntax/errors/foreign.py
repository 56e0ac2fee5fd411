"""What authors bring along from other languages and tools, and what to write here: hints of syntax errors."""

from __future__ import annotations

_CHOICE = "a choice is written `param kind : choice one | two`"
STATEMENTS_ELSEWHERE = {
    "if": "to make statements conditional, write `when ... { ... }`",
    "for": "to repeat parts, write `repeat x[i] in 0 ..< n { ... }`",
    "import": "to import from a module, write `use module { Name }`",
    "from": "to import from a module, write `use module { Name }`",
    "def": "a function is written `let f(x) = ...`",
    "class": "a reusable part is written `template Name { ... }`",
    "var": "to name a value, write `let x = ...`",
    "const": "to name a value, write `let x = ...`",
    "assert": "to require a condition, write `require ...`",
    "else": "`else` follows the closing brace of a `when`",
    "end": "a block ends with `}`",
    "endif": "a block ends with `}`",
    "elif": "write `else when ... { ... }`",
    "elseif": "write `else when ... { ... }`",
    "using": "to import from a module, write `use module { Name }`",
    "include": "to import from a module, write `use module { Name }`",
    "while": "to repeat parts, write `repeat x[i] in 0 ..< n { ... }`",
    "function": "a function is written `let f(x) = ...`",
    "return": "a function is written `let f(x) = ...`; its value follows `=`",
    "print": "`apgc ledger` shows values; a program cannot print",
    "object": "a category is written `category Name { ... }`",
    "module": "each file is a module; its only header is `apg 1`",
    "constraint": "to require a condition, write `require ...`",
    "set": "to name a value, write `let x = ...`; to state an equation, `align a = b`",
    "parameter": "a parameter is written `param x : length in 1cm .. 2cm`",
    **dict.fromkeys(("choice", "enum", "option"), _CHOICE),
    **dict.fromkeys(
        ("length", "angle", "ratio", "float", "number"), "a parameter is written `param x : length in 1cm .. 2cm`"
    ),
    "int": "a whole number is written `count n in 1 .. 4`",
    "apg": "`apg 1` must be the first line of a file",
    "variable": "to name a value, write `let x = ...`",
    **dict.fromkeys(
        "union difference intersection translate rotate scale cube sphere cylinder box add place".split(),
        "a shape is a part: `part post : Cylinder(radius = 1cm, height = 8cm)`, placed by `connect`, `joint` or `align`",
    ),
    "link": "links are derived from joints: declare parts, and joints between them",
}
CHARACTERS = {
    "'": 'text goes in double quotes: `"..."`',
    ";": "a statement ends at the end of its line; no `;` is needed",
    "&": "write `and`",
    "!": "write `not`",
    "`": "names are written without quotes",
    "\\": "a line continues by itself while a bracket is open",
    "%": "a percent sign follows its number directly: `8%`; a remainder is `mod(a, b)`",
    "\u2212": "use the keyboard's minus sign: `-`",
    "\u2013": "use the keyboard's minus sign: `-`",
    "\u2014": "use the keyboard's minus sign: `-`",
    "\u00d7": "write `*`",
    "\u00b7": "write `*`",
    "\u00f7": "write `/`",
    "\u2264": "write `<=`",
    "\u2265": "write `>=`",
    "\u2260": "write `!=`",
    "\u2192": "write `->`",
    "\u2026": "write `..`",
    "\u00b2": "write `^2`",
    "\u00b3": "write `^3`",
    "\u00bd": "write `1/2`",
    "\u03c0": "write `pi`",
    "\u00b0": "write the unit `deg`: `30deg`",
    "\u201c": 'use straight quotes: `"..."`',
    "\u201d": 'use straight quotes: `"..."`',
    "\u201e": 'use straight quotes: `"..."`',
    "\u00a0": "this is a non-breaking space: use an ordinary one",
    "\u200b": "this is a zero-width space: remove it",
}
MICROMETRES = ("\u00b5m", "\u03bcm")  # with the micro sign, and with the letter


_PLACED = "place a part by `connect` or `align`, in a separate statement"
CLAUSES_ELSEWHERE = {
    **{("part", word): _PLACED for word in ("at", "on", "to", "in", "fit")},
    **{
        ("part", word): "write `turned 90deg about x`, or `along x` to lay its z along x"
        for word in ("rotate", "rotated", "rotation", "turn")
    },
    ("part", "optional"): "write `| none` behind the last alternative",
    ("part", "mirror"): "for a mirrored pair, write `repeat x mirror across y { ... }`",
    ("param", "|"): _CHOICE,
    ("param", ".."): "a range follows `in`, and `=` gives the default: `param x : length in 1cm .. 2cm = 15mm`",
    ("align", "gap"): "put the distance into the equation: `align a.left = b.left + 1cm`",
    **{
        ("connect", word): "a moving part is attached by a `joint`"
        for word in ("range", "about", "along", "rest", "mimic")
    },
    ("connect", "weight"): "only alternatives and `prefer` take a weight",
    ("require", "weight"): "for a condition that may be broken, use `prefer`",
    ("prefer", "else"): "for a condition with a message, use `require`",
    ("joint", "spring"): "a spring back to `rest` is told by `stiffness 200N/m`, of a hinge by `stiffness 2Nm/rad`",
    **{("joint", word): "write `range low .. high`" for word in ("limit", "limits", "between")},
    **{
        ("joint", word): "a joint turns `about` an edge or a line and slides `along` a direction"
        for word in ("axis", "around")
    },
    ("joint", "ratio"): "a joint that follows another is told by `mimic lead * other`",
    ("limit", "range"): "put the range right after the joint: `limit lid.open 0deg .. 20deg`",
}
"""Clauses that people look for in a statement, and where they are."""
