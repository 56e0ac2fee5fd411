"""A program read from a file, checked item by item: names, indices, tables, variables, numbers, and what must be a tree.

The expressions have been checked one by one when they were read (``nodes``). What passes here can be planned, evaluated and
told of without asking again; whether its objects are any good is for the requirements and the checks of the runtime.
"""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterable, Iterator, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any

from .. import shapes
from ..language import DISTRIBUTIONS, JOINTS, WEIGHTED
from . import program as P
from .expr import Column, Expr, Scope
from .nodes import KINDS, NAME, NodeFault, Nodes, require
from .primitive import LATER, Patch, Piece, Primitive
from .reference import Elsewhere, Onward, Reference, Under, definitions_of

_WORD = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_OPTION = re.compile(NAME.pattern + r"(#[0-9]{1,4})?")  # the second of one template is told apart
UNITS = frozenset({"", "m", "rad", "kg", "kg/m3", "s", "m/s", "N", "Nm"})
_MOST_PATCHES = 100  # of one indexed surface; the language allows 64
_NAMED = {  # fields that hold names, which flow into files and paths
    P.Draw: ("options",),
    P.Part: ("path", "name", "template"),
    P.Site: ("path", "primitive"),
    P.Link: ("path",),
    P.Joint: ("path", "name"),
    P.Target: ("surfaces",),
    P.Label: ("vocabulary", "name"),
    P.Grasp: ("name",),
    P.Keypoint: ("name",),
    P.Material: ("name",),
    P.Slot: ("path", "name"),
    Primitive: ("name", "parameters", "surfaces", "whole"),
    Patch: ("name",),
    Piece: ("name",),
}
_CONDITIONS = frozenset({"guard", "condition", "allowed", "requires", "semantic", "materials"})
_SURFACE = frozenset({"u", "v", *(f"{a}.{b}" for a in ("p", "n", "size") for b in "xyz")})
_GRASP = frozenset({"t", *(f"size.{b}" for b in "xyz")})
_REFERENCES = (Under, Elsewhere, Onward)
shapes.NAMED |= {Expr: "an expression (%n)", Column: "a column ($n)", Scope: "a table (@n)"}


class Verifier:
    """Checks items of one program; each method raises Fault or Misfit with what is wrong with its item."""

    def __init__(self, program: P.Program, nodes: Nodes):
        self.program, self.nodes = program, nodes

    def shape(self, item: Any, number: int) -> None:
        """The structure of a record and the names in it, whatever the others are."""
        shapes.fit(item, type(item))
        for record in (
            item,
            *getattr(item, "targets", ()),
            *getattr(item, "patches", ()),
            *getattr(item, "pieces", ()),
        ):
            self.named(record)

    def item(self, item: Any, number: int) -> None:
        """A record of a list of the program, the one of this number in its list, when all have their shape."""
        for cell in _cells(item, type(item)):
            self.placed(cell, _scope_of(item))
        self.truths(_conditions(item))
        getattr(self, f"_{type(item).__name__.lower()}", lambda *_: None)(item, number)

    def truths(self, cells: Iterable[tuple[str, Expr]]) -> None:
        for name, cell in cells:
            require(self.nodes.truth(cell), f"{name} is true or false, not a number")

    def whole(self) -> None:
        """What only the whole program tells."""
        program = self.program
        require(program.scopes and program.scopes[0].kind == "root", "the first table is not a root")
        require(_WORD.fullmatch(program.name), "the name of the program is not a valid name")
        named = [draw.column for draw in program.draws]
        require(len(set(named)) == len(named), "a column is drawn twice")
        both = next((c for c in named if c in program.definitions), None)
        require(both is None, f"the column {both and both.name} is drawn and defined")

    # ------------------------------------------------------------ what all have in common

    def scope(self, scope: Scope) -> None:
        shapes.fit(scope.name, str, "name")
        if scope.parent is None:
            require(
                scope.kind == "root" and not self.program.scopes,
                "only the first table may be without a parent, as the root",
            )
            return
        require(scope.kind in ("repeat", "guard"), f"a table is a repeat or a guard, not {str(scope.kind)[:40]!r}")
        if not isinstance(scope.parent, Scope) or not isinstance(scope.count, Expr):
            raise NodeFault("a table has a parent (@n) and a count (%n)")
        require(self.nodes.stands(scope.count, scope.parent), "the count of a table reads a table that it cannot see")

    def column(self, column: Column) -> None:
        require(isinstance(column.scope, Scope), "a column is of a table (@n)")
        require(column.kind in KINDS, f"there is no kind of column {str(column.kind)[:40]!r}")
        if not isinstance(column.name, str) or not NAME.fullmatch(column.name):
            raise NodeFault(f"{shapes.show_value(column.name)} is not a name of a column")

    def definition(self, column: Any, value: Any) -> None:
        require(
            isinstance(column, Column) and isinstance(value, Expr), "define takes a column ($n) and an expression (%n)"
        )
        require(column not in self.program.definitions, f"the column {column.name} is defined twice")
        self.placed(value, column.scope)
        require(
            self.nodes.truth(value) == (column.kind == "bool"),
            f"the column {column.name} is of another kind than its value",
        )

    def vocabulary(self, name: Any, words: Any) -> None:
        shapes.fit(words, tuple[str, ...])
        require(words[:1] == (P.UNLABELLED,), f"the first word of a vocabulary is not {P.UNLABELLED}")
        for word in (name, *words):
            require(
                isinstance(word, str) and _WORD.fullmatch(word),
                f"{shapes.show_value(word)} is not a word of a vocabulary",
            )

    def placed(self, expr: Expr, scope: Scope | None) -> None:
        require(self.nodes.stands(expr, scope), "a value reads a table that it cannot see, or a variable of a formula")

    def formulas(self, exprs: Sequence[Expr | None], known: frozenset[str], scope: Scope | None = None) -> None:
        for expr in exprs:
            wrong = None if expr is None else self.nodes.computes(expr, known, scope)
            require(wrong is None, wrong or "")

    def named(self, item: Any) -> None:
        for name in _NAMED.get(type(item), ()):
            value = getattr(item, name)
            for one in (value,) if isinstance(value, str) else value:
                form = _OPTION if name == "options" else NAME
                if not form.fullmatch(one):  # words for each would take longer than the test
                    raise NodeFault(f"{name}: {shapes.show_value(one)} is not a name")

    def index(self, number: int, among: Sequence[Any], what: str, least: int = 0) -> None:
        require(least <= number < len(among), f"there is no {what} {number}")

    def reference(self, reference: Reference, among: Sequence[Any], what: str) -> None:
        for number in definitions_of(reference):
            self.index(number, among, what)
        for item in _records(reference):
            if isinstance(item, Elsewhere):
                require(item.repeat.kind == "repeat", "a value elsewhere must be in an element of a repeat")
                if item.rank is None:
                    require(item.scope.within(item.repeat), "the element before is looked for outside its repeat")
                else:
                    self.placed(item.rank, item.scope)

    # ------------------------------------------------------------ draws and requirements

    def _draw(self, draw: P.Draw, number: int) -> None:
        require(draw.address, "a draw has no address")
        require(draw.unit in UNITS, f"{shapes.show_value(draw.unit)} is not a unit of values inside")
        if draw.kind == "choice":
            require(
                draw.options and len(draw.options) == len(draw.weights),
                "a choice needs a weight for each of its options",
            )
            require(len(set(draw.options)) == len(draw.options), "a choice has an option twice")
            usual = 0.0 if draw.default is None else draw.default.constant
            require(usual in range(len(draw.options)), "the default of a choice must be one of its options")
        else:
            require(draw.kind in ("real", "count"), f"there is no kind of draw {shapes.show_value(draw.kind)}")
            require(draw.low is not None and draw.high is not None, "a number is drawn between low and high")
            if draw.distribution == WEIGHTED:
                self._weighted(draw)
                return self._narrowed(draw)
            require(
                draw.distribution in DISTRIBUTIONS, f"there is no distribution {shapes.show_value(draw.distribution)}"
            )
            require(
                len(draw.arguments) in DISTRIBUTIONS[draw.distribution].arguments,
                f"{draw.distribution} is given the wrong number of arguments",
            )
        self._narrowed(draw)

    def _weighted(self, draw: P.Draw) -> None:
        cells = [a.constant for a in draw.arguments]
        require(cells and len(cells) % 2 == 0, "a weighted number has as many weights as values")
        good = [cell is not None and not isinstance(cell, bool) and math.isfinite(cell) for cell in cells]
        require(all(good), "the values and weights of a weighted number are numbers")
        require(all(float(cell or 0.0) > 0.0 for cell in cells[len(cells) // 2 :]), "a weight is above 0")

    def _narrowed(self, draw: P.Draw) -> None:
        """What requirements leave of a draw."""
        for limit in draw.limits:
            self.index(limit.option, draw.options, "option")
            self.index(limit.requirement, self.program.requirements, "requirement")
        asked = [one for b in draw.bounds for one in (b.requirement, *b.also)]
        for one in (*asked, *(one for u in draw.unions for one in (u.requirement, *u.also))):
            self.index(one, self.program.requirements, "requirement")
        for bound in draw.bounds:
            require(
                bound.side in ("low", "high"),
                f"the side of a bound is low or high, not {shapes.show_value(bound.side)}",
            )
        require(all(union.intervals for union in draw.unions), "a range of several intervals is empty")

    def _requirement(self, requirement: P.Requirement, number: int) -> None:
        for one in requirement.repair:
            self.index(one, self.program.draws, "draw")

    # ------------------------------------------------------------ parts, links and joints

    def _part(self, part: P.Part, number: int) -> None:
        require(-1 <= part.parent < number, "a part must come after the part that contains it")
        require(
            part.parent < 0 or self.among(part.scope, part.parent),
            "the part that contains it does not exist in all its rows",
        )
        for word, _ in part.semantic:
            self.word("semantic", word)
        for axis in () if part.symmetry is None else _choices(part.symmetry[1]):
            require(axis.constant in (0.0, 1.0, 2.0), "the symmetry of a part is about axis 0, 1 or 2")
        self.reference(part.link, self.program.links, "link")
        self.reference(part.holder, self.program.parts, "part")

    def among(self, scope: Scope, part: int) -> bool:
        """Whether each row of a table lies in one of the part."""
        return scope.within(self.program.parts[part].scope)

    def _site(self, site: P.Site, number: int) -> None:
        primitive = self.program.primitives.get(site.primitive)
        require(primitive is not None, f"there is no primitive {site.primitive}")
        assert primitive is not None
        require(
            len(site.parameters) == len(primitive.parameters),
            f"{site.primitive} takes {len(primitive.parameters)} parameters",
        )
        self.index(site.part, self.program.parts, "part")
        require(self.among(site.scope, site.part), "the part that contains it does not exist in all its rows")
        for name, _ in site.materials:
            require(name in self.program.materials, f"there is no material {shapes.show_value(name)}")
        self.reference(site.link, self.program.links, "link")

    def _link(self, link: P.Link, number: int) -> None:
        self.index(link.part, self.program.parts, "part", -1)

    def _joint(self, joint: P.Joint, number: int) -> None:
        require(joint.kind in JOINTS, f"there is no kind of joint {shapes.show_value(joint.kind)}")
        self.index(joint.child, self.program.links, "link")
        self.reference(joint.parent, self.program.links, "link")
        joints = self.program.joints
        # whether they follow one another in a ring depends on guards and ranks: the runtime asks by row
        self.reference(() if joint.mimic is None else joint.mimic[0], joints, "joint")
        require(joint.curve is None or joint.mimic is not None, "a joint with a curve follows no other")
        for leader in (joints[k] for k in (() if joint.mimic is None else definitions_of(joint.mimic[0]))):
            require(leader.curve is None, "a joint follows one with a curve")
            require(
                joint.curve is None or leader.mimic is None, "a joint with a curve follows one that follows another"
            )
        self.formulas([joint.curve], frozenset({P.LEAD}), joint.scope)
        for gate in joint.gates:
            self.reference(gate.joint, joints, "joint")

    def _closure(self, closure: P.Closure, number: int) -> None:
        for reference in closure.links:
            self.reference(reference, self.program.links, "link")

    def _allowed(self, allowed: P.Allowed, number: int) -> None:
        require(allowed.kind in ("overlap", "free", "floating"), f"nothing allows {shapes.show_value(allowed.kind)}")
        for one in (*allowed.first, *allowed.second):
            self.index(one, self.program.parts, "part")
        require(len(allowed.ranks) == 2, "ranks are those of either side")

    def _clear(self, clear: P.Clear, number: int) -> None:
        for one in (*clear.first, *clear.second):
            self.index(one, self.program.parts, "part")
        require(len(clear.ranks) == 2, "ranks are those of either side")

    def _slot(self, slot: P.Slot, number: int) -> None:
        for one in slot.parts:
            self.index(one, self.program.parts, "part")

    # ------------------------------------------------------------ labels

    def word(self, vocabulary: str, name: str) -> None:
        known = self.program.vocabularies.get(vocabulary, ())
        require(name in known, f"the vocabulary {vocabulary} has no word {shapes.show_value(name)}")

    def _label(self, label: P.Label, number: int) -> None:
        if label.vocabulary == "semantic":
            self.word("semantic", label.name)
        require(len(label.vector) in (0, 3), "a vector has three components")
        require(not label.vector or label.vocabulary == "field", "a vector is a field")
        require(0 <= label.depth <= 10_000, "the depth of a label is a small number")
        require(label.motion in ("", "along", "about"), f"a label has no motion {shapes.show_value(label.motion)}")
        for joint in label.joints:
            self.index(joint, self.program.joints, "joint")
        for target in label.targets:
            self.index(target.site, self.program.sites, "site")
            scope = self.program.sites[target.site].scope
            for cell in _cells(target, P.Target):
                self.placed(cell, scope)
            self.formulas(label.formulas, _SURFACE, scope)

    def _grasp(self, grasp: P.Grasp, number: int) -> None:
        self.reference(grasp.link, self.program.links, "link")
        self.formulas(grasp.formulas, _GRASP, grasp.scope)
        names = [name for name, _ in grasp.hand]
        require(
            set(names) <= set(P.MEASURES) and len(set(names)) == len(names),
            "a hand has a measure that grippers do not have",
        )

    def _keypoint(self, keypoint: P.Keypoint, number: int) -> None:
        self.reference(keypoint.link, self.program.links, "link")

    def _material(self, material: P.Material, number: int) -> None:
        for field in fields(material):
            value = getattr(material, field.name)
            if field.name == "colour":
                require(
                    value and all(0 <= c <= 1 for one in value for c in one),
                    "colours are numbers from 0 to 1, and there is one",
                )
            elif field.name != "name":
                most = 1.0 if field.name in ("metalness", "roughness", "transparency", "restitution") else 1e6
                require(0 <= value[0] <= value[1] <= most, f"{field.name} is a range from 0 to {most:g}")
        require(material.density[0] > 0, "a density is above 0")

    # ------------------------------------------------------------ primitives

    def _primitive(self, primitive: Primitive, number: int) -> None:
        self.parameters(primitive)
        for name in LATER:
            self.formulas_of(primitive, name, getattr(primitive, name))

    def parameters(self, primitive: Primitive) -> None:
        """What a primitive is a formula of."""
        names, own = primitive.parameters, frozenset(primitive.parameters)
        require(len(own) == len(names), "a parameter is given twice")
        clash = own & {"u", "v", "i", "p.x", "p.y", "p.z"}
        require(not clash, f"a parameter is called {', '.join(sorted(clash))}, which has another meaning in a formula")
        require(len(primitive.test) == len(names), "there is a test range for each parameter")
        require(all(low <= high for low, high in primitive.test), "a test range ends before it begins")
        require(own.issuperset(primitive.whole), "a number of copies must be a parameter")

    def formulas_of(self, primitive: Primitive, name: str, held: Any) -> None:
        """The field ``name`` of a primitive, which holds formulas and has its shape."""
        own = frozenset(primitive.parameters)
        if name == "inside":
            self.formulas([held], own | {"p.x", "p.y", "p.z"})
        elif name == "patches":
            require(held, "a primitive has no surface")
            for patch in held:
                require(
                    patch.count is None or 0 <= patch.count <= _MOST_PATCHES,
                    f"a surface exists up to {_MOST_PATCHES} times",
                )
                indexed = own | {"i"} if patch.count is not None else own
                self.formulas(patch.position, indexed | {"u", "v"})
                self.formulas((*patch.u_range, *patch.v_range, patch.guard), indexed)
        elif name == "pieces":
            for piece in held:
                require(piece.points, "a convex piece has no points")
                self.formulas([piece.count], own)
                self.formulas([piece.guard, *(cell for point in piece.points for cell in point)], own | {"i"})
        else:
            self.formulas(held, own)

    def late(self, primitive: Primitive, name: str, held: Any) -> None:
        """A field of a primitive that is read behind the others."""
        shapes.fit(held, shapes.hints(Primitive)[name], name)
        for record in held if name in ("patches", "pieces") else ():
            self.named(record)
        self.truths(_conditions_in(name, held))
        self.formulas_of(primitive, name, held)


def _scope_of(item: Any) -> Scope | None:
    return item.column.scope if isinstance(item, P.Draw) else getattr(item, "scope", None)


_FORMULAS = {  # fields that hold formulas, or that stand in other tables than their record
    P.Joint: {"curve"},
    P.Label: {"value", "guard", "vector", "targets"},
    P.Grasp: {"at", "approach", "close", "opening", "quality", "hand"},
    Primitive: set(LATER),
}


_SEVERAL = (tuple, list)


@cache
def _fields(kind: type) -> tuple[str, ...]:
    """What the records of a class hold; nothing for what is no record of a program, or only tells where something is."""
    if not is_dataclass(kind) or issubclass(kind, (Scope, Column, *_REFERENCES)):
        return ()
    return tuple([field.name for field in fields(kind)])


def _cells(value: Any, kind: type | None = None) -> list[Expr]:
    """The expressions of an item that have values in its rows."""
    found: list[Expr] = []
    _add_cells(value, found, _FORMULAS.get(kind, ()) if kind else ())
    return found


def _add_cells(value: Any, found: list[Expr], others: Container[str] = ()) -> None:
    """Add those of a value, without its fields ``others``."""
    if isinstance(value, Expr):
        found.append(value)
    elif type(value) in _SEVERAL:
        for one in value:
            _add_cells(one, found)
    else:
        for name in _fields(value.__class__):
            if name not in others:
                _add_cells(getattr(value, name), found)


def _conditions(value: Any) -> list[tuple[str, Expr]]:
    """The expressions of an item, and of the records in it, which must be true or false, with the names of their fields."""
    found: list[tuple[str, Expr]] = []
    for name in _fields(value.__class__):
        found += _conditions_in(name, getattr(value, name))
    return found


def _conditions_in(name: str, held: Any) -> list[tuple[str, Expr]]:
    """The same of a field of this name."""
    found = [(name, cell) for cell in _cells(held)] if name in _CONDITIONS else []
    if type(held) in _SEVERAL:
        for one in held:
            found += _conditions(one)
    return found


def _records(reference: Reference) -> Iterator[Under | Elsewhere | Onward]:
    for item in reference:
        if not isinstance(item, int):
            yield item
            yield from _records(item.links)


__all__ = ["NodeFault", "Verifier"]


def _choices(a: Expr) -> Iterator[Expr]:
    """What a value is one of: itself, or what either branch of a condition may be."""
    seen: set[Expr] = set()
    left = [a]
    while left:
        node = left.pop()
        if node.op == "where":
            left += [b for b in node.args[1:] if b not in seen]
            seen.update(node.args[1:])
        else:
            yield node
