"""Scalar expressions over the columns of tables: immutable, interned, folded while they are built.

An expression lives in a *scope* (a table): the deepest one that its columns belong to, or none for a constant or a
formula over free variables. A value of an ancestor scope is gathered into a deeper one implicitly; values go the other
way only through ``phi`` (one row or none per parent row), ``reduce`` and ``element``.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Hashable, Iterable, Iterator, Sequence
from typing import Any

from .functions import FUNCTIONS, fold_constants
from .functions import PREDICATES as PREDICATES
from .interned import Interned
from .scopes import Column as Column
from .scopes import Scope as Scope
from .scopes import ScopeError as ScopeError
from .show import is_short
from .show import show as show


class Expr:
    """One node. ``op`` names it, ``args`` are expressions, ``value`` what is not an expression; ``reads`` has a bit for each
    free variable in it.
    """

    __slots__ = ("op", "args", "value", "scope", "reads", "__weakref__")

    op: str
    args: tuple[Expr, ...]
    value: Any
    scope: Scope | None
    reads: int

    @property
    def constant(self) -> float | None:
        return self.value if self.op == "const" else None

    def __repr__(self) -> str:
        return show(self) if is_short(self, 200) else f"<{self.op} of many terms>"

    def __add__(self, other: Expr | float) -> Expr:
        return add(self, wrap(other))

    def __radd__(self, other: float) -> Expr:
        return add(wrap(other), self)

    def __sub__(self, other: Expr | float) -> Expr:
        return sub(self, wrap(other))

    def __rsub__(self, other: float) -> Expr:
        return sub(wrap(other), self)

    def __mul__(self, other: Expr | float) -> Expr:
        return mul(self, wrap(other))

    def __rmul__(self, other: float) -> Expr:
        return mul(wrap(other), self)

    def __truediv__(self, other: Expr | float) -> Expr:
        return div(self, wrap(other))

    def __rtruediv__(self, other: float) -> Expr:
        return div(wrap(other), self)

    def __neg__(self) -> Expr:
        return neg(self)


_interned: Interned[Expr] = Interned()
_bits: dict[Any, int] = {}  # free variable -> its bit

# ops that read other tables: phi (value: child scopes; args: one per child, then the default), reduce (value: (kind, child)),
# element (value: child; args: expression, rank), previous (value: scope; args: expression, first), scan (exclusive sum before a row)
CROSSING = frozenset({"phi", "reduce", "element", "previous", "scan"})


_find = _interned.find


def _make(op: str, args: tuple[Expr, ...] = (), value: object = None, scope: Scope | None = None) -> Expr:
    key = (op, args) if value is None else (op, args, value if isinstance(value, tuple) else (type(value), value))
    return _find(key) or _new(key, op, args, value, scope)


def _new(key: Hashable, op: str, args: tuple[Expr, ...], value: object, scope: Scope | None) -> Expr:
    made = Expr()
    made.op, made.args, made.value, made.scope = op, args, value, scope
    reads = 1 << _bits.setdefault(value, len(_bits)) if op == "var" else 0
    for arg in args:
        reads |= arg.reads
    made.reads = reads
    _interned.keep(key, made)
    return made


def raw(op: str, args: tuple[Expr, ...] = (), value: object = None, scope: Scope | None = None) -> Expr:
    """A node just as it is, without folding (for reading a program back); the scope follows from the arguments."""
    return _make(op, args, value, scope if scope is not None else deepest(args))


def operation(op: str, args: tuple[Expr, ...]) -> Expr:
    """An operation of ``FUNCTIONS``, just as it is: what nearly all nodes of a program are."""
    key = op, args
    found = _find(key)
    if found is None:
        found = _new(key, op, args, None, deepest(args))
    return found


def deepest(args: Iterable[Expr]) -> Scope | None:
    """The scope in which an operation on ``args`` lives; they must lie on one chain of ancestors."""
    best: Scope | None = None
    for arg in args:
        if arg.scope is None or arg.scope is best:
            continue
        if best is None or arg.scope.within(best):
            best = arg.scope
        elif not best.within(arg.scope):
            raise ScopeError(best, arg.scope)
    return best


def truth(a: Expr) -> bool:
    """Whether a value is true or false rather than a number."""
    if a.op in ("where", "phi"):
        return all(map(truth, a.args[a.op == "where" :]))
    if a.op in ("element", "previous"):
        return truth(a.args[0])
    if a.op == "col":
        return bool(a.value.kind == "bool")
    return a.op in PREDICATES or isinstance(a.value, bool) or a.op == "reduce" and a.value[0] in ("any", "all")


def const(value: float | bool) -> Expr:
    if not isinstance(value, bool):
        value = float(value)
        if value == 0.0:
            value = 0.0  # one zero: -0.0 would be a second constant of the same value
        elif value != value:
            value = math.nan  # one nan, which equals itself by being the same object
    return _make("const", value=value)


ZERO, ONE, TRUE, FALSE = const(0.0), const(1.0), const(True), const(False)
_MINUS = const(-1.0)


def wrap(value: Expr | float) -> Expr:
    return value if isinstance(value, Expr) else const(value)


def col(column: Column) -> Expr:
    return _make("col", value=column, scope=column.scope)


def var(name: str) -> Expr:
    """A free variable of a formula (``u``, ``v``, ``p.x``, a parameter of a primitive)."""
    return _make("var", value=name)


def rank(scope: Scope) -> Expr:
    """The rank of a row of a repeat among its siblings, from 0."""
    return _make("rank", value=scope, scope=scope)


def call(op: str, *args: Expr) -> Expr:
    """An operation of ``FUNCTIONS``, folded when all its arguments are constants."""
    arity, function = FUNCTIONS[op]
    if len(args) != arity:
        raise ValueError(f"{op} takes {arity} arguments")
    for arg in args:
        if arg.op != "const":
            key = op, args
            return _find(key) or _new(key, op, args, None, deepest(args))
    value = fold_constants(function, [a.value for a in args])
    if op in ("sin", "cos") and math.isfinite(value) and abs(value - round(value)) < 1e-15:
        value = float(round(value))  # quarter turns are exact
    return const(value)


def add(a: Expr, b: Expr) -> Expr:
    if a is ZERO:
        return b
    if b is ZERO:
        return a
    if b.op == "neg":
        return sub(a, b.args[0])
    return call("add", a, b)


def sub(a: Expr, b: Expr) -> Expr:
    if b is ZERO:
        return a
    if a is ZERO:
        return neg(b)
    if a is b:
        return ZERO
    if b.op == "neg":
        return add(a, b.args[0])
    return call("sub", a, b)


def mul(a: Expr, b: Expr) -> Expr:
    if a is ZERO or b is ZERO:
        return ZERO
    if a is ONE:
        return b
    if b is ONE:
        return a
    if a is _MINUS:
        return neg(b)
    if b is _MINUS:
        return neg(a)
    if (a.op == "where" or b.op == "where") and _signed(a) and _signed(b):
        pair = [e for e in (a, b) if e.op == "where"]
        condition = pair[0].args[0]
        if condition is pair[-1].args[0]:
            (x, y), (v, w) = (e.args[1:] if e.op == "where" else (e, e) for e in (a, b))
            return where(condition, mul(x, v), mul(y, w))
    return call("mul", a, b)


def _signed(a: Expr) -> bool:
    """A constant, or one of two by a condition (the sign of a mirror's halves): products of those fold."""
    return a.op == "const" or a.op == "where" and a.args[1].op == "const" and a.args[2].op == "const"


def div(a: Expr, b: Expr) -> Expr:
    if a is ZERO:
        return ZERO
    if b is ONE:
        return a
    if b.op == "const" and b.value not in (0.0, True, False) and a.op != "const":
        return mul(a, const(1.0 / float(b.value)))
    return call("div", a, b)


def neg(a: Expr) -> Expr:
    if a.op == "where" and _signed(a):
        return where(a.args[0], neg(a.args[1]), neg(a.args[2]))
    return a.args[0] if a.op == "neg" else call("neg", a)


def power(a: Expr, b: Expr) -> Expr:
    if b.constant == 1.0:
        return a
    if b.constant == 2.0:
        return mul(a, a)
    return call("pow", a, b)


def both(a: Expr, b: Expr) -> Expr:
    if a is FALSE or b is FALSE:
        return FALSE
    if a is TRUE:
        return b
    if b is TRUE or a is b:
        return a
    return call("and", a, b)


def either(a: Expr, b: Expr) -> Expr:
    if a is TRUE or b is TRUE:
        return TRUE
    if a is FALSE:
        return b
    if b is FALSE or a is b:
        return a
    return call("or", a, b)


def negate(a: Expr) -> Expr:
    return a.args[0] if a.op == "not" else call("not", a)


def where(condition: Expr, a: Expr, b: Expr) -> Expr:
    if condition is TRUE or a is b:
        return a
    if condition is FALSE:
        return b
    return call("where", condition, a, b)


def total(values: Iterable[Expr]) -> Expr:
    return functools.reduce(add, values, ZERO)


def all_of(conditions: Iterable[Expr]) -> Expr:
    return functools.reduce(both, conditions, TRUE)


def any_of(conditions: Iterable[Expr]) -> Expr:
    return functools.reduce(either, conditions, FALSE)


def minimum(*args: Expr) -> Expr:
    best = args[0]
    for arg in args[1:]:
        best = best if best is arg else call("min", best, arg)
    return best


def maximum(*args: Expr) -> Expr:
    best = args[0]
    for arg in args[1:]:
        best = best if best is arg else call("max", best, arg)
    return best


def phi(parent: Scope, branches: Iterable[tuple[Scope, Expr]], default: Expr = ZERO) -> Expr:
    """In ``parent``, the value of whichever child has a row, else ``default`` (an expression of ``parent``).

    Branches are ``(child guard scope, expression in it)``, whose rows exclude one another; a scope further below is
    merged step by step.
    """
    branches = _nearest(parent, tuple(branches))
    if branches and all(value is branches[0][1] for _, value in branches):
        value = branches[0][1]
        if value.scope is None or parent.within(value.scope):
            if value is default or default is ZERO:
                return value
    return _make("phi", (*(v for _, v in branches), default), tuple(s for s, _ in branches), parent)


def _nearest(parent: Scope, branches: tuple[tuple[Scope, Expr], ...]) -> tuple[tuple[Scope, Expr], ...]:
    """Branches of children of ``parent`` out of branches of guard scopes anywhere below it."""
    if all(scope.parent is parent for scope, _ in branches):
        return branches
    groups: dict[Scope, list[tuple[Scope, Expr]]] = {}
    for scope, value in branches:
        child = next(s for s in scope.ancestors() if s.parent is parent)
        groups.setdefault(child, []).append((scope, value))
    merged = []
    for child, held in groups.items():
        own = next((value for scope, value in held if scope is child), ZERO)
        below = [(scope, value) for scope, value in held if scope is not child]
        merged.append((child, phi(child, below, own) if below else own))
    return tuple(merged)


def reduce(kind: str, child: Scope, value: Expr) -> Expr:
    """``sum``, ``min``, ``max``, ``any`` or ``all`` of the rows of ``child`` per row of its parent.

    Over no rows: 0, +inf, -inf, False, True.
    """
    return _make("reduce", (value,), (kind, child), child.parent)


def element(child: Scope, value: Expr, index: Expr) -> Expr:
    """The value of the row of ``child`` with rank ``index`` (an expression of the parent), for each row of its parent."""
    if child.parent is not None and index.scope is not None and not child.parent.within(index.scope):
        raise ScopeError(child, index.scope)
    return _make("element", (value, index), child, child.parent)


def previous(scope: Scope, value: Expr, first: Expr) -> Expr:
    """The value of the sibling before; ``first`` for rank 0."""
    return _make("previous", (value, first), scope, scope)


def scan(scope: Scope, value: Expr) -> Expr:
    """The sum of ``value`` over the siblings before a row."""
    return _make("scan", (value,), scope, scope)


def solve(residuals: Sequence[Expr], slopes: Sequence[Expr], knowns: Sequence[Expr], starts: Sequence[Expr]) -> Expr:
    """n equations solved together by Newton's method, of which ``root`` takes the unknowns.

    ``residuals`` (n) and ``slopes`` (n * n, their derivatives) are formulas over ``solve.x0`` ..., the unknowns, which
    begin at ``starts``, and ``solve.p0`` ..., the values ``knowns``.
    """
    return _make(
        "solve", (*residuals, *slopes, *knowns, *starts), (len(starts), len(knowns)), deepest((*knowns, *starts))
    )


def root(bundle: Expr, index: int) -> Expr:
    """One unknown of equations solved together."""
    return _make("root", (bundle,), (index,), bundle.scope)


# ---------------------------------------------------------------- walking


def nodes(root: Expr) -> Iterator[Expr]:
    """All nodes of an expression, each once."""
    seen: set[Expr] = set()
    stack = [root]
    while stack:
        node = stack.pop()
        if node not in seen:
            seen.add(node)
            yield node
            stack.extend(node.args)


def variables(exprs: Iterable[Expr]) -> set[str]:
    """Names of the variables that expressions read."""
    reads = 0
    for expr in exprs:
        reads |= expr.reads
    names = list(_bits)
    return {str(names[place]) for place in range(reads.bit_length()) if reads >> place & 1}


def leaves(root: Expr) -> set[Column]:
    """The columns an expression reads, those inside phi, reductions and elements too."""
    return {node.value for node in nodes(root) if node.op == "col"}
