"""Labels, materials, grasps and keypoints: targets to sites, formulas into the frames of their targets."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from ...graph import expr as E
from ...graph.expr import Expr, Scope
from ...graph.primitive import pair, triple
from ...graph.program import Grasp, Keypoint, Label, Pose, Target
from ...records import dataclass
from ...semantics import types
from ...semantics.meanings import Current, Declared, Global
from ...syntax import ast
from ...syntax.walk import path_root
from ...syntax.walk import walk as nodes_in
from ..expressions.context import Draft, where
from ..expressions.env import Element, Env
from ..expressions.evaluate import Evaluator
from ..expressions.rows import has_row
from ..values.carry import moved
from ..values.faces import extent
from ..values.kinds import Box, Frame, Line, Look, Ref, Surface, Value, Vec, carriers_of
from ..values.vectors import compose, inverse, place, sole_axis, unit
from . import nowhere
from .drives import Drive
from .guards import shown
from .links import Links
from .looks import sole_look
from .overridden import Said, note
from .part import Component
from .paths import walk
from .statements import Meanings, attempt


@dataclass(slots=True, eq=False)
class Aim:
    """What a target path names: a part or surfaces of it, in the object's frame."""

    part: Component
    surfaces: tuple[str, ...]
    frame: Pose  # of the formula, in the object
    box: Box  # in that frame
    scope: Scope  # the table of one instance of the target
    depth: int
    there: Expr = E.TRUE  # where a slot that a `when` binds means it, and in which element of a repeat


def statements(links: Links, env: Env) -> None:
    """The labels and the like of a body in the order of its text, those inside parts first (so that outer ones may stand over
    them)."""
    homes = list(nested(env))
    for home in homes:
        for part in home.parts:
            for body in part.bodies:
                statements(links, body)
    said = [(home, statement) for home in homes for statement in home.statements]
    symmetries = [(home, s) for home, s in said if isinstance(s, ast.SymmetryStmt)]
    for home, symmetric in sorted(symmetries, key=lambda pair: _one_element(pair[1])):  # one element last: it says more
        attempt(links, home, symmetric, MEANINGS)
    for home, statement in sorted(said, key=lambda pair: pair[1].span.start):
        if not isinstance(statement, ast.SymmetryStmt):
            attempt(links, home, statement, MEANINGS)


def nested(env: Env) -> Iterator[Env]:
    """An environment, then its repeats and branches and what is in them."""
    yield env
    for inner in env.inner:
        yield from nested(inner)


# ---------------------------------------------------------------- targets


def _aims(links: Links, env: Env, node: ast.Expr) -> list[Aim]:
    """The things a target names; a path may run through repeats and slots."""
    found: list[Aim] = []
    slot = isinstance(env.context.typed.type_of(node), types.SlotType)
    for value, home, named in walk(env, node):
        reached = len(found)
        if isinstance(value, Surface):
            for _, part, _, name in value.branches:
                found.append(_aim_at(links, part, _slot_owner(part, home, env, slot) if slot else part, (name,)))
        elif isinstance(value, Ref):
            for branch in value.branches:
                found.extend(_aim_at(links, p, _slot_owner(p, home, env, slot), ()) for p, _ in branch.members)
        elif isinstance(value, Element):
            for part in value.env.all_parts():
                found.append(_aim_at(links, part, part, ()))
        else:
            raise Evaluator(env).impossible(node.span, "a part, a slot or a surface", value)
        for aim in found[reached:]:
            bound = has_row(home.scope, aim.scope) if home.root is not env.root else E.TRUE
            aim.there = E.both(bound, named)
    return found


def _slot_owner(part: Component, home: Env, env: Env, slot: bool) -> Component:
    """Whose axes a formula has: those of the instance whose role declares the slot, for a part reached through one; its own for
    a part that is named itself, whatever slots are bound beside it."""
    instance = home.root.instance
    if instance is None or home.root is env.root:
        return part
    names = (
        {s.name for s in instance.part.role.body if isinstance(s, ast.SlotDecl)}
        if instance.part.role is not None
        else set()
    )
    return instance.part if part.name in names or slot and instance.bindings else part


def _aim_at(links: Links, part: Component, owner: Component, surfaces: tuple[str, ...]) -> Aim:
    """The formula's frame: axes of ``owner``, box of ``part`` in them."""
    if owner is part:
        return Aim(part, surfaces, links.part_world(part), part.box(), part.env.scope, _depth_of(part))
    frame = links.part_world(owner)
    box = extent(moved(part.box(), compose(inverse(frame), links.part_world(part))))
    return Aim(part, surfaces, frame, box, part.env.scope, _depth_of(part))


def _depth_of(part: Component) -> int:
    depth, instance = 1, part.env.root.instance
    while instance is not None:
        depth, instance = depth + 1, instance.part.env.root.instance
    return depth


def sites_of(links: Links, part: Component) -> list[int]:
    """All elementary primitives of a part, those of its inner parts included."""
    inner = (site for body in part.bodies for p in body.all_parts() for site in sites_of(links, p))
    return [*links.sites.get(part, ()), *inner]


def _nodes_of(links: Links, part: Component) -> Iterator[tuple[Scope, int]]:
    """The nodes of the part tree that are a part, one for each alternative, with their tables."""
    for instance in part.instances:
        if (number := links.nodes.get(instance)) is not None:
            yield instance.scope, number


def targets(links: Links, aim: Aim) -> tuple[Target, ...]:
    center = aim.box.center
    return tuple(Target(site, aim.surfaces, aim.frame, aim.box.size, center) for site in sites_of(links, aim.part))


def formula(links: Links, env: Env, aim: Aim) -> Evaluator:
    """Evaluates in the frame of the target with its centre as origin; p, n, u, v, size are the target's own."""
    local: dict[str, Value] = {
        "p": Vec(tuple(E.var(f"p.{a}") for a in "xyz")),
        "n": Vec(tuple(E.var(f"n.{a}") for a in "xyz")),
        "u": E.var("u"),
        "v": E.var("v"),
        "size": Vec(tuple(E.var(f"size.{a}") for a in "xyz")),
    }
    origin = Pose(aim.frame.rotation, place(aim.frame, aim.box.center), aim.frame.mirror)
    carry = compose(inverse(origin), links.world(env))
    made = Evaluator(env, local, frame=carry)
    made.drive = Drive(links, env, aim, origin)
    return made


# ---------------------------------------------------------------- statements


def label(links: Links, env: Env, statement: ast.LabelStmt) -> None:
    program = env.context.program
    for node in statement.targets:
        for aim in _aims(links, env, node):
            ev = formula(links, env, aim)
            guard, there = _where(ev, statement, aim), _standing(env, aim)
            if statement.joint is not None:
                assert ev.drive is not None
                there = E.both(there, ev.drive.there(statement.joint))
            holds = E.both(there, guard)
            if statement.value is None:  # what holds or does not is its condition
                degree, present_if = guard, there
            else:
                degree, present_if = shown(ev.scalar(statement.value), aim.scope), holds
            made = Label(
                statement.vocabulary,
                statement.label,
                targets(links, aim),
                degree,
                where(statement.span),
                guard=present_if,
                joints=_acted(links, ev, statement),
                motion=motion(env, statement),
            )
            links.context.labels.append((aim.depth, made))
            word = () if statement.vocabulary == "semantic" else (statement.label, made.joints)
            said = Said(f"`{statement.label}`", statement, node, holds, statement.value is None)
            note(env, ("label", statement.vocabulary, *word, aim.part, aim.surfaces), said)
            above = E.TRUE if statement.value is None else E.call("lt", E.ZERO, degree)
            nowhere.note(env.context, nowhere.Holding(statement, guard, above, aim.box.size))
            whole = statement.vocabulary == "semantic" and statement.value is None and not aim.surfaces
            if whole and not holds.reads:  # it holds for a part as a whole, or does not
                for _, number in _nodes_of(links, aim.part):
                    made_of = program.parts[number]
                    words = (*made_of.semantic, (statement.label, holds))
                    program.parts[number] = replace(made_of, semantic=words)


def _acted(links: Links, ev: Evaluator, statement: ast.LabelStmt) -> tuple[int, ...]:
    """The joints that a label is for: the one it names, else those that its formula asks about."""
    assert ev.drive is not None
    formulas = (statement.where, statement.value)
    asked = [statement.joint] if statement.joint is not None else _drives_in(ev.env.context, formulas)
    found = [joint for node in asked for joint in ev.drive.joints(node)]
    return tuple(k for k, joint in enumerate(links.context.program.joints) if any(joint is one for one in found))


def _drives_in(context: Draft, formulas: tuple[ast.Expr | None, ...]) -> list[ast.Expr]:
    """What `pushes(joint)` and the like in formulas name."""
    calls = ((one, context.form(one)) for one in nodes_in(formulas) if isinstance(one, ast.CallExpr))
    return [call.arguments[0].value for call, form in calls if form is not None and form.kind == "force"]


def motion(env: Env, statement: ast.LabelStmt) -> str:
    """The kind of joint that the word of a label moves by, as its vocabulary says."""
    symbol = env.context.symbol(statement)
    if symbol is None or not isinstance(symbol.decl, ast.VocabularyDecl) or statement.label not in symbol.decl.words:
        return ""
    return symbol.decl.motions[symbol.decl.words.index(statement.label)]


def _field_label(links: Links, env: Env, statement: ast.FieldStmt) -> None:
    first = links.context.fields.setdefault(statement.name, statement)
    if (first.type.name, first.type.size) != (statement.type.name, statement.type.size):
        kinds = (statement.type.span.text, first.type.span.text)
        raise links.context.error(
            "wrong-type",
            statement.type.span,
            f"the field `{statement.name}` holds `{kinds[0]}` here, but `{kinds[1]}` elsewhere: all of them share one array",
            hint="give one of them another name",
            notes=((first.type.span, "here"),),
        )
    for node in statement.targets:
        for aim in _aims(links, env, node):
            ev = formula(links, env, aim)
            guard, value = _where(ev, statement, aim), ev.value(statement.value)
            vector: tuple[Expr, ...] = ()
            if statement.type.name == "bool":
                number = ev.truth(value, statement.value.span)
            elif isinstance(value, Vec):
                number, vector = E.ZERO, tuple(shown(v, aim.scope) for v in value.items)
            else:
                number = ev.scalar(statement.value)
            made = Label(
                "field",
                statement.name,
                targets(links, aim),
                shown(number, aim.scope),
                where(statement.span),
                guard=E.both(_standing(env, aim), guard),
                vector=vector,
            )
            links.context.labels.append((aim.depth, made))
            said = Said(f"`{statement.name}`", statement, node, made.guard, True)
            nowhere.note(env.context, nowhere.Holding(statement, guard, E.TRUE, aim.box.size))
            note(env, ("field", statement.name, aim.part, aim.surfaces), said)


def _where(ev: Evaluator, statement: ast.LabelStmt | ast.FieldStmt, aim: Aim) -> Expr:
    """What stands behind ``where``, for the rows of the target."""
    return E.TRUE if statement.where is None else shown(ev.condition(statement.where), aim.scope)


def _standing(env: Env, aim: Aim) -> Expr:
    """What the ``when`` around a statement says, as far as the target may be there without it."""
    return E.both(has_row(env.scope, aim.scope), aim.there)


def present(env: Env, aim: Aim) -> Expr:
    """Where a statement about a part as a whole holds: where that part is, too, which may have `none` for an alternative."""
    return E.both(_standing(env, aim), aim.part.exists)


def material(links: Links, env: Env, statement: ast.MaterialStmt) -> None:
    meaning = env.context.meaning(statement)
    look = sole_look(env.context, meaning.symbol) if isinstance(meaning, Global) else Evaluator(env).meant(meaning)
    if not isinstance(look, Look):
        raise env.context.internal(statement.material_span, "this is not a material")
    for node in statement.targets:
        for aim in _aims(links, env, node):
            there = _standing(env, aim)
            looks = tuple((name, E.both(there, shown(predicate, aim.scope))) for name, predicate in look.options)
            said = Said(f"`{statement.material}`", statement, node, there, True)
            note(env, ("material", aim.part, aim.surfaces), said)
            for site in sites_of(links, aim.part):
                links.context.materials.setdefault(site, []).append((aim.depth, looks))


def grasp(links: Links, env: Env, statement: ast.GraspStmt) -> None:
    at, approach, close, opening = statement.at, statement.approach, statement.close, statement.opening
    assert at is not None and approach is not None and close is not None and opening is not None
    for aim in _aims(links, env, statement.target):
        ev = formula(links, env, aim)
        if statement.parameter is not None:
            ev.local[statement.parameter] = E.var("t")
        scope = env.context.guard(aim.scope, present(env, aim), f"{env.path}{statement.name}")
        own = dict(ev.local)
        plain, turned = (Evaluator(env, local, frame=ev.frame) for local in (own, {**own, **axes()}))
        ends = () if statement.range is None else (statement.range.low, statement.range.high)
        low, high = (shown(Evaluator(env).scalar(end), scope) for end in ends) if ends else (E.ZERO, E.ZERO)
        vectors = plain.vector(at.value), turned.direction(approach.value), turned.direction(close.value)
        hand, ahead, across = (triple(shown(c, scope) for c in vector) for vector in vectors)
        quality = E.ONE if statement.quality is None else plain.scalar(statement.quality.value)
        links.context.program.grasps.append(
            Grasp(
                statement.name,
                scope,
                links.of(aim.part),
                aim.frame,
                aim.box.size,
                aim.box.center,
                low,
                high,
                hand,
                ahead,
                across,
                shown(plain.scalar(opening.value), scope),
                shown(quality, scope),
                where(statement.span),
                tuple((measure.word, shown(plain.scalar(measure.value), scope)) for measure in statement.hand),
            )
        )


def axes() -> dict[str, Value]:
    """In a grasp, axis words are the target's own axes."""
    return {letter: Vec(unit(k)) for k, letter in enumerate("xyz")}


def keypoint(links: Links, env: Env, statement: ast.KeypointStmt) -> None:
    program = env.context.program
    if _is_part_path(env, statement.target):
        for aim in _aims(links, env, statement.target):
            point = place(aim.frame, aim.box.center)
            if statement.at is not None:
                own = formula(links, env, aim)
                own.local.update({"size": Vec(aim.box.size)})
                origin = Pose(aim.frame.rotation, point, aim.frame.mirror)
                point = place(origin, Evaluator(env, own.local, frame=own.frame).vector(statement.at))
            scope = env.context.guard(aim.scope, present(env, aim), f"{env.path}{statement.name}")
            point = triple(shown(c, scope) for c in point)
            program.keypoints.append(Keypoint(statement.name, scope, links.of(aim.part), point, where(statement.span)))
        return
    value = Evaluator(env).value(statement.target)
    match value:
        case Frame(origin=point) | Line(point=point):
            pass
        case _:
            point = Evaluator(env).vector(statement.target)
    on = carriers_of(value)
    link = links.carried(on, statement.span) if on else (0,)
    point = place(links.world(env), point)
    program.keypoints.append(Keypoint(statement.name, env.scope, link, point, where(statement.span)))


def _is_part_path(env: Env, node: ast.Expr) -> bool:
    """Whether a target names parts: a slot may bind surfaces, and `previous` is a part of another element."""
    if not isinstance(env.context.typed.type_of(node), types.PartType | types.SlotType):
        return False
    named = isinstance(env.context.meaning(path_root(node)), Declared | Current)
    return named and all(isinstance(reached.value, Ref) for reached in walk(env, node))


def symmetry(links: Links, env: Env, statement: ast.SymmetryStmt) -> None:
    direction = Evaluator(env).direction(statement.direction)
    found = sole_axis(direction)
    if found is None:
        span = statement.direction.span
        raise env.context.error(
            "bad-axis",
            span,
            "a symmetry must be about x, y or z, axes of the part itself",
            hint="write `about x`, `about y` or `about z`",
        )
    axis = E.const(float(found))
    turns = E.ZERO if statement.turn is None else E.maximum(Evaluator(env).scalar(statement.turn), E.ONE)
    program = env.context.program
    about = statement.span.words.partition(":")[2].strip()
    for aim in _aims(links, env, statement.target):
        said = Said(f"`{about}`", statement, statement.target, _standing(env, aim), True)
        note(env, ("symmetry", aim.part), said)
        for scope, number in _nodes_of(links, aim.part):
            known = program.parts[number].symmetry or (E.ONE, axis)
            here = E.both(has_row(env.scope, scope), aim.there)
            told = (E.where(here, shown(a, scope), b) for a, b in zip((turns, axis), known, strict=True))
            program.parts[number] = replace(program.parts[number], symmetry=pair(told))


def _one_element(statement: ast.SymmetryStmt) -> bool:
    """Whether a statement is about one element of a repeat."""
    return any(isinstance(node, ast.IndexExpr) for node in nodes_in(statement.target))


MEANINGS: Meanings = {
    ast.SymmetryStmt: symmetry,
    ast.LabelStmt: label,
    ast.FieldStmt: _field_label,
    ast.MaterialStmt: material,
    ast.GraspStmt: grasp,
    ast.KeypointStmt: keypoint,
}
