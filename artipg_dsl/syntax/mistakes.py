"""Syntax errors that people make, by example: what to say about each, and sentences that contain it.

The sentences are parsed once, when the first syntax error needs words; the state of the parser and the token at
which each stops are the key to its message. ``{}`` stands for the offending token.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

from lark import Token, UnexpectedToken

from ..source import Source
from .grammar import Machine


class Mistake(NamedTuple):
    """``sentences`` stand in the body of a category, except those that begin with ``top:``."""

    message: str
    hint: str
    sentences: tuple[str, ...]


MISTAKES = (
    Mistake(
        "`:` is missing between a name and what it is", "for example `part door : SlabDoor`",
        ("part x Cuboid", "root part x Cuboid", "style x Handle = A", "joint x revolute a -> b",
         "field x ratio on a = 1",          "port x frame", "part x = Cuboid", "style x = A"),
    ),
    Mistake(
        "this parameter has no type", "a type stands behind a colon: `param width : length in 40cm .. 60cm = 50cm`",
        ("param x = 5cm", "param x in 1cm .. 2cm", "param x length", "param x > 0", "inherit x length", "param x\n",
         "param x 5cm", "param x ~ normal(1, 2)"),
    ),
    Mistake("a name is missing before `{}`", "a declaration begins with its word, then its name",
            ("param : length", "part : Cuboid", "joint : revolute a -> b", "count in 1 .. 2", "slot = a", "let = 3",
             "style : Handle = A", "port : frame", "repeat in 0 ..< 3 {", "top:category {", "top:role {",
             "top:template : Role {", "top:vocabulary {", "top:primitive {", "label on a")),
    Mistake("the type is missing before `{}`", "for example `length`, `angle`, `ratio`, `count` or `choice a | b`",
            ("param x : = 5cm", "param x : in 1cm .. 2cm", "param x : 5cm", "param x : > 0")),
    Mistake("the kind of joint is missing", "for example `joint open : revolute body -> door about door.left.back`",
            ("joint open : body -> door", "joint open : -> door")),
    Mistake("`=` is missing before `{}`", "a declaration gives its value behind `=`",
            ("let x 5", "let x : 5", "let f(x) x", "let x\n", "top:let x 5", "top:let f(x) x", "inside (p) p.x",
             "box [1, 2, 3]", "solid lathe(a)", "curve a line(1)", "piece a hull(b)")),
    Mistake("comparisons cannot be chained", "compare twice: `a < b and b < c`",
            ("require a < b < c", "require a <= b < c", "require a == b == c", "require a < b > c",
             "require a < b >= c",              "require a < b != c", "require a < b <= c")),
    Mistake("`is` takes the name of a role or template", "for example `when handle is BarHandle { ... }`",
            ("when a is 5 {", "when a is not B {", "require a is (B)", "when a is none {")),
    Mistake("elements are counted with `..<`", "write `in 0 ..< n`: the index is then 0, 1, ... n - 1",
            ("repeat x[i] in 0 .. 5 { }", "repeat x in 0 .. n { }")),
    Mistake("the elements of a repeat are given as `in 0 ..< n`",
            "for example `repeat shelf[k] in 0 ..< shelves { ... }`",
            ("repeat x in 5 { }", "repeat x[i] in n { }", "repeat x in n split box along x { }")),
    Mistake("a range is written with `..`; both ends belong to it", "`..<` counts the elements of a repeat",
            ("count n in 1 ..< 5", "param x : length in 1cm ..< 2cm")),
    Mistake("a label is written `vocabulary.word`", "for example `label semantic.door on door`",
            ("label door on door", "label door = 3")),
    Mistake("the names that a `use` brings in stand in braces", "for example `use handles { Handle, BarHandle }`",
            ("top:use handles BarHandle", "top:use handles\nuse doors { A }", "top:use handles : A")),
    Mistake("alternatives are separated by `|`", "for example `part door : Door = SlabDoor | WindowDoor weight 2`",
            ("part x : A or B", "part x : A, B", "part x : R = A or B", "part x : R = A, B", "style s : R = A or B",
             "style s : R = A, B")),
    Mistake("a template or `none` is missing", "for example `part door : Door = SlabDoor | none`",
            ("part x : R = | A", "part x : A | | B", "part x : 5", "part x : R = 5cm", "part x : A |\n}",
             "style s : R = 5", "part x : \"A\"")),
    Mistake("this `when` is the guard of the alternative before it and has no block",
            "a statement `when ... { }` begins on a line of its own",
            ("part x : A when b { part c : D }", "style x : R = A when b { part c : D }",
             "part x : A weight 2 when b {")),
    Mistake("the `when` that follows `else` is not `if`", "write `else when ... { }`", ("when a { } else if b { }",)),
    Mistake("a name stands before `=` in an argument", "for example `Cuboid(size = [1cm, 2cm, 3cm])`",
            ("part x : A(= 3)", "part x : A(b, = 3)")),
    Mistake("a power is written with `^`", "for example `r ^ 2`", ("let x = a ** 2",)),
    Mistake("a message in quotes is missing behind `else`", "for example `require a <= b else \"a does not fit\"`",
            ("require a else b", "require a else 5", "require a else\n}", "require stable else b")),
    Mistake("an overlap needs its reason", "`allow overlap a, b because \"the post is glued into the wall\"`",
            ("allow overlap a, b\n", "allow overlap a, b }")),
    Mistake("`allow` is followed by `overlap` or `floating`", "`allow overlap a, b because \"...\"`", ("allow a, b", "allow a")),
    Mistake("`from` is missing", "`clear a from b by 1mm`", ("clear a, b by 1mm", "clear a by 1mm", "clear a\n")),
    Mistake("`by` is missing", "`clear a from b by 1mm`", ("clear a from b\n", "clear a from b, c")),
    Mistake("`on` is missing before `{}`", "a label, keypoint, grasp or material says on what it is",
            ("label a.b c", "label a.b = c", "keypoint a at b", "grasp g for t in 0 .. 1 { }", "material oak body",
             "keypoint a b", "grasp g h { }", "label a.b\n", "material oak\n")),
    Mistake("`about` is missing", "for example `turned 20deg about y`, `symmetry knob : any about z`",
            ("part x : A turned 20deg\n", "symmetry a : any z", "symmetry a : turn 2 z",
             "part x : A turned 20deg along y",              "symmetry a : any\n", "symmetry a : turn 2\n")),
    Mistake("a symmetry is `turn` with a number, or `any`", "`symmetry handle : turn 2 about z`",
            ("symmetry a : 2 about z", "symmetry a : z")),
    Mistake("`and` is missing", "`connect bar between a and b`", ("connect a between b, c", "connect a between b\n")),
    Mistake("the range of a parameter is written `u in low .. high`",
            "`surface side (u in 0turn .. 1turn, v in 0 .. 1) = ...`",
            ("surface a (u, v) = [1, 2, 3]", "surface a (u in 0 .. 1) = [1]", "curve a (v) = [1, 2]",
             "surface a = [1, 2, 3]",              "surface a (u = 1)")),
)  # fmt: skip


def wrapped(sentence: str) -> str:
    """A whole program that holds the sentence."""
    return sentence.removeprefix("top:") + "\n" if sentence.startswith("top:") else f"category C {{\n{sentence}\n}}\n"


@cache
def table(tools: Machine) -> dict[tuple[int, str], Mistake]:
    """State and token type to what to say."""
    found: dict[tuple[int, str], Mistake] = {}
    for mistake in MISTAKES:
        for sentence in mistake.sentences:
            where = stop(tools, sentence)
            if where is not None:
                found.setdefault(where, mistake)
    return found


def stop(tools: Machine, sentence: str) -> tuple[int, str] | None:
    """The state and the type of the token at which the parser stops in a sentence; None where it goes through."""
    text = wrapped(sentence)
    try:
        tools.run(Source("", text), text)
    except UnexpectedToken as error:
        return key(error)
    return None


def key(error: UnexpectedToken) -> tuple[int, str]:
    assert isinstance(error.token, Token)
    return error.interactive_parser.parser_state.position, error.token.type
