"""Expressions as they are read from a file: built only where operator, arguments, tables and variables fit together.

What is read is data that anyone may have written, so nothing is taken on trust: what passes here can be planned and
evaluated. An expression may hold free variables (a formula) only through plain operations; what reads tables holds none.
"""

from __future__ import annotations

import re
from typing import Any

from .expr import Column, Expr, Scope, ScopeError, operation, raw
from .functions import FUNCTIONS, PREDICATES

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*(\.[A-Za-z0-9_]+)*")
KINDS = ("real", "count", "choice", "bool")
_REDUCTIONS = ("sum", "min", "max", "any", "all")
_MOST_UNKNOWNS = 64  # of equations that are solved together
_NONE: frozenset[str] = frozenset()
_ARITY = {op: (row[0], op in PREDICATES) for op, row in FUNCTIONS.items()}
Facts = tuple[frozenset[str], bool, bool]
"""The free variables of an expression; whether it is true or false; whether it is made of constants, variables and operations on them
alone."""


class NodeFault(ValueError):
    """What is wrong, in words."""


def require(holds: object, words: str) -> None:
    if not holds:
        raise NodeFault(words)


def _joined(one: Facts, other: Facts) -> Facts:
    """What is said of an operation on two expressions: one of the two, where that says it."""
    if one[1:] == other[1:]:
        if one[0] >= other[0]:
            return one
        if one[0] <= other[0]:
            return other
    return one[0] | other[0], one[1] or other[1], one[2] and other[2]


class Nodes:
    """The expressions read so far: the free variables of each, and whether it is true or false rather than a number."""

    def __init__(self) -> None:
        self.facts: dict[Expr, Facts] = {}
        self.make("const", True, ())  # what records have where nothing is written

    def truth(self, expr: Expr) -> bool:
        return self.facts[expr][1]

    def plain(self, op: str, args: tuple[Expr, ...]) -> Expr:
        """The node of an operation (one of FUNCTIONS) on expressions that were read. Raises NodeFault."""
        facts = self.facts
        arity, predicate = _ARITY[op]
        if len(args) != arity:
            raise NodeFault(f"{op} takes {arity} arguments, not {len(args)}")
        known = facts[args[0]]
        for arg in args:
            other = facts[arg]
            if (
                other is not known
            ):  # most of the time it is: that of the argument with the most variables, again and again
                known = _joined(known, other)
        if op == "where":
            known = known[0], facts[args[1]][1] and facts[args[2]][1], known[2]
        elif predicate:
            known = known[0], True, known[2]
        elif known[1]:
            raise NodeFault(f"{op} calculates with numbers, not with true and false")
        try:
            node = operation(op, args)
        except ScopeError as error:
            raise NodeFault(str(error)) from None
        facts[node] = known
        return node

    def make(self, op: str, value: Any, args: tuple[Any, ...]) -> Expr:
        """The node. Raises Fault."""
        # the words of faults are put together where there are some: a program has tens of thousands of nodes
        if not all([isinstance(a, Expr) and a in self.facts for a in args]):
            raise NodeFault(f"the arguments of {op} are expressions (%n)")
        if op in FUNCTIONS:
            return self.plain(op, args)
        if op not in _SPECIAL:
            raise NodeFault(f"there is no operator {op[:40]!r}")
        if op != "solve" and any([self.facts[a][0] for a in args]):
            raise NodeFault(f"a variable of a formula is inside {op}")
        try:
            node, truth = getattr(self, f"_{op}")(value, args)
        except ScopeError as error:
            raise NodeFault(str(error)) from None
        self.facts[node] = frozenset((value,)) if op == "var" else _NONE, truth, op in ("const", "var")
        return node

    def stands(self, expr: Expr, scope: Scope | None) -> bool:
        """Whether an expression has a value in the rows of ``scope``."""
        return not self.facts[expr][0] and (expr.scope is None or scope is not None and scope.within(expr.scope))

    def computes(self, expr: Expr, known: frozenset[str], scope: Scope | None) -> str | None:
        """What keeps an expression from being a formula over the variables ``known`` and values in the rows of ``scope``."""
        strange = self.facts[expr][0] - known
        if strange:
            return f"a formula reads {sorted(strange)[0]}, which it does not know"
        stack, seen = [expr], set()
        while stack:
            node = stack.pop()
            if node in seen or self.facts[node][2]:
                continue
            seen.add(node)
            if not self.facts[node][0] and node.scope is not None:
                if scope is None or not scope.within(node.scope):
                    return "a formula reads a table that it cannot see"
            elif node.op in FUNCTIONS:
                stack.extend(node.args)
            else:
                return f"{node.op} is not allowed in a formula"
        return None

    # ------------------------------------------------------------ operators

    def _const(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(not args and isinstance(value, bool | float), "a constant is a number such as 0.5, true or false")
        return raw("const", (), value), isinstance(value, bool)

    def _var(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(
            not args and isinstance(value, str) and NAME.fullmatch(value), "the name of a variable is made of words"
        )
        return raw("var", (), value), False

    def _col(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(not args and isinstance(value, Column), "col reads a column ($n)")
        return raw("col", (), value, value.scope), value.kind == "bool"

    def _rank(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(not args and isinstance(value, Scope), "rank is of a table (@n)")
        return raw("rank", (), value, value), False

    def _phi(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(
            isinstance(value, tuple) and value and all(isinstance(s, Scope) for s in value),
            "phi merges tables [@n ...]",
        )
        parent = value[0].parent
        require(
            parent and all(s.parent is parent and s.kind == "guard" for s in value), "phi merges guards of one table"
        )
        require(
            len(args) == len(value) + 1, f"phi of {len(value)} tables takes {len(value) + 1} arguments, not {len(args)}"
        )
        held = all(self.stands(a, s) for a, s in zip(args, (*value, parent), strict=True))
        require(held, "phi reads a table that it cannot see")
        return raw("phi", args, value, parent), all(self.truth(a) for a in args)

    def _reduce(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        kind, child = value
        require(kind in _REDUCTIONS, f"there is no reduction {str(kind)[:40]!r}")
        require(isinstance(child, Scope) and child.parent, "reduce is over the rows of a table below another (@n)")
        require(len(args) == 1 and self.stands(args[0], child), "reduce takes one argument in the rows of its table")
        return raw("reduce", args, (kind, child), child.parent), kind in ("any", "all")

    def _element(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(isinstance(value, Scope) and value.parent, "element is of a table below another (@n)")
        require(len(args) == 2, "element takes a value and a rank")
        require(
            self.stands(args[0], value) and self.stands(args[1], value.parent),
            "element reads a table that it cannot see",
        )
        return raw("element", args, value, value.parent), self.truth(args[0])

    def _previous(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(isinstance(value, Scope), "previous is of a table (@n)")
        require(
            len(args) == 2 and all(self.stands(a, value) for a in args),
            "previous takes a value and a first one in its table",
        )
        return raw("previous", args, value, value), all(self.truth(a) for a in args)

    def _scan(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(isinstance(value, Scope), "scan is of a table (@n)")
        require(len(args) == 1 and self.stands(args[0], value), "scan takes one argument in the rows of its table")
        return raw("scan", args, value, value), False

    def _solve(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        whole = all(isinstance(n, int) and not isinstance(n, bool) for n in value)
        require(
            whole and 1 <= value[0] <= _MOST_UNKNOWNS and value[1] >= 0,
            "solve says how many unknowns and values it has",
        )
        size, known = value
        formulas, values = args[: size + size * size], args[size + size * size :]
        require(len(values) == known + size, f"solve of {size} unknowns and {known} values has other arguments")
        names = frozenset([f"solve.x{k}" for k in range(size)] + [f"solve.p{k}" for k in range(known)])
        require(
            all(self.facts[a][2] and self.facts[a][0] <= names for a in formulas),
            "solve solves formulas of its unknowns and values",
        )
        require(not any(self.facts[a][0] for a in values), "a variable of a formula is inside solve")
        return raw("solve", args, value), False

    def _root(self, value: Any, args: tuple[Expr, ...]) -> tuple[Expr, bool]:
        require(len(args) == 1 and args[0].op == "solve", "root is of equations solved together")
        (index,) = value
        require(type(index) is int and 0 <= index < args[0].value[0], "root says which unknown it is")
        return raw("root", args, value, args[0].scope), False


_SPECIAL = frozenset({"const", "var", "col", "rank", "phi", "reduce", "element", "previous", "scan", "solve", "root"})
