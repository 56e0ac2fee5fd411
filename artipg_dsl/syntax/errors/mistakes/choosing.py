"""Mistakes in templates, their alternatives and their arguments."""

from .base import Mistake

CHOOSING = (
    Mistake(
        "a style gives a role behind `:`, and its templates behind `=`",
        "for example `style pull : Handle = BarHandle | BowHandle`; for one template without a role, `style leg : Leg = Leg`; "
        "for several, write the alternatives at the part; for materials, `style look : material = oak | steel`",
        ("style x = A", "style x : A(b = 1)", "style x : A | B", "style x : A weight 2", "style x : A\n"),
    ),
    Mistake(
        "alternatives are separated by `|`",
        "for example `part door : Door = SlabDoor | WindowDoor weight 2`",
        (
            "part x : A or B",
            "part x : A, B",
            "part x : A(b = 1) or none",
            "part x : A(b = 1), none",
            "part x : R = A or B",
            "part x : R = A, B",
            "style s : R = A or B",
            "style s : R = A, B",
            "part x : R = A weight 2, B",
            "part x : A weight 2, B",
            "style s : R = A weight 2, B",
        ),
    ),
    Mistake(
        "`?` only marks what a role leaves optional",
        "a part that may be absent has the alternative `none`: `part lid : Lid | none`",
        ("part x : A?", "part x : A(b = 1)?", "part x?", "part x : R = A?", "part x : R = A | B?"),
    ),
    Mistake(
        "a template or `none` is missing",
        "for example `part door : Door = SlabDoor | none`",
        (
            "part x : R = | A",
            "part x : A | | B",
            "part x : 5",
            "part x : R = 5cm",
            "part x : A |\n}",
            "style s : R = 5",
            'part x : "A"',
        ),
    ),
    Mistake(
        "this `when` guards the alternative before it and cannot have a block",
        "a `when ... { }` statement must begin on a new line",
        ("part x : A when b { part c : D }", "style x : R = A when b { part c : D }", "part x : A weight 2 when b {"),
    ),
    Mistake(
        "the condition of an alternative follows `when`, not `if`",
        "for example `part lid : Flat when small | Domed`",
        ("part x : A if b", "part x : A(b = 1) if c", "part x : R = A if b", "style x : R = A if b"),
    ),
    Mistake(
        "an argument needs a name before `=`",
        "for example `Cuboid(size = [1cm, 2cm, 3cm])`",
        ("part x : A(= 3)", "part x : A(b, = 3)"),
    ),
    Mistake(
        "arguments must be in parentheses",
        "for example `Cuboid(size = [1cm, 2cm, 3cm])`",
        ("part x : A[b = 1]", "part x : A[b]", "part x : A{", "part x : R = A[b]"),
    ),
    Mistake(
        "an argument is written with `=`",
        "for example `Cuboid(size = [1cm, 2cm, 3cm])`",
        ("part x : A(size : 1)", "part x : A(b, size : 1)", "part x : R = A(size : 1)", "let x = f(size : 1)"),
    ),
)
