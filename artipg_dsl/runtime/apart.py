"""``clear a from b by d``: parts that keep a distance, at rest and while each joint moves alone; ``all``: in every state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..graph.program import Clear
from .bodies import Pieces
from .floating import sites_within
from .together import least, ways
from .tree import Tree
from .validate import checked


def too_near(tree: Tree, body: Pieces) -> list[tuple[str, np.ndarray]]:
    """In words with the line, which of these statements do not hold, and the objects in which they do not."""
    found: list[tuple[str, np.ndarray]] = []
    program = tree.batch.program
    site = np.concatenate([np.full(len(t), t.number) for t in tree.batch.sites()]) if program.clear else None
    for statement in program.clear:
        assert site is not None
        part = sides(tree, body, statement, site[body.solid])
        rows = checked(tree, part)
        names: dict[str, list[int]] = {}
        for link, joint in zip(rows[:, 0].astype(int).tolist(), rows[:, 2].astype(int).tolist(), strict=True):
            when = "at rest" if joint < 0 else f"while {program.joints[tree.joints.definition[joint]].path} moves"
            names.setdefault(when, []).append(int(tree.links.owner[link]))
        if statement.whatever:
            way = ways(tree)
            way = way.at(np.flatnonzero((way.joint >= 0).sum(axis=1) > 1))
            met = least(tree, part, way, np.zeros(len(tree.joints.owner), dtype=bool))[1]
            if met.any():
                names["while several joints move"] = tree.links.owner[way.first[met]].tolist()
        found += [
            (f"{statement.where}: `{statement.text}` does not hold {when}", np.unique(o)) for when, o in names.items()
        ]
    return found


def sides(tree: Tree, body: Pieces, statement: Clear, site: np.ndarray) -> Pieces:
    """The pieces of the parts that a statement names, with their gap and side; boxes larger by half the gap."""
    program, batch = tree.batch.program, tree.batch
    owner = batch.owner(statement.scope)
    gap = np.full(len(batch), -1.0)  # where the statement says nothing
    np.maximum.at(gap, owner, batch.read([statement.distance], statement.scope)[0])
    one, two = (
        np.isin(site, sites_within(program, set(nodes))) & elements(tree, ranks)[body.solid]
        for nodes, ranks in zip((statement.first, statement.second), statement.ranks, strict=True)
    )
    side = one * 1 + two * 2
    rows = np.flatnonzero((side > 0) & (gap[body.owner] >= 0.0))
    part = body.part(rows)
    half = gap[part.owner][:, None] / 2
    return replace(part, low=part.low - half, high=part.high + half, gap=gap[part.owner], side=side[rows])


def elements(tree: Tree, wanted: tuple[tuple[str, int], ...]) -> np.ndarray:
    """Which primitives, by row of the tables of sites, belong to the elements of repeats that are meant."""
    batch, found = tree.batch, []
    for table in batch.sites():
        meant = np.ones(len(table), dtype=bool)
        for name, rank in batch.rowmap.ranks(batch.program.sites[table.number].scope):
            for repeat, number in wanted:
                if name.rpartition(".")[2] == repeat:
                    meant &= rank == number
        found.append(meant)
    return np.concatenate(found)
