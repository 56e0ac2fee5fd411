"""Paths in space: chains of lines and arcs, or a formula over one parameter.

``curve neck = from([0, 0, 0], z) line(a) arc(radius = r, angle = 180deg, towards = x) line(b)``: each piece goes on
where the last one ends, in its direction; an arc turns towards the side that is named.

A path that is handed to a primitive (``param path : curve``) keeps its shape - which pieces, which constants - and its
other numbers become parameters ``path.0``, ``path.1`` ... of that primitive.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from ..graph import expr as E
from ..graph.derive import derive
from ..graph.expr import ONE, ZERO, Expr
from ..syntax import ast
from .builtins import named, need
from .curves import Curve
from .evaluate import Evaluator
from .profiles import V
from .vectors import Triple, dot, minus, normalized, plus, times

# how the numbers of a path are tested where they are parameters: metres and radians
TESTS = {"at": (-0.1, 0.1), "along": (0.4, 1.0), "length": (0.03, 0.2), "radius": (0.05, 0.12), "angle": (0.3, 2.6)}
TESTS["formula"] = (0.05, 0.2)


@dataclass(frozen=True, slots=True)
class Step:
    """A word of a path with its numbers: from (at, along), line (length), arc (radius, angle, towards), formula."""

    word: str
    numbers: tuple[Expr, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """A piece of a path: place and unit direction over v = 0 .. 1, and for an arc what it turns about."""

    place: Triple
    direction: Triple
    length: Expr = ZERO
    center: Triple | None = None
    out: Triple | None = None  # from the centre to the start
    radius: Expr = ZERO
    angle: Expr = ZERO

    def at(self, value: float) -> Triple:
        return tuple(E.substitute(c, {V: E.const(value)}) for c in self.place)  # type: ignore[return-value]

    def towards(self, value: float) -> Triple:
        return tuple(E.substitute(c, {V: E.const(value)}) for c in self.direction)  # type: ignore[return-value]


def steps_of(curve: Curve) -> tuple[Step, ...]:
    """The words of a path; raises Abort after a diagnostic where the curve is none."""
    ev = Evaluator(curve.env)
    if not isinstance(curve.value, ast.ChainExpr):
        low, high = curve.ends()
        point = curve.point()
        if len(point) != 3:
            raise curve.env.context.error(
                "bad-curve", curve.value.span, f"the curve `{curve.name}` lies in a plane; a path lies in space",
                hint="give [x, y, z], or from(point, direction) line(length) ...",
            )  # fmt: skip
        v = E.add(low, E.mul(V, E.sub(high, low)))
        return (Step("formula", tuple(E.substitute(c, {V: v}) for c in point)),)
    found = []
    numbers: tuple[Expr, ...]
    for piece in curve.value.pieces:
        word = piece.function.name
        if word == "from":
            given = named(piece, "at", "along")
            numbers = (*ev.vector(need(ev, piece, given, "at")), *ev.direction(need(ev, piece, given, "along")))
        elif word == "line":
            numbers = (ev.scalar(need(ev, piece, named(piece, "length"), "length")),)
        else:
            given = named(piece, "radius", "angle", "towards")
            radius, angle = (ev.scalar(need(ev, piece, given, k)) for k in ("radius", "angle"))
            numbers = (radius, angle, *ev.direction(need(ev, piece, given, "towards")))
        found.append(Step(word, numbers))
    if len(found) < 2:
        raise curve.env.context.error(
            "bad-curve", curve.value.span, f"the path `{curve.name}` has no length", hint="add line(...) or arc(...)"
        )
    return tuple(found)


def stretches(steps: Iterable[Step]) -> list[Stretch]:
    """The pieces of a path with their places and directions."""
    found: list[Stretch] = []
    at: Triple = (ZERO, ZERO, ZERO)
    along: Triple = (ONE, ZERO, ZERO)
    for step in steps:
        if step.word == "from":
            at, along = step.numbers[:3], normalized(step.numbers[3:])  # type: ignore[assignment,arg-type]
            continue
        if step.word == "formula":
            place: Triple = step.numbers  # type: ignore[assignment]
            speed = tuple(derive(c, "v") for c in place)
            found.append(Stretch(place, normalized(speed)))  # type: ignore[arg-type]
            continue
        if step.word == "line":
            length = step.numbers[0]
            found.append(Stretch(plus(at, times(along, E.mul(V, length))), along, length))
        else:
            radius, angle, *towards = step.numbers
            found.append(arc(at, along, radius, angle, (towards[0], towards[1], towards[2])))
        at, along = found[-1].at(1.0), found[-1].towards(1.0)
    return found


def arc(at: Triple, along: Triple, radius: Expr, angle: Expr, towards: Triple) -> Stretch:
    """An arc that begins at ``at`` in the unit direction ``along`` and turns towards a side."""
    aside = dot(along, towards)
    inward = normalized(towards if aside is ZERO else minus(towards, times(along, aside)))
    turned = E.mul(V, angle)
    c, s = E.call("cos", turned), E.call("sin", turned)
    place = plus(at, plus(times(inward, E.mul(radius, E.sub(ONE, c))), times(along, E.mul(radius, s))))
    direction = plus(times(along, c), times(inward, s))
    center = plus(at, times(inward, radius))
    return Stretch(place, direction, E.mul(radius, angle), center, times(inward, E.const(-1.0)), radius, angle)


@dataclass(frozen=True, slots=True, eq=False)
class Handed:
    """A path as a parameter: its steps over variables ``names``, whose values are ``scalars``; ``key`` is its shape."""

    steps: tuple[Step, ...]
    names: tuple[str, ...]
    scalars: tuple[Expr, ...]
    tests: tuple[tuple[float, float], ...]
    key: tuple


def handed(curve: Curve, name: str) -> Handed:
    """What a use of a primitive hands in for its curve parameter ``name``."""
    names: list[str] = []
    scalars: list[Expr] = []
    tests: list[tuple[float, float]] = []
    variables: dict[Expr, Expr] = {}

    still: dict[Expr, bool] = {}
    done: dict[Expr, Expr] = {}

    def moving(node: Expr) -> bool:
        if node not in still:
            still[node] = node is not V and not any([moving(a) for a in node.args])
        return not still[node]

    def replaced(node: Expr, kind: str) -> Expr:
        if node.op == "const" or node is V:
            return node
        if moving(node):
            if node not in done:
                done[node] = E.rebuild(node, tuple(replaced(a, kind) for a in node.args))
            return done[node]
        if node not in variables:
            variables[node] = E.var(f"{name}.{len(names)}")
            names.append(f"{name}.{len(names)}")
            scalars.append(node)
            tests.append(TESTS[kind])
        return variables[node]

    steps = []
    for step in steps_of(curve):
        kinds = {
            "from": ("at",) * 3 + ("along",) * 3, "line": ("length",), "arc": ("radius", "angle") + ("along",) * 3,
            "formula": ("formula",) * 3,
        }[step.word]  # fmt: skip
        numbers = tuple(replaced(e, kind) for e, kind in zip(step.numbers, kinds, strict=True))
        steps.append(Step(step.word, numbers))
    return Handed(tuple(steps), tuple(names), tuple(scalars), tuple(tests), tuple((s.word, s.numbers) for s in steps))
