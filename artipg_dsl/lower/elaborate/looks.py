"""Materials: declared properties, and styles that choose among materials."""

from __future__ import annotations

from dataclasses import dataclass

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.program import Material
from ...semantics.symbols import Symbol
from ...syntax import ast
from ..expressions.context import Context
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.kinds import Choice, Vec
from .draws import draw_choice
from .ranges import MATERIAL, plain

RANGES = {
    "density": "density", "friction_static": "friction_static", "static_friction": "friction_static",
    "friction_dynamic": "friction_dynamic", "dynamic_friction": "friction_dynamic", "restitution": "restitution",
    "metalness": "metalness", "roughness": "roughness", "transparency": "transparency",
}  # fmt: skip


@dataclass(slots=True, eq=False)
class Look:
    """``style look : material = oak | white``: each material with the predicate under which it is the one."""

    options: tuple[tuple[str, Expr], ...]
    choice: Choice

    def chosen(self, name: str) -> Expr | None:
        return self.choice.chosen(name)


def build_look(env: Env, statement: ast.StyleDecl) -> Look:
    several: dict[str, list[ast.Alternative]] = {}
    for alternative in statement.alternatives:
        several.setdefault(alternative.name or "none", []).append(alternative)
    same = tuple(tuple(found) for found in several.values())
    choice = draw_choice(env, env.path + statement.name, tuple(several), same, statement.name_span, statement)
    options = []
    for code, (alternative, *_) in enumerate(same):
        symbol = env.module.find(alternative.name or "")
        if symbol is None or symbol.kind != "material":
            raise env.context.error(
                "unknown-material", alternative.name_span, f"there is no material `{alternative.name}`"
            )
        lower_material(env.context, symbol)
        options.append((symbol.name, E.call("eq", choice.code, E.const(float(code)))))
    return Look(tuple(options), choice)


def lower_material(context: Context, symbol: Symbol) -> Material:
    found = context.program.materials.get(symbol.name)
    if found is not None:
        return found
    home = Env(context, symbol.module, symbol, context.program.scopes[0], "")
    ev = Evaluator(home)
    values: dict = {"name": symbol.name}
    declaration = symbol.decl
    assert isinstance(declaration, ast.MaterialDecl)
    for clause in declaration.properties:
        if clause.word in ("colour", "color"):
            colours = []
            for node in clause.values:
                value = ev.value(node)
                if not isinstance(value, Vec):
                    raise context.error(
                        "wrong-kind", node.span, "a colour is a vector [red, green, blue] of numbers in 0 .. 1"
                    )
                colours.append(tuple(settled(context, "colour", node, c) for c in value.items))
            values["colour"] = tuple(colours)
        elif clause.word in RANGES:
            values[RANGES[clause.word]] = span_of(ev, RANGES[clause.word], clause)
        elif clause.word == "friction":
            values["friction_static"] = values["friction_dynamic"] = span_of(ev, "friction_static", clause)
        else:
            known = sorted({*RANGES, "colour", "friction"})
            raise context.error(
                "unknown-clause", clause.span, f"a material has no `{clause.word}`", hint=f"it has {', '.join(known)}"
            )
    made = Material(**values)
    context.program.materials[symbol.name] = made
    return made


def span_of(ev: Evaluator, name: str, clause: ast.Clause) -> tuple[float, float]:
    """The range of a property: one value, or the two ends."""
    numbers = [settled(ev.env.context, name, node, ev.scalar(node)) for node in clause.values]
    if numbers[0] > numbers[-1]:
        raise ev.env.context.error(
            "empty-range", clause.span, "the range is empty: its low end lies above its high end", hint="swap the ends"
        )
    return numbers[0], numbers[-1]


def settled(context: Context, name: str, node: ast.Expr, value: Expr) -> float:
    """A property's number, which is known beforehand and lies in the range that is legal for it."""
    if value.constant is None:
        raise context.error("wrong-kind", node.span, "the properties of a material are numbers, or ranges of them")
    number, legal = float(value.constant), MATERIAL[name]
    if not legal.holds(number):
        raise context.error("illegal-value", node.span, f"`{name}` is {plain(number)}, but {legal.words}")
    return number
