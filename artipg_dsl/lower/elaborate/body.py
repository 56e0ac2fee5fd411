"""Bodies of categories and templates: declarations first, then the statements that place and attach, then the solving."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Scope
from ...semantics.symbols import Symbol, lineage, names_of
from ...source import Span
from ...syntax import ast
from ..expressions.context import Abort
from ..expressions.env import Env, Hinge, Thunk
from ..expressions.evaluate import Evaluator
from ..expressions.ports import Binding, PortArray, bound
from ..solids.curves import let
from ..solve.solve import settle
from ..values.faces import centred
from ..values.kinds import Ref, Value, reference
from . import connect
from .behind import said_inside
from .build import build_part
from .draws import draw_scalar
from .interface import own_parameter, parameters_of
from .looks import build_look
from .repeat import build_repeat
from .style import Style, build_style

if TYPE_CHECKING:
    from .part import Instance, Option


_WAITING = (ast.SlotDecl, ast.PortDecl, ast.JointDecl)  # what they declare is looked at when somebody names it


def _lower_body(instance: Instance, option: Option, scope: Scope, given: dict[str, Value]) -> Env:
    """The body of a template instance, elaborated and solved in its own environment."""
    part = instance.part
    context = part.context
    symbol = option.symbol
    env = Env(context, symbol.module, symbol, scope, part.path + ".", instance=instance)
    instance.env = env
    env.names.update(given)
    for owner, declaration, name in parameters_of(symbol):
        if name in given or declaration.keyword == "out":
            continue
        env.module = owner.module
        env.names[name] = instance.values[name] = own_parameter(env, declaration, name, part.style, option.code)
    env.module = symbol.module
    if part.style is not None:
        _share_counts(env, symbol, part.style, option.code)
    instance.values.update({k: v for k, v in given.items() if k not in instance.values})
    if instance.size is not None:
        env.box = centred(instance.size)
    lower_statements(env, tuple(s for s in symbol.body if not isinstance(s, ast.ParamDecl)))
    return env


def _share_counts(env: Env, symbol: Symbol, style: Style, option: int) -> None:
    """Counts of a template that a style stands for are drawn once, as its parameters are; those whose range follows from
    measures of the part are each part's own."""
    for statement in symbol.body:
        if isinstance(statement, ast.CountDecl) and statement.name not in env.names and _has_fixed_range(statement):

            def make(statement: ast.CountDecl = statement) -> E.Expr:
                shared = style.shared(option, statement.name, statement, None, env)
                assert shared is not None, "a range that is written out is that of all parts"
                return shared

            env.names[statement.name] = Thunk(make, statement.name_span)


def _has_fixed_range(statement: ast.CountDecl) -> bool:
    """Whether the range of a count is written out."""
    domain = statement.domain
    return all(isinstance(end, ast.NumberExpr) for end in (domain.low, domain.high))


def lower_statements(env: Env, body: tuple[ast.Stmt, ...]) -> None:
    _declare(env, body)
    connect.statements(env)
    settle(env)


# ---------------------------------------------------------------- declarations


def _declare(env: Env, body: tuple[ast.Stmt, ...]) -> None:
    """Register every name of a body, then lower the declarations in the order of the text."""
    body = said_inside(env, body)
    _announce(env, body)
    lower(env, body)


def _announce(env: Env, body: tuple[ast.Stmt, ...]) -> None:
    env.statements.extend(body)
    for statement in body:
        register(env, statement)


def lower(env: Env, body: tuple[ast.Stmt, ...]) -> None:
    for statement in body:
        with env.context.attempt(statement.span):
            if isinstance(statement, ast.WhenStmt):
                for branch, inner in enter_when(env, statement):
                    lower(branch, inner)
            elif not isinstance(statement, _WAITING):
                for name in names_of(statement):
                    env.lower(name)
    _bind_slots(env, body)


def register(env: Env, statement: ast.Stmt) -> None:
    """Give each declared name a thunk, unless it has a value (an argument) or a thunk already; other statements wait."""

    def thunk(name: str, span: Span, make: Callable[[], Value]) -> None:
        if name not in env.names:
            env.names[name] = Thunk(make, span)

    def taken(name: str, span: Span, make: Callable[[], Value]) -> None:
        """In a branch of ``when``, too, an argument stands for what is declared."""
        handed = env.depth == 0 and env.instance is not None and name in env.instance.values
        thunk(name, span, partial(env.root.force, name) if handed else make)

    match statement:
        case ast.ParamDecl():
            for name, span in zip(statement.names, statement.name_spans, strict=True):
                taken(name, span, partial(own_parameter, env, statement, name))
        case ast.CountDecl():
            taken(statement.name, statement.name_span, lambda: draw_scalar(env, statement, env.path + statement.name))
        case ast.LetDecl() | ast.CurveDecl():
            env.names.setdefault(statement.name, let(env, statement))
        case ast.PartDecl():
            thunk(statement.name, statement.name_span, lambda: reference(build_part(env, statement, _lower_body)))
        case ast.StyleDecl() if statement.role == "material":
            thunk(statement.name, statement.name_span, lambda: build_look(env, statement))
        case ast.StyleDecl():
            thunk(statement.name, statement.name_span, lambda: build_style(env, statement))
        case ast.RepeatStmt():
            thunk(statement.name, statement.name_span, lambda: build_repeat(env, statement, _declare, register))
        case ast.JointDecl() if statement.kind is not None:
            env.names[statement.name] = Hinge(env, statement)
        case ast.PortDecl() if statement.value is not None:
            _register_port(env, statement)
        case _:
            pass


def _register_port(env: Env, statement: ast.PortDecl) -> None:

    def make() -> Value:
        found = bound(env, statement)
        if isinstance(found, Ref):
            found = Evaluator(env).ref_box(found)
        return found

    if statement.index is None:
        env.names[statement.name] = Thunk(make, statement.name_span)
        return
    array = env.root.names.setdefault(statement.name, PortArray(statement.name, {}))
    assert isinstance(array, PortArray)
    array.pending.append(Binding(env, statement.index, statement))
    array.size = array.size or _port_count(env, statement.name)


def _port_count(env: Env, name: str) -> int:
    """How many ports ``port name[n]`` of the template or its role promises; 0 where neither says."""
    for owner in lineage(env.symbol) if env.symbol is not None else ():
        for statement in owner.body:
            if (
                isinstance(statement, ast.PortDecl)
                and statement.name == name
                and statement.value is None
                and statement.index
            ):
                return int(Evaluator(env).scalar(statement.index).constant or 0.0)
    return 0


def enter_when(env: Env, statement: ast.WhenStmt) -> list[tuple[Env, tuple[ast.Stmt, ...]]]:
    """The branches of a ``when``, tables of the rows for which the guard holds, one per guard: names and statements are known."""
    if statement not in env.entered:
        found = env.entered[statement] = []  # a guard that asks for what stands under it finds nothing
        ev = Evaluator(env)
        env.deciding.append(statement)
        try:
            condition = ev.condition(statement.guard)
        except Abort:
            del env.entered[statement]
            raise
        finally:
            env.deciding.remove(statement)
        for guard, body in ((condition, statement.body), (E.negate(condition), statement.otherwise)):
            if not body or guard is E.FALSE:
                continue
            branch = env.branches.get(guard)
            if branch is None:
                scope = env.context.guard(env.scope, guard, f"{env.path}when {E.show(guard)}")
                branch = env.branches[guard] = env.nested(scope, env.path)
            _announce(branch, body)
            found.append((branch, body))
    return env.entered[statement]


def _bind_slots(env: Env, body: tuple[ast.Stmt, ...]) -> None:
    """Slots of the instance: what ``slot x = ...`` lists; otherwise a part of the slot's name binds itself."""
    instance = env.instance
    if instance is None:
        return
    for statement in body:
        if isinstance(statement, ast.SlotDecl) and statement.targets:
            instance.bindings.setdefault(statement.name, []).append((env, statement))
