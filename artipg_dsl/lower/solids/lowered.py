"""A lowered primitive: its formulas over variables, and what a use of it asks and offers."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr
from ...graph.interval import holds_always
from ...graph.primitive import Primitive, triple
from ...graph.substitution import substitute
from ...records import dataclass
from ...source import Span
from ..expressions.context import Bend
from ..values.carry import mapped
from ..values.handed import Handed
from ..values.kinds import Box, Choice, Surface, Value, Vec
from ..values.vectors import HERE
from .curves import Curve
from .paths import handed

if TYPE_CHECKING:
    from ..elaborate.part import Instance


@dataclass(frozen=True, slots=True, eq=False)
class Condition:
    """What a primitive asks of its parameters: ``holds``, which is ``sides`` low <= high where there are two; ``message``
    says what is wrong, ``text`` what is asked. ``bend`` as in ``made.Demand``.
    """

    holds: Expr
    sides: tuple[Expr, Expr] | None
    message: str
    text: str
    bend: tuple[Expr, Expr] | None = None


@dataclass(slots=True, eq=False)
class Lowered:
    """A primitive's formulas over variables, and what else its declaration offers."""

    primitive: Primitive
    names: tuple[str, ...]  # of its parameters
    ports: dict[str, Value] = field(default_factory=dict)
    conditions: list[Condition] = field(default_factory=list)
    centred_size: bool = False
    possible: bool = True  # whether some of its test values meet the conditions, where a path shapes it
    paths: tuple[Handed, ...] = ()  # what its first use handed in
    trace: tuple[tuple[Span, str], ...] = ()  # and where
    digest: str = ""  # of the primitive, where it is known

    @property
    def blamed(self) -> tuple[Span, str] | None:
        """The author's curve that gives it its shape, where there is one."""
        return blame(self.paths, self.primitive.name) if self.paths else None

    def scalars(self, instance: Instance) -> tuple[Expr, ...]:
        """The arguments of a use in the order of the primitive's parameters."""
        found: list[Expr] = []
        for name in self.names:
            value = instance.values.get(name)
            if isinstance(value, Curve):
                found.extend(handed(value, name).scalars)
            elif isinstance(value, Vec):
                found.extend(value.items)
            else:
                assert isinstance(value, Expr | Choice)
                found.append(value if isinstance(value, Expr) else value.code)
        return tuple(found)

    def mapping(self, instance: Instance) -> dict[Expr, Expr]:
        names = self.primitive.parameters
        return {E.var(n): v for n, v in zip(names, self.scalars(instance), strict=True)}

    def box(self, instance: Instance) -> Box:
        mapping = self.mapping(instance)
        low, high = (triple(substitute(c, mapping) for c in end) for end in (self.primitive.low, self.primitive.high))
        return Box(low, high)

    def member(self, instance: Instance, name: str) -> Value | None:
        if name in self.ports:
            mapping = self.mapping(instance)
            return mapped(self.ports[name], lambda e: substitute(e, mapping))
        if name in self.primitive.surfaces:
            return Surface(((None, instance.part, HERE, name),))
        return None

    def require(self, instance: Instance) -> None:
        """The declaration's requirements (and positive parameters) for this use, in its table."""

        mapping = self.mapping(instance)
        part, context = instance.part, instance.part.context
        for condition in self.conditions:
            here = substitute(condition.holds, mapping)
            if here is E.TRUE or holds_always(here, context.draws):
                continue
            sides, bend = (
                None if pair is None else (substitute(pair[0], mapping), substitute(pair[1], mapping))
                for pair in (condition.sides, condition.bend)
            )
            place, message, name = part.span, condition.message, "the path"
            if bend is not None:
                curve = next((v for v in instance.values.values() if isinstance(v, Curve)), None)
                if curve is not None:
                    place, name = curve.statement.name_span, f"`{curve.name}`"
                message = f"{name} bends more tightly than its section allows"
            told, text = f"{part.path}: {message}", f"{part.path}: {condition.text}"
            number = context.require(instance.scope, here, place, told, sides=sides, text=text)
            context.stated[number] = place, False
            if bend is not None:
                context.bends[number] = Bend(name, place, part.path, part.span, *bend)


def blame(paths: tuple[Handed, ...], primitive: str) -> tuple[Span, str]:
    """Where the curves are written that give a primitive its shape, and the beginning of a message about them."""
    names = " and ".join(f"`{path.curve.name}`" for path in paths)
    verb = "is not a valid path" if len(paths) == 1 else "are not valid paths"
    return paths[0].curve.statement.name_span, f"{names} {verb} for `{primitive}`"
