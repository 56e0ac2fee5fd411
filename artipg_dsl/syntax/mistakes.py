"""Syntax errors that people make, by example: what to say about each, and sentences that contain it.

``{}`` stands for the offending token. ``examples`` finds the message for an error by these sentences.
"""

from __future__ import annotations

from typing import NamedTuple


class Mistake(NamedTuple):
    """``sentences`` stand in the body of a category, except those that begin with ``top:``."""

    message: str
    hint: str
    sentences: tuple[str, ...]


MISTAKES = (
    Mistake(
        "`:` is missing between the name and its type",
        "for example `part door : SlabDoor`",
        (
            "part x Cuboid",
            "root part x Cuboid",
            "style x Handle = A",
            "joint x revolute a -> b",
            "field x ratio on a = 1",
            "port x frame",
            "part x = Cuboid",
        ),
    ),
    Mistake(
        "a style gives a role behind `:`, and its templates behind `=`",
        "for example `style pull : Handle = BarHandle | BowHandle`; for one template without a role, `style leg : Leg = Leg`; "
        "for several, write the alternatives at the part; for materials, `style look : material = oak | steel`",
        ("style x = A", "style x : A(b = 1)", "style x : A | B", "style x : A weight 2", "style x : A\n"),
    ),
    Mistake(
        "`limit` takes no element of a repeat",
        "put it inside the repeat, for one element under a guard: `when k == 0 { limit open 0deg .. 20deg }`",
        ("limit a[0].b 1 .. 2", "limit a[k].b 1 .. 2", "limit a[last].b 1deg .. 2deg", "limit a[0].b.c 1 .. 2"),
    ),
    Mistake(
        "this parameter has no type",
        "a type follows a colon: `param width : length in 40cm .. 60cm = 50cm`",
        (
            "param x = 5cm",
            "param x in 1cm .. 2cm",
            "param x length",
            "param x > 0",
            "inherit x length",
            "param x\n",
            "param x 5cm",
            "param x ~ normal(1, 2)",
        ),
    ),
    Mistake(
        "a name is missing before `{}`",
        "a declaration begins with its keyword, then its name",
        (
            "param : length",
            "part : Cuboid",
            "joint : revolute a -> b",
            "count in 1 .. 2",
            "slot = a",
            "let = 3",
            "style : Handle = A",
            "port : frame",
            "repeat in 0 ..< 3 {",
            "top:category {",
            "top:role {",
            "top:template : Role {",
            "top:vocabulary {",
            "top:primitive {",
            "label on a",
        ),
    ),
    Mistake(
        "the type is missing before `{}`",
        "for example `length`, `angle`, `ratio`, `count` or `choice a | b`",
        ("param x : = 5cm", "param x : in 1cm .. 2cm", "param x : 5cm", "param x : > 0"),
    ),
    Mistake(
        "the kind of joint is missing",
        "for example `joint open : revolute body -> door about door.left.back`",
        ("joint open : body -> door", "joint open : -> door"),
    ),
    Mistake(
        "`=` is missing before `{}`",
        "a declaration gives its value after `=`",
        (
            "let x 5",
            "let f(x) x",
            "let x\n",
            "top:let x 5",
            "top:let f(x) x",
            "inside (p) p.x",
            "box [1, 2, 3]",
            "solid lathe(a)",
            "curve a line(1)",
            "piece a hull(b)",
        ),
    ),
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
        "a range is written with `..` and includes both ends",
        "`..<` only counts the elements of a repeat",
        ("count n in 1 ..< 5", "param x : length in 1cm ..< 2cm"),
    ),
    Mistake(
        "a `let` takes no type: it has the type of its value",
        "write `let half = width / 2`",
        ("let x : 5", "let x : length = 5", "top:let x : 5"),
    ),
    Mistake(
        "a label is written `vocabulary.word`",
        "for example `label semantic.door on door`",
        ("label a:b on c", "label door on door", "label door = 3"),
    ),
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
        "a property is followed by its value alone",
        "for example `colour [0.6, 0.4, 0.2]`, with a space between",
        (
            "top:material a { colour = [1, 0, 0] }",
            "top:material a { colour : [1, 0, 0] }",
            "top:material a { density 5 colour = 1 }",
        ),
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
        "a word of a vocabulary stands without quotes",
        "for example `label semantic.door on door`",
        ('label "a" on b', 'label a."b" on c', 'label a "b" on c'),
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
    Mistake("`else` is followed by `when`, not by `if`", "write `else when ... { }`", ("when a { } else if b { }",)),
    Mistake(
        "an argument needs a name before `=`",
        "for example `Cuboid(size = [1cm, 2cm, 3cm])`",
        ("part x : A(= 3)", "part x : A(b, = 3)"),
    ),
    Mistake(
        "a vector is written in square brackets",
        "write `[x, y, z]`",
        (
            "let x = (1, 2, 3)",
            "part x : A(size = (1, 2, 3))",
            "let x = f((1, 2))",
            "let x = (a, b)",
            "let x = (1cm, 2cm)",
        ),
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
        "the arrow of a joint is `->`",
        "`joint name : kind parent -> child`",
        ("joint j : revolute a => b", "joint j : revolute a = b"),
    ),
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
    Mistake(
        "the index of a repeat must be in square brackets",
        "for example `repeat leg[k] in 0 ..< 4 { ... }`",
        ("repeat x i in 0 ..< 4 {", "repeat x(i) in 0 ..< 4 {"),
    ),
    Mistake(
        "a name may only contain letters, digits and `_`",
        "write `left_leg`",
        (
            "part a-b : C",
            "param a-b : length",
            "let a-b = 1",
            "style a-b : C = D",
            "joint a-b : revolute c -> d",
            "slot a-b",
            "count a-b in 1 .. 2",
            "top:category A-B {",
            "top:template A-B {",
            "repeat a-b in 0 ..< 2 {",
        ),
    ),
    Mistake(
        "a name must begin with a letter",
        "for example `second_leg`",
        (
            "part 2 : A",
            "param 2 : length",
            "let 5 = 3",
            "count 2 in 1 .. 2",
            "joint 2 : revolute a -> b",
            "repeat 2 in 0 ..< 3 {",
            "style 2 : A = B",
            "slot 2",
            "port 2 : frame",
            "top:category 2 {",
            "top:template 2 {",
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
        "the question mark of an optional port comes after its name",
        "write `port x ? : frame`",
        ("port x : frame ?", "port x[2] : frame ?"),
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
        "a material must be named here",
        "to choose among materials, declare a style: `style look : material = steel when dark | oak`",
        ("material (a if b else c) on x",),
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
        "the options of a choice are written without quotes",
        "for example `param kind : choice round | square = round`",
        ('param x : choice "a" | "b"', 'param x : choice a | "b"'),
    ),
    Mistake(
        "the options of a choice are separated by `|`",
        "for example `param kind : choice round | square`",
        (
            "param x : choice a, b",
            "param x : choice a or b",
            "param x : choice a and b",
            "param x : choice a / b",
            "param x : choice a b",
            "param x : choice a | b or c",
            "param x : choice a | b, c",
        ),
    ),
    Mistake(
        "the options of a choice stand without brackets",
        "for example `param kind : choice round | square`",
        ("param x : choice (a | b)", "param x : choice [a, b]", "param x : choice { a, b }"),
    ),
    Mistake(
        "a point is written in square brackets",
        "write `at [x, y, z]`",
        ("keypoint a on b at 0, 0, 0", "keypoint a on b at 1cm, 0, 0", "keypoint a on b at -1cm, 0"),
    ),
    Mistake(
        "a reduction goes over all elements by itself",
        "write the path through the repeat: `sum(leg.bar.size.z)`, `max(row.wide)`",
        ("let x = sum(a.b for c in d)", "let x = max(a for c in d)", "let x = sum(2 * a for c in d)"),
    ),
    Mistake("a power is written with `^`", "for example `r ^ 2`", ("let x = a ** 2",)),
    Mistake(
        "a message in quotes is missing after `else`",
        'for example `require a <= b else "a does not fit"`',
        ("require a else b", "require a else 5", "require a else\n}", "require stable else b"),
    ),
    Mistake(
        "an allowed overlap takes two parts, separated by a comma",
        '`allow overlap a, b because "the post is glued into the wall"`',
        ('allow overlap a and b because "c"', 'allow overlap a because "c"', "allow overlap a b", "allow overlap a\n"),
    ),
    Mistake(
        "the number of elements stands behind `ring`",
        "for example `repeat foot[k] ring 3 about line(at = hub.center, along = z) { }`, without `in 0 ..< n`",
        ("repeat x[i] in 0 ..< 3 ring about z {", "repeat x[i] ring about z {", "repeat x ring about z {"),
    ),
    Mistake(
        "the pieces of a path follow one another without commas",
        "for example `curve way = from([0, 0, 0], x) line(3cm) arc(radius = 2cm, angle = 90deg, towards = z)`",
        ("curve x = from([0, 0, 0], x), line(3cm)", "curve x = from([0, 0, 0], x) line(3cm), arc(1cm, 90deg, z)"),
    ),
    Mistake(
        "an allowed overlap needs a reason",
        '`allow overlap a, b because "the post is glued into the wall"`',
        ("allow overlap a, b\n", "allow overlap a, b }"),
    ),
    Mistake(
        "`allow` must be followed by `overlap` or `floating`",
        '`allow overlap a, b because "..."`',
        ("allow a, b", "allow a"),
    ),
    Mistake("`from` is missing", "`clear a from b by 1mm`", ("clear a, b by 1mm", "clear a by 1mm", "clear a\n")),
    Mistake("`by` is missing", "`clear a from b by 1mm`", ("clear a from b\n", "clear a from b, c")),
    Mistake(
        "`free` takes two parts",
        "`free a, b` lets two parts touch and pass through one another",
        ("free a\n", "free a }", "free a b", "free a and b"),
    ),
    Mistake(
        "a range must directly follow the joint",
        "`limit lid.open 0deg .. 20deg`",
        ("limit a range 0deg .. 10deg", "limit a.b range 1 .. 2"),
    ),
    Mistake(
        "parameters must be declared inside the braces",
        "for example `param width : length in 1cm .. 2cm`",
        ("top:category C(a) {", "top:template C(a) {", "top:role C(a) {", "top:primitive C(a) {"),
    ),
    Mistake(
        "`on` is missing before `{}`",
        "a label, keypoint, grasp or material must say what it is on",
        (
            "label a.b c",
            "label a.b = c",
            "keypoint a at b",
            "grasp g for t in 0 .. 1 { }",
            "material oak body",
            "keypoint a b",
            "grasp g h { }",
            "label a.b\n",
            "material oak\n",
        ),
    ),
    Mistake(
        "`about` is missing",
        "for example `turned 20deg about y`, `symmetry knob : any about z`",
        (
            "part x : A turned 20deg\n",
            "symmetry a : any z",
            "symmetry a : turn 2 z",
            "part x : A turned 20deg along y",
            "symmetry a : any\n",
            "symmetry a : turn 2\n",
        ),
    ),
    Mistake(
        "a symmetry must be `turn` with a number, or `any`",
        "`symmetry handle : turn 2 about z`",
        ("symmetry a : 2 about z", "symmetry a : z"),
    ),
    Mistake("`and` is missing", "`connect bar between a and b`", ("connect a between b, c", "connect a between b\n")),
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
