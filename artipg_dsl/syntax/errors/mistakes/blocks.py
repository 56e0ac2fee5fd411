"""Mistakes in blocks, their braces and the elements of a `repeat`."""

from .base import Mistake

BLOCKS = (
    Mistake(
        "a block is written in braces, without a colon",
        "for example `when width > 40cm { ... }`",
        (
            "when a : b",
            "when a > 1 : b",
            "when a > 1cm : b",
            "when a { } else : b",
            "top:category C : X {",
            "top:primitive P : X {",
            "repeat x[i] in 0 ..< n : b",
            "repeat x[i] in 0 ..< 4 : b",
            "top:template C : X : Y",
        ),
    ),
    Mistake("`else` is followed by `when`, not by `if`", "write `else when ... { }`", ("when a { } else if b { }",)),
    Mistake(
        "elements must be counted with `..<`",
        "write `in 0 ..< n`: the index is then 0, 1, ... n - 1",
        ("repeat x[i] in 0 .. 5 { }", "repeat x in 0 .. n { }"),
    ),
    Mistake(
        "the elements of a repeat must be given as `in 0 ..< n`",
        "for example `repeat shelf[k] in 0 ..< shelves { ... }`",
        (
            "repeat x 5 { }",
            "repeat x[i] 5 { }",
            "repeat x[i] n { }",
            "repeat x[i], 5 { }",
            "repeat x[i] = 5 { }",
            "repeat x in 5 { }",
            "repeat x[i] in n { }",
            "repeat x in n split box along x { }",
            "repeat x in n pitch 1cm along x { }",
            "repeat x in f(n) pitch 1cm along x { }",
            "repeat x in n spread a along x { }",
            "repeat x in f(n) spread a along x { }",
            "repeat x in f(n) split a along x { }",
            "repeat x in f(n) { }",
        ),
    ),
    Mistake(
        "the brackets hold the index alone",
        "the elements follow behind them: `repeat shelf[k] in 0 ..< shelves { ... }`",
        (
            "repeat x[i in 0 ..< n] { }",
            "repeat x[i = n] { }",
            "repeat x[i, j] in 0 ..< n { }",
            "repeat x[3] in 0 ..< n { }",
        ),
    ),
    Mistake(
        "the index of a repeat must be in square brackets",
        "for example `repeat leg[k] in 0 ..< 4 { ... }`",
        ("repeat x i in 0 ..< 4 {", "repeat x(i) in 0 ..< 4 {"),
    ),
    Mistake(
        "the box is missing before `along`",
        "for example `spread body along y`",
        (
            "repeat x[i] in 0 ..< 3 spread along y {",
            "repeat x[i] in 0 ..< 3 split along y {",
            "repeat x[i] fill along y every 1cm {",
        ),
    ),
    Mistake(
        "the number of elements stands behind `ring`",
        "for example `repeat foot[k] ring 3 about line(at = hub.center, along = z) { }`, without `in 0 ..< n`",
        ("repeat x[i] in 0 ..< 3 ring about z {", "repeat x[i] ring about z {", "repeat x ring about z {"),
    ),
)
