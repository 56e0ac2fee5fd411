"""Materials: declared properties, and styles that choose among materials."""

from __future__ import annotations

from dataclasses import dataclass

from ..graph import expr as E
from ..graph.expr import Expr
from ..graph.program import Material
from ..semantics.symbols import Symbol
from ..syntax import ast
from .context import Context
from .draws import draw_choice
from .env import Env
from .evaluate import Evaluator
from .values import Choice, Vec

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
                colours.append(tuple(float(c.constant or 0.0) for c in value.items))
            values["colour"] = tuple(colours)
        elif clause.word in RANGES:
            numbers = [float(ev.scalar(n).constant or 0.0) for n in clause.values]
            values[RANGES[clause.word]] = (numbers[0], numbers[-1])
        elif clause.word == "friction":
            numbers = [float(ev.scalar(n).constant or 0.0) for n in clause.values]
            values["friction_static"] = values["friction_dynamic"] = (numbers[0], numbers[-1])
        else:
            known = sorted({*RANGES, "colour", "friction"})
            raise context.error(
                "unknown-clause", clause.span, f"a material has no `{clause.word}`", hint=f"it has {', '.join(known)}"
            )
    made = Material(**values)
    context.program.materials[symbol.name] = made
    return made
