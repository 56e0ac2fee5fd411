"""Values of constant expressions in SI units, for checks on ranges and defaults."""

from __future__ import annotations

from ..language import NUMBERS
from ..syntax import ast
from ..units import UNITS
from .symbols import ModuleScope


def constant(expr: ast.Expr, module: ModuleScope | None = None) -> float | None:
    """The value of an expression of numbers (and, given their module, named constants), or None where it is not one."""
    match expr:
        case ast.NumberExpr(value=value, unit=unit):
            return value * UNITS[unit][0] if unit in UNITS else value if not unit else None
        case ast.UnaryExpr(op="-" | "+" as op, operand=operand):
            inner = constant(operand, module)
            return None if inner is None else -inner if op == "-" else inner
        case ast.BinaryExpr(op="+" | "-" | "*" | "/" | "^", left=left, right=right):
            a, b = constant(left, module), constant(right, module)
            return None if a is None or b is None else _apply(expr.op, a, b)
        case ast.NameExpr(name=name) if name in NUMBERS:
            return NUMBERS[name]
        case ast.NameExpr(name=name) if module is not None:
            symbol = module.find(name)
            if symbol is not None and isinstance(symbol.decl, ast.FunctionDecl) and not symbol.decl.parameters:
                return constant(symbol.decl.value)  # one step is enough: constants are written out
    return None


def _apply(op: str, a: float, b: float) -> float | None:
    try:
        match op:
            case "+":
                return a + b
            case "-":
                return a - b
            case "*":
                return a * b
            case "/":
                return a / b
            case _:
                power = a**b
                return power if isinstance(power, float) else None
    except (ZeroDivisionError, OverflowError):
        return None


def components(expr: ast.Expr, module: ModuleScope | None = None) -> tuple[float | None, ...]:
    """The values of a vector's components, or the one of a number; None for each that is not constant."""
    if isinstance(expr, ast.VectorExpr):
        return tuple(constant(item, module) for item in expr.items)
    return (constant(expr, module),)


def is_unitless(expr: ast.Expr) -> bool:
    """Whether an expression consists of numbers without units alone."""
    match expr:
        case ast.NumberExpr(unit=unit):
            return unit == ""
        case ast.NameExpr(name=name):
            return name in NUMBERS
        case ast.UnaryExpr(operand=operand):
            return is_unitless(operand)
        case ast.BinaryExpr(left=left, right=right):
            return is_unitless(left) and is_unitless(right)
        case ast.VectorExpr(items=items):
            return all(isinstance(i, ast.HoleExpr) or is_unitless(i) for i in items)
    return False
