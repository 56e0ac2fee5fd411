"""Paths of statements about parts: through every repeat and slot on the way, or through one element by its number."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ...graph import expr as E
from ...graph.expr import Expr
from ...language import JOINTS
from ...semantics.meanings import Current, Declared, Inner, Previous
from ...semantics.types import ANGLE, LENGTH
from ...syntax import ast
from ..expressions.context import Fetched
from ..expressions.env import Element, Env, Hinge
from ..expressions.evaluate import Evaluator
from ..expressions.members import At
from ..values.kinds import Ref, Surface, Value
from ..values.vectors import HERE

if TYPE_CHECKING:
    from .links import Links
    from .part import Instance


class Reached(NamedTuple):
    """What a path leads to, the environment it lives in, and for which elements of repeats the path means it."""

    value: Value
    home: Env
    named: Expr = E.TRUE


def walk(env: Env, node: ast.Expr) -> list[Reached]:
    """Values of a path through every repeat it names, each in its own environment; an index says of which element."""
    meaning = env.context.meaning(node)
    if isinstance(node, ast.NameExpr):
        at: Env | None = env if isinstance(meaning, Declared) else None
        while at is not None:  # each branch of a `when` that declares the name, on its own
            if node.name not in at.names and (branched := at.branched(node.name)):
                return [Reached(value, branch) for branch, value in branched]
            if node.name not in at.names and at.foregoes(node.name):
                return []
            at = at.outer if node.name not in at.names else None
        value = Evaluator(env).meant(meaning) if isinstance(meaning, Declared | Current | Previous) else None
        if isinstance(value, At):
            value = value.element
        if value is not None:
            return [Reached(value, env)]
        raise env.context.internal(node.span, f"`{node.name}` has no value here")
    if isinstance(node, ast.IndexExpr):
        return [at._replace(named=E.both(at.named, _element_named(env, at, node))) for at in walk(env, node.obj)]
    if not isinstance(node, ast.MemberExpr) or not isinstance(meaning, Inner):
        raise env.context.internal(node.span, "this is not a path of declared names")
    found: list[Reached] = []
    for value, _, named in walk(env, node.obj):
        match value:
            case Element(env=home) if meaning.name in home.names:
                found.append(Reached(home.force(meaning.name), home, named))
            case Element(env=home):
                found.extend(Reached(v, branch, named) for branch, v in home.branched(meaning.name))
            case Ref():
                found.extend(r._replace(named=E.both(named, r.named)) for r in _inner_values(value, meaning))
    if not found:
        raise env.context.error(
            "unknown-member",
            node.name_span,
            f"nothing here has `{node.name}`",
            hint=f"bind `{node.name}` in an alternative, or leave this statement out",
        )
    return found


def _element_named(env: Env, at: Reached, node: ast.IndexExpr) -> Expr:
    """Whether a row of a repeat is the element that an index names."""
    element = at.value
    if not isinstance(element, Element):
        raise Evaluator(env).impossible(node.obj.span, "a repeat", element)
    index = Evaluator(env).position(element, node.index)
    if index.scope is not None and not element.scope.within(index.scope):
        raise env.context.error(
            "wrong-kind",
            node.index.span,
            "this index varies over instances that the elements do not belong to",
            hint="use a number, `last` or a count as index, or put the statement inside the repeat, under a `when`",
        )
    env.context.named.append(Fetched(env.scope, index, element.count, node.span, env.context.known))
    return E.call("eq", E.rank(element.scope), index)


def elements_named(env: Env, node: ast.Expr) -> Expr:
    """Whether a row of the repeats that a path runs through is of the elements that its indices name."""
    found = E.TRUE
    while isinstance(node, ast.MemberExpr | ast.IndexExpr):
        if isinstance(node, ast.IndexExpr):
            for reached in walk(env, node.obj):
                found = E.both(found, _element_named(env, reached, node))
        node = node.obj
    return found


def _inner_values(ref: Ref, meaning: Inner) -> list[Reached]:
    """A member of every alternative that has it and may be there."""
    found: list[Reached] = []
    name = meaning.name
    for branch in ref.branches:
        for part, _ in branch.members:
            for instance in part.instances:
                if instance.symbol in meaning.without:
                    continue
                if name in instance.bindings:
                    found.extend(instance.bound(name))
                    continue
                found.extend(_own_members(instance, name))
    return found


def _own_members(instance: Instance, name: str) -> list[Reached]:
    """What an instance declares under a name: one value, one in each branch that does, or what its repeats declare."""
    if instance.solid is not None:
        has = name in instance.solid.primitive.surfaces
        return [Reached(Surface(((None, instance.part, HERE, name),)), instance.part.env)] if has else []
    env = instance.env
    assert env is not None
    if name in env.names:
        return [Reached(env.force(name), env)]
    return [Reached(value, env) for _, value in env.branched(name)] or _in_repeats(env, name)


def _in_repeats(env: Env, name: str) -> list[Reached]:
    """What repeats of a body declare: a part or a joint in one binds the slot or the joint of its name."""
    found: list[Reached] = []
    for inner in env.inner:
        has = inner.depth > env.depth and name in inner.names
        found += [Reached(inner.force(name), inner)] if has else _in_repeats(inner, name)
    return found


def joints(links: Links, env: Env, node: ast.Expr) -> list[int]:
    """The joints that a path names, by their numbers: one, or those of several alternatives and branches. Of a role only here the
    kind is known, and whether its values are what they are taken for."""
    hinges = (reached.value for reached in walk(env, node))
    found = sorted(links.made[hinge] for hinge in hinges if isinstance(hinge, Hinge) and hinge in links.made)
    wanted = env.context.typed.checker.measured.get(id(node))
    for joint in (links.context.program.joints[k] for k in found) if wanted is not None else ():
        given = LENGTH if JOINTS[joint.kind].slides else ANGLE
        if given != wanted:
            raise env.context.error(
                "wrong-dimension",
                node.span,
                f"the joint `{joint.path}` is {joint.kind}, so its value is {given}, but it is taken for {wanted} here",
                hint="put this under `when PART is TEMPLATE { }`, which leaves joints of one kind",
            )
    return found
