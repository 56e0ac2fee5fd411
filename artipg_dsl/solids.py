"""The primitives of a compilation, examined: surfaces that do not close are findings at their declarations."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any, TypeVar

from .diagnostics import Report
from .geometry import facts
from .geometry.agreement import find_box_fault, find_inside_fault, find_piece_beyond, measure_missed
from .geometry.errors import PrimitiveError
from .geometry.patches import evaluate_rows
from .geometry.topology import orientation, seams
from .geometry.trial import draw_any, variants
from .graph.primitive import Primitive
from .graph.program import Program
from .lower.expressions.context import Abort
from .lower.program import new_context
from .lower.solids.lowered import Lowered
from .lower.solids.primitives import lower_primitive
from .lower.solve.feasible import plain
from .semantics.check import TypedProgram
from .semantics.symbols import Symbol
from .syntax import ast

_T = TypeVar("_T")

_HINT = "two edges match where both surfaces give the same curve from end to end; compare the signs and the ranges of u and v"

_BROAD = "bend it less, or use a thinner section"
_TRIED = 256  # test values at which a bend is looked at
# of its size that a solid reaches beyond its pieces, or its box beyond it: worth a warning, and an error
LOOSE, ABSENT = 0.05, 0.1
_STEEP = 0.02  # of a slope beyond 1 that is worth a warning
_NARROW = "does the path cross or touch itself, or bend more tightly than its section allows? Narrow the ranges in its formula"


def check_closed(solids: Mapping[Any, Lowered], report: Report) -> None:
    """Report ``leaky-primitive`` for each lowered primitive whose surfaces do not bound a solid.

    Every surface, at each variant its test values show, must meet others all around and have the inside on one side.
    """
    for symbol, lowered in solids.items():
        if lowered.digest:
            facts.tell_digest(lowered.primitive, lowered.digest)
        own = symbol[0] if isinstance(symbol, tuple) else symbol  # one that is made of a curve is known by both
        try:
            examine_primitive(lowered.primitive)
            _cover(symbol, lowered, report)
            _enclose(own, lowered, report)
            if _is_distance(own, lowered, report):
                _hold(own, lowered, report)
        except PrimitiveError as error:
            _tell(own, lowered, error, report)


def _stated(symbol: Symbol, kind: type[ast.Stmt]) -> list[ast.Stmt]:
    """The statements of one kind in a primitive that is not of the library: those are tested."""
    body = getattr(symbol, "body", ())
    return [s for s in body if isinstance(s, kind) and not symbol.module.source.name.startswith("library/")]


def _enclose(symbol: Symbol, lowered: Lowered, report: Report) -> None:
    """Warn of a box that an author states and that is not the box of the surfaces: parts are placed by it."""
    stated = _stated(symbol, ast.BoxDecl)
    if not stated:
        return
    fault = facts.recall_fact(
        lowered.primitive, "box", lambda: find_box_fault(lowered.primitive, LOOSE), lambda f: f, _words
    )
    if fault is not None:
        said = f"the box of the primitive `{symbol.name}` is not that of its surfaces: {fault}"
        hint = "`box = low .. high` names the least and the greatest corner; `box = [a, b, c]` is centred on the origin"
        report.warning("leaky-primitive", stated[0].span, said, hint=hint)


def _is_distance(symbol: Symbol, lowered: Lowered, report: Report) -> bool:
    """Warn of an inside function that an author states and that is no distance: what is hidden, and what weighs, is told by it."""
    stated = _stated(symbol, ast.InsideDecl)
    if not stated:
        return True
    fault = facts.recall_fact(
        lowered.primitive, "distance", lambda: find_inside_fault(lowered.primitive, _STEEP), lambda f: f, _words
    )
    if fault is not None:
        said = f"the inside function of the primitive `{symbol.name}` disagrees with its surfaces: {fault}"
        hint = "`inside` is a length: negative within all of the solid, and from place to place it changes by no more than the way"
        report.warning("leaky-primitive", stated[0].span, said, hint=hint)
    return fault is None


def _words(data: Any) -> str | None:
    if data is not None and not isinstance(data, str):
        raise TypeError("what is wrong is words")
    return data


def _cover(symbol: Symbol, lowered: Lowered, report: Report) -> None:
    """Report convex pieces that an author states and that leave out much of the solid: nothing would touch it there."""
    stated = _stated(symbol, ast.PieceDecl)
    if not stated:
        return
    found = facts.recall_fact(
        lowered.primitive, "missed", lambda: measure_missed(lowered.primitive), lambda far: far, partial(_found, float)
    )
    if found is None or found[0] < LOOSE:
        return
    far, place = found
    told = report.error if far > ABSENT else report.warning
    told(
        "missing-pieces",
        stated[0].span,
        f"the pieces of the primitive `{symbol.name}` miss part of it, up to {100 * far:.0f} % of its size away ({place})",
        hint="collisions are computed from the convex pieces: give pieces that fill the solid, or none if it is convex",
    )


def _hold(symbol: Symbol, lowered: Lowered, report: Report) -> None:
    """Warn of convex pieces that reach out of a solid whose surfaces an author states: something would touch them there."""
    if not _stated(symbol, ast.SurfaceDecl):
        return
    found = facts.recall_fact(
        lowered.primitive,
        "beyond",
        lambda: find_piece_beyond(lowered.primitive, LOOSE),
        lambda f: f,
        partial(_found, str),
    )
    if found is None:
        return
    name, words = found
    stated = [s for s in _stated(symbol, ast.PieceDecl) if isinstance(s, ast.PieceDecl)]
    place = next((s.span for s in stated if s.name == name.partition("[")[0]), symbol.decl.name_span)
    report.warning(
        "missing-pieces",
        place,
        f"a piece of the primitive `{symbol.name}` reaches out of it: {words}"
        if stated
        else f"the primitive `{symbol.name}` is concave, and has no pieces: its hull {words.removeprefix('this piece ')}",
        hint="collisions are computed from the convex pieces: give pieces that fill the solid, each within it",
    )


def examine_primitive(primitive: Primitive) -> None:
    """Raises PrimitiveError for the first fault; that there is none is kept between runs."""

    def closed() -> bool:
        for variant in variants(primitive):
            seams(primitive, variant)
        orientation(primitive)
        return True

    facts.recall_fact(primitive, "closed", closed, bool, _true)


def _true(data: object) -> bool:
    if data is not True:
        raise ValueError("a primitive is known to be closed, or nothing is known")
    return True


def _found(kind: type[_T], data: Any) -> tuple[_T, str] | None:
    """Something of a kind and words, from data."""
    if data is None:
        return None
    value, words = data
    if not isinstance(value, kind) or not isinstance(words, str):
        raise TypeError(f"what is found is a {kind.__name__} and words")
    return value, words


def _tell(symbol: Symbol, lowered: Lowered, error: PrimitiveError, report: Report) -> None:
    """The finding at the declaration of the primitive, with a note at the surface at fault; at its author's curve, where it
    is one that gives the primitive its shape.
    """
    name = (error.patch or "").partition("[")[0]
    notes = [(s.span, "this surface") for s in symbol.body if isinstance(s, ast.SurfaceDecl) and s.name == name]
    notes += [(s.span, "this makes it") for s in symbol.body if isinstance(s, ast.SolidDecl)]
    subject = f"the surface `{error.patch}` of the primitive" if error.patch else "the primitive"
    place, hint = symbol.decl.name_span, _HINT if "edge" in error.words else None
    message = f"{subject} `{symbol.name}` is faulty: {error.words}"
    tight = _too_tight(lowered)
    if tight is not None:
        message, hint = f"the path of the primitive `{symbol.name}` {tight}", _BROAD
    if lowered.blamed is not None:
        place, begin = lowered.blamed
        for path in lowered.paths:
            message = path.in_words(message)
        message, hint = (f"{begin}: {message}", _NARROW) if tight is None else (f"{begin}: it {tight}", _BROAD)
    report.error("leaky-primitive", place, message, hint=hint, notes=tuple(notes), trace=lowered.trace)


def _too_tight(lowered: Lowered) -> str | None:
    """That a path bends more tightly than its section allows, at all test values."""
    for condition in lowered.conditions:
        if condition.bend is not None:
            params = draw_any(lowered.primitive, _TRIED)
            reach, radius = evaluate_rows(lowered.primitive, condition.bend, params)
            if not evaluate_rows(lowered.primitive, (condition.holds,), params, bool).any():
                least, most = (plain(float(v), "m") for v in (reach.min(), radius.max()))
                bend = f"its radius of curvature is at most {most} there"
                return f"bends too tightly: {bend}, and the section reaches at least {least} towards the inside"
    return None


def lower_own(typed: TypedProgram, report: Report) -> dict[Symbol, Lowered]:
    """The primitives that the file declares, lowered by themselves; those over curves take their shape from a use."""
    context = new_context(report, Program(typed.main.name, ""), typed)
    found: dict[Symbol, Lowered] = {}
    for symbol in typed.main.own():
        if symbol.kind != "primitive" or any(
            isinstance(s, ast.ParamDecl) and s.type.name == "curve" for s in symbol.body
        ):
            continue
        try:
            found[symbol] = lower_primitive(context, symbol)
        except Abort:
            continue
    return found
