"""Parts built from their declarations: the choice, the inputs, one instance for each alternative."""

from __future__ import annotations

from collections.abc import Callable

from ...graph import expr as E
from ...graph.expr import Scope
from ...semantics.meanings import Declared, Global, Word
from ...semantics.symbols import Symbol
from ...semantics.types import DIMENSIONS
from ...syntax import ast
from ...syntax.walk import walk
from ..expressions.arithmetic import condition_of, number
from ..expressions.context import Present
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..solids.primitives import lower_primitive
from ..values.kinds import Choice, Frame, Plane, Value
from .draws import draw_choice, open_parameter
from .handed import note
from .interface import own_parameter, parameters_of, within
from .looks import look_of
from .part import Component, Instance, Option
from .place import pose_of
from .style import Style, complete_choice, sole_style, templates_of

LowerBody = Callable[[Instance, Option, Scope, dict[str, Value]], Env]  # of a template: ``body.lower_body``


def build_part(env: Env, declaration: ast.PartDecl, lower_body: LowerBody) -> Component:
    """Lower the declaration of a part: its choice, its inputs, its instances; registers its unknowns."""
    context = env.context
    part = Component(context, env, declaration.name, env.path + declaration.name, declaration, pose_of)
    env.parts.append(part)
    context.parts.append(part)
    alternatives, arguments = declaration.alternatives, declaration.arguments
    if (
        declaration.role is None
        and len(alternatives) == 1
        and isinstance(style := _named_style(env, alternatives[0]), Style)
    ):
        arguments, guard = alternatives[0].arguments, alternatives[0].guard
        part.style, part.role, alternatives = style, style.role, style.alternatives
        if guard is not None:
            part.exists = Evaluator(env).condition(guard)
    elif declaration.role is not None:
        part.role = context.symbol(declaration)
    if part.style is None:
        alternatives = complete_choice(env, alternatives)
    templates = templates_of(env, alternatives) if part.style is None else part.style.templates
    part.options = [
        Option(a.name, templates[a.name], a, code) for code, a in enumerate(alternatives) if a.name is not None
    ]
    _make_choice(part, alternatives)
    if part.role is None and len(part.options) == 1:
        arguments = arguments + part.options[0].source.arguments
    interface = part.role if part.role is not None else part.options[0].symbol if len(part.options) == 1 else None
    if interface is not None:
        _make_inputs(part, interface, arguments)
    for option in part.options:
        part.instances.append(_instantiate(part, option, lower_body))
    return part


def _named_style(env: Env, alternative: ast.Alternative) -> Value | None:
    """The style that an alternative names; None where it names a template or a primitive."""
    meaning = env.context.meaning(alternative)
    return env.find(meaning.name, meaning.depth) if isinstance(meaning, Declared) else None


def _make_choice(part: Component, alternatives: tuple[ast.Alternative, ...]) -> None:
    if len(alternatives) == 1:
        return
    names = tuple(a.name or "none" for a in alternatives)
    if part.style is not None:
        part.choice = part.style.choice
    else:
        part.choice = draw_choice(part.env, part.path, names, [(a,) for a in alternatives], part.span, part.declaration)
    absent = [k for k, a in enumerate(alternatives) if a.name is None]
    for code in absent:
        part.exists = E.both(part.exists, E.negate(E.call("eq", part.choice.code, E.const(float(code)))))


def _make_inputs(part: Component, interface: Symbol, arguments: tuple[ast.Argument, ...]) -> None:
    """Values of the interface's parameters: the arguments, and open columns for what is not given."""
    env = part.env
    given = {a.name: a for a in arguments if a.name is not None}
    part.given = {name: argument.span for name, argument in given.items()}
    drawn_within = within(interface)
    for name, argument in given.items():
        if name in drawn_within:
            part.inputs[name] = _handed_in(part, env, drawn_within[name], name, argument)
            note(interface, env, part.inputs, drawn_within[name], argument, part.inputs[name])
    local = Env(env.context, interface.module, interface, env.scope, part.path + ".", names=dict())
    asked = parameters_of(interface)
    needless = set() if part.role is None else _said_by_all(part) - set(given)
    needless -= {
        node.name for _, declaration, _ in asked for node in walk(declaration) if isinstance(node, ast.NameExpr)
    }
    for symbol, declaration, name in asked:
        if declaration.keyword == "out" or name in needless:
            continue
        local.module = symbol.module
        stated = given.get(name)
        if stated is not None and not _has_hole(stated.value):
            value = _handed_in(part, env, declaration, name, stated)
            note(symbol, env, part.inputs, declaration, stated, value)
        elif declaration.type.name == "material" and declaration.default is not None:
            value = look_of(local, declaration.default)
        else:
            value = open_parameter(part, local, declaration, name, stated)
        part.inputs[name] = value
        local.names[name] = value
    part.more = tuple(argument for name, argument in given.items() if name not in part.inputs)


def _said_by_all(part: Component) -> set[str]:
    """The parameters that every alternative of a part gives itself."""
    said = [{a.name for a in option.source.arguments if a.name is not None} for option in part.options]
    return set.intersection(*said) if said else set()


def _has_hole(node: ast.Expr) -> bool:
    return isinstance(node, ast.VectorExpr) and any(isinstance(i, ast.HoleExpr) for i in node.items)


def _handed_in(
    part: Component, env: Env, declaration: ast.ParamDecl | ast.CountDecl, name: str, argument: ast.Argument
) -> Value:
    """The value of an argument, which is written in ``env``, for a parameter or a count: an option (``open = front``), a
    template as a style of its own (``pull = BarHandle``), a material, or whatever else it says."""
    node = argument.value
    if isinstance(declaration, ast.CountDecl):
        return Evaluator(env).scalar(node)
    if _has_hole(node):
        raise part.context.error(
            "misplaced-hole",
            node.span,
            f"no equation determines `{name}` here, so it cannot be left open",
            hint="give all of its components",
        )
    kind = declaration.type
    match env.context.meaning(node):
        case Word(text):
            return Choice(E.const(float(kind.values.index(text))), kind.values)
        case Global(symbol) if symbol.kind == "template":
            return sole_style(part.env, f"{part.name}.{name}", env.context.symbol(kind), symbol, node.span)
    if kind.name == "material":
        return look_of(env, node)
    if kind.values and isinstance(node, ast.IfExpr):
        return _either(part, env, declaration, name, node)
    value = Evaluator(env).value(node)
    if isinstance(value, Frame | Plane) and kind.size is None and kind.name in DIMENSIONS:
        return Evaluator(env).number(value, node.span)  # of a plane, the coordinate that it has here
    return value


def _either(part: Component, env: Env, declaration: ast.ParamDecl, name: str, node: ast.IfExpr) -> Value:
    """An option that a condition decides: ``open = front if wide else top``."""
    ev = Evaluator(env)
    condition = condition_of(ev, node)
    codes = []
    for branch in (node.then, node.otherwise):
        chosen = _handed_in(part, env, declaration, name, ast.Argument(span=branch.span, name=name, value=branch))
        codes.append(number(ev, chosen, branch.span))
    return Choice(E.where(condition, *codes), declaration.type.values)


def _instantiate(part: Component, option: Option, lower_body: LowerBody) -> Instance:
    """The alternative in its own table (that of the environment when there is nothing to choose)."""
    context = part.context
    guard = part.guard(option)
    scope = context.guard(part.env.scope, guard, f"{part.path}={option.name}", Present(part.path, option.name))
    instance = Instance(part, option.symbol, scope, part.path + ".")
    if len(context.trace) > 40 and option.symbol.kind == "template":
        raise context.error(
            "circular-definition",
            part.span,
            f"`{option.name}` contains itself",
            hint="end the chain: give the inner part another template, or a `when` that stops it",
        )
    context.trace.append((part.span, f"in `{part.path}` ({option.name})"))
    try:
        own, home = dict(part.inputs), part.env if part.style is None else part.style.env
        arguments = option.source.arguments if part.role is not None or len(part.options) > 1 else ()
        declared = {name: declaration for _, declaration, name in parameters_of(option.symbol)} | within(option.symbol)
        for argument in arguments:
            name = argument.name or ""
            if name in part.given:
                raise context.error(
                    "wrong-arguments",
                    argument.span,
                    f"`{name}` is given twice: by the alternative `{option.name}`, and by the part `{part.name}`",
                    hint="give it in one of the two places",
                    notes=((part.given[name], "by the part"),),
                )
            if _has_hole(argument.value):
                raise context.error(
                    "misplaced-hole",
                    argument.value.span,
                    f"`{option.name}` is one of several alternatives, so none of its sizes can be left open",
                    hint="to leave a size of all alternatives open, let the role pass it in: "
                    "`part lid : Lid(size = [_, _, 1cm]) = Flat | Domed`",
                )
            own[name] = _handed_in(part, home, declared[name], name, argument)
            note(option.symbol, part.env, own, declared[name], argument, own[name])
        for argument in part.more:
            name = argument.name or ""
            own[name] = _handed_in(part, part.env, declared[name], name, argument)
            note(option.symbol, part.env, own, declared[name], argument, own[name])
        instance.values = own
        if option.symbol.kind == "primitive":
            complete(instance)
            instance.solid = lower_primitive(context, option.symbol, own)
            instance.solid.require(instance)
        else:
            instance.env = lower_body(instance, option, scope, own)
    finally:
        context.trace.pop()
    return instance


def complete(instance: Instance) -> None:
    """Parameters of a primitive that one alternative among several leaves out: drawn, or their defaults."""
    part, symbol = instance.part, instance.symbol
    local = Env(part.context, symbol.module, symbol, instance.scope, instance.path, names=dict(instance.values))
    for _, declaration, name in parameters_of(symbol):
        if name in instance.values:
            continue
        if declaration.default is None and declaration.domain is None:
            raise part.context.error(
                "missing-argument",
                part.span,
                f"`{symbol.name}` needs `{name}`",
                hint=f"give it with the alternative: {symbol.name}({name} = ...)",
            )
        local.names[name] = instance.values[name] = own_parameter(local, declaration, name)
