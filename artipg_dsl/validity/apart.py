"""``clear a from b by d``: parts that keep a distance, at rest and while each joint moves alone; ``all``: in every state."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..graph.program import Clear
from .bodies import Pieces
from .fault import Fault
from .meant import find_meant, sites_of
from .together import least_share, list_ways
from .tree import Tree
from .validate import find_meetings


def find_too_near(tree: Tree, body: Pieces) -> list[Fault]:
    """Which of these statements do not hold."""
    found: list[Fault] = []
    program = tree.batch.program
    for statement in program.clear:
        part = _sides(tree, body, statement)
        rows = find_meetings(tree, part)
        names: dict[str, list[int]] = {}
        for link, joint in zip(rows[:, 0].astype(int).tolist(), rows[:, 2].astype(int).tolist(), strict=True):
            when = "at rest" if joint < 0 else f"while {program.joints[tree.joints.definition[joint]].path} moves"
            names.setdefault(when, []).append(int(tree.links.owner[link]))
        if statement.whatever:
            way = list_ways(tree)
            way = way.at(np.flatnonzero((way.joint >= 0).sum(axis=1) > 1))
            met = least_share(tree, part, way, np.zeros(len(tree.joints.owner), dtype=bool))[1]
            if met.any():
                names["while several joints move"] = tree.links.owner[way.first[met]].tolist()
        words = f"`{statement.text}` does not hold"
        found += [Fault(f"{words} {when}", np.unique(owners), statement.where) for when, owners in names.items()]
    return found


def _sides(tree: Tree, body: Pieces, statement: Clear) -> Pieces:
    """The pieces of the parts that a statement names, with their gap, side and group; boxes larger by half the gap."""
    batch = tree.batch
    distance = batch.read([statement.distance], statement.scope)[0]
    count = sum(len(table) for table in batch.sites())
    repeats = sum(scope.kind == "repeat" for scope in statement.scope.ancestors())
    side, gap, group = np.zeros(count, dtype=np.int64), np.full(count, -1.0), np.full((count, repeats), -1)
    for bit, nodes, ranks in zip((1, 2), (statement.first, statement.second), statement.ranks, strict=True):
        named, start = find_meant(batch, statement, nodes, ranks, distance), 0
        for table, (rows, of) in zip(batch.sites(), sites_of(batch, named.row), strict=True):
            at = start + rows
            side[at] |= bit
            gap[at] = np.maximum(gap[at], named.value[of])
            group[at] = named.group[of]
            start += len(table)
    rows = np.flatnonzero(side[body.solid] > 0)
    part = body.part(rows)
    solid = body.solid[rows]
    half = gap[solid][:, None] / 2
    return replace(
        part, low=part.low - half, high=part.high + half, gap=gap[solid], side=side[solid], group=group[solid]
    )
