"""Attachments to links and joints, sites and the part tree, once every pose is known.

What carries a part is a reference (``graph.reference``): alternatives of a part and branches of ``when`` may bring links of
their own, and what lies on an element of a repeat rides on the link of that element.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import field, replace
from itertools import takewhile

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.program import Link, Part, Pose, Site
from ...graph.reference import Elsewhere, Onward, Reference, Under
from ...records import dataclass
from ...source import Span
from ...syntax import ast
from ..expressions.context import Draft, Present
from ..expressions.env import Env, Hinge, exists_in
from ..expressions.extents import union_of
from ..solve.cases import covered
from ..values.kinds import Carrier, InElement, part_of
from ..values.vectors import HERE, IDENTITY, compose
from .connect import Attachment
from .guards import is_alone
from .joints import build_joint
from .part import Component, Instance


@dataclass(slots=True, eq=False)
class Links:
    """Numbers of links, joints, part nodes and sites while they are made."""

    context: Draft
    worlds: dict[Env, Pose] = field(default_factory=dict)
    own: dict[Attachment, int] = field(default_factory=dict)  # link that a joint moves
    owners: dict[int, Component] = field(default_factory=dict)  # whose frame such a link takes
    known: dict[Component, Reference] = field(default_factory=dict)
    nodes: dict[Instance, int] = field(default_factory=dict)
    sites: dict[Component, list[int]] = field(default_factory=dict)
    joints: dict[int, int] = field(default_factory=dict)  # link -> its joint
    made: dict[Hinge, int] = field(default_factory=dict)  # joint as it is declared -> its number
    stated: dict[int, ast.JointDecl] = field(default_factory=dict)  # joint -> its statement
    mimics: dict[int, tuple[Env, ast.Expr]] = field(default_factory=dict)  # joint -> what it follows, as it is written
    gates: dict[int, tuple[Env, ast.Expr]] = field(default_factory=dict)  # joint -> what it waits for, as it is written
    resolving: set[Component] = field(default_factory=set)

    # ------------------------------------------------------------ poses in the object's frame

    def world(self, env: Env) -> Pose:
        """The pose of an environment's frame in the object."""
        found = self.worlds.get(env)
        if found is None:
            if env.outer is not None:
                found = compose(self.world(env.outer), env.frame) if env.frame is not HERE else self.world(env.outer)
            elif env.instance is not None:
                found = self.part_world(env.instance.part)
            else:  # the category: lifted so that the object stands on z = 0
                found = Pose(IDENTITY, (E.ZERO, E.ZERO, E.neg(union_of(env, env.scope).low[2])), E.ONE)
            self.worlds[env] = found
        return found

    def part_world(self, part: Component) -> Pose:
        outer = self.world(part.env)
        return compose(outer, part.pose) if outer is not HERE else part.pose

    # ------------------------------------------------------------ links

    def is_one(self, env: Env, references: Iterable[Reference]) -> bool:
        """Whether references are to one and the same link wherever a statement in ``env`` stands."""
        found = set(references)
        if len(found) != 1:
            return False
        (only,) = found
        return len(only) == 1 and isinstance(only[0], int) and is_alone(env, self.context.program.links[only[0]].scope)

    def attachments(self, part: Component) -> list[Attachment]:
        """How a part is attached: once, or once in each branch of a ``when``; joints first."""
        return sorted(part.attachments, key=lambda a: a.joint is None)

    def of(self, part: Component) -> Reference:
        """The link that carries a part."""
        if part in self.known:
            return self.known[part]
        if part in self.resolving:
            found = [(p, a) for p in self.resolving for a in self.attachments(p)]
            found.sort(key=lambda pair: pair[1].span.start)
            raise self.context.error(
                "circular-definition",
                part.span,
                f"`{part.name}` is attached to "
                + ("itself" if len(found) == 1 else f"a part that is attached to `{part.name}` itself"),
                hint="attach one of them to the root, or to a part that is attached to it",
                notes=tuple((a.span, f"attaches `{p.name}`") for p, a in found[:4]),
            )
        self.resolving.add(part)
        try:
            self.known[part] = self.find(part)
        finally:
            self.resolving.discard(part)
        return self.known[part]

    def find(self, part: Component) -> Reference:
        attachments = self.attachments(part)
        found: list[tuple[Scope, Reference]] = []
        onward: list[Scope] = []
        repeat = None
        for attachment in attachments:
            before = next((to for to in attachment.to if isinstance(to, InElement) and self.rides(to, part)), None)
            if attachment.joint is not None:
                links: Reference = (self.own_link(part, attachment),)
            elif attachment.base:
                links = self.base(part.env)
            elif before is not None:  # rigid on the element before
                repeat = before.repeat
                onward.append(attachment.env.scope)
                continue
            else:
                links = self.carried(attachment.to, attachment.span)
            found.append((attachment.env.scope, links))
        if not self.everywhere(part, attachments):
            owner = part.env.root.instance
            rest = [(part.env.scope, self.base(part.env))] if owner is None else self.first(owner, part)
            found.extend(rest)
        links = self.whichever(found)
        return links if repeat is None or self.outside(links, repeat) else (Onward(repeat, tuple(onward), links),)

    def rides(self, before: InElement, part: Component) -> bool:
        """Whether what lies in the element before is rigid on ``part`` there, through other parts or not."""
        at = before.part
        seen: set[Component] = set()
        while before.rank is None and not isinstance(at, InElement) and at not in seen:
            if at is part:
                return True
            seen.add(at)
            owner, attachments = at.env.root.instance, self.attachments(at)
            if len(attachments) == 1 and attachments[0].env.scope is at.env.scope and len(attachments[0].to) == 1:
                if attachments[0].joint is not None:
                    return False
                at = attachments[0].to[0]
            elif owner is not None and all(a.base and a.joint is None for a in attachments):
                first = [] if attachments else first_parts(owner)
                if len(first) > 1:
                    return False
                at = owner.part if first in ([], [at]) else first[0]
            else:
                return False
        return False

    def everywhere(self, part: Component, attachments: list[Attachment]) -> bool:
        """Whether one of the attachments of a part holds wherever it exists."""
        if any(a.env.scope is part.env.scope for a in attachments):
            return True
        if (
            not attachments or part.env.root.instance is None
        ):  # in a category each part is attached: it has been checked
            return bool(attachments)
        guards = [_condition(a.env.scope, part.env.scope) for a in attachments]
        return covered(guards, self.context.draws, part.exists)

    def whichever(self, found: list[tuple[Scope, Reference]]) -> Reference:
        """One reference out of those that hold in exclusive scopes, the last of them in all that is left."""
        if all(links == found[-1][1] for _, links in found):
            return found[-1][1] if found else ()
        made: list[int | Under | Elsewhere | Onward] = []
        for scope, links in found[:-1]:
            own = all(isinstance(k, int) and self.context.program.links[k].scope.within(scope) for k in links)
            made.extend(links if own else (Under(scope, links),))
        return tuple(dict.fromkeys((*made, *found[-1][1])))

    def outside(self, reference: Reference, repeat: Scope) -> bool:
        """Whether a reference comes to the same link in all elements of a repeat."""
        scopes = (self.context.program.links[k].scope if isinstance(k, int) else None for k in reference)
        return all(scope is not None and repeat.within(scope) and repeat is not scope for scope in scopes)

    def first(self, instance: Instance, below: Component | None = None) -> list[tuple[Scope, Reference]]:
        """The links of a template's first parts, those before ``below``, and where each counts; then that of its base, unless
        one of them exists everywhere."""
        if instance.env is None:
            return [(instance.scope, self.of(instance.part))]
        found: list[tuple[Scope, Reference]] = []
        guards: list[Expr] = []
        for part in takewhile(lambda part: part is not below, first_parts(instance)):
            found.append((self.there(part.env.scope, part), self.of(part)))
            guards.append(E.both(_condition(part.env.scope, instance.env.scope), part.exists))
            if covered(guards, self.context.draws):
                return found
        return [*found, (instance.env.scope, self.base(instance.env))]

    def base(self, env: Env) -> Reference:
        """What carries a template as a whole; the object's root link in a category."""
        owner = env.root.instance
        return (0,) if owner is None else self.of(owner.part)

    def there(self, scope: Scope, part: Component) -> Scope:
        """The rows of a table in which a part exists."""
        return self.context.guard(scope, part.exists, f"{part.path} exists", Present(part.path))

    def own_link(self, part: Component, attachment: Attachment) -> int:
        """The link of a part that a joint moves (made at the first question)."""
        if attachment not in self.own:
            program = self.context.program
            scope = attachment.env.scope
            if part.exists is not E.TRUE and not exists_in(attachment.env, part.exists):
                scope = self.there(scope, part)
            self.own[attachment] = len(program.links)
            self.owners[len(program.links)] = part
            program.links.append(Link(part.path, scope, -1))
        return self.own[attachment]

    def carried(self, parts: tuple[Carrier, ...], span: Span) -> Reference:
        """The link on which values of these parts lie; alternatives of one part give several."""
        found: list[Reference] = []
        for part in parts:
            links = self.carrier(part)
            if links not in found:
                found.append(links)
        if len(found) > 1 and not _exclusive(parts):
            raise self.context.error(
                "two-links",
                span,
                "this lies on two links: " + " and ".join(f"`{part_of(p).name}`" for p in parts[:2]),
                hint="joints may move them apart: name a face or a port of only one of them",
                notes=tuple((part_of(p).span, f"`{part_of(p).name}`") for p in parts[:2]),
            )
        return self.ordered(k for links in found for k in links)

    def ordered(self, links: Iterable[int | Under | Elsewhere | Onward]) -> Reference:
        """Links of several alternatives, those that exist seldom first: what carries one of them otherwise comes after all."""
        scopes = {k: self.context.program.links[k].scope if isinstance(k, int) else k.scope for k in links}
        return tuple(sorted(scopes, key=lambda k: -sum(1 for _ in scopes[k].ancestors())))

    def carrier(self, part: Carrier) -> Reference:
        """The link of a part's box and of ports that name no inner part: its first link."""
        if isinstance(part, InElement):
            links = self.carrier(part.part)
            return (
                links if self.outside(links, part.repeat) else (Elsewhere(part.scope, part.repeat, part.rank, links),)
            )
        found: list[int | Under | Elsewhere | Onward] = []
        for instance in part.instances:
            found.extend(self.whichever(self.first(instance)))
        return self.ordered(found) or self.of(part)

    # ------------------------------------------------------------ the tree

    def build(self, env: Env, parent: int) -> None:
        """Nodes, sites and joints of the parts of an environment, depth first in the order of the text."""
        for part in env.parts:
            with self.context.attempt(part.span):
                self.build_part(part, parent)
        for inner in env.inner:
            self.build(inner, parent)

    def build_part(self, part: Component, parent: int) -> None:
        program = self.context.program
        pose = self.part_world(part)
        links = self.of(part)
        for instance in part.instances:
            box = instance.box()
            number = len(program.parts)
            self.nodes[instance] = number
            carried = self.whichever(self.first(instance))
            program.parts.append(
                Part(
                    part.path, part.name, instance.scope, parent, instance.symbol.name, pose, box.low, box.high, carried
                )
            )
            if instance.solid is not None:
                self.sites.setdefault(part, []).append(len(program.sites))
                program.sites.append(
                    Site(
                        part.path,
                        instance.scope,
                        instance.solid.primitive.name,
                        instance.solid.scalars(instance),
                        pose,
                        links,
                        number,
                    )
                )
            elif instance.env is not None:
                self.build(instance.env, number)
        for attachment in self.attachments(part):
            if attachment.joint is not None:
                build_joint(self, part, attachment)

    def hold(self) -> None:
        """Note for every part which part carries it rigidly."""
        program = self.context.program
        numbers: dict[Component, list[int]] = {}

        def held(by: Carrier) -> Reference:
            if isinstance(by, InElement):
                inner = held(by.part)
                return (Elsewhere(by.scope, by.repeat, by.rank, inner),) if inner else ()
            return tuple(numbers.get(by, ()))

        for instance, number in self.nodes.items():
            numbers.setdefault(instance.part, []).append(number)
        for part, nodes in numbers.items():
            rigid = [a for a in self.attachments(part) if a.joint is None and not a.base]
            holders = dict.fromkeys(n for a in rigid for p in a.to if p is not part for n in held(p))
            for number in nodes if holders else ():
                program.parts[number] = replace(program.parts[number], holder=tuple(holders))


def first_parts(instance: Instance) -> list[Component]:
    """The parts of a template's body of which the first that exists is its first part; empty for a primitive.

    That is the first part of the text; one that a ``when`` declares counts where it exists, if it hangs on no part beside
    it. In a body all of whose parts are repeated it is the first of these.
    """
    if instance.env is None:
        return []
    parts, body = instance.parts(), instance.env
    found: list[Component] = []
    for part in sorted((p for p in parts if p.env.depth == body.depth), key=lambda p: p.span.start):
        if part.env is body or all(a.base for a in part.attachments):
            found.append(part)
        if part.env is body and part.exists is E.TRUE:
            break
    return found or parts[:1]


def _condition(scope: Scope, home: Scope) -> Expr:
    """The condition on which a row of ``home`` has one in a table of a ``when`` in it."""
    inside = (s for s in scope.ancestors() if s is not home and s.within(home))
    return E.all_of(s.count for s in inside if s.count is not None)


def _exclusive(parts: tuple[Carrier, ...]) -> bool:
    """Whether parts live in tables whose rows exclude one another (alternatives), or belong to one another."""
    if len({part_of(p).env.root.instance for p in parts}) > 1:
        return True
    scopes = {p.scope if isinstance(p, InElement) else p.env.scope for p in parts}
    return len(scopes) > 1
