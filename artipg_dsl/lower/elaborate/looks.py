"""Materials: declared properties, and styles that choose among materials."""

from __future__ import annotations

from typing import Any

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.program import Material
from ...semantics.meanings import Global
from ...semantics.symbols import Symbol
from ...syntax import ast
from ..expressions.context import Draft
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.kinds import Choice, Look
from .draws import draw_choice
from .ranges import MATERIAL, plain


def build_look(env: Env, statement: ast.StyleDecl) -> Look:
    several: dict[str, list[ast.Alternative]] = {}
    for alternative in statement.alternatives:
        several.setdefault(alternative.name or "none", []).append(alternative)
    same = tuple(tuple(found) for found in several.values())
    choice = draw_choice(env, env.path + statement.name, tuple(several), same, statement.name_span, statement)
    options = []
    for code, (alternative, *_) in enumerate(same):
        symbol = env.context.symbol(alternative)
        if symbol is None:
            raise env.context.internal(alternative.name_span, "this is not a material")
        _lower_material(env.context, symbol)
        options.append((symbol.name, E.call("eq", choice.code, E.const(float(code)))))
    return Look(tuple(options), choice)


def sole_look(context: Draft, symbol: Symbol) -> Look:
    """What a material's name stands for where a style of materials may be handed in: that material, always."""
    return Look(((_lower_material(context, symbol).name, E.TRUE),), Choice(E.ZERO, (symbol.name,)))


def look_of(env: Env, node: ast.Expr) -> Look:
    """The material, or the style of materials, that an expression names."""
    meaning = env.context.meaning(node)
    if isinstance(meaning, Global):
        return sole_look(env.context, meaning.symbol)
    value = Evaluator(env).value(node)
    if isinstance(value, Look):
        return value
    raise env.context.internal(node.span, "this is not a material")


def _lower_material(context: Draft, symbol: Symbol) -> Material:
    found = context.program.materials.get(symbol.name)
    if found is not None:
        return found
    home = Env(context, symbol.module, symbol, context.program.scopes[0], "")
    ev = Evaluator(home)
    values: dict[Any, Any] = {"name": symbol.name}
    declaration = symbol.decl
    assert isinstance(declaration, ast.MaterialDecl)
    if declaration.colour is not None:
        colours = ((node, ev.vector(node)) for node in ends(declaration.colour))
        values["colour"] = tuple(tuple(_read_number(context, "colour", n, c) for c in colour) for n, colour in colours)
    properties = {
        "density": declaration.density,
        "friction_static": declaration.static_friction or declaration.friction,
        "friction_dynamic": declaration.dynamic_friction or declaration.friction,
        "restitution": declaration.restitution,
        "metalness": declaration.metalness,
        "roughness": declaration.roughness,
        "transparency": declaration.transparency,
    }
    values |= {name: _span_of(ev, name, clause) for name, clause in properties.items() if clause is not None}
    made = Material(**values)
    context.program.materials[symbol.name] = made
    return made


def ends(clause: ast.Clause[ast.RangeExpr]) -> tuple[ast.Expr, ...]:
    """The two ends of a property's range, or its one value."""
    low, high = clause.value.low, clause.value.high
    return (low,) if low is high else (low, high)


def _span_of(ev: Evaluator, name: str, clause: ast.Clause[ast.RangeExpr]) -> tuple[float, float]:
    """The range of a property: one value, or the two ends."""
    numbers = [_read_number(ev.env.context, name, node, ev.scalar(node)) for node in ends(clause)]
    if numbers[0] > numbers[-1]:
        raise ev.env.context.error(
            "empty-range", clause.span, "the range is empty: its low end lies above its high end", hint="swap the ends"
        )
    return numbers[0], numbers[-1]


def _read_number(context: Draft, name: str, node: ast.Expr, value: Expr) -> float:
    """A property's number, which is known beforehand and lies in the range that is legal for it."""
    if value.constant is None:
        raise context.internal(node.span, "this depends on what is drawn")
    number, legal = float(value.constant), MATERIAL[name]
    if not legal.holds(number):
        raise context.error(
            "illegal-value",
            node.span,
            f"`{name}` is {plain(number)}, but {legal.refusal(number)}",
            hint="write a number in that range",
        )
    return number
