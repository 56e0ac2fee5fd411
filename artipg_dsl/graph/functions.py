"""The operations of numbers and truth values: how many arguments each takes and what it makes of constants."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

# name -> (arity, scalar implementation used for folding constants)
FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "add": (2, lambda a, b: a + b),
    "sub": (2, lambda a, b: a - b),
    "mul": (2, lambda a, b: a * b),
    "div": (2, lambda a, b: a / b),
    "neg": (1, lambda a: -a),
    "pow": (2, lambda a, b: a**b),
    "abs": (1, abs),
    "sqrt": (1, math.sqrt),
    "sin": (1, math.sin),
    "cos": (1, math.cos),
    "tan": (1, math.tan),
    "asin": (1, math.asin),
    "acos": (1, math.acos),
    "atan": (1, math.atan),
    "atan2": (2, math.atan2),
    "hypot": (2, math.hypot),
    "exp": (1, math.exp),
    "log": (1, math.log),
    "floor": (1, lambda a: a if math.isinf(a) else math.floor(a)),
    "ceil": (1, lambda a: a if math.isinf(a) else math.ceil(a)),
    "sign": (1, lambda a: float((a > 0) - (a < 0))),
    "min": (2, lambda a, b: a if a != a or a < b else b),
    "max": (2, lambda a, b: a if a != a or a > b else b),
    "mod": (2, lambda a, b: a % b),
    "lt": (2, lambda a, b: a < b),
    "le": (2, lambda a, b: a <= b),
    "eq": (2, lambda a, b: a == b),
    "and": (2, lambda a, b: bool(a) and bool(b)),
    "or": (2, lambda a, b: bool(a) or bool(b)),
    "not": (1, lambda a: not a),
    "where": (3, lambda c, a, b: a if c else b),
}
PREDICATES = frozenset({"lt", "le", "eq", "and", "or", "not"})


def fold_constants(function: Callable[..., float], values: Sequence[float]) -> float:
    """The value of a function of constants: nan where it has none (1 / 0, the root or the logarithm of -1), inf where it is
    too large for a number. What an author writes of this kind is refused where it stands (``lower.expressions.arithmetic``)."""
    try:
        value = function(*values)
    except (ValueError, ZeroDivisionError):
        return math.nan
    except OverflowError:
        return math.inf
    return math.nan if isinstance(value, complex) else value
