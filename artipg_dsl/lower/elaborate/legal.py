"""Every number of an object has a legal range: what is never legal is an error, what may not be becomes a requirement.

What interval analysis shows to be legal whatever is drawn costs nothing; the rest is asked of each object, so that one with
a size of nan or an axis of no length is drawn again, counted and reported as for a ``require``.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from ...graph import expr as E
from ...graph.defined import PARTIAL, Defined, Sharp
from ...graph.expr import Expr, Scope
from ...graph.feasible import is_certain
from ...graph.formula import row_values
from ...graph.interval import Intervals
from ...graph.linear import tidy
from ...graph.primitive import triple
from ...graph.program import Draw, Grasp, Joint, Label, Part, Pose, Program, Requirement, Where
from ...graph.substitution import substitute
from ...language import DISTRIBUTIONS, JOINTS
from ...records import dataclass
from ...source import Source, Span
from ...syntax import ast
from ..expressions.context import Draft, Fetched, where
from ..expressions.env import Env
from ..solve.feasible import plain as in_unit
from ..values.vectors import cross, dot
from . import gates
from .links import Links
from .ranges import (
    APART,
    AXIS,
    DIRECTION,
    DISTANCE,
    DRIVEN,
    ELEMENT,
    ELEMENTS,
    HELD,
    MEDIAN,
    MOTION,
    NUMBER,
    OPENING,
    OPTION,
    PITCH,
    PLACE,
    POSITIONS,
    RESERVE,
    ROWS,
    SHARE,
    SIZE,
    SPREAD,
    STEP,
    TURN,
    WEIGHT,
    Legal,
    OnSurface,
    Quantity,
    plain,
)

_CHANGE = "correct it, or the ranges of what it is made of"
_SHARES = 5  # values of a grasp's parameter at which its formulas are asked for


def legalize(links: Links, env: Env) -> None:
    """Report what is never legal; require what might not be. Follows upon the bounds of draws: it narrows nothing."""
    context, program = links.context, links.context.program
    intervals = Sharp(program.draws, program.definitions)
    defined = Defined(intervals)
    asked: dict[_Asked, list[Quantity]] = {}
    sources: dict[str, Source] | None = None
    refused: set[object] = set()
    seen: set[tuple[Scope, Expr, Legal, Expr]] = set()
    off = any(q.place and not holds(q, intervals, defined) and _never(q, intervals) for q in context.asked)
    void = (quantity for element in context.named for quantity in of_element(element))
    for quantity, needed in (*((q, True) for q in _quantities(links)), *((q, False) for q in void)):
        if holds(quantity, intervals, defined):
            continue
        key = (quantity.scope, quantity.value, quantity.legal, quantity.guard)
        if key in seen:
            continue
        seen.add(key)
        if _never(quantity, intervals):
            sources = sources or {module.source.name: module.source for module in env.module.used()}
            nowhere = quantity.place is None and math.isnan(quantity.value.constant or 0.0)
            # what is too large lies too far off, and what is beyond a surface lies nowhere
            follows = SIZE in refused and quantity.legal is PLACE or off and nowhere
            if not follows and str(quantity.where) not in refused:  # of one statement, what is told first
                refuse(context, quantity, intervals, sources)
            refused |= {str(quantity.where), quantity.legal}
        elif needed:
            asked.setdefault(_Asked.of(quantity, context, intervals, defined), []).append(quantity)
    for one, several in asked.items():
        _require(context, one, several, intervals, defined)


def _require(context: Draft, one: _Asked, several: list[Quantity], intervals: Sharp, defined: Defined) -> None:
    """Make a requirement of what is asked of several quantities alike, and note what to say where it fails."""
    condition = E.all_of(E.either(E.negate(quantity.guard), within(quantity)) for quantity in several)
    if condition is E.TRUE:
        return
    number, first = len(context.program.requirements), several[0]
    if one.operation is None and (endless := _find_endless(several, context, intervals, defined)) is not None:
        context.endless[number] = endless
    place, text = one.where, first.name
    if first.legal.remedy and first.place is None and one.operation is None:
        context.remedies[number] = first.legal.remedy
    if one.operation is not None:
        span = context.operations[one.operation]
        place, text = where(span), span.words
        context.undefined[number] = span, PARTIAL[one.operation.op]
    elif (on := first.place) is not None:
        text = on.span.words
        context.undefined[number] = on.span, on.why
    context.program.requirements.append(Requirement(one.scope, condition, E.TRUE, one.message, place, text=text))


@dataclass(frozen=True, slots=True)
class _Asked:
    """What is told where a number is not legal: that of all the numbers that one ``operation`` leaves without a value, once."""

    scope: Scope
    message: str
    where: Where | None
    operation: Expr | None = None

    @staticmethod
    def of(quantity: Quantity, context: Draft, intervals: Intervals, defined: Defined) -> _Asked:
        low, high = intervals.of(quantity.value)
        if quantity.place is not None:
            return _Asked(quantity.scope, quantity.place.told, quantity.where)
        if quantity.legal.low <= low and high <= quantity.legal.high:
            operation = defined.culprit(quantity.value)
            if operation is not None and operation in context.operations:
                words = context.operations[operation].words
                return _Asked(quantity.scope, f"`{words}` has no value: {PARTIAL[operation.op]}", None, operation)
        return _Asked(quantity.scope, f"{quantity.name}: {quantity.legal.words}", quantity.where)


def _find_endless(
    several: list[Quantity], context: Draft, intervals: Intervals, defined: Defined
) -> tuple[Span, str] | None:
    """The operation that alone makes one of the numbers as large as it may be: where, and which."""
    for quantity in several:
        if not all(map(math.isfinite, intervals.of(quantity.value))):
            operation = defined.culprit(quantity.value, direct=True)
            if operation is not None and operation in context.operations:
                return context.operations[operation], operation.op
    return None


def holds(quantity: Quantity, intervals: Intervals, defined: Defined) -> bool:
    """Whether a number is legal whatever is drawn."""
    value, legal = quantity.value, quantity.legal
    if value.constant is not None:
        return legal.holds(float(value.constant))
    low, high = intervals.of(value)
    return legal.low <= low and high <= legal.high and defined.certain(value)


def _never(quantity: Quantity, intervals: Intervals) -> bool:
    """Whether a number is never legal, in what every object has."""
    value, legal = quantity.value, quantity.legal
    if intervals.of(quantity.guard)[0] < 1.0 or not is_certain(quantity.scope, intervals) and value.constant is None:
        return False
    low, high = intervals.of(value)
    return value.constant is not None or high < legal.low or low > legal.high


def within(quantity: Quantity) -> Expr:
    """The predicate that a number is legal; nan is not."""
    legal, value = quantity.legal, quantity.value
    return E.both(E.call("le", E.const(legal.low), value), E.call("le", value, E.const(legal.high)))


def refuse(context: Draft, quantity: Quantity, intervals: Intervals, sources: dict[str, Source]) -> None:
    value, place = quantity.value, quantity.where
    if quantity.place is not None:
        _refuse_place(context, quantity.place, intervals)
        return
    low, high = intervals.of(value)
    if math.inf in (low, -high) and (operation := Defined(intervals).culprit(value, direct=True)) in context.operations:
        at = context.operations[operation]
        context.report.error(
            "undefined-value",
            at,
            f"`{at.words}` is too large for a number",
            hint="check the formula, and the ranges of what it is made of",
        )
        return
    unit = quantity.legal.unit
    amount = (
        _shown(float(value.constant), unit)
        if value.constant is not None
        else f"at least {_shown(low, unit)}"
        if low > quantity.legal.high
        else f"at most {_shown(high, unit)}"
    )
    span = quantity.span
    if span is None and place is not None and place.file in sources:
        span = _line_of(sources[place.file], place)
    if quantity.legal is ELEMENT:
        context.report.error(
            "illegal-value",
            span,
            f"{quantity.name}: {ELEMENT.words}",
            hint="they are counted from 0; `[last]` is the last one",
        )
        return
    hint = quantity.legal.remedy or (_CHANGE if unit else None)
    said = f"{quantity.name} is {amount}, but {quantity.legal.refusal(low)}"
    context.report.error("illegal-value", span, said, hint=hint)


def _shown(value: float, unit: str) -> str:
    return in_unit(value, unit) if unit and math.isfinite(value) else plain(value)


def _refuse_place(context: Draft, on: OnSurface, intervals: Intervals) -> None:
    """Report a place that lies beyond its surface in every object."""
    (low, high), *ends = (intervals.of(value) for value in (on.value, *on.ends))
    least, most = min(end[0] for end in ends), max(end[1] for end in ends)
    so = ""
    if low > most or high < least:
        above = low > most
        at = in_unit(low if above else high, on.unit)
        if low != high:
            at = f"at {'least' if above else 'most'} {at}"
        so = f", where `{on.name}` goes from {in_unit(least, on.unit)} to {in_unit(most, on.unit)}; here it is {at}"
    context.report.error("undefined-value", on.span, f"`{on.span.words}` has no value: {on.why}{so}", hint=on.remedy)


def _line_of(source: Source, place: Where) -> Span:
    """From a place to the end of its line."""
    text = source.line(place.line)
    start = sum(len(line) + 1 for line in source.text.split("\n")[: place.line - 1]) + place.column - 1
    code = text[place.column - 1 :].split("#")[0].rstrip()
    return Span(source, start, start + max(len(code), 1))


# ---------------------------------------------------------------- the numbers of each record


def _quantities(links: Links) -> Iterator[Quantity]:
    """All numbers of a program that have a legal range."""
    program, context = links.context.program, links.context
    yield from context.asked
    for element in context.fetched:
        yield from of_element(element)
    for scope, span in context.counted.items():
        yield from rows(scope, where(span))
    for draw in program.draws:
        yield from _of_draw(draw, context.values.get(draw.column, {}))
    places = {number: where(instance.part.span) for instance, number in links.nodes.items()}
    for number, part in enumerate(program.parts):
        yield from _of_box(part, places.get(number))
    for number, part in enumerate(program.parts):
        yield from _of_pose(f"`{part.path}`", part.scope, part.pose, places.get(number))
    for site in program.sites:
        for name, value in zip(program.primitives[site.primitive].parameters, site.parameters, strict=True):
            yield Quantity(f"`{name}` of `{site.path}`", site.scope, value, NUMBER, places.get(site.part))
    for number, joint in enumerate(program.joints):
        yield from _of_joint(joint, links.stated.get(number))
        yield from gates.quantities(program, joint)
    for label in program.labels:
        yield from _of_label(label, program)
    for grasp in program.grasps:
        yield from _of_grasp(grasp)
    for keypoint in program.keypoints:
        yield from each(f"the keypoint `{keypoint.name}`", keypoint.scope, keypoint.point, PLACE, keypoint.where)
    for closure in program.closures:
        for point in closure.points:
            yield from each("a point of this `close`", closure.scope, point, PLACE, closure.where)
    for clear in program.clear:
        yield Quantity(f"the distance of `{clear.text}`", clear.scope, clear.distance, DISTANCE, clear.where)
    for preference in program.preferences:
        yield Quantity(
            f"the weight of `{preference.text}`", preference.scope, preference.weight, WEIGHT, preference.where
        )


def each(name: str, scope: Scope, values: Iterable[Expr], legal: Legal, place: Where | None) -> Iterator[Quantity]:
    for value in values:
        yield Quantity(name, scope, value, legal, place)


def rows(scope: Scope, place: Where) -> Iterator[Quantity]:
    """How many elements a repeat has, and how many all repeats of an object have together."""
    assert scope.count is not None and scope.parent is not None
    yield Quantity(f"the number of elements of `{scope.name}`", scope.parent, scope.count, ELEMENTS, place)
    total, above = scope.count, scope.parent
    while above.parent is not None:
        total = E.reduce("sum", above, total) if above.kind == "repeat" else E.phi(above.parent, [(above, total)])
        above = above.parent
    if total is not scope.count:
        yield Quantity(f"the number of all elements of `{scope.name}`", above, total, ROWS, place)


def of_element(element: Fetched) -> Iterator[Quantity]:
    """That the element of a rank is there: none before it that is not, and none missing behind it."""
    if element.rank.reads | element.guard.reads:  # in the formula of a label, of every point
        return
    left = E.sub(E.sub(element.count, E.ONE), element.rank)
    tables = [element.scope, *(e.scope for e in (left, element.guard) if e.scope is not None)]
    scope = next((s for s in tables if all(s.within(other) for other in tables)), None)
    if scope is None:
        return
    for value in (element.rank, left):
        yield Quantity(f"`{element.span.words}`", scope, value, ELEMENT, where(element.span), element.guard)


def _of_draw(draw: Draw, spans: dict[tuple[str, int], Span]) -> Iterator[Quantity]:
    """The numbers that a draw follows from; ``spans``: where they are written, if they are."""
    name, scope, place = f"`{draw.column.name}`", draw.column.scope, draw.where

    def of(what: str, value: Expr, legal: Legal, at: tuple[str, int] = ("", 0)) -> Quantity:
        return Quantity(f"{what} of {name}", scope, value, legal, place, span=spans.get(at))

    for number, end in enumerate((draw.low, draw.high)):
        if end is not None:
            yield of("an end of the range", end, NUMBER, ("range", number))
    for number, weight in enumerate(draw.weights):
        yield of("a weight", weight, WEIGHT, ("weight", number))
    if draw.weights and all(w.constant is not None for w in draw.weights):
        total = E.maximum(*draw.weights)
        yield of("the largest weight", total, OPTION)
    for number, argument in enumerate(draw.arguments):
        positive = number in DISTRIBUTIONS[draw.distribution].positive
        legal = (SPREAD if number else MEDIAN) if positive else NUMBER
        if not (number and draw.distribution == "lognormal"):  # whose spread is a share
            legal = replace(legal, unit=draw.unit)
        yield of("an argument of the distribution", argument, legal, ("argument", number))
    if draw.vary is not None:
        yield of("the step", draw.vary[1], STEP, ("vary", 0))


def _of_pose(name: str, scope: Scope, pose: Pose, place: Where | None) -> Iterator[Quantity]:
    yield from each(f"the place of {name}", scope, pose.translation, PLACE, place)
    yield from each(f"the direction of {name}", scope, (cell for row in pose.rotation for cell in row), TURN, place)


def _of_box(part: Part, place: Where | None) -> Iterator[Quantity]:
    name = f"`{part.path}`"
    for axis, low, high in zip("xyz", part.low, part.high, strict=True):
        yield Quantity(f"the size of {name} along {axis}", part.scope, tidy(E.sub(high, low)), SIZE, place)
        yield from each(f"the box of {name}", part.scope, (low, high), PLACE, place)


def _of_joint(joint: Joint, statement: ast.JointDecl | None) -> Iterator[Quantity]:
    """The numbers of a joint; ``statement``: as it is written, if it is."""
    name, scope, place = f"the joint `{joint.path}`", joint.scope, joint.where
    spans = _values_of(statement)

    def behind(*words: str) -> Span | None:
        """The value behind the first of some words that is written."""
        return next((spans[word] for word in words if word in spans), None)

    unit = gates.unit_of(joint)
    yield from each(f"the place of {name}", scope, joint.origin, PLACE, place)
    if JOINTS[joint.kind].axis:
        yield Quantity(f"the length of the axis of {name}", scope, dot(joint.axis, joint.axis), AXIS, place)
    for end, value in (("low end", joint.low), ("high end", joint.high), ("rest value", joint.rest)):
        if value is not None:
            at = behind("rest", "range") if end == "rest value" else behind("range")
            yield Quantity(f"the {end} of {name}", scope, value, replace(MOTION, unit=unit), place, span=at)
    if joint.low is not None and joint.high is not None:
        ordered = Legal(
            -1e-9, 2e4, "the low end must not lie above the high end", unit, remedy="swap the ends, or correct one"
        )
        extent = f"the length of the range of {name}"
        yield Quantity(extent, scope, E.sub(joint.high, joint.low), ordered, place, span=behind("range"))
        if joint.rest is not E.minimum(E.maximum(E.ZERO, joint.low), joint.high):
            inside = E.minimum(E.sub(joint.rest, joint.low), E.sub(joint.high, joint.rest))
            within = Legal(
                -1e-9, 2e4, "it must lie in the range", unit, remedy="move `rest` into the range, or widen the range"
            )
            between = f"the distance of the rest value of {name} from the nearer end of its range"
            yield Quantity(between, scope, inside, within, place, span=behind("rest", "range"))
    held = (("damping", joint.damping, HELD), ("friction", joint.friction, HELD), ("stiffness", joint.stiffness, HELD))
    driven = (("effort", joint.effort, DRIVEN), ("velocity", joint.velocity, DRIVEN))
    for word, value, legal in (*held, *driven):
        if value is not None:
            yield Quantity(f"the {word} of {name}", scope, value, legal, place, span=behind(word))
    if joint.effort is not None and joint.stiffness is not None and joint.low is not None and joint.high is not None:
        way = E.maximum(E.sub(joint.rest, joint.low), E.sub(joint.high, joint.rest))
        left = E.sub(joint.effort, E.mul(joint.stiffness, way))
        reserve = f"the effort of {name} less what its spring takes at the end of its range"
        yield Quantity(reserve, scope, left, RESERVE, place, span=behind("effort"))
    if joint.positions is not None:
        catches = f"the number of positions of {name}"
        yield Quantity(catches, scope, joint.positions, POSITIONS, place, span=behind("positions"))
    if joint.pitch is not None:
        yield Quantity(f"the pitch of {name}", scope, E.call("abs", joint.pitch), PITCH, place, span=behind("pitch"))
    if joint.mimic is not None:
        yield from each(f"the factor of {name}", scope, joint.mimic[1:], NUMBER, place)


def _values_of(statement: ast.JointDecl | None) -> dict[str, Span]:
    """Where the values stand that a joint states, by their words."""
    if statement is None:
        return {}
    s = statement
    clauses = ast.present(s.damping, s.friction, s.stiffness, s.effort, s.velocity, s.pitch, s.positions, s.rest)
    spans = {clause.word: clause.value.span for clause in clauses}
    return spans if s.range is None else {**spans, s.range.word: s.range.value.span}


def _of_label(label: Label, program: Program) -> Iterator[Quantity]:
    """What a formula reads of each row; what it makes of points is asked where it is evaluated."""
    name = f"the {'field' if label.vocabulary == 'field' else 'label'} `{label.name}`"
    guard, *values = label.formulas
    if guard.op != "const" and row_values([guard]) != [guard]:  # it reads coordinates of points
        return
    for scope in dict.fromkeys(program.sites[target.site].scope for target in label.targets):
        for value in values:
            if value.constant is not None or value.scope is not None and row_values([value]) == [value]:
                free = label.vocabulary == "field" or value.op in E.PREDICATES or isinstance(value.value, bool)
                yield Quantity(name, scope, value, NUMBER if free else SHARE, label.where, guard)
            else:
                reads = f"what {name} reads"
                yield from (Quantity(reads, scope, read, NUMBER, label.where, guard) for read in row_values([value]))


def _of_grasp(grasp: Grasp) -> Iterator[Quantity]:
    """A grasp at the values of its parameter at which it is laid out, in boxes as large as they are."""
    name, scope, place = f"the grasp `{grasp.name}`", grasp.scope, grasp.where
    yield from each(f"the range of {name}", scope, (grasp.low, grasp.high), NUMBER, place)
    box = {E.var(f"size.{axis}"): size for axis, size in zip("xyz", grasp.size, strict=True)}
    for k in range(_SHARES):
        share = E.const(k / (_SHARES - 1))
        t = E.add(grasp.low, E.mul(E.sub(grasp.high, grasp.low), share))
        formulas = [substitute(f, {**box, E.var("t"): t}) for f in grasp.formulas]
        at, approach, close = (triple(formulas[3 * i : 3 * i + 3]) for i in range(3))
        yield from each(f"the place of {name}", scope, at, PLACE, place)
        yield Quantity(f"the length of `approach` of {name}", scope, norm(approach), DIRECTION, place)
        yield Quantity(f"the length of `close` of {name}", scope, norm(close), DIRECTION, place)
        yield Quantity(
            f"the part of `close` across the `approach` of {name}", scope, norm(cross(approach, close)), APART, place
        )
        yield Quantity(f"the opening of {name}", scope, formulas[9], OPENING, place)
        yield Quantity(f"the quality of {name}", scope, formulas[10], SHARE, place)
        yield from each(f"the hand of {name}", scope, formulas[11:], HELD, place)


def norm(vector: Sequence[Expr]) -> Expr:
    return E.call("sqrt", dot(vector, vector))
