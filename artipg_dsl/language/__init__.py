"""The language's own words: what it calls its types, functions and members, what each takes and gives, and what each is for.

In: nothing. Out: tables of records, from which the checker takes its rules, lowering the meaning, messages what to suggest and
the reference its pages; completion and hovering in an editor could be made of them as they are. A word that is in no table is
unknown to all of them. Begin with ``functions``.

    functions     sin, min, frame, circle, pushes ...: the forms in which each is called
    members       what may follow a dot: faces of a box, coordinates of a point
    kinds         kinds of joints, forms of a repeat, operators on curves, distributions: what each needs and takes
    words         types, axes, constants, and what may be declared
    tables        the tables in Markdown, for the language reference
"""

from .functions import FORMS, FUNCTIONS, METHODS, Form, Parameter
from .kinds import DISTRIBUTIONS, JOINTS, OPERATORS, REPEATS, WEIGHTED, Kind
from .members import FACES, MEMBERS, OWN, Member
from .words import DIRECTIONS, NUMBERS, TYPES, WORDS, Word, reserved_name

__all__ = [
    "DIRECTIONS",
    "DISTRIBUTIONS",
    "FACES",
    "FORMS",
    "FUNCTIONS",
    "JOINTS",
    "MEMBERS",
    "METHODS",
    "NUMBERS",
    "OPERATORS",
    "OWN",
    "REPEATS",
    "TYPES",
    "WEIGHTED",
    "WORDS",
    "Form",
    "Kind",
    "Member",
    "Parameter",
    "Word",
    "reserved_name",
]
