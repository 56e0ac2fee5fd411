"""The two numbers that name a place on a surface: of the dimensions over which the primitive states it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..syntax import ast
from .ranges import range_type
from .types import ANGLE, RATIO, UNKNOWN, PartType, ScalarType, Type

if TYPE_CHECKING:
    from ..language import Parameter
    from .checker import Checker
    from .scope import Entry
    from .symbols import Symbol


def check_parameters(ck: Checker, named: ast.Expr, bound: list[tuple[ast.Argument, Parameter]]) -> bool:
    """Whether ``u`` and ``v`` of ``at`` have the dimensions that they have on the surface, as far as those are known here; what has
    not is reported."""
    part = ck.types.get(id(named.obj)) if isinstance(named, ast.MemberExpr) else None
    if not isinstance(part, PartType):
        return True
    assert isinstance(named, ast.MemberExpr)
    for argument, parameter in bound:
        given = ck.types.get(id(argument.value), UNKNOWN)
        if parameter.type != "number" or not isinstance(given, ScalarType) or given.zero:
            continue
        for variant in part.variants:
            wanted = _ranges(ck, variant.symbol, named.name).get(parameter.name)
            if isinstance(wanted, ScalarType) and wanted.dimension != given.dimension:
                ck.mismatch(argument.value, given, wanted, f"`{parameter.name}` of `{named.span.words}`")
                return False
    return True


def _ranges(ck: Checker, symbol: Symbol | None, name: str) -> dict[str, Type]:
    """The types of what a surface of a primitive ranges over; empty where an operator makes it of no curve with that name."""
    if symbol is None or symbol.kind != "primitive":
        return {}
    for entry in ck.scope_of(symbol).table.get(name, ()):
        node = entry.node
        if isinstance(node, ast.SurfaceDecl):
            return {"u": _range(ck, entry, node.u_range), "v": _range(ck, entry, node.v_range)}
        solid = next((s for s in symbol.body if isinstance(s, ast.SolidDecl)), None)
        if isinstance(node, ast.CurveDecl) and solid is not None:
            along = _range(ck, entry, node.parameter_range)
            across = ANGLE if solid.operator == "lathe" else RATIO
            return {"u": along, "v": across} if solid.operator in ("sweep", "loft") else {"u": across, "v": along}
    return {}


def _range(ck: Checker, entry: Entry, interval: ast.RangeExpr) -> Type:
    with ck.muted():
        return range_type(ck, ck.context(entry.scope), interval)
