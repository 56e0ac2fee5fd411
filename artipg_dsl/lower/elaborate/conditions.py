"""What objects have to fulfil: ``require``, ``prefer``, ``clear``; and what may touch: ``_allow``, ``free``."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

from ...graph import expr as E
from ...graph.depend import draws_behind
from ...graph.expr import Expr
from ...graph.program import Allowed, Clear, Preference, Stable
from ...source import Span
from ...syntax import ast
from ...syntax.walk import walk
from ..expressions.context import where
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from ..solids.primitives import comparison
from ..values.kinds import Choice, Ref, Value, part_of
from . import paths
from .absence import presence
from .connect import carriers
from .guards import is_alone
from .links import Links
from .part import Component
from .statements import Meanings


def require(links: Links, env: Env, statement: ast.RequireStmt) -> None:
    ev = Evaluator(env)
    if statement.condition is None:
        message = statement.message or ("it tips over when open" if statement.stable == "open" else "it tips over")
        env.context.program.stable.append(Stable(env.scope, statement.stable == "open", message, where(statement.span)))
        return
    for node in _conjuncts(_positive(statement.condition)):
        others, bounding = _disjuncts(node)
        condition, slack, strict = comparison(ev, bounding)
        guard = E.all_of((presence(env, node), *(E.negate(ev.condition(other)) for other in others)))
        message = statement.message or statement.span.words
        repair = () if statement.repair is None else giving(env, ev.value(statement.repair))
        number = env.context.require(
            env.scope, condition, statement.span, message, guard, slack, node.span.words, repair
        )
        if strict:
            env.context.strict.add(number)
        env.context.stated[number] = statement.span, env.scope.parent is None and not env.path


def giving(env: Env, value: Value) -> tuple[int, ...]:
    """The draws that a ``repair`` names: the value itself, a part's template, or what determines the value."""
    if isinstance(value, Ref):
        parts: list[Component] = [part for branch in value.branches for part, *_ in branch.members]
        codes = [part.choice.code for part in parts if part.choice is not None]
    else:
        codes = [value.code if isinstance(value, Choice) else value] if isinstance(value, Expr | Choice) else []
    drawn = {draw.column: number for number, draw in enumerate(env.context.program.draws)}
    own = [drawn[code.value] for code in codes if code.op == "col" and code.value in drawn]
    return tuple(own) or tuple(draws_behind(env.context.program, codes))


def prefer(links: Links, env: Env, statement: ast.PreferStmt) -> None:
    ev = Evaluator(env)
    weight = E.ONE if statement.weight is None else ev.scalar(statement.weight)
    if statement.weight is not None and weight.constant is not None and not 0.0 < float(weight.constant) < math.inf:
        raise env.context.error(
            "wrong-arguments",
            statement.weight.span,
            "the weight of a preference must be above 0",
            hint="to prefer the opposite, write the opposite condition",
        )
    condition, *_ = comparison(ev, _positive(statement.condition))
    guard = presence(env, statement.condition)
    if env.scope.parent is None and not env.path:
        env.context.preferred[len(env.context.program.preferences)] = statement.span
    env.context.program.preferences.append(
        Preference(env.scope, condition, guard, weight, where(statement.span), statement.condition.span.words)
    )


_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "and": "or", "or": "and"}


def _positive(node: ast.Expr, wanted: bool = True, said: Span | None = None) -> ast.Expr:
    """A condition, or (``wanted`` False) its opposite, without a `not` around inequalities: `not (a <= b)` is `a > b`. That narrows a
    draw, and where a side has no value, neither of the two holds. ``said``: the text of the `not` around it, which messages quote."""
    span = said or node.span
    if not any(isinstance(part, ast.BinaryExpr) and part.op in ("<", "<=", ">", ">=") for part in walk(node)):
        return node if wanted else ast.UnaryExpr(span=span, op="not", operand=node)
    match node:
        case ast.UnaryExpr(op="not", operand=operand):
            return _positive(operand, not wanted, span)
        case ast.BinaryExpr(op="and" | "or", left=left, right=right):
            op = node.op if wanted else _OPPOSITE[node.op]
            return replace(
                node, span=span, op=op, left=_positive(left, wanted, said), right=_positive(right, wanted, said)
            )
        case ast.BinaryExpr(op="<" | "<=" | ">" | ">=") if not wanted:
            return replace(node, span=span, op=_OPPOSITE[node.op])
    return node if wanted else ast.UnaryExpr(span=span, op="not", operand=node)


def _conjuncts(node: ast.Expr) -> list[ast.Expr]:
    """``a and b`` is two requirements."""
    if isinstance(node, ast.BinaryExpr) and node.op == "and":
        return _conjuncts(node.left) + _conjuncts(node.right)
    return [node]


def _disjuncts(node: ast.Expr) -> tuple[list[ast.Expr], ast.Expr]:
    """``a or b``: where ``a`` does not hold, ``b`` is required; ``b`` is the last inequality, which can narrow a draw."""
    found: list[ast.Expr] = []

    def flatten(e: ast.Expr) -> None:
        if isinstance(e, ast.BinaryExpr) and e.op == "or":
            flatten(e.left)
            flatten(e.right)
        else:
            found.append(e)

    flatten(node)
    ordered = [e for e in found if isinstance(e, ast.BinaryExpr) and e.op in ("<", "<=", ">", ">=")]
    if len(found) == 1 or not ordered:
        return [], node
    return [e for e in found if e is not ordered[-1]], ordered[-1]


def _allow(links: Links, env: Env, statement: ast.AllowStmt) -> None:
    sides = [statement.subject] if statement.other is None else [statement.subject, statement.other]
    first, second = (*(nodes(links, env, node) for node in sides), ())[:2]
    ranks = (*(tuple(indices(env, node)) for node in sides), ())[:2]
    if statement.other is not None:
        word = "free" if statement.kind == "free" else f"allow {statement.kind}"
        _refuse_one(links, env, statement.span, word, (first, second), ranks)
        if _is_one_link(links, env, (*first, *second)):
            raise env.context.error(
                "wrong-arguments",
                statement.span,
                f"`{statement.subject.span.words}` and `{statement.other.span.words}` move as one: they may overlap anyway",
                hint="drop this, or attach one of them by a joint",
            )
    links.context.program.allowed.append(
        Allowed(statement.kind, env.scope, first, second, statement.reason or "", ranks)
    )


def clear(links: Links, env: Env, statement: ast.ClearStmt) -> None:
    first, second = (nodes(links, env, node) for node in (statement.subject, statement.other))
    distance = Evaluator(env).scalar(statement.distance)
    ranks = tuple(tuple(indices(env, node)) for node in (statement.subject, statement.other))
    _refuse_one(links, env, statement.span, "clear", (first, second), ranks)
    links.context.program.clear.append(
        Clear(env.scope, first, second, distance, statement.span.words, ranks, where(statement.span), statement.all)
    )


def _refuse_one(
    links: Links,
    env: Env,
    span: Span,
    word: str,
    sides: tuple[tuple[int, ...], ...],
    ranks: tuple[tuple[tuple[str, int], ...], ...],
) -> None:
    """Refuse a statement about two parts of which both are the same one."""
    first, second = sides
    alone = all(is_alone(env, links.context.program.parts[node].scope) for node in first)
    if first == second and ranks[0] == ranks[1] and (alone or ranks[0]):
        hint = (
            "name the other part; of two elements of a repeat, write behind it `row[0].tray` and `row[1].tray`, "
            "or `row.tray` twice for any two"
        )
        raise env.context.error("wrong-arguments", span, f"`{word}` names the same part twice", hint=hint)


def _is_one_link(links: Links, env: Env, nodes: Iterable[int]) -> bool:
    """Whether parts lie on one link in every object."""
    return links.is_one(env, [links.context.program.parts[node].link for node in nodes])


def indices(env: Env, node: ast.Expr) -> Iterator[tuple[str, int]]:
    """The repeats of a path that have a number behind them: the names of their tables and that rank, -1 for `last`."""
    if isinstance(node, ast.MemberExpr | ast.IndexExpr):
        yield from indices(env, node.obj)
    if isinstance(node, ast.IndexExpr):
        name = node.obj.name if isinstance(node.obj, ast.NameExpr | ast.MemberExpr) else ""
        last = isinstance(node.index, ast.NameExpr) and node.index.name == "last"
        rank = -1 if last else Evaluator(env).scalar(node.index).constant
        if rank is None or rank < 0 and not last:
            raise env.context.error(
                "wrong-kind",
                node.index.span,
                "this statement can name an element of a repeat only by its number or `last`",
                hint=f"`{name}[0]`, `{name}[last]`; omit the number for all elements, or put the statement inside the repeat",
            )
        repeats = (at.value.scope.name for at in paths.walk(env, node.obj) if isinstance(at.value, Element))
        yield from ((repeat, int(rank)) for repeat in dict.fromkeys(repeats))


def nodes(links: Links, env: Env, node: ast.Expr) -> tuple[int, ...]:
    """The nodes of the part tree that a path of names means."""
    parts: set[Component] = set()
    for value, home, _ in paths.walk(env, node):
        parts.update(value.env.all_parts() if isinstance(value, Element) else map(part_of, carriers(value, home.scope)))
    if not parts:
        raise env.context.error(
            "wrong-kind",
            node.span,
            f"`{node.span.words}` is not a part",
            hint="name a part, an element of a repeat or a slot",
        )
    return tuple(sorted(number for instance, number in links.nodes.items() if instance.part in parts))


MEANINGS: Meanings = {ast.RequireStmt: require, ast.PreferStmt: prefer, ast.AllowStmt: _allow, ast.ClearStmt: clear}
