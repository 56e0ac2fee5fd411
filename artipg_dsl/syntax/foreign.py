"""What authors bring along from other languages and tools, and what to write here: hints of syntax errors."""

from __future__ import annotations

STATEMENTS_ELSEWHERE = {
    "if": "a condition on statements is `when ... { ... }`",
    "for": "repetition is `repeat x[i] in 0 ..< n { ... }`",
    "import": "modules come in by `use module { Name }`",
    "from": "modules come in by `use module { Name }`",
    "def": "a function is `let f(x) = ...`",
    "class": "reusable parts are `template Name { ... }`",
    "var": "a name for a value is `let x = ...`",
    "const": "a name for a value is `let x = ...`",
    "assert": "a condition that has to hold is `require ...`",
    "else": "`else` follows the closing brace of a `when`",
    "elif": "write `else when ... { ... }`",
    "elseif": "write `else when ... { ... }`",
    "using": "modules come in by `use module { Name }`",
    "include": "modules come in by `use module { Name }`",
    "while": "repetition is `repeat x[i] in 0 ..< n { ... }`",
    "function": "a function is `let f(x) = ...`",
    "return": "a function is `let f(x) = ...`: its value stands behind `=`",
    "print": "`apgc ledger` shows values; a program prints nothing",
    "object": "a category of objects is `category Name { ... }`",
    "module": "a file is a module; it has no header but `apg 1`",
    "constraint": "a condition that has to hold is `require ...`",
    "set": "a name for a value is `let x = ...`, an equation is `align a = b`",
    "parameter": "a parameter is `param x : length in 1cm .. 2cm`",
    "apg": "`apg 1` is the first line of a file",
    "variable": "a name for a value is `let x = ...`",
    "link": "links follow from joints: declare parts, and joints between them",
}
CHARACTERS = {
    "'": 'text stands in double quotes: `"..."`',
    ";": "a statement ends at the end of its line; no `;` is needed",
    "&": "write `and`",
    "!": "write `not`",
    "`": "names stand without quotes",
    "\\": "a line that is open in brackets goes on by itself",
    "%": "a percentage is written right behind its number: `8%`; a remainder is `mod(a, b)`",
    "\u2212": "write the minus of the keyboard: `-`",
    "\u2013": "write the minus of the keyboard: `-`",
    "\u2014": "write the minus of the keyboard: `-`",
    "\u00d7": "write `*`",
    "\u00b7": "write `*`",
    "\u00f7": "write `/`",
    "\u2264": "write `<=`",
    "\u2265": "write `>=`",
    "\u2260": "write `!=`",
    "\u2192": "write `->`",
    "\u2026": "write `..`",
    "\u00b0": "write the unit `deg`: `30deg`",
    "\u201c": 'write the quotes of the keyboard: `"..."`',
    "\u201d": 'write the quotes of the keyboard: `"..."`',
    "\u201e": 'write the quotes of the keyboard: `"..."`',
    "\u00a0": "this is a space that does not break: write a plain one",
    "\u200b": "this space has no width: remove it",
}


_PLACED = "a part is placed by `connect` or `align`, in a statement of its own"
CLAUSES_ELSEWHERE = {
    **{("part", word): _PLACED for word in ("at", "on", "to", "in", "fit")},
    ("part", "mirror"): "two parts are `repeat x mirror across y { ... }`",
    ("align", "gap"): "the distance stands in the equation: `align a.left = b.left + 1cm`",
    **{
        ("connect", word): "what moves is attached by a `joint`"
        for word in ("range", "about", "along", "rest", "mimic")
    },
    ("connect", "weight"): "a weight is that of an alternative, or of `prefer`",
    ("require", "weight"): "what may be broken is a `prefer`",
    ("prefer", "else"): "a condition with a message is a `require`",
    ("limit", "range"): "the range follows the joint: `limit lid.open 0deg .. 20deg`",
}
"""Clauses that people look for in a statement, and where they are."""
