"""Findings on requirements: ranges that can never be met, with the chain of reasons; and requirements and preferences that say nothing."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ...graph.expr import TRUE, Column, Scope, sub
from ...graph.feasible import Conflict, find_conflicts, find_idle, find_settled, is_certain
from ...graph.interval import Intervals
from ...graph.linear import Linear
from ...graph.program import Draw, Program
from ...source import Span
from ...syntax import ast
from ...syntax.walk import walk
from ..expressions.context import Bend, Draft

if TYPE_CHECKING:
    from ..elaborate.part import Component

_Notes = tuple[tuple[Span, str], ...]

_WIDEN = "widen a range, or correct the requirement"


def judge(context: Draft, hollow: list[tuple[Scope, tuple[int, ...]]], own: str) -> None:
    """Report what can never be met: an error where every object has it, else a warning.

    ``hollow`` are requirements that contradict one another; ``own`` names the main file.
    """
    program = context.program
    intervals = Intervals(program.draws, program.definitions)
    for scope, reasons in hollow[:1]:
        _tell(context, Conflict(None, reasons[0], reasons, (), math.nan, math.nan, scope, is_certain(scope, intervals)))
    told: set[frozenset[int]] = set()
    for conflict in find_conflicts(program):
        if frozenset(conflict.reasons) not in told:  # one contradiction empties several ranges: the first tells it
            told.add(frozenset(conflict.reasons))
            _tell(context, conflict)
    _refuse_exact(context, intervals)
    if context.report.failed:
        return
    _warn_idle(context, own)
    for number, holds in find_settled(program):
        span = context.preferred.get(number)
        if span is not None and span.source.name == own:
            said = "always holds: no values in the ranges can break it" if holds else "never holds"
            message = f"this preference {said}, so it makes no object rarer than another"
            context.report.warning("always-true", span, message, hint="drop it, or correct the comparison")


def _warn_idle(context: Draft, own: str) -> None:
    """Name requirements of the category, or the parts of them that `and` joins, that hold for every object."""
    program = context.program
    idle, told = set(find_idle(program)), dict[Span, list[tuple[str, str]]]()
    for number, (span, root) in context.stated.items():
        if not root or span.source.name != own:
            continue
        requirement = program.requirements[number]
        why = "no values in the ranges can break it" if number in idle else ""
        if requirement.condition is TRUE:
            why = "nothing that it compares differs between objects"
        told.setdefault(span, []).append((requirement.text, why))
    for span, conjuncts in told.items():
        whole = all(why for _, why in conjuncts)
        for text, why in conjuncts[:1] if whole else conjuncts:
            if why:
                context.report.warning(
                    "always-true",
                    span,
                    f"{'this requirement' if whole else f'`{text}`'} always holds: {why}",
                    hint="drop it, or correct the comparison",
                )


def _refuse_exact(context: Draft, intervals: Intervals) -> None:
    """Report requirements that a number drawn from a range be equal to something: it never is. Where every object has one, that is
    an error."""
    program = context.program
    drawn = {
        d.column: d for d in program.draws if d.kind == "real" and d.distribution != "values" and d.low is not d.high
    }
    reader = Linear(drawn.__contains__, program.definitions, through=True)
    exact: dict[int, Column] = {
        union.requirement: draw.column
        for draw in drawn.values()
        for union in draw.unions
        if all(low is high for low, high in union.intervals)
    }
    for number in context.stated:
        condition = program.requirements[number].condition
        form = reader.form(sub(*condition.args)) if number not in exact and condition.op == "eq" else None
        own = [] if form is None else [c for c, factor in form[0].items() if factor.constant]
        if own:
            exact[number] = max(own, key=list(drawn).index)  # the one drawn last
    for number, column in exact.items():
        if number not in context.stated:
            continue
        requirement = program.requirements[number]
        certain = requirement.guard is TRUE and is_certain(requirement.scope, intervals)
        so = "" if certain else _never_drawn(context, requirement.scope)
        (context.report.error if certain else context.report.warning)(
            "impossible",
            context.stated[number][0],
            f"`{column.name}` is drawn from a range, so `{requirement.text}` never holds exactly{so}",
            hint="state an equation, `align a = b`, and declare what follows from it without a range or as `derived`",
            notes=tuple((span, "drawn here") for span in filter(None, [context.spans.get(column)])),
        )


def _never_drawn(context: Draft, scope: Scope) -> str:
    """What follows where only some objects have a row of a table, and none of these is valid."""
    words = context.in_words(scope)
    return f"; so {'what stands under this `when`' if words == 'a `when`' else words} is never drawn"


def _tell(context: Draft, conflict: Conflict) -> None:
    """Report a contradiction, by the path that is too tight, the range that is empty, or the requirement that never holds."""
    spans = list(dict.fromkeys(context.stated[r][0] for r in conflict.reasons if r in context.stated))
    settled = [context.settled[r] for r in conflict.reasons if r in context.settled]
    chain = [(span, "and this is required") for span in spans[1:]]
    chain += dict.fromkeys((place, f"and {name}, which follows from it, must {must}") for place, name, must in settled)
    for k in conflict.draws:
        column = context.program.draws[k].column
        if column in context.spans:
            chain.append((context.spans[column], f"`{column.name}` is drawn here"))
    bend = next((context.bends[r] for r in conflict.reasons if r in context.bends), None)
    tight = None if bend is None else _too_tight(context.program, bend)
    if bend is not None and tight is not None:
        hint = "bend it less, or use a thinner section"
        _report(context, conflict, bend.place, tight, hint, ((bend.span, "the section along it"), *chain))
    elif conflict.draw is not None:
        _tell_of_range(context, conflict, context.program.draws[conflict.draw], spans, tuple(chain))
    else:
        _tell_of_requirement(context, conflict, spans, tuple(chain))


def _tell_of_range(context: Draft, conflict: Conflict, draw: Draw, spans: list[Span], chain: _Notes) -> None:
    """Report a number whose range requirements leave nothing of; ``spans`` is where these are stated."""
    own = context.spans.get(draw.column)
    message = (
        f"`{draw.column.name}` has no legal value: it would have to be at least {plain(conflict.low, draw.unit)} "
        f"and at most {plain(conflict.high, draw.unit)}"
    )
    hint = _WIDEN
    asked = [context.program.requirements[r].message for r in conflict.reasons if r in context.stated]
    users = [(said, part) for said in asked if (part := of_part(context, said)) is not None]
    for said, part in users[:1]:  # what a primitive requires stands in no line of the program
        message += f"; else {said}"
        hint = f"change the arguments of `{part.name}`, or the ranges that they come from"
    follows = next((context.settled[r][1] for r in conflict.reasons if r in context.settled), None)
    if own is not None and spans:
        chain = ((own, "its range"), *chain)
    elif follows is not None:
        hint = f"equations determine {follows}: give it a value, correct them, or widen the range"
    _report(context, conflict, spans[0] if spans else own, message, hint, chain)


def _tell_of_requirement(context: Draft, conflict: Conflict, spans: list[Span], chain: _Notes) -> None:
    """Report a requirement that nothing satisfies; ``spans`` is where it and those that contradict it are stated."""
    span = spans[0] if spans else None
    message = "this requirement can never hold: " + (
        "others contradict it" if len(spans) > 1 else "no values in the ranges can satisfy it"
    )
    hint = _WIDEN
    said = context.program.requirements[conflict.reasons[0]].message if len(conflict.reasons) == 1 else ""
    if span is not None and said not in ("", span.words):
        message = f"{said}, for every draw"
    user = of_part(context, said)
    if user is not None and user.span == span:
        outer = _in_category(context, user)
        hint = f"change the arguments of `{outer.name}`, its sizes, or the ranges that they come from"
        if outer is user:
            hint = hint_of_size(context, user, said) or hint
        else:
            hint = _hint_of_open(outer) or hint
            span, chain = outer.span, (*chain, (user.span, "this part of it"))
    _report(context, conflict, span, message, hint, chain)


def _report(context: Draft, conflict: Conflict, span: Span | None, message: str, hint: str, notes: _Notes) -> None:
    """An error where every object has the contradiction, else a warning; what a primitive requires of its parameters, which has no
    place, is told where it is used."""
    if span is None:
        return
    if conflict.certain:
        context.report.error("impossible", span, message, hint=hint, notes=notes)
    else:
        message += _never_drawn(context, conflict.scope)
        context.report.warning("impossible", span, message, hint=hint, notes=notes)


def hint_of_size(context: Draft, part: Component, said: str) -> str | None:
    """What to try where the size of a part follows from an equation, as that of one face where nothing says where the part lies."""
    name = said.removeprefix(f"{part.path}: ").removesuffix(" must be positive")
    axis = name.removeprefix("size.")
    given = {node.name for node in walk(part.declaration) if isinstance(node, ast.Argument)}
    if name.isidentifier() and name not in given:
        return f"equations determine `{part.name}.{name}`: give it a value, or correct them"
    if axis not in ("x", "y", "z") or "xyz".index(axis) not in context.centred.get(part, ()):
        return None
    one, other = {"x": ("front", "back"), "y": ("left", "right"), "z": ("top", "bottom")}[axis]
    so = f"`{part.name}` is centred along {axis}, and its size follows from the one face that is placed"
    return f"{so}: place its {one} and its {other}"


def _hint_of_open(part: Component) -> str | None:
    """What to try where equations determine parameters of a part that it is not given."""
    names = [u.name for u in part.env.unknowns if u.part is part and u.kind == "size"]
    if not names:
        return None
    return f"equations determine {' and '.join(names)}: give a value, or correct them"


def of_part(context: Draft, said: str) -> Component | None:
    """The part whose primitive requires what is ``said``."""
    return next((part for part in context.parts if said.startswith(f"{part.path}: ")), None)


def _in_category(context: Draft, part: Component) -> Component:
    """The part of the category that a part of a library template is in; a part in the file of the category itself."""
    file = next((p.span.source for p in context.parts if p.declaration.root), part.span.source)
    around = (p for p in context.parts if p.span.source is file and f"{part.path}.".startswith(f"{p.path}."))
    return max(around, key=lambda p: len(p.path), default=part)


def _too_tight(program: Program, bend: Bend) -> str | None:
    """That a path bends more tightly than a section allows, where the ranges alone show it."""
    known = Intervals(program.draws, program.definitions)
    (least, wide), (narrow, most) = known.of(bend.reach), known.of(bend.radius)
    if not most < least:
        return None
    reach = f"reaches {'' if least == wide else 'at least '}{plain(least, 'm')} towards the inside"
    radius = f"its radius of curvature is {'' if narrow == most else 'at most '}{plain(most, 'm')}"
    return f"{bend.path} bends too tightly for `{bend.part}`: {radius} there, and the section {reach}"


def plain(value: float, unit: str) -> str:
    """A number in the unit that people use for its size."""
    if unit == "m":
        if abs(value) < 0.01:
            return f"{1000 * value:.4g}mm" if value else "0"
        if abs(value) < 10:
            return f"{100 * value:.4g}cm"
        return f"{value:.4g}m" if abs(value) < 1e4 else f"{value / 1000:.4g}km"
    if unit == "rad":
        return f"{math.degrees(value):.4g}deg"
    return f"{value:.4g}{unit}"
