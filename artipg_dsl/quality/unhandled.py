"""Joints that no label says how to move: neither what they carry nor what follows them has a word beside what it is."""

from __future__ import annotations

import numpy as np

from ..annotate.interactions import find_possible
from ..validity.tree import Tree

_NAMING = ("semantic", "field")  # vocabularies that say what a surface is


def find_unhandled(tree: Tree) -> list[int]:
    """The definitions of the joints that move by themselves and of which, in no object of the batch, anything that they carry or
    lead has a label of an affordance; none of a program that says of no joint how to move it."""
    batch = tree.batch
    labels = [label for label in batch.program.labels if label.vocabulary not in _NAMING]
    held = np.zeros(len(tree.above), dtype=bool)
    tables = batch.sites()
    for (_, target), may in find_possible(batch, labels).items():
        table = tables[target.site]
        held[(tree.first[table.owner] + table.link)[may]] = True
    chain = tree.chain[held]
    held[chain[chain >= 0]] = True
    handled = np.zeros(len(tree.leader), dtype=bool)
    np.logical_or.at(handled, tree.leader, held[tree.child])
    if not handled.any():
        return []
    definition = tree.joints.definition
    alone = (tree.leader == np.arange(len(tree.leader))) & (np.array(tree.joints.kind, dtype=object) != "fixed")
    moving = set(definition[alone].tolist())
    return sorted(moving - set(definition[handled].tolist()))
