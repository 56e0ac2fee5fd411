"""Mistakes in the clauses of statements."""

from .base import Mistake

STATING = (
    Mistake(
        "`limit` takes no element of a repeat",
        "put it inside the repeat, for one element under a guard: `when k == 0 { limit open 0deg .. 20deg }`",
        ("limit a[0].b 1 .. 2", "limit a[k].b 1 .. 2", "limit a[last].b 1deg .. 2deg", "limit a[0].b.c 1 .. 2"),
    ),
    Mistake(
        "a label is written `vocabulary.word`",
        "for example `label semantic.door on door`",
        ("label a:b on c", "label door on door", "label door = 3"),
    ),
    Mistake(
        "a word of a vocabulary stands without quotes",
        "for example `label semantic.door on door`",
        ('label "a" on b', 'label a."b" on c', 'label a "b" on c'),
    ),
    Mistake(
        "`for` stands before `on`",
        "for example `label affordance.lift for raise on cover`",
        ("label a.b on c for d", "label a.b on c where d for e"),
    ),
    Mistake(
        "a message follows `else`",
        'for example `require a <= b else "a does not fit"`',
        (
            'require a, "b"',
            'require a > b, "c"',
            'require a > 1cm, "c"',
            'require a "b"',
            'require a > b "c"',
            'require a > 1cm "c"',
        ),
    ),
    Mistake(
        "the arrow of a joint is `->`",
        "`joint name : kind parent -> child`",
        ("joint j : revolute a => b", "joint j : revolute a = b"),
    ),
    Mistake(
        "a material must be named here",
        "to choose among materials, declare a style: `style look : material = steel when dark | oak`",
        ("material (a if b else c) on x",),
    ),
    Mistake(
        "a point is written in square brackets",
        "write `at [x, y, z]`",
        ("keypoint a on b at 0, 0, 0", "keypoint a on b at 1cm, 0, 0", "keypoint a on b at -1cm, 0"),
    ),
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
        "`on` is missing before `{}`",
        "a label, keypoint, grasp or material must say what it is on",
        (
            "label a.b c",
            "label a.b = c",
            "label a.b : c",
            "material a = b",
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
        "for example `turned 20deg about y`, `symmetry hub : turn 4 about z`, `symmetry knob : any about z`",
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
)
