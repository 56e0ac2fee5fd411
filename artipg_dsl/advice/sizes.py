"""Sizes, places and turns that have perhaps a wrong unit or a wrong axis."""

from __future__ import annotations

import numpy as np

from ..geometry.sites import boxes_of_links, object_boxes
from ..lower.solve.feasible import plain
from ..runtime.tables import plain_name
from .seen import Seen

_SLACK = 1e-6  # of what a turn has in its matrix
_OFF = 0.5  # times the size of its link: what lies farther off than that has perhaps a wrong unit
_SMALL, _LARGE = 2e-3, 20.0  # metres: objects across which it is less or more have perhaps a wrong unit
_UNEVEN = 0.01  # of a size: by how much the two sizes of what a quarter turn leaves alike may differ, or more than others must


def warn_wide(seen: Seen) -> None:
    """Name the grasps that open wider than a hand does, in every object that has them."""
    from ..annotate.grasps import sample_grasps  # start-up
    from ..annotate.gripper import find_wide  # start-up

    if not seen.batch.program.grasps:
        return
    for family, opening, stroke in find_wide(sample_grasps(seen.batch)):
        grasp = seen.batch.program.grasps[family]
        seen.report.warning(
            "wide-grasp",
            seen.line(grasp.where) or seen.span,
            f"no hand makes the grasp `{grasp.name}`: it opens by {plain(float(f'{opening:.3g}'), 'm')} or more, "
            f"and the hand by {plain(stroke, 'm')}",
            hint="grasp where it is narrower, or state a larger hand, as in `opening size.y  stroke 20cm`",
        )


def warn_off(seen: Seen) -> None:
    """Name the keypoints and grasps that lie far off their link, in every object that has them."""
    from ..annotate.grasps import place_keypoint, sample_grasps  # start-up

    program = seen.batch.program
    if not (program.grasps or program.keypoints):
        return
    links, grasps = seen.batch.links(), sample_grasps(seen.batch)
    first = np.searchsorted(links.owner, np.arange(len(seen.batch)))
    low, high = boxes_of_links(seen.batch.sites(), first, len(links.owner))
    placed = []
    for each in program.keypoints:
        owner, point = place_keypoint(seen.batch, each)
        number = seen.batch.link_numbers(each.scope, each.link)
        placed.append((f"keypoint `{each.name}`", each.where, first[owner] + number, point))
    for family, grasp in enumerate(program.grasps):
        own = grasps.family == family
        row = first[grasps.owner[own]] + grasps.link[own]
        placed.append((f"grasp `{grasp.name}`", grasp.where, row, grasps.point[own]))
    for name, where, row, point in placed:
        row, point = row[np.isfinite(low[row, 0])], point[np.isfinite(low[row, 0])]
        gap = np.linalg.norm(np.maximum(np.maximum(low[row] - point, point - high[row]), 0.0), axis=1)
        size = np.linalg.norm(high[row] - low[row], axis=1)
        if not len(row) or not (gap > _OFF * size).all():
            continue
        link = program.links[links.definition[row[0]]].path
        seen.report.warning(
            "far-off",
            seen.line(where) or seen.span,
            f"the {name} lies {plain(float(f'{gap[0]:.2g}'), 'm')} off the link of `{link}`, on which it is, "
            f"and which is about {plain(float(f'{size[0]:.2g}'), 'm')} across",
            hint="is the unit right? `at` is measured from the middle of what follows `on`, along its axes",
        )


def warn_odd_size(seen: Seen) -> None:
    """Name the largest part of objects most of which are as large as no furniture is, or as small."""
    tables = [table for table in seen.batch.sites() if len(table)]
    if not tables:
        return
    boxes = object_boxes(tables, len(seen.batch))
    size = np.linalg.norm(boxes[1] - boxes[0], axis=1)
    size = np.sort(size[np.isfinite(size)])
    usual = float(size[len(size) // 2])
    if _SMALL <= usual <= _LARGE:
        return
    spans = [np.linalg.norm(np.subtract(*table.boxes()), axis=1).max() for table in tables]
    largest = tables[int(np.argmax(spans))].path
    seen.report.warning(
        "odd-size",
        seen.of(largest) or seen.span,
        f"a `{seen.batch.program.name}` is about {plain(float(f'{usual:.2g}'), 'm')} across, `{largest}` "
        f"{plain(float(f'{max(spans):.2g}'), 'm')}",
        hint="is the unit right? Look at the ranges that the size is made of",
    )


def warn_asymmetric(seen: Seen) -> None:
    """Report parts that are said to look the same after a share of a turn, of which the box alone tells that they do not.

    A width comes again after that share and after half a turn; halfway between two that are alike it is less at most as a
    straight side makes it: that of a hexagon 0.866 times.
    """
    parts = seen.batch.parts()
    turns, axis = parts.symmetry.T
    size = np.take_along_axis(parts.high - parts.low, (axis[:, None] + [1, 2]) % 3, axis=1)
    folds = np.maximum(turns, 1)
    slimmest = np.where(turns % 4 == 0, 1.0, np.cos(np.pi / np.where(turns % 2 == 0, folds, 2 * folds)))
    uneven = (turns >= 0) & (size.min(axis=1) < (slimmest - _UNEVEN) * size.max(axis=1))
    for definition in sorted(set(parts.definition[uneven].tolist())):
        rows = np.flatnonzero((parts.definition == definition) & (turns >= 0))
        if not uneven[rows].all():
            continue
        path, about = plain_name(parts.name[rows[0]]), "xyz"[axis[rows[0]]]
        one, other = (f"{100 * length:.3g}" for length in size[rows[0]].tolist())
        share = "a quarter turn" if turns[rows[0]] % 4 == 0 else f"1/{turns[rows[0]]} of a turn"
        seen.report.warning(
            "bad-symmetry",
            seen.of(path) or seen.span,
            f"`{path}` does not look the same after {share} about its {about}: across it, it is {one} by {other} cm",
            hint="name what is round or square, with the axes of the part itself, or write `turn 2`",
        )


def warn_turned_twice(seen: Seen) -> None:
    """Report parts in a ring of more than two that are turned from one element to the next once more as the ring turns them."""
    for span, scope, *matrices in seen.lowering.context.spun:
        if span.source is not seen.span.source:
            continue
        owner = seen.batch.owner(scope)
        turn, ring = (
            np.stack(seen.batch.read([cell for row in matrix for cell in row], scope), axis=-1).reshape(-1, 3, 3)
            for matrix in matrices
        )
        first = np.searchsorted(owner, owner)
        off = np.abs(turn - ring @ ring[first].transpose(0, 2, 1) @ turn[first])
        share = np.trace(ring, axis1=1, axis2=2)  # 3 of the first element, -1 of a half turn, which is one either way
        if off.max(initial=0.0) < _SLACK and ((share > -1 + _SLACK) & (share < 3 - _SLACK)).any():
            seen.report.warning(
                "turned-again",
                span,
                "the ring has turned each element by this angle already, so the part is turned twice as far",
                hint="leave the index out of the angle: in a `ring`, axes are those of the element",
            )
