"""What the tables of a few objects show that is perhaps not meant: how far joints move, how wide grasps open, how large things are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .diagnostics import Report
from .diagnostics.suggest import any_of
from .records import dataclass
from .source import Source, Span

if TYPE_CHECKING:
    from .graph.program import Where
    from .lower.program import Lowering
    from .runtime.batch import Batch

_NAMED = 6  # joints that a warning names
_SLACK = 1e-6  # radians or metres, by which rounding takes a joint out of its range
_FAR = 3.0  # times the size of its object: what slides farther than that has perhaps a wrong unit
_OFF = 0.5  # times the size of its link: what lies farther off than that has perhaps a wrong unit, too
_SMALL, _LARGE = 2e-3, 20.0  # metres: objects across which it is less or more have perhaps a wrong unit
_SHORT = 1e-3  # metres
_UNEVEN = 0.01  # of a size: by how much the two sizes of what a quarter turn leaves alike may differ, or more than others must


@dataclass(frozen=True, slots=True)
class Measured:
    """A few objects, and what is to be said of their tables; ``span``: where the category is declared."""

    batch: Batch
    lowering: Lowering
    span: Span
    report: Report

    def warn_of_measures(self) -> None:
        self.warn_rigid()
        self.warn_caught()
        self.warn_beyond()
        self.warn_far()
        self.warn_wide()
        self.warn_off()
        self.warn_odd_size()
        self.warn_asymmetric()
        self.warn_turned_twice()

    def follow(self) -> bool:
        """Whether every joint that follows another by a formula can; the first that cannot is reported."""
        from .runtime.curves import TurnsBack  # start-up

        if all(joint.curve is None for joint in self.batch.program.joints):
            return True
        try:
            self.batch.joints()
        except TurnsBack as wrong:
            words = wrong.message.split(": ", 1)[1]  # the report says where
            where = self.lowering.links.mimics[wrong.definition][1].span
            self.report.error("bad-mimic", where, words, hint=wrong.hint)
            return False
        return True

    def warn_rigid(self) -> None:
        """Name the joints of objects whose loops leave none of them to move."""
        loops, names, links = self.batch.loops, self.batch.joints().name, self.batch.links()
        if loops is None:
            return
        for number, (joints, follows) in enumerate(zip(loops.variable, loops.follows, strict=True)):
            there = joints >= 0
            if there.any() and follows[there].all():
                held = any_of([names[k] for k in joints[there][:_NAMED].tolist()], "and")
                pairs = links.definition[loops.link[:, loops.owner == number]].T.tolist()
                one, other = (f"`{self.batch.program.links[k].path}`" for k in pairs[0])
                self.report.warning(
                    "rigid-loop",
                    self.span,
                    f"no joint on the loops of `{self.batch.program.name}` can move: `close` determines {held}",
                    hint=f"it ties the link of {one} to that of {other}: a place lies on the link of the parts that its formula "
                    "names; a loop of four hinges with parallel axes moves, a triangle does not: add a joint, or `connect` the parts",
                )
                return

    def warn_caught(self) -> None:
        """Name joints with `positions` whose values closed loops determine, in every object that has them."""
        loops, joints, program = self.batch.loops, self.batch.joints(), self.batch.program
        if loops is None:
            return
        led = np.zeros(len(joints.name), dtype=bool)
        led[loops.variable[loops.follows]] = True
        drives = loops.driven(np.arange(len(led)))
        for number, joint in enumerate(program.joints):
            mine = np.flatnonzero(joints.definition == number)
            if joint.positions is not None and len(mine) and led[mine].all():
                lead = program.joints[joints.definition[drives[mine[0]]]].path
                self.report.warning(
                    "unknown-clause",
                    self._line(joint.where) or self.span,
                    f"the positions of `{joint.path}` have no effect: its closed loop determines where it is",
                    hint=f"drop them, or give them to `{lead}`, which drives the loop",
                )

    def warn_beyond(self) -> None:
        """Name joints that what they follow takes out of their own range, in every object that has them."""
        from .lower.solve.feasible import plain  # start-up

        joints = self.batch.joints()
        led = np.flatnonzero(joints.mimic >= 0)
        leader = np.searchsorted(joints.owner, joints.owner)[led] + joints.mimic[led]
        ends = [joints.multiplier[led] * end[leader] + joints.offset[led] for end in (joints.low, joints.high)]
        least, most = np.minimum(*ends), np.maximum(*ends)
        beyond = (least < joints.low[led] - _SLACK) | (most > joints.high[led] + _SLACK)
        endless = np.isnan(joints.low[leader]) & np.isfinite(joints.low[led]) & (joints.multiplier[led] != 0.0)
        beyond |= endless
        beyond_turned = endless | (-most < joints.low[led] - _SLACK) | (-least > joints.high[led] + _SLACK)
        for number, k in _always(joints.definition[led], beyond):
            joint = self.batch.program.joints[number]
            if joint.curve is not None:
                continue
            unit = "m" if joint.kind == "prismatic" else "rad"
            taken, own = (
                f"{plain(float(low), unit)} .. {plain(float(high), unit)}"
                for low, high in ((least[k], most[k]), (joints.low[led][k], joints.high[led][k]))
            )
            said = f"is taken through {taken}"
            hint = "widen its range, narrow that of what it follows, or change the factor or the offset"
            if not joints.offset[led][k] and not beyond_turned[k]:
                hint = "change the sign of its factor, or the signs of its range and its axis"
            if endless[k]:
                lead = self.batch.program.joints[joints.definition[leader[k]]].path
                said = f"follows `{lead}`, which turns without end"
                hint = f"give `{lead}` a range: `revolute ... range 0turn .. 3turn`"
            self.report.warning(
                "bad-mimic",
                self._line(joint.where) or self.span,
                f"`{joint.path}` {said}, and its range is {own}",
                hint=hint,
            )
        one_way = (np.abs(least + most) > _SLACK) & ((least > -_SLACK) | (most < _SLACK))
        for number, k in _always(joints.definition[led], one_way & ~beyond & ~beyond_turned):
            joint = self.batch.program.joints[number]
            unit = "m" if joint.kind == "prismatic" else "rad"
            if joint.curve is None and np.isfinite(joints.low[led][k]):
                taken = f"{plain(float(least[k]), unit)} .. {plain(float(most[k]), unit)}"
                self.report.warning(
                    "bad-mimic",
                    self._line(joint.where) or self.span,
                    f"`{joint.path}` is taken through {taken} alone, and its range has as much room on the other side",
                    hint=f"look at it with its joints open: if it goes the right way, state that range, `range {taken}`; "
                    "else change the sign of its factor",
                )

    def warn_far(self) -> None:
        """Name joints that slide much farther than their object is large, in every object that has them."""
        from .geometry.sites import object_boxes  # start-up
        from .lower.solve.feasible import plain  # start-up

        joints = self.batch.joints()
        way = joints.high - joints.low
        slides = np.array([kind == "prismatic" for kind in joints.kind], dtype=bool)
        if self.batch.program.closures or not np.any(slides & (way > _SHORT)):
            return  # in a loop, the ends only bound where it is sought
        low, high = object_boxes(self.batch.sites(), len(self.batch))
        size = np.linalg.norm(np.maximum(high - low, 0.0), axis=1)
        far = slides & (way > np.maximum(_SHORT, _FAR * size[joints.owner]))
        for number, k in _always(joints.definition, far):
            joint = self.batch.program.joints[number]
            self.report.warning(
                "far-motion",
                self._line(joint.where) or self.span,
                f"`{joint.path}` slides {plain(float(way[k]), 'm')}, and the whole object is about "
                f"{plain(float(f'{size[joints.owner[k]]:.2g}'), 'm')} across",
                hint="is the unit right? Shorten its range, or bound what the range is made of",
            )

    def warn_wide(self) -> None:
        """Name the grasps that open wider than a hand does, in every object that has them."""
        from .annotate.grasps import sample_grasps  # start-up
        from .annotate.gripper import find_wide  # start-up
        from .lower.solve.feasible import plain  # start-up

        if not self.batch.program.grasps:
            return
        for family, opening, stroke in find_wide(sample_grasps(self.batch)):
            grasp = self.batch.program.grasps[family]
            self.report.warning(
                "wide-grasp",
                self._line(grasp.where) or self.span,
                f"no hand makes the grasp `{grasp.name}`: it opens by {plain(float(f'{opening:.3g}'), 'm')} or more, "
                f"and the hand by {plain(stroke, 'm')}",
                hint="grasp where it is narrower, or state a larger hand, as in `opening size.y  stroke 20cm`",
            )

    def warn_off(self) -> None:
        """Name the keypoints and grasps that lie far off their link, in every object that has them."""
        from .annotate.grasps import place_keypoint, sample_grasps  # start-up
        from .geometry.sites import boxes_of_links  # start-up
        from .lower.solve.feasible import plain  # start-up

        program = self.batch.program
        if not (program.grasps or program.keypoints):
            return
        links, grasps = self.batch.links(), sample_grasps(self.batch)
        first = np.searchsorted(links.owner, np.arange(len(self.batch)))
        low, high = boxes_of_links(self.batch.sites(), first, len(links.owner))
        placed = []
        for each in program.keypoints:
            owner, point = place_keypoint(self.batch, each)
            number = self.batch.link_numbers(each.scope, each.link)
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
            self.report.warning(
                "far-off",
                self._line(where) or self.span,
                f"the {name} lies {plain(float(f'{gap[0]:.2g}'), 'm')} off the link of `{link}`, on which it is, "
                f"and which is about {plain(float(f'{size[0]:.2g}'), 'm')} across",
                hint="is the unit right? `at` is measured from the middle of what follows `on`, along its axes",
            )

    def warn_odd_size(self) -> None:
        """Name the largest part of objects most of which are as large as no furniture is, or as small."""
        from .geometry.sites import object_boxes  # start-up
        from .lower.solve.feasible import plain  # start-up

        tables = [table for table in self.batch.sites() if len(table)]
        if not tables:
            return
        boxes = object_boxes(tables, len(self.batch))
        size = np.linalg.norm(boxes[1] - boxes[0], axis=1)
        size = np.sort(size[np.isfinite(size)])
        usual = float(size[len(size) // 2])
        if _SMALL <= usual <= _LARGE:
            return
        spans = [np.linalg.norm(np.subtract(*table.boxes()), axis=1).max() for table in tables]
        largest = tables[int(np.argmax(spans))].path
        self.report.warning(
            "odd-size",
            self._of(largest) or self.span,
            f"a `{self.batch.program.name}` is about {plain(float(f'{usual:.2g}'), 'm')} across, `{largest}` "
            f"{plain(float(f'{max(spans):.2g}'), 'm')}",
            hint="is the unit right? Look at the ranges that the size is made of",
        )

    def warn_asymmetric(self) -> None:
        """Report parts that are said to look the same after a share of a turn, of which the box alone tells that they do not.

        A width comes again after that share and after half a turn; halfway between two that are alike it is less at most as a
        straight side makes it: that of a hexagon 0.866 times.
        """
        from .runtime.tables import plain_name  # start-up

        parts = self.batch.parts()
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
            self.report.warning(
                "bad-symmetry",
                self._of(path) or self.span,
                f"`{path}` does not look the same after {share} about its {about}: across it, it is {one} by {other} cm",
                hint="name what is round or square, with the axes of the part itself, or write `turn 2`",
            )

    def warn_turned_twice(self) -> None:
        """Report parts in a ring of more than two that are turned from one element to the next once more as the ring turns them."""
        for span, scope, *matrices in self.lowering.context.spun:
            if span.source is not self.span.source:
                continue
            owner = self.batch.owner(scope)
            turn, ring = (
                np.stack(self.batch.read([cell for row in matrix for cell in row], scope), axis=-1).reshape(-1, 3, 3)
                for matrix in matrices
            )
            first = np.searchsorted(owner, owner)
            off = np.abs(turn - ring @ ring[first].transpose(0, 2, 1) @ turn[first])
            share = np.trace(
                ring, axis1=1, axis2=2
            )  # 3 of the first element, -1 of a half turn, which is one either way
            if off.max(initial=0.0) < _SLACK and ((share > -1 + _SLACK) & (share < 3 - _SLACK)).any():
                self.report.warning(
                    "turned-again",
                    span,
                    "the ring has turned each element by this angle already, so the part is turned twice as far",
                    hint="leave the index out of the angle: in a `ring`, axes are those of the element",
                )

    def _of(self, path: str) -> Span | None:
        return place_of(self.lowering, path, self.span)

    def _line(self, where: Where | None) -> Span | None:
        return line_of(self.span.source, where)


def line_of(source: Source, where: Where | None) -> Span | None:
    """The whole of a line, if it is in ``source``, as a rule the file of the category."""
    if where is None or where.file != source.name:
        return None
    text = source.line(where.line)
    start = source.start(where.line) + len(text) - len(text.lstrip())
    return Span(source, start, start + len(text.strip()))


def place_of(lowering: Lowering, path: str, category: Span) -> Span | None:
    """Where the part with this path is declared, or the one that it is in, if that is in the file of the category."""
    while path:
        here = (part.span for part in lowering.context.parts if part.path == path)
        if found := next((span for span in here if span.source is category.source), None):
            return found
        path = path.rpartition(".")[0]
    return None


def _always(definition: np.ndarray, there: np.ndarray) -> Iterator[tuple[int, int]]:
    """The definitions (n,) of which each that there is has something, as ``there`` (n,) says, and the first place of each."""
    lacking = set(definition[~there].tolist())
    for number in sorted(set(definition.tolist()) - lacking):
        yield number, int(np.flatnonzero(definition == number)[0])
