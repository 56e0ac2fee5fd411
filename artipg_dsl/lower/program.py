"""The lowering from end to end: a checked category to a program of tables."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from ..diagnostics import Report
from ..graph.expr import Scope, ScopeError
from ..graph.linear import Circle
from ..graph.program import UNLABELLED, Link, Program
from ..graph.reference import definitions_of
from ..graph.writing import write
from ..records import dataclass
from ..semantics.check import TypedProgram
from ..semantics.symbols import Symbol
from ..syntax import ast
from .elaborate import branches, draws, drives, gates, handed, labels, mimic, motions, nowhere, overridden, rings
from .elaborate import conditions as stated
from .elaborate.body import enter_when, lower_statements
from .elaborate.drives import driven
from .elaborate.legal import legalize
from .elaborate.links import Links, first_parts
from .elaborate.part import Component
from .elaborate.slots import slots
from .elaborate.statements import carry_out
from .elaborate.surfaces import frame_on
from .expressions import builtins
from .expressions.context import Abort, Draft, Makers
from .expressions.env import Env
from .solids.curves import offset
from .solve.bounds import attach_bounds
from .solve.feasible import judge
from .solve.solve import circular


@dataclass(slots=True, eq=False)
class Lowering:
    """What the passes share and leave behind: the program, and what the ledger and other views of it need."""

    category: Symbol
    program: Program
    context: Draft
    root: Env
    links: Links
    text: str = ""  # of the program, when it is complete

    def unplaced(self) -> Iterator[Component]:
        """The parts in the text of the category that nothing places along any axis; not those that stand in an element of a repeat,
        nor the first of a template, by which the others go."""
        for part, axes in self.context.centred.items():
            if len(axes) < 3 or part.span.source is not self.root.module.source:
                continue
            owner = part.env.root.instance
            if part.env.element is None and (owner is None or part not in first_parts(owner)):
                yield part


FUNCTIONS = {**builtins.FUNCTIONS, "offset": offset, "at": frame_on, "drive": driven}
"""What calls of functions mean, by the ``meaning`` of their forms; curves and the pieces of paths mean something to solids only."""


def new_context(report: Report, program: Program, typed: TypedProgram) -> Draft:
    """What the lowering of a program, or of the primitives of a file, shares."""
    return Draft(report, program, typed, Makers(enter_when, FUNCTIONS))


def lower_category(typed: TypedProgram, category: Symbol, report: Report) -> Lowering | None:
    """Lower a category by the passes; None after errors."""
    program = Program(category.name, category.decl.doc)
    root = Scope(category.name)
    program.scopes.append(root)
    context = new_context(report, program, typed)
    env = Env(context, category.module, category, root, "")
    lowering = Lowering(category, program, context, env, Links(context))
    for stage in STAGES:
        for step in stage:
            try:
                step.run(lowering)
            except Abort:
                return None
            except ScopeError as error:
                context.mixed(error, category.decl.name_span)
                return None
            except Circle as error:
                circular(lowering.root, error.columns)
                return None
            for watch in WATCHERS:
                watch(step, lowering)
        if report.failed:
            return None
    return lowering


# ---------------------------------------------------------------- the passes


def statements(lowering: Lowering) -> None:
    """Take the category apart: tables of its repeats and guards, instances of its parts, equations, and each unknown settled."""
    lower_statements(lowering.root, lowering.category.body)
    lowering.program.draws = lowering.context.draws


def tree(lowering: Lowering) -> None:
    """Place the parts in the object's frame, in the order of the text, with their primitives, and say what moves them."""
    program = lowering.program
    program.links.append(Link(_root_path(lowering.root), program.scopes[0], -1))
    lowering.links.build(lowering.root, -1)


def followers(lowering: Lowering) -> None:
    """Say of each joint with ``mimic`` which joint it follows, and of each with ``when`` which joints it waits for."""
    mimic.resolve(lowering.links)
    mimic.refuse_chains(lowering.links)
    gates.resolve(lowering.links)


def no_rings(lowering: Lowering) -> None:
    """Refuse links that hang on one another, and joints that follow or wait for one another."""
    rings.refuse(lowering.links)


def motion(lowering: Lowering) -> None:
    """Narrow joints by ``limit``, tie loops by ``close``, mark the joints that go as far as ``clearance``."""
    carry_out(lowering.links, lowering.root, motions.MEANINGS)
    clearances(lowering.links)
    gates.refuse_loops(lowering.links)
    mimic.refuse_loops(lowering.links)


def carried(lowering: Lowering) -> None:
    """Say of each link whose frame it takes, and of each part what carries it rigidly."""
    _number_links(lowering.links)
    lowering.links.hold()


def what_is_said(lowering: Lowering) -> None:
    """What is said about surfaces and parts: labels, fields, grasps, keypoints, symmetries, materials."""
    context = lowering.context
    labels.statements(lowering.links, lowering.root)
    overridden.warn(context, lowering.root.module.source)
    nowhere.warn(context, lowering.root.module.source)
    drives.report(context)
    _order_labels(context)
    _dress(context)


def conditions(lowering: Lowering) -> None:
    """What objects have to fulfil, and which parts may touch."""
    carry_out(lowering.links, lowering.root, stated.MEANINGS)


def counterparts(lowering: Lowering) -> None:
    """What templates of a role bind to its slots."""
    slots(lowering.links, lowering.root)


def vocabularies(lowering: Lowering) -> None:
    """The words that labels may have, of all modules that are used."""
    _spoken(lowering.root)


def idle_starts(lowering: Lowering) -> None:
    """Warn of ``near`` where nothing is searched."""
    for span, searched in lowering.context.near.items():
        if not searched and span.source is lowering.root.module.source:
            lowering.context.report.warning(
                "idle-near",
                span,
                "`near` has no effect here: the equation is solved without a search",
                hint="drop it; a range, a default or a requirement determines which value is drawn",
            )


def bounds(lowering: Lowering) -> None:
    """Turn requirements into ranges of the draws; refuse those that nothing can meet."""
    judge(lowering.context, attach_bounds(lowering.program, lowering.context.strict), lowering.root.module.source.name)


def arguments(lowering: Lowering) -> None:
    """Warn of arguments outside the ranges of what they are for, and of what they, or other ranges, leave out."""
    handed.warn(lowering.context)
    draws.warn_never_drawn(lowering.context, lowering.root.module.source)
    branches.warn(lowering.context, lowering.root.module.source)


def legality(lowering: Lowering) -> None:
    """Refuse numbers that are never legal; require of others that they are. It narrows no draw."""
    if not lowering.context.unclear:
        legalize(lowering.links, lowering.root)


def seal(lowering: Lowering) -> None:
    """The text of the program, and the hash of what it computes."""
    lowering.text, lowering.program.hash = write(lowering.program)


@dataclass(frozen=True, slots=True)
class Pass:
    """A step of the lowering: the fields of the program that it reads and those that it fills or changes."""

    run: Callable[[Lowering], None]
    needs: str
    gives: str

    @property
    def name(self) -> str:
        return self.run.__name__


STAGES = (
    (Pass(statements, "", "scopes draws definitions requirements materials primitives"),),
    (
        Pass(tree, "scopes draws definitions primitives", "scopes links joints parts sites"),
        Pass(followers, "joints", "joints"),
        Pass(no_rings, "draws links joints", ""),
    ),
    (
        Pass(motion, "scopes links joints", "scopes joints closures"),
        Pass(carried, "links parts", "links parts"),
        Pass(vocabularies, "", "vocabularies"),
        Pass(
            what_is_said,
            "scopes vocabularies joints parts sites",
            "scopes parts sites labels grasps keypoints materials",
        ),
        Pass(conditions, "scopes draws definitions parts", "requirements preferences stable allowed clear"),
        Pass(counterparts, "parts", "slots"),
        Pass(idle_starts, "", ""),
        Pass(bounds, "draws definitions requirements", "draws"),
    ),
    (
        Pass(arguments, "draws definitions", ""),
        Pass(legality, "draws definitions parts sites joints labels grasps keypoints requirements", "requirements"),
        Pass(seal, "", "hash"),
    ),
)
"""The lowering in the order of its passes. A stage begins when none before it has reported an error; its passes all run, so that
as much as possible is reported at once."""

WATCHERS: list[Callable[[Pass, Lowering], None]] = []
"""What is called after each pass: tests verify the program there."""


def clearances(links: Links) -> None:
    """Mark the joints that turn or slide as far as nothing is in the way; refuse those that do not move by themselves."""
    program = links.context.program
    leaders = [
        (k, joint.path) for joint in program.joints if joint.mimic is not None for k in definitions_of(joint.mimic[0])
    ]
    followed = dict(reversed(leaders))
    for number, span in links.context.clearances.items():
        joint = program.joints[number]
        why = None
        if joint.mimic is not None:
            why = f"`{joint.path}` follows another joint"
        elif number in followed:
            why = f"`{followed[number]}` follows `{joint.path}`"
        elif joint.gates:
            why = f"`{joint.path}` waits for another joint"
        elif joint.positions is not None:
            why = f"`{joint.path}` has `positions`"
        elif program.closures:
            why = "the object has a closed loop (`close`)"
        if why is not None:
            links.context.unclear.append((span, why))
        program.joints[number] = replace(joint, clearance=True, whatever=number in links.context.whatever)


def _root_path(env: Env) -> str:
    return next((p.path for p in env.parts if p.declaration.root), "base")


def _number_links(links: Links) -> None:
    """Give each link the node of its part, whose frame it takes."""
    program = links.context.program
    owners = links.owners
    for number, link in enumerate(program.links):
        part = owners.get(number)
        node = next((n for instance, n in links.nodes.items() if instance.part is part), -1) if part is not None else 0
        program.links[number] = replace(link, part=node)


def _order_labels(context: Draft) -> None:
    """Outer labels first, so that the innermost is said last; the order of the text among equals."""
    ordered = sorted(context.labels, key=lambda pair: pair[0])
    context.program.labels = [replace(label, depth=depth) for depth, label in ordered if label.targets]


def _dress(context: Draft) -> None:
    """The materials of each site: outer ones first, the last that holds counts."""
    program = context.program
    for number, found in context.materials.items():
        ordered = [pair for _, pairs in sorted(found, key=lambda f: f[0]) for pair in pairs]
        program.sites[number] = replace(program.sites[number], materials=tuple(ordered))


def _spoken(env: Env) -> None:
    """The vocabularies in sight of the category and of everything it uses.

    Words of vocabularies of one name add up, those of what a module uses before its own: numbers stay. The first is
    that of a surface without any.
    """
    program = env.context.program
    program.vocabularies["semantic"] = (UNLABELLED,)  # points have a class, whether the text has words for it or not
    for symbol in (symbol for module in env.module.used() for symbol in module.names.values()):
        if symbol.kind == "vocabulary":
            assert isinstance(symbol.decl, ast.VocabularyDecl)
            words = program.vocabularies.get(symbol.name, (UNLABELLED,))
            extra = tuple(w for w in symbol.decl.words if w not in words)
            program.vocabularies[symbol.name] = words + extra
