"""Mistakes in values, conditions, ranges and curves."""

from .base import Mistake

VALUES = (
    Mistake(
        "comparisons cannot be chained",
        "compare twice: `a < b and b < c`",
        (
            "require a < b < c",
            "require a <= b < c",
            "require a == b == c",
            "require a < b > c",
            "require a < b >= c",
            "require a < b != c",
            "require a < b <= c",
        ),
    ),
    Mistake(
        "`is` takes the name of a role or template",
        "for example `when handle is BarHandle { ... }`",
        ("when a is 5 {", "when a is not B {", "require a is not B", "require a is (B)"),
    ),
    Mistake(
        "`none` is no template: what it leaves is absent",
        "a part by itself tells whether it is there: `when handle { }`, `when not handle { }`",
        ("when a is none {",),
    ),
    Mistake(
        "a range is written with `..` and includes both ends",
        "`..<` only counts the elements of a repeat",
        ("count n in 1 ..< 5", "param x : length in 1cm ..< 2cm"),
    ),
    Mistake(
        "a vector is written in square brackets",
        "write `[x, y, z]`; a range is written `low .. high`",
        (
            "let x = (1, 2, 3)",
            "part x : A(size = (1, 2, 3))",
            "let x = f((1, 2))",
            "let x = (a, b)",
            "let x = (1cm, 2cm)",
        ),
    ),
    Mistake(
        "a range is written with two dots",
        "write `1cm .. 2cm`",
        ("param x : length in 1cm ... 2cm", "count x in 1 ... 2", "let x = f(1 ... 2)"),
    ),
    Mistake(
        "expected a name after the dot",
        "a number needs digits after its point, as in `5.0`; a range is written with two dots, as in `1cm .. 2cm`",
        (
            "let x = 5. * 2",
            "let x = 5. + 2",
            "let x = 5. - 2",
            "let x = 5. / 2",
            "let x = f(5.)",
            "let x = f(5., 1)",
            "param x : length in 1cm . 2cm",
            "let x = a.[1]",
            "let x = a.(1)",
        ),
    ),
    Mistake(
        "a range is written without brackets",
        "write `in 1cm .. 2cm`",
        (
            "param x : length in [1cm .. 2cm]",
            "count x in [1 .. 2]",
            "param x : length in (1cm .. 2cm)",
            "count x in (1 .. 2)",
        ),
    ),
    Mistake(
        "`|` separates the alternatives of a part",
        "to join conditions, write `or`",
        (
            "require a | b",
            "when a | b {",
            "let x = a | b",
            "prefer a | b",
            "require a > 1 | b",
            "require a > 1cm | b",
            "when a > 1 | b {",
        ),
    ),
    Mistake(
        "`?` only marks what a role leaves optional",
        "a conditional value is written `1 if a > b else 2`",
        ("let x = a ? 1 : 2", "let x = a > 1 ? 1 : 2", "let x = a > 1cm ? 1 : 2", "part x : A(b = c ? 1 : 2)"),
    ),
    Mistake(
        "a reduction goes over all elements by itself",
        "write the path through the repeat: `sum(leg.bar.size.z)`, `max(row.wide)`",
        ("let x = sum(a.b for c in d)", "let x = max(a for c in d)", "let x = sum(2 * a for c in d)"),
    ),
    Mistake("a power is written with `^`", "for example `r ^ 2`", ("let x = a ** 2",)),
    Mistake(
        "the pieces of a path follow one another without commas",
        "for example `curve way = from([0, 0, 0], x) line(3cm) arc(radius = 2cm, angle = 90deg, towards = z)`",
        ("curve x = from([0, 0, 0], x), line(3cm)", "curve x = from([0, 0, 0], x) line(3cm), arc(1cm, 90deg, z)"),
    ),
    Mistake(
        "each parameter needs a range: `u in low .. high`",
        "`surface side (u in 0turn .. 1turn, v in 0 .. 1) = ...`",
        (
            "surface a (u, v) = [1, 2, 3]",
            "surface a (u in 0 .. 1) = [1]",
            "curve a (v) = [1, 2]",
            "surface a = [1, 2, 3]",
            "surface a (u = 1)",
        ),
    ),
)
