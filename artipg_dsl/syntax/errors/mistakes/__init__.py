"""Syntax errors that people make, by example, a file per family. ``examples`` finds the message for an error by their sentences.

Out: ``MISTAKES``. Begin with ``base``.

    base            what a mistake has
    declaring       what a declaration is called, of which type it is and what it is given
    choosing        templates, their alternatives and their arguments
    blocks          blocks, their braces and the elements of a ``repeat``
    values          values, conditions, ranges and curves
    stating         the clauses of statements
    files           imports, materials and vocabularies
"""

from __future__ import annotations

from .base import Mistake
from .blocks import BLOCKS
from .choosing import CHOOSING
from .declaring import DECLARING
from .files import FILES
from .stating import STATING
from .values import VALUES

MISTAKES = (*DECLARING, *CHOOSING, *BLOCKS, *VALUES, *STATING, *FILES)

__all__ = ["MISTAKES", "Mistake"]
