"""The registry of diagnostic codes, a file per family. A new code is one entry in the file of its family.

Out: ``CODES`` by name, and ``explain`` for a terminal. Begin with ``base``.

    base                  what a code has
    reading, resolving    syntax and files; names and what they lead to
    stating               what a statement lacks, and what cannot stand in it
    values, structure     types, units and ranges; parts, roles, joints and labels
    solids                primitives and curves
    equations             what determines what, and what can never hold
    examples              what is wrong with the objects that `apgc check` draws
    advice                what is legal and perhaps not meant
"""

from __future__ import annotations

from textwrap import fill, indent

from .advice import ADVICE
from .base import Code
from .equations import EQUATIONS
from .examples import EXAMPLES
from .reading import READING
from .resolving import RESOLVING
from .solids import SOLIDS
from .stating import STATING
from .structure import STRUCTURE
from .values import VALUES

FAMILIES: dict[str, tuple[Code, ...]] = {
    "Files, modules, syntax": READING,
    "Names": (*RESOLVING, *STATING),
    "Values": VALUES,
    "Structure": STRUCTURE,
    "Primitives and curves": SOLIDS,
    "Equations and repeats": EQUATIONS,
    "Objects": EXAMPLES,
    "Advice": ADVICE,
}
"""The codes of each family, by its title."""
CODES: dict[str, Code] = {code.name: code for family in FAMILIES.values() for code in family}
"""All codes by name."""


def explain(name: str) -> str | None:
    """The long text of a code with its example, for a terminal; None for a name that is no code."""
    code = CODES.get(name)
    if code is None:
        return None
    parts = [f"{code.name}: {code.summary}", fill(code.text, 100)]
    if code.example:
        parts.append("For example:\n\n" + indent(code.example.rstrip(), "    "))
    return "\n\n".join(parts) + "\n"


__all__ = ["CODES", "FAMILIES", "Code", "explain"]
