"""Paths in space: chains of lines and arcs, or a formula over one parameter.

``curve neck = from([0, 0, 0], z) line(a) arc(radius = r, angle = 180deg, towards = x) line(b)``: each piece goes on
where the last one ends, in its direction; an arc turns towards the side that is named.

A path that is handed to a primitive (``param path : curve``) keeps its shape - which pieces, which constants - and its
other numbers become parameters ``path.0``, ``path.1`` ... of that primitive, tested over what the domains of its author's
parameters allow.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from ...graph import expr as E
from ...graph.derive import derive
from ...graph.expr import ONE, ZERO, Expr
from ...graph.interval import Interval, Intervals
from ...graph.primitive import Triple, triple
from ...graph.substitution import substitute, substitute_all
from ...language import FORMS
from ...records import dataclass
from ...syntax import ast
from ..expressions.builtins import bound
from ..expressions.evaluate import Evaluator
from ..solve.feasible import plain
from ..values.handed import Handed, Step
from ..values.vectors import cross, dot, minus, normalized, plus, times
from .curves import OUTLINES, Curve
from .probe import Probe
from .profiles import V

# how the numbers of a path are tested where nothing is known of them: metres and radians
_TESTS = {"at": (-0.1, 0.1), "along": (0.4, 1.0), "length": (0.03, 0.2), "radius": (0.05, 0.12), "angle": (0.3, 2.6)}
_TESTS["formula"] = (0.05, 0.2)
MOST_STEPS = 1024  # at which the turning of a path is looked at
_GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
_POSITIVE = ("length", "radius", "angle")
_PARALLEL = 1e-9  # the sine of an angle that rounding leaves
KINDS = {
    "from": ("at",) * 3 + ("along",) * 3,
    "line": ("length",),
    "arc": ("radius", "angle") + ("along",) * 3,
    "formula": ("formula",) * 3,
}


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

    def at(self, value: float | Expr) -> Triple:
        return triple(substitute_all(self.place, {V: E.wrap(value)}))

    def towards(self, value: float | Expr) -> Triple:
        return triple(substitute_all(self.direction, {V: E.wrap(value)}))


_CLOSED = tuple(form for form in FORMS if form.meaning in OUTLINES)


def number(ev: Evaluator, node: ast.Expr) -> tuple[Expr, ...]:
    return (ev.scalar(node),)


_READ = {"point": Evaluator.vector, "direction": Evaluator.direction}  # what is not one number


def steps_of(curve: Curve) -> tuple[Step, ...]:
    """The words of a path; raises Abort after a diagnostic where the curve is none."""
    ev = Evaluator(curve.env)
    if not isinstance(curve.value, ast.ChainExpr):
        low, high = curve.ends()
        point = () if ev.env.context.form(curve.value) in _CLOSED else curve.point()
        if len(point) != 3:
            raise curve.env.context.error(
                "bad-curve",
                curve.value.span,
                f"the curve `{curve.name}` lies in a plane; a path must lie in space",
                hint="write [x, y, z], or from(point, direction) line(length) ...",
            )
        v = E.add(low, E.mul(V, E.sub(high, low)))
        return (Step("formula", tuple(substitute(c, {V: v}) for c in point)),)
    found = []
    for piece in curve.value.pieces:
        form = ev.env.context.form(piece)
        assert form is not None
        given = bound(piece, form)
        numbers = (n for p in form.parameters for n in _READ.get(p.type, number)(ev, given[p.name]))
        found.append(Step(form.name, tuple(numbers)))
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
            at, along = triple(step.numbers[:3]), normalized(triple(step.numbers[3:]))
            continue
        if step.word == "formula":
            place = triple(step.numbers)
            speed = triple(derive(c, "v") for c in place)
            found.append(Stretch(place, normalized(speed)))
            continue
        if step.word == "line":
            length = step.numbers[0]
            found.append(Stretch(plus(at, times(along, E.mul(V, length))), along, length))
        else:
            radius, angle, *towards = step.numbers
            found.append(arc(at, along, radius, angle, (towards[0], towards[1], towards[2])))
        at, along = found[-1].at(1.0), found[-1].towards(1.0)
    return found


def angles(probe: Probe, rail: Stretch, steps: int) -> np.ndarray:
    """(steps, rows): the angles between a path's directions at the ends of equal steps, half a turn at the most."""
    seen = np.nan_to_num(probe.along(rail.direction, [k / steps for k in range(steps + 1)], V))
    return np.arccos(np.clip((seen[1:] * seen[:-1]).sum(axis=1), -1.0, 1.0))


def _speeds(probe: Probe, rail: Stretch, steps: int) -> np.ndarray:
    """(steps, rows): how fast a path turns, radians by v, at a place within each step that no period of the path meets always."""
    k = np.arange(steps)
    speed = [derive(c, "v") for c in rail.place]
    places = probe.spread("v", tuple((k + (0.5 + k * _GOLDEN) % 1.0) / steps))
    first, second = places(*speed, *(derive(c, "v") for c in speed)).reshape(2, 3, steps, -1)
    with np.errstate(all="ignore"):
        turning = np.sqrt((np.cross(first, second, axis=0) ** 2).sum(axis=0)) / (first**2).sum(axis=0)
    return np.nan_to_num(turning, posinf=0.0)


def turned(probe: Probe, rail: Stretch) -> float:
    """The greatest angle (radians) that a formula's path turns through in all.

    It is the sum of the angles between equal steps. A step that turns by more than half a turn shows less than that, so
    the steps are halved until they show what the speed of turning says, and where they never do, the speed is believed.
    """
    return probe.once(_turned, rail)


def _turned(probe: Probe, rail: Stretch) -> float:
    steps = 256
    while True:
        shown, meant = angles(probe, rail, steps).sum(axis=0), _speeds(probe, rail, steps).mean(axis=0)
        if (meant <= 1.05 * shown + 0.5).all():
            return float(shown.max())
        if steps >= MOST_STEPS:
            return float(np.maximum(shown, meant).max())
        steps *= 2


def windows(probe: Probe, rail: Stretch) -> int:
    """Into how many equal parts of its parameter a path is cut so that it turns once in each, or less."""
    return 1 if rail.length is not ZERO else max(1, math.ceil(turned(probe, rail) / math.tau - 0.01))


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


def _test_range(kind: str, known: Interval) -> Interval:
    """The values at which a number of a path is tested: those that the domains allow, else the usual ones of its kind."""
    usual = _TESTS[kind]
    low, high = (k if math.isfinite(k) else u for k, u in zip(known, usual, strict=True))
    if kind in _POSITIVE and high > 0:  # where sizes depend on one another, bounds of a difference are too wide
        low = max(low, min(usual[0], 0.1 * high))
    return (
        (low, high)
        if low <= high
        else (low, low + usual[1] - usual[0])
        if math.isfinite(known[0])
        else (high - usual[1] + usual[0], high)
    )


def handed(curve: Curve, name: str) -> Handed:
    """What a use of a primitive hands in for its curve parameter ``name``."""
    if name not in curve.handed:
        curve.handed[name] = _handed(curve, name)
    return curve.handed[name]


def _handed(curve: Curve, name: str) -> Handed:
    context = curve.env.context
    known = Intervals(context.draws, context.program.definitions)
    steps = steps_of(curve)
    _refuse_odd(curve, steps, known)
    numbers = {number: kind for step in steps for number, kind in zip(step.numbers, KINDS[step.word], strict=True)}
    found = _variables_of(numbers)
    variables = {node: E.var(f"{name}.{k}") for k, node in enumerate(found)}
    moved = tuple(Step(s.word, tuple(substitute(e, variables) for e in s.numbers)) for s in steps)
    names = tuple(str(v.value) for v in variables.values())
    return Handed(curve, moved, names, tuple(found), tuple(_test_range(kind, known.of(e)) for e, kind in found.items()))


def _refuse_odd(curve: Curve, steps: Sequence[Step], known: Intervals) -> None:
    """Refuse pieces of a chain that no object can have: a length below 0, an arc that turns to where it goes already. Raises Abort."""
    if not isinstance(curve.value, ast.ChainExpr):
        return
    error, along = curve.env.context.error, triple(steps[0].numbers[3:])
    for piece, step, rail in zip(curve.value.pieces[1:], steps[1:], stretches(steps), strict=True):
        for expr, kind in zip(step.numbers, KINDS[step.word], strict=True):
            most = known.of(expr)[1] if kind in _POSITIVE else math.inf
            if most <= 0.0:
                at_most = " at most" if expr.constant is None else ""
                said = f"the {kind} of this `{step.word}` is {plain(most, 'rad' if kind == 'angle' else 'm')}{at_most}"
                hint = (
                    "turn the other way with the opposite `towards`"
                    if kind == "angle"
                    else "shorten what it is taken from"
                )
                raise error("bad-curve", piece.span, said + ": it must be above 0", hint=hint)
        if step.word == "arc" and all(
            c.constant is not None and abs(c.constant) < _PARALLEL for c in cross(along, triple(step.numbers[2:]))
        ):
            said = "this `arc` turns towards the direction in which the path runs there, or away from it"
            hint = "`towards` names a side of the path, such as x where it runs along z"
            if axis := next(
                (a for a, c in zip("xyz", along, strict=True) if abs(c.constant or 0.0) > 1 - _PARALLEL), None
            ):
                one, other = (letter for letter in "xyz" if letter != axis)
                hint = f"the path runs along {axis} there: `towards` names a side of it, {one}, -{one}, {other} or -{other}"
            raise error("bad-curve", piece.span, said, hint=hint)
        along = rail.towards(1.0)


def _variables_of(numbers: dict[Expr, str]) -> dict[Expr, str]:
    """What a path's numbers are made of, with their kinds: the greatest terms without v, or, where they are no more, the
    columns that these read, which depend on one another in no way.
    """
    terms: dict[Expr, str] = {}
    moving: dict[Expr, bool] = {}

    def moves(node: Expr) -> bool:
        if node not in moving:
            moving[node] = node is V or any([moves(a) for a in node.args])
        return moving[node]

    seen: set[Expr] = set()

    def visit(node: Expr, kind: str) -> None:
        if node in seen or node.op == "const" or node is V:
            return
        if not moves(node):
            terms.setdefault(node, kind)
            return
        seen.add(node)
        for arg in node.args:
            visit(arg, kind)

    for number, kind in numbers.items():
        visit(number, kind)
    columns = dict.fromkeys(sorted({c for node in terms for c in E.leaves(node)}, key=lambda c: c.path))
    plain = all(c.kind == "real" for c in columns) and not any(_crosses(node) for node in terms)
    shorter = len(columns) < len(terms) or len(columns) == len(terms) and "formula" in terms.values()
    return {E.col(c): "formula" for c in columns} if columns and plain and shorter else terms


def _crosses(root: Expr) -> bool:
    """Whether a value reads other tables, or is no formula of columns alone."""
    return any(node.op in E.CROSSING or node.op in ("solve", "root", "rank", "var") for node in E.nodes(root))
