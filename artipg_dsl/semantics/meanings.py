"""What the names of a program stand for, decided once by the checker and read by the lowering.

A ``Meaning`` belongs to a place in the text, not to a use of its template: it says in which body a name is declared, by
the number of repeats around that body, and never which value it has there.
"""

from __future__ import annotations

from dataclasses import field

from ..language import Form
from ..records import dataclass
from .symbols import Symbol
from .types import UNKNOWN, Type, sort_of


@dataclass(frozen=True, slots=True)
class Meaning:
    """Base of all meanings."""


@dataclass(frozen=True, slots=True)
class Local(Meaning):
    """A name that only this place has: a parameter of a function, or ``p`` and ``n`` of a formula on a surface."""

    name: str


@dataclass(frozen=True, slots=True)
class Declared(Meaning):
    """A declaration of a body that has ``depth`` repeats around it; in branches of ``when`` there may be several."""

    name: str
    depth: int


@dataclass(frozen=True, slots=True)
class Current(Meaning):
    """The element in which this stands, of the repeat whose body has ``depth`` repeats around it, itself included."""

    depth: int


@dataclass(frozen=True, slots=True)
class Previous(Meaning):
    """The element before that one."""

    depth: int


@dataclass(frozen=True, slots=True)
class Global(Meaning):
    """A declaration of a file: a function, a material, a template or role as a style."""

    symbol: Symbol


@dataclass(frozen=True, slots=True)
class BuiltIn(Meaning):
    """A function of the language, in the form in which it is called here."""

    form: Form


@dataclass(frozen=True, slots=True)
class OwnBox(Meaning):
    """A face, ``center``, ``size`` or ``box`` of the box of the template itself."""

    member: str


@dataclass(frozen=True, slots=True)
class Feature(Meaning):
    """What stands after a dot and is the language's own: a face, ``size``, ``out``, ``x``, the ``gap`` of an element."""

    member: str


@dataclass(frozen=True, slots=True)
class Inner(Meaning):
    """What stands after a dot and is declared: by the template or primitive of a part, in the body of an element.

    ``without``: alternatives that there are not here and that declare something else by this name. ``kind``: what it is here, of an
    alternative's own; in a function, for the argument of the call that was looked at last.
    """

    name: str
    without: frozenset[Symbol] = field(default=frozenset(), compare=False)
    kind: Type = field(default=UNKNOWN, compare=False)

    def alike(self, other: Inner) -> bool:
        """Whether one text may mean both: where either leaves alternatives out, what is left has to be of one sort."""
        left_out, known = self.without | other.without, UNKNOWN not in (self.kind, other.kind)
        return not left_out or not known or sort_of(self.kind) == sort_of(other.kind)


@dataclass(frozen=True, slots=True)
class Axis(Meaning):
    """The direction x, y or z."""

    number: int


@dataclass(frozen=True, slots=True)
class Constant(Meaning):
    """``true``, ``false`` or ``pi``."""

    value: float | bool


@dataclass(frozen=True, slots=True)
class Word(Meaning):
    """One of the words of a choice."""

    text: str


@dataclass(frozen=True, slots=True)
class Base(Meaning):
    """``base``: what the template is attached to."""


@dataclass(frozen=True, slots=True)
class Last(Meaning):
    """``last``, as an index: the last element of a repeat."""


@dataclass(frozen=True, slots=True)
class Clearance(Meaning):
    """``clearance``, as an end of a range of motion: as far as nothing is in the way."""
