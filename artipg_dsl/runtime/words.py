"""The words of the vocabulary ``semantic`` that parts and links bear, by their places in it, 0 for none."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ..graph.expr import Expr, Scope
from ..graph.program import Link, Program
from .tables import Rowmap

Read = Callable[[Sequence[Expr], Scope], list[np.ndarray]]


def words_of_parts(program: Program, rowmap: Rowmap, read: Read) -> list[np.ndarray]:
    """For each part of the program (rows of its scope,) the place of its word; ``read`` evaluates expressions for rows of a scope."""
    words = program.vocabularies.get("semantic", ())
    found = []
    for part in program.parts:
        said = np.zeros(rowmap.rows(part.scope).size, dtype=np.int64)
        for (word, _), holds in zip(part.semantic, read([p for _, p in part.semantic], part.scope), strict=True):
            said = np.where(holds, words.index(word), said)
        found.append(said)
    return found


def words_of_link(program: Program, rowmap: Rowmap, of_parts: Sequence[np.ndarray], link: Link) -> np.ndarray:
    """(rows of the link's scope,) the place of the word of the part that the link is, whichever of its alternatives that is; else
    of the word that the program gives the link as such. ``of_parts`` are the words of all parts."""
    found = np.zeros(rowmap.rows(link.scope).size, dtype=np.int64)
    if link.part < 0:
        return found
    own = program.parts[link.part]
    for words, part in zip(of_parts, program.parts, strict=True):
        if part.path == own.path and part.scope.within(link.scope):
            found[rowmap.across(part.scope, link.scope)] = words
        elif part.path == own.path and link.scope.within(part.scope):
            found = words[rowmap.across(link.scope, part.scope)]
    usual = program.vocabularies["semantic"].index(own.word) if own.word else 0
    return np.where(found == 0, usual, found)
