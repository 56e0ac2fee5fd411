"""What the templates of a role bind to its slots: the counterparts by which one is carried over to another."""

from __future__ import annotations

from ...graph.expr import ScopeError
from ...graph.program import Slot
from ...semantics.symbols import members
from ...syntax import ast
from ..expressions.context import Abort
from ..expressions.env import Env
from ..values.kinds import Ref, Surface, Value
from .links import Links
from .part import Component, Instance


def slots(links: Links, env: Env) -> None:
    """Record the slots of all parts of an environment and of those inside."""
    for part in env.parts:
        names = [] if part.role is None else [s.name for s in members(part.role) if isinstance(s, ast.SlotDecl)]
        for instance in part.instances:
            for name in names:
                bound = tuple(sorted(numbers(links, instance, name)))
                if bound and len(part.instances) > 1:
                    links.context.program.slots.append(Slot(part.path, name, part.env.scope, bound))
            if instance.env is not None:
                slots(links, instance.env)
    for inner in env.inner:
        slots(links, inner)


def numbers(links: Links, instance: Instance, name: str) -> set[int]:
    """The part nodes that a slot binds in one template."""
    try:
        if name in instance.bindings:
            values = [reached.value for reached in instance.bound(name)]
        else:
            found = instance.member(name)
            values = [] if found is None else [found]
    except (Abort, ScopeError):  # reported where the slot is used
        return set()
    parts = {part for value in values for part in named(value)}
    return {node for instance, node in links.nodes.items() if instance.part in parts}


def named(value: Value) -> list[Component]:
    if isinstance(value, Ref):
        return [part for branch in value.branches for part, _ in branch.members]
    return [branch[1] for branch in value.branches] if isinstance(value, Surface) else []
