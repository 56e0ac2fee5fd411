"""Declared primitives: their formulas once per declaration, boxes and ports per use."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.interval import Interval, Intervals
from ...graph.primitive import Patch, Piece, Primitive, Triple, triple
from ...graph.substitution import replaced
from ...semantics.symbols import Symbol
from ...syntax import ast
from ..expressions.context import Draft, where
from ..expressions.env import Env, Function, Thunk
from ..expressions.evaluate import Evaluator
from ..expressions.ports import bound
from ..values.handed import Handed
from ..values.kinds import Value, Vec
from ..values.vectors import times
from .curves import Curve, let
from .lowered import Condition, Lowered, blame
from .made import Made
from .paths import handed
from .probe import possible, test_ranges
from .recalled import entry_of, keep, recall

_MOST_COPIES = 64  # of an indexed surface
_STRICT = 2e-9  # twice what requirements are decided to (TOLERANCE of the runtime)
# seconds of lowering a primitive of the file itself, and one of another: what takes less is not kept
_LONG, _BRIEF = 0.03, 0.002


def lower_primitive(context: Draft, symbol: Symbol, values: dict[str, Value] | None = None) -> Lowered:
    """The formulas of a primitive, once per declaration, and per shape of the paths that uses hand in."""
    paths: dict[str, Handed] = {}
    for statement in symbol.body:
        if isinstance(statement, ast.ParamDecl) and statement.type.name == "curve":
            for name, span in zip(statement.names, statement.name_spans, strict=True):
                curve = (values or {}).get(name)
                if not isinstance(curve, Curve):
                    raise context.internal(span, f"`{name}` of `{symbol.name}` is not a path")
                paths[name] = handed(curve, name)
    key = (symbol, *(path.key for path in paths.values())) if paths else symbol
    tested: dict[str, Interval] = {}
    if key not in context.solids and paths:
        plain = shaped(context, symbol, paths, {})
        if not plain.possible:
            tested = _beyond_tests(context, symbol, paths, values or {})
            key = (symbol, *(path.key for path in paths.values()), *tested.items())
        if not tested:
            context.solids[key] = plain
            context.program.primitives[plain.primitive.name] = plain.primitive
    if key not in context.solids:
        made = context.solids[key] = shaped(context, symbol, paths, tested)
        context.program.primitives[made.primitive.name] = made.primitive
    return context.solids[key]


def shaped(context: Draft, symbol: Symbol, paths: dict[str, Handed], tested: dict[str, Interval]) -> Lowered:
    """The formulas of a primitive along given paths, tested over what is stated, or ``tested`` instead."""
    name, number = symbol.name, 2
    while name in context.program.primitives:
        name, number = f"{symbol.name}_{number}", number + 1
    entry = entry_of(symbol, name, paths, tested)
    found, begun = None if entry is None else recall(entry), time.process_time()
    if found is None:
        found = _made(context, symbol, name, paths, tested)
        least = _LONG if symbol.module is context.typed.main else _BRIEF
        if entry is not None and time.process_time() - begun > least:
            keep(entry, found)
    found.paths, found.trace = tuple(paths.values()), tuple(context.trace)
    return found


def _made(context: Draft, symbol: Symbol, name: str, paths: dict[str, Handed], tested: dict[str, Interval]) -> Lowered:
    context.typed.shape(symbol)
    try:
        context.blamed = blame(tuple(paths.values()), symbol.name) if paths else None
        context.tested = tested
        return make(context, symbol, name, paths)
    finally:
        context.blamed, context.tested = None, {}
        replaced.cache_clear()  # another primitive has other formulas


def _beyond_tests(
    context: Draft, symbol: Symbol, paths: dict[str, Handed], values: dict[str, Value]
) -> dict[str, Interval]:
    """The ranges of what a use hands in beside a path where they lead out of the test ranges, none of which is possible along
    it: a thin wire may bend tightly.
    """
    known = Intervals(context.draws, context.program.definitions)
    env = Env(context, symbol.module, symbol, Scope(f"primitive {symbol.name}"), "")
    env.names.update(paths)
    found: dict[str, Interval] = {}
    for name, (low, high) in test_ranges(env):
        own, _, axis = name.partition(".")
        value = values.get(own)
        item = value.items["xyz".index(axis)] if isinstance(value, Vec) and axis else value
        if isinstance(item, Expr):
            least, most = known.of(item)
            if math.isfinite(least) and math.isfinite(most) and not low <= least <= most <= high:
                found[name] = (max(least, min(low, most / 10)) if low > 0 else least, most)
    return found


def make(context: Draft, symbol: Symbol, title: str, paths: dict[str, Handed]) -> Lowered:
    """The formulas of a primitive, with the paths that a use hands in."""
    env = Env(context, symbol.module, symbol, Scope(f"primitive {symbol.name}"), "")
    parameters = [s for s in symbol.body if isinstance(s, ast.ParamDecl)]
    env.names.update(paths)
    conditions = [c for s in parameters if s.type.name != "curve" for c in _declare_parameters(env, s)]
    tests = dict(test_ranges(env))
    stated = _declare_names(env, symbol.body)
    for statement in symbol.body:
        if isinstance(statement, ast.RequireStmt) and statement.condition is not None:
            conditions.append(_condition_of(Evaluator(env), statement))
    whole = [n for s in parameters if s.type.name in ("count", "bool") for n in s.names]
    made = _solid(env, symbol.body)
    if made is None or not made.patches:
        raise context.internal(symbol.decl.name_span, f"the primitive `{symbol.name}` is incomplete")
    for demand in made.requires:
        pair = demand.low, demand.high
        within = E.call("le", *pair)
        if within is not E.TRUE:
            conditions.append(Condition(within, pair, demand.message, "requirement of the operator", demand.bend))
    primitive = Primitive(
        title,
        tuple(tests),
        tuple(tests.values()),
        made.patches,
        made.inside,
        made.low,
        made.high,
        made.pieces,
        tuple(c.holds for c in conditions),
        str(where(symbol.decl.span)),
        tuple(dict.fromkeys(p.name for p in made.patches)),
        tuple(whole),
    )
    ports = {**made.ports, **{name: env.force(name) for name in stated}}
    lowered = Lowered(primitive, tuple(n for s in parameters for n in s.names), ports, conditions)
    size = [E.var(f"size.{a}") for a in "xyz"]
    half = [E.mul(s, E.const(0.5)) for s in size]
    lowered.possible = not paths or not conditions or possible(env, [c.holds for c in conditions])
    lowered.centred_size = all(h is c for h, c in zip(half, made.high, strict=True))
    return lowered


def _declare_names(env: Env, body: tuple[ast.Stmt, ...]) -> list[str]:
    """Give the names of a primitive that are no parameters what they stand for; the names of its ports."""
    ports = []
    for statement in body:
        if isinstance(statement, ast.LetDecl | ast.CurveDecl):
            env.names[statement.name] = let(env, statement)
        elif isinstance(statement, ast.SurfaceDecl):
            env.names[statement.name] = Function(statement.name, (statement.u, statement.v), statement.value, env)
        elif isinstance(statement, ast.PortDecl) and statement.value is not None:
            ports.append(statement.name)
            env.names[statement.name] = Thunk(partial(bound, env, statement), statement.name_span)
    return ports


def _solid(env: Env, body: tuple[ast.Stmt, ...]) -> Made | None:
    """The solid that surfaces bound, or that an operator makes of curves, with the pieces and the box that are stated, if any."""
    limits = domains(env, body)
    patches: list[Patch] = []
    pieces: list[Piece] = []
    inside: Expr | None = None
    box: tuple[Triple, Triple] | None = None
    operator: ast.SolidDecl | None = None
    for statement in body:
        match statement:
            case ast.SurfaceDecl():
                patches.append(_patch_of(env, statement, limits))
            case ast.PieceDecl():
                pieces.append(_piece_of(env, statement))
            case ast.InsideDecl():
                point = Vec(tuple(E.var(f"p.{a}") for a in "xyz"))
                inside = Evaluator(env, {statement.parameter: point}).scalar(statement.value)
            case ast.BoxDecl():
                box = box_of(Evaluator(env), statement)
            case ast.SolidDecl():
                operator = statement
            case _:
                pass
    if operator is not None:
        from .operators import solid_of  # start-up: most solids are kept

        made = solid_of(env, operator)
        low, high = box or (made.low, made.high)
        return replace(made, pieces=tuple(pieces) or made.pieces, low=low, high=high)
    return None if inside is None or box is None else Made(tuple(patches), tuple(pieces), inside, *box)


def _declare_parameters(env: Env, statement: ast.ParamDecl) -> list[Condition]:
    """Give the names of a statement their variables; what it asks of them."""
    size, asked = statement.type.size, []
    for name in statement.names:
        components = [f"{name}.{'xyz'[k]}" for k in range(size)] if size else [name]
        env.names[name] = Vec(tuple(E.var(c) for c in components)) if size else E.var(name)
        for component in components:
            value, pairs = E.var(component), []
            told, text = f"{component} lies outside its domain", f"{component} in its domain"
            if statement.positive:
                pairs = [(E.const(1e-5), value)]
                told, text = f"{component} must be positive", f"{component} > 0"
            elif statement.domain is not None:
                low, high = (Evaluator(env).scalar(n) for n in (statement.domain.low, statement.domain.high))
                pairs = [(low, value), (value, high)]
            asked += [Condition(E.call("le", *pair), pair, told, text) for pair in pairs]
    return asked


def _condition_of(ev: Evaluator, statement: ast.RequireStmt) -> Condition:
    assert statement.condition is not None
    condition, slack, _ = comparison(ev, statement.condition)
    return Condition(condition, slack, statement.message or "a requirement of the primitive fails", "requirement")


def comparison(ev: Evaluator, node: ast.Expr) -> tuple[Expr, tuple[Expr, Expr] | None, bool]:
    """A condition and, for an inequality, its two sides (low, high), and whether these must differ without a least difference."""
    if isinstance(node, ast.BinaryExpr) and node.op in ("<", "<=", ">", ">="):
        left, right = ev.number(ev.value(node.left), node.left.span), ev.number(ev.value(node.right), node.right.span)
        pair = (left, right) if node.op in ("<", "<=") else (right, left)
        apart = _apart(ev.env, left, right) if node.op in ("<", ">") else None
        if apart:
            pair = pair[0], E.sub(pair[1], E.const(apart))
        return E.call("le", *pair), pair, apart == 0.0
    return ev.condition(node), None, False


def _apart(env: Env, left: Expr, right: Expr) -> float:
    """By how much one side of a strict inequality is less than the other: sampling cannot tell ``<`` from ``<=`` where they are
    real, but does where they are one of some values (``drawers * 5cm < 15cm``)."""
    if _is_whole(left) and _is_whole(right):
        return 1.0
    difference = E.sub(left, right)
    columns = {node.value for node in _real_leaves(difference)}
    listed = (
        {draw.column for draw in env.context.program.draws if draw.distribution == "values"} if columns else columns
    )
    return _STRICT if columns <= listed and not E.variables([difference]) else 0.0


def _is_whole(value: Expr) -> bool:
    """Whether a value is seen to be a whole number: counts, ranks, constants, and what is made of these."""
    return all(
        node.op in ("add", "sub", "mul", "neg", "abs", "min", "max")
        or (node.op == "const" and isinstance(node.value, float) and node.value.is_integer())
        or (node.op == "col" and node.value.kind == "count")
        for node in _reached(value, ("rank", "floor", "ceil"))
    )


def _real_leaves(value: Expr) -> Iterator[Expr]:
    """The columns of real numbers that a value changes with continuously."""
    return (n for n in _reached(value, ("floor", "ceil", "sign")) if n.op == "col" and n.value.kind == "real")


def _reached(value: Expr, steps: tuple[str, ...]) -> Iterator[Expr]:
    """What a value is made of, each node once, without those of the operations ``steps`` and what they alone read, and without
    conditions."""
    seen: set[Expr] = set()
    left = [value]
    while left:
        node = left.pop()
        if node in seen or node.op in steps:
            continue
        seen.add(node)
        yield node
        left.extend(node.args[1:] if node.op == "where" else node.args)


def box_of(ev: Evaluator, statement: ast.BoxDecl) -> tuple[Triple, Triple]:
    if statement.value is not None:
        size = ev.vector(statement.value)
        half = times(size, E.const(0.5))
        return triple(E.neg(c) for c in half), half
    assert statement.low is not None and statement.high is not None
    return ev.vector(statement.low), ev.vector(statement.high)


def domains(env: Env, body: tuple[ast.Stmt, ...]) -> dict[Expr, Interval]:
    """The constant domains of scalar parameters."""
    found: dict[Expr, Interval] = {}
    for statement in body:
        if isinstance(statement, ast.ParamDecl) and statement.domain is not None and not statement.type.size:
            low, high = (Evaluator(env).scalar(n).constant for n in (statement.domain.low, statement.domain.high))
            if low is not None and high is not None:
                found |= {E.var(name): (float(low), float(high)) for name in statement.names}
    return found


def _copies(env: Env, number: Expr, node: ast.Expr, limits: dict[Expr, Interval]) -> tuple[int, Expr | None]:
    """The greatest number of copies of an indexed surface, and where it varies, which of them exist."""
    if number.constant is not None:
        return int(number.constant), None
    known = Intervals((), {})
    known.memo.update(limits)
    _, most = known.of(number)
    if not most <= _MOST_COPIES:
        raise env.context.error(
            "open-count",
            node.span,
            f"the number of copies of this surface has no known limit, or one above {_MOST_COPIES}",
            hint="use a count with a range: `param sides : count in 3 .. 12`",
        )
    return int(most + 1e-9), E.call("lt", E.var("i"), number)


def _patch_of(env: Env, statement: ast.SurfaceDecl, limits: dict[Expr, Interval]) -> Patch:
    local: dict[str, Value] = {statement.u: E.var("u"), statement.v: E.var("v")}
    if statement.index is not None:
        local[statement.index] = E.var("i")
    ev = Evaluator(env, local)
    plain = Evaluator(env, {statement.index: E.var("i")} if statement.index is not None else None)
    u = (plain.scalar(statement.u_range.low), plain.scalar(statement.u_range.high))
    v = (plain.scalar(statement.v_range.low), plain.scalar(statement.v_range.high))
    guard = None if statement.guard is None else ev.condition(statement.guard)
    count = None
    if statement.index_count is not None:
        count, present = _copies(env, plain.scalar(statement.index_count), statement.index_count, limits)
        guard = present if guard is None else guard if present is None else E.both(guard, present)
    return Patch(statement.name, ev.vector(statement.value), u, v, guard, count)


def _piece_of(env: Env, statement: ast.PieceDecl) -> Piece:
    local: dict[str, Value] = {statement.index: E.var("i")} if statement.index is not None else {}
    ev = Evaluator(env, local)
    count = None if statement.count is None else Evaluator(env).scalar(statement.count)
    guard = None if statement.guard is None else ev.condition(statement.guard)
    return Piece(statement.name, tuple(ev.vector(p) for p in statement.points), count, guard)
