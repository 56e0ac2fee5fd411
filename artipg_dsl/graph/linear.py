"""Linear forms of expressions in chosen columns, and solving for a single occurrence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

from . import expr as E
from .expr import ONE, ZERO, Column, Expr, Scope

LinearForm = tuple[dict[Column, Expr], Expr]  # coefficient of each column, and the rest
Parts = tuple[dict[Any, Expr], Expr]  # the same with atoms beside the columns


_PARTIAL = frozenset({"div", "pow", "sqrt", "log", "asin", "acos", "tan", "mod"})


class Circle(Exception):
    """Definitions that lead back to where they began; ``columns`` are those on the way."""

    def __init__(self, columns: list[Column]):
        super().__init__(" -> ".join(c.name for c in (*columns, columns[0])))
        self.columns = columns


def follow(column: Column, running: dict[Column, None]) -> None:
    """Note that the definition of a column is being followed, inside those that are ``running``. Raises Circle if it is one of them."""
    if column in running:
        way = list(running)
        raise Circle(way[way.index(column) :])
    running[column] = None


class Linear:
    """Linear forms in the columns for which ``unknown`` holds, reading defined columns through ``definitions``.

    What stands in the row before counts as known, unless ``through`` is set: a recurrence is not an equation in itself. With
    ``whole``, what may have no value outside its branch stays in it.
    """

    def __init__(
        self,
        unknown: Callable[[Column], bool],
        definitions: Mapping[Column, Expr],
        *,
        through: bool = False,
        whole: bool = False,
    ):
        self.unknown, self.definitions, self.through, self.whole = unknown, definitions, through, whole
        self.memo: dict[Expr, Parts] = {}
        self.partial: dict[Expr, bool] = {}
        self.reads_memo: dict[Expr, bool] = {}
        self.running: dict[Column, None] = {}  # definitions that are being followed, outermost first

    def reads(self, node: Expr) -> bool:
        """Whether the expression depends on an unknown at all. Raises Circle."""
        known = self.reads_memo.get(node)
        if known is None:
            if node.op == "col":
                column: Column = node.value
                definition = self.definitions.get(column)
                known = self.unknown(column)
                if not known and definition is not None:
                    follow(column, self.running)
                    known = self.reads(definition)
                    del self.running[column]
            elif node.op == "previous" and not self.through:
                known = False
            else:
                known = False
                for a in node.args:  # most of them have been asked about: no call for those
                    found = self.reads_memo.get(a)
                    if self.reads(a) if found is None else found:
                        known = True
                        break
            self.reads_memo[node] = known
        return known

    def columns(self, node: Expr) -> set[Column]:
        """The unknowns on which an expression depends."""
        found: set[Column] = set()
        stack = [node]
        seen: set[Expr] = set()
        while stack:
            at = stack.pop()
            if at in seen or not self.reads(at):
                continue
            seen.add(at)
            if at.op == "col":
                column: Column = at.value
                if self.unknown(column):
                    found.add(column)
                else:
                    stack.append(self.definitions[column])
            else:
                stack.extend(at.args)
        return found

    def form(self, node: Expr) -> LinearForm | None:
        """Coefficients and rest, or None where the expression is not linear in the unknowns."""
        found = self.parts(node)
        if any(isinstance(key, Expr) for key in found[0]):
            return None
        return found

    def parts(self, node: Expr) -> Parts:
        """A sum of coefficients times columns or *atoms* (what is not linear, kept whole so that it can cancel)."""
        if not self.reads(node):
            return {}, node
        found = self.memo.get(node)
        if found is None:
            found = self.memo[node] = self._parts(node)
        return found

    def _parts(self, node: Expr) -> Parts:
        if node.op == "col":
            column: Column = node.value
            return ({column: ONE}, ZERO) if self.unknown(column) else self.parts(self.definitions[column])
        if node.op in ("add", "sub"):
            left, right = self.parts(node.args[0]), self.parts(node.args[1])
            return combine(left, right, ONE if node.op == "add" else E.const(-1.0))
        if node.op == "neg":
            return _scaled(self.parts(node.args[0]), E.const(-1.0))
        if node.op == "mul":
            a, b = node.args
            if not (self.reads(a) and self.reads(b)):
                return _scaled(self.parts(a if self.reads(a) else b), b if self.reads(a) else a)
        if node.op == "div" and not self.reads(node.args[1]):
            return _scaled(self.parts(node.args[0]), E.div(ONE, node.args[1]))
        if node.op == "where" and not self.reads(node.args[0]):
            return self.branches(node.args[1:], lambda values: E.where(node.args[0], *values))
        if node.op == "phi":
            scopes, parent = node.value, node.scope
            assert parent is not None
            return self.branches(
                node.args,
                lambda values: E.phi(parent, zip(scopes, values[:-1], strict=True), values[-1]),
                parent=parent,
            )
        return {node: ONE}, ZERO

    def undefined(self, key: Column | Expr) -> bool:
        """Whether a term may have no value where its factor is 0: a quotient, a root, ... of what other rows know."""
        if not isinstance(key, Expr):
            return False
        known = self.partial.get(key)
        if known is None:
            known = self.partial[key] = key.op in _PARTIAL or any(self.undefined(a) for a in key.args)
        return known

    def branches(self, args: tuple[Expr, ...], make: Callable[..., Any], *, parent: Scope | None = None) -> Parts:
        """The forms of alternatives as one. With ``parent`` the args are those of a phi: what lives in a child table
        stays inside, since only columns of ``parent``'s chain can stand beside it, and its default is free."""
        forms = [self.parts(a) for a in args]
        if parent is not None:
            forms = [_kept_inside(form, parent) for form in forms]
        names = dict.fromkeys(c for f in forms for c in f[0])
        real = forms[:-1] if parent is not None else forms
        coefficients: dict[Column | Expr, Expr] = {}
        for name in names:
            values = [f[0].get(name, ZERO) for f in forms]
            shared = {f[0].get(name, ZERO) for f in real}
            single = shared.pop() if len(shared) == 1 else None
            if single is not None and (parent is None or parent.within(single.scope)):
                coefficients[name] = single
            elif self.whole and self.undefined(name):
                forms = [_move_to_rest(form, name) for form in forms]
            else:
                coefficients[name] = make(values)
        return coefficients, make([f[1] for f in forms])


def _move_to_rest(form: Parts, key: Any) -> Parts:
    """A form in which a term belongs to the rest."""
    left, rest = dict(form[0]), form[1]
    factor = left.pop(key, ZERO)
    return left, E.add(rest, E.mul(factor, key if isinstance(key, Expr) else E.col(key)))


def _kept_inside(form: Parts, parent: Scope) -> Parts:
    """A form in which only what ``parent``'s rows know stands as a term; the others belong to the rest."""
    coefficients: dict[Column | Expr, Expr] = {}
    rest = form[1]
    for key, factor in form[0].items():
        if parent.within(key.scope):
            coefficients[key] = factor
        else:
            rest = E.add(rest, E.mul(factor, key if isinstance(key, Expr) else E.col(key)))
    return coefficients, rest


_everything = Linear(lambda c: True, {}, whole=True)  # sums of boxes have terms in common: what is known of them stays
_SEEN = 50_000  # expressions, which are held meanwhile


@lru_cache(maxsize=2048)  # three of four have just been asked for: a box has one centre for all who ask
def tidy(node: Expr) -> Expr:
    """The same value as a sum in which equal terms are gathered and opposite ones are gone."""
    if len(_everything.reads_memo) > _SEEN:
        _everything.memo.clear()
        _everything.reads_memo.clear()
        _everything.partial.clear()
    terms, rest = _everything.parts(node)
    total = rest
    for key, factor in terms.items():
        item = key if isinstance(key, Expr) else E.col(key)
        if factor.constant == -1.0:
            total = E.sub(total, item)
        else:
            total = E.add(total, E.mul(factor, item)) if total is not ZERO else E.mul(factor, item)
    return total


def combine(a: Parts, b: Parts, factor: Expr) -> Parts:
    """a + factor * b, without the coefficients that cancel."""
    coefficients = dict(a[0])
    for column, value in b[0].items():
        total = E.add(coefficients.get(column, ZERO), E.mul(factor, value))
        if total is ZERO:
            coefficients.pop(column, None)
        else:
            coefficients[column] = total
    return coefficients, E.add(a[1], E.mul(factor, b[1]))


def _scaled(form: Parts, factor: Expr) -> Parts:
    return {c: E.mul(v, factor) for c, v in form[0].items()}, E.mul(form[1], factor)


_INVERSES: dict[str, Callable[[Expr], Expr]] = {
    "neg": E.neg,
    "sqrt": lambda v: E.mul(v, v),
    "asin": lambda v: E.call("sin", v),
    "exp": lambda v: E.call("log", v),
    "log": lambda v: E.call("exp", v),
}
_EVEN = (2.0, 4.0, 6.0, 8.0)
_PRINCIPAL: dict[str, Callable[[Expr], Expr]] = {
    "abs": lambda v: v,  # lengths: the positive root
    "sin": lambda v: E.call("asin", v),
    "cos": lambda v: E.call("acos", v),
    "tan": lambda v: E.call("atan", v),
}


def isolate(node: Expr, target: Column, value: Expr, linear: Linear) -> Expr | None:
    """Solve ``node = value`` for a column that stands in it once; the principal root where there are several."""
    found = roots(node, target, value, linear, lambda *given: [given[-1]])
    return None if found is None else found[0]


def roots(
    node: Expr, target: Column, value: Expr, linear: Linear, others: Callable[[str, Expr, Expr, Expr], list[Expr]]
) -> list[Expr] | None:
    """The roots of ``node = value`` for a column that stands in it once, None where they cannot be told.

    ``others(op, argument, value, root)``: of an operation that takes one value at several arguments, those to go on with, given
    the principal one. Where that is of an absolute value or of ``hypot``, the value may be negative, and there is none.
    """
    values = [value]
    while True:
        if node.op == "col":
            if node.value is target:
                return values
            definition = linear.definitions.get(node.value)
            if definition is None:
                return None
            node = definition
            continue
        inside = [k for k, a in enumerate(node.args) if linear.reads(a)]
        if len(inside) != 1:
            if node.op == "mul" and node.args[0] is node.args[1]:
                values = [root for v in values for root in others("mul", node.args[0], v, E.call("sqrt", v))]
                node = node.args[0]
                continue
            return None
        k = inside[0]
        inverse = _inverse(node, k)
        if inverse is None:
            return None
        if node.op in _PRINCIPAL or node.op == "hypot" or node.op == "pow" and node.args[1].constant in _EVEN:
            values = [root for v in values for root in others(node.op, node.args[k], v, inverse(v))]
        else:
            values = [inverse(v) for v in values]
        node = node.args[k]


def _inverse(node: Expr, k: int) -> Callable[[Expr], Expr] | None:
    """What gives the argument ``k`` of an operation for its value, None where nothing does."""
    if node.op in _INVERSES or node.op in _PRINCIPAL:
        return _INVERSES.get(node.op) or _PRINCIPAL[node.op]
    if len(node.args) != 2:
        return None
    other = node.args[1 - k]
    match node.op:
        case "add":
            return lambda v: E.sub(v, other)
        case "sub":
            return (lambda v: E.add(v, other)) if k == 0 else (lambda v: E.sub(other, v))
        case "mul":
            return lambda v: E.div(v, other)
        case "div":
            return (lambda v: E.mul(v, other)) if k == 0 else (lambda v: E.div(other, v))
        case "hypot":
            return lambda v: E.call("sqrt", E.sub(E.mul(v, v), E.mul(other, other)))
        case "pow" if k == 0:
            return lambda v: E.call("pow", v, E.div(ONE, other))
    return None


def solve_block(forms: list[LinearForm], columns: list[Column]) -> dict[Column, Expr] | None:
    """Gauss elimination of ``form = 0`` for as many columns; pivots are constants where there are any."""
    rows = [(dict(c), rest) for c, rest in forms]
    order: list[tuple[Column, dict[Column, Expr], Expr]] = []
    left = list(columns)
    while left:
        best = None
        for r, (coefficients, _) in enumerate(rows):
            for column in left:
                value = coefficients.get(column)
                if value is not None and value is not ZERO:
                    quality = (value.op != "const", len(coefficients))
                    if best is None or quality < best[0]:
                        best = (quality, r, column)
        if best is None:
            return None
        _, r, column = best
        coefficients, rest = rows.pop(r)
        pivot = coefficients.pop(column)
        factor = E.div(E.const(-1.0), pivot)
        solved = _scaled((coefficients, rest), factor)  # column = solved
        next_rows = []
        for other, other_rest in rows:
            value = other.pop(column, None)
            next_rows.append((other, other_rest) if value is None else combine((other, other_rest), solved, value))
        rows = next_rows
        order.append((column, solved[0], solved[1]))
        left.remove(column)
    result: dict[Column, Expr] = {}
    for column, coefficients, rest in reversed(order):
        total = rest
        for known, share in coefficients.items():
            total = E.add(total, E.mul(share, result.get(known, E.col(known))))
        result[column] = total
    return result
