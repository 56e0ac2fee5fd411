"""Ranges and defaults of different units, one of which is perhaps wrong: `14mm .. 20cm`, and `3cm .. 45cm = 37mm`.

Of 1,126 ranges of two numbers with a default, in categories, the library and other programs, 85 have a default in another unit than both ends.
It lies at a sixth of the range at least, and at five eighths at most; but for one, its number in the unit of the ends lies outside.
"""

from __future__ import annotations

from collections.abc import Iterator

from ..diagnostics import Report
from ..syntax import ast
from ..syntax.walk import walk
from ..units import UNITS
from .check import TypedProgram

_WIDE = 8.0  # times the low end: ranges of fewer are usual
_OUTER = 0.1  # of a range: few defaults lie nearer to an end, and none of those has another unit
_LARGE = 10.0  # a number of two digits is hardly ever meant in the smaller unit and in the larger one


def warn_mixed(typed: TypedProgram, report: Report) -> None:
    """Report ranges of the file that would be usual ones if both ends had the unit of one of them."""
    for node in walk(typed.main.tree.declarations):
        if isinstance(node, ast.ParamDecl) and node.domain is not None:
            for low, high, usual in _ranges(node):
                _warn_default(low, high, usual, report)
                if meant := list(_meant(low, high, usual)):
                    written = f"{low.span.text} .. {high.span.text}"
                    report.warning(
                        "mixed-units",
                        low.span.to(high.span),
                        f"the high end of `{written}` is {_factor(low, high):.2g} times the low one, and their units differ",
                        hint=f"is one of the units wrong? Write {' or '.join(f'`{each}`' for each in meant)}; "
                        f"if both are right, give them one unit: `{low.span.text} .. {_in_unit(high, low.unit)}`",
                    )


def _warn_default(low: ast.NumberExpr, high: ast.NumberExpr, usual: ast.Expr | None, report: Report) -> None:
    """Report a default beside an end of the range that would lie in it with the unit of both ends, too."""
    if not isinstance(usual, ast.NumberExpr) or low.unit != high.unit or usual.unit in (low.unit, ""):
        return
    if not {low.unit, usual.unit} <= UNITS.keys() or UNITS[low.unit][1] != UNITS[usual.unit][1]:
        return
    first, last, value = (each.value * UNITS[each.unit][0] for each in (low, high, usual))
    if first < last and low.value <= usual.value <= high.value:
        share = (value - first) / (last - first)
        if 0.0 <= share < _OUTER or 1.0 - _OUTER < share <= 1.0:
            report.warning(
                "mixed-units",
                usual.span,
                f"`{usual.span.text}` lies beside the {'low' if share < 0.5 else 'high'} end of its range, whose unit is `{low.unit}`",
                hint=f"is its unit wrong? Write `{usual.value:g}{low.unit}`; if it is right, write `{_in_unit(usual, low.unit)}`",
            )


def _ranges(node: ast.ParamDecl) -> Iterator[tuple[ast.NumberExpr, ast.NumberExpr, ast.Expr | None]]:
    """The ends of a range as they are written, of a vector those of each component, and a value that is usual in it."""
    assert node.domain is not None
    usual = node.default
    if usual is None and node.distribution is not None and node.distribution.name != "values":
        usual = next((argument.value for argument in node.distribution.arguments), None)
    ends = [each.items if isinstance(each, ast.VectorExpr) else (each,) for each in (node.domain.low, node.domain.high)]
    middle = usual.items if isinstance(usual, ast.VectorExpr) else (usual,) * len(ends[0])
    for low, high, value in zip(*ends, middle, strict=False):
        if isinstance(low, ast.NumberExpr) and isinstance(high, ast.NumberExpr):
            yield low, high, value


def _meant(low: ast.NumberExpr, high: ast.NumberExpr, usual: ast.Expr | None) -> Iterator[str]:
    """The ranges that are perhaps meant: with one unit, in which the usual value lies, or with large numbers."""
    if low.unit == high.unit or low.value <= 0.0 or not {low.unit, high.unit} <= UNITS.keys():
        return
    if UNITS[low.unit][1] != UNITS[high.unit][1] or not 0.0 < low.value < high.value or _factor(low, high) < _WIDE:
        return
    for unit in (low.unit, high.unit):
        factor = UNITS[unit][0]
        if isinstance(usual, ast.NumberExpr) and usual.unit in UNITS:
            likely = low.value * factor <= usual.value * UNITS[usual.unit][0] <= high.value * factor
        else:
            likely = usual is None and low.value >= _LARGE
        if likely:
            yield f"{low.value:g}{unit} .. {high.value:g}{unit}"


def _factor(low: ast.NumberExpr, high: ast.NumberExpr) -> float:
    return high.value * UNITS[high.unit][0] / (low.value * UNITS[low.unit][0])


def _in_unit(number: ast.NumberExpr, unit: str) -> str:
    return f"{number.value * UNITS[number.unit][0] / UNITS[unit][0]:.6g}{unit}"
