"""What a few objects of a program show that is legal and perhaps not meant: what floats, collides, is buried, hardly ever valid or slow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .diagnostics import Report
from .diagnostics.suggest import any_of
from .records import dataclass
from .source import Span

if TYPE_CHECKING:
    from .graph.program import Where
    from .lower.elaborate.part import Component
    from .lower.program import Lowering
    from .runtime.batch import Batch
    from .validity.floating import Solids

_NAMED = 6  # parts that a warning names
_SLACK = 1e-6  # radians or metres, by which rounding takes a joint out of its range
_FAR = 3.0  # times the size of its object: what slides farther than that has perhaps a wrong unit
_OFF = 0.5  # times the size of its object: what lies farther off than that has perhaps a wrong unit, too
_SMALL, _LARGE = 2e-3, 20.0  # metres: objects across which it is less or more have perhaps a wrong unit
_SHORT = 1e-3  # metres
_APART = 1e-4  # metres: what is farther apart does not touch
_UNEVEN = 0.01  # of a size: by how much the two sizes of what a quarter turn leaves alike may differ, or more than others must


@dataclass(frozen=True, slots=True)
class Examined:
    """A few objects, and what is to be said of them; ``span``: where the category is declared."""

    batch: Batch
    lowering: Lowering
    span: Span
    report: Report

    def warn(self) -> None:
        from .geometry.errors import PrimitiveError  # start-up

        self.warn_excluded()
        if not self.follow():
            return
        self.warn_rigid()
        self.warn_caught()
        self.warn_beyond()
        self.warn_far()
        self.warn_wide()
        self.warn_off()
        self.warn_odd_size()
        self.warn_asymmetric()
        for look in (self.warn_of_cost, self.warn_untested, self.warn_invalid):
            try:
                look()
            except PrimitiveError:
                return  # told elsewhere, or when objects are drawn

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

    def warn_excluded(self) -> None:
        """Name the values of counts and choices that requirements leave hardly any object."""
        from .quality.excluded import find_excluded  # start-up

        told = {found.span for found in self.report.diagnostics if found.code in ("impossible", "undefined-value")}
        for one in find_excluded(self.batch):
            draw, column = self.batch.program.draws[one.draw], self.batch.program.draws[one.draw].column
            places = [self._stated(number) for number in one.requirements[:_NAMED]]
            spans = list(dict.fromkeys(span for span in places if span is not None))
            drawn = self.lowering.context.spans.get(column)
            own = [drawn] if drawn is not None and drawn.source is self.span.source else []
            if told.intersection(spans) or not (own or spans):
                continue
            value = f"`{draw.options[int(one.value)]}`" if draw.kind == "choice" else f"{one.value:.0f}"
            first = self.batch.program.requirements[one.requirements[0]]
            it = f"`{' '.join((first.text or first.message).split())}` ({first.where})"
            if spans:
                it = "this requirement"
                if not spans[0].text.startswith("require"):  # that of a primitive, which an argument breaks
                    it = f"what must hold here ({first.message})"
                if one.requirements[0] not in self.lowering.context.stated:
                    it = f"what must hold here ({first.message}{why_endless(self.lowering, one.requirements[0])})"
            why = (
                f"{'all' if not one.kept else f'{one.tried - one.kept} of'} {one.tried} objects tried with it break {it}"
                if one.tried
                else f"{it} leaves it out"
            )
            chain = [(span, "and this one, perhaps") for span in spans[1:]] + [(span, "drawn here") for span in own]
            self.report.warning(
                "excluded-value",
                (spans or own)[0],
                f"`{column.name}` is {'hardly ever' if one.kept else 'never'} {value}: {why}",
                hint="widen the ranges of what is required, or write `align` for an equation; "
                "if the value is not meant, leave it out of the range or the alternatives",
                notes=tuple(chain) if spans else (),
            )

    def _stated(self, requirement: int) -> Span | None:
        """Where a requirement is written, if that is in the file of the category."""
        stated = self.lowering.context.stated.get(requirement)
        span = self._line(self.batch.program.requirements[requirement].where) if stated is None else stated[0]
        return span if span is not None and span.source is self.span.source else None

    def warn_floating(self, solids: Solids) -> None:
        """Report the parts that float in each of the objects that have them: none of those is ever valid."""
        from .validity.adrift import find_adrift  # start-up
        from .validity.floating import alone  # start-up

        links = find_adrift(solids)
        paths, floating = solids.paths(), set(links)
        here = [part for part in self.lowering.context.parts if part.span.source is self.lowering.root.module.source]
        for whole in (True, False):  # what floats as a whole is told as one part, else the innermost part of the file
            for part in sorted(here, key=lambda part: part.path.count("."), reverse=not whole):
                within = f"{part.path}."
                own = {path for path in floating if f"{path}.".startswith(within)}
                if not own or whole and any(f"{path}.".startswith(within) and path not in own for path in paths):
                    continue
                floating -= own
                first = min(own, key=list(links).index)
                self.report.warning(
                    "floating-part",
                    part.span,
                    alone(first, links[first]),
                    hint=f'{self._how_to_hold(part, solids)}; if that is meant, write `allow floating {part.name} because "..."`',
                )

    def warn_coincident(self) -> None:
        """Report parts of which elements of a repeat fill the same space: they look like one."""
        from .validity.twins import find_twins  # start-up

        twins = find_twins(self.batch)
        for part in self.lowering.context.parts:
            own = [path for path in twins if path == part.path or path.startswith(f"{part.path}.")]
            if own and part.span.source is self.lowering.root.module.source:
                twins = [path for path in twins if path not in own]
                repeat = part.path.split(".")[-2] if "." in part.path else "row"
                self.report.warning(
                    "coincident",
                    part.span,
                    f"elements of `{own[0]}` fill the same space, in every object examined",
                    hint=f"place it by what differs between elements, such as `align {part.name}.center.y = {repeat}.center.y`; "
                    "in a `ring` or a `mirror`, move it off the axis or the plane",
                )

    def warn_buried(self) -> None:
        """Report parts of which all, or some elements of a repeat, lie inside another part of their link: nothing of them is seen."""
        from .validity.buried import find_buried  # start-up

        buried, told = find_buried(self.batch), set[str]()
        unplaced = {found.span for found in self.report.diagnostics if found.code == "unplaced"}
        sites = {table.path: table for table in self.batch.sites()}
        for part in sorted(self.lowering.context.parts, key=lambda part: part.path.count(".")):
            own = [path for path in sites if f"{path}.".startswith(f"{part.path}.")]
            if part.span.source is not self.span.source or not own or not buried.keys() >= {*own} or told & {*own}:
                continue
            told |= {*own}
            by, rows = buried[own[0]]
            mirror = sites[own[0]].mirror
            if part.span in unplaced:
                continue  # told, with its cause
            said, hint = f"nothing of `{part.path}` is seen: it lies", f"place it on a face of `{by}`, or leave it out"
            if not rows.all():
                said = f"some elements of `{part.path}` lie"
                if len(set(mirror[rows])) == len(set(mirror[~rows])) == 1 and mirror[rows][0] != mirror[~rows][0]:
                    said = f"one of the two halves of `{part.path}` lies"
                    hint = "a `mirror` is across the plane through the origin of what it stands in, not through the middle of another part: "
                    hint += "state the half on the positive side, by its distance from that plane"
            self.report.warning("buried", part.span, f"{said} inside `{by}`, in every object examined", hint=hint)

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

    def _how_to_hold(self, part: Component, solids: Solids) -> str:
        """What to write so that a part that floats touches its link. Axes along which it reaches what carries it are not to blame."""
        from .lower.values.kinds import part_of  # start-up
        from .validity.adrift import find_gaps  # start-up

        free = self.lowering.context.centred.get(part, set())
        carrier = next((part_of(other).path for attachment in part.attachments for other in attachment.to), None)
        gaps = None if carrier is None else find_gaps(solids, part.path, carrier)
        apart = set() if gaps is None else set(np.flatnonzero(gaps > _APART).tolist())
        if gaps is not None and apart and not apart & free:
            away = " and ".join(f"{1000 * gaps[axis]:.3g} mm along {'xyz'[axis]}" for axis in sorted(apart))
            return f"it is {away} from `{carrier}`: bring the two together, or attach it to what it does touch"
        axes = ["xyz"[axis] for axis in sorted(free & apart if apart else free)]
        if not 0 < len(axes) < 3:
            return f"place it {how_to_place(part)}, or attach it to what it does touch"
        return (
            f"nothing places it along {' and '.join(axes)}, where it is centred by default: "
            f"say where with `align`; behind `on` a face, `at center` puts it in the middle of that face"
        )

    def warn_invalid(self) -> None:
        """Report parts that float, links that collide at rest in each of the objects that have both, and other faults that all
        objects have."""
        from .runtime.tables import plain_name  # start-up
        from .validity.bodies import gather  # start-up
        from .validity.floating import Solids  # start-up
        from .validity.stuck import find_never, find_stuck  # start-up
        from .validity.tree import Tree  # start-up

        tree = Tree(self.batch)
        body = gather(self.batch, tree.first, tree.turn, tree.shift)
        solids = Solids(tree, body)
        self.warn_floating(solids)
        self.warn_coincident()
        self.warn_buried()
        for stuck in find_stuck(tree, body):
            one, other = (plain_name(part) for part in stuck.parts)
            on = [
                f"`{part}` is on the link of `{link}`"
                for part, link in zip((one, other), stuck.links, strict=True)
                if part != link and not part.startswith(f"{link}.")
            ]
            self.report.warning(
                "colliding-links",
                self._later(one, other),
                f"`{stuck.parts[0]}` and `{stuck.parts[1]}` overlap with all joints at rest, in every object examined that has both"
                + (f" ({' and '.join(on)})" if on else ""),
                hint="leave a gap, as in `align lid.bottom = body.top + 1mm`; "
                f'if the overlap is meant, write `allow overlap {one}, {other} because "..."`',
            )
        for fault in find_never(solids):
            span = self._line(fault.where)
            told = fault.what if span or fault.where is None else fault.words
            self.report.warning(
                "never-valid",
                span or self._of(fault.part or "") or self.span,
                f"{told}, in every object examined",
                hint=f"no object would be valid{': ' * bool(fault.example)}{fault.example}; "
                "`apgc render --unchecked` draws some as they are",
            )

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
        for number in np.unique(joints.definition[led]).tolist():
            mine = joints.definition[led] == number
            joint = self.batch.program.joints[number]
            if joint.curve is not None or not beyond[mine].all():
                continue
            k, unit = int(np.flatnonzero(mine)[0]), "m" if joint.kind == "prismatic" else "rad"
            taken, own = (
                f"{plain(float(low), unit)} .. {plain(float(high), unit)}"
                for low, high in ((least[k], most[k]), (joints.low[led][k], joints.high[led][k]))
            )
            said = f"is taken through {taken}"
            hint = "widen its range, narrow that of what it follows, or change the factor or the offset"
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
        for number in np.unique(joints.definition[far]).tolist():
            mine = joints.definition == number
            joint = self.batch.program.joints[number]
            if not far[mine].all():
                continue
            k = int(np.flatnonzero(mine)[0])
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
        """Name the keypoints and grasps that lie far off their object, in every object that has them."""
        from .annotate.grasps import place_keypoint, sample_grasps  # start-up
        from .geometry.sites import object_boxes  # start-up
        from .lower.solve.feasible import plain  # start-up

        program = self.batch.program
        if not (program.grasps or program.keypoints):
            return
        low, high = object_boxes(self.batch.sites(), len(self.batch))
        grasps = sample_grasps(self.batch)
        placed = [
            *((f"keypoint `{each.name}`", each.where, *place_keypoint(self.batch, each)) for each in program.keypoints),
            *(
                (f"grasp `{each.name}`", each.where, grasps.owner[own], grasps.point[own])
                for number, each in enumerate(program.grasps)
                for own in [grasps.family == number]
            ),
        ]
        for name, where, owner, point in placed:
            gap = np.linalg.norm(np.maximum(np.maximum(low[owner] - point, point - high[owner]), 0.0), axis=1)
            size = np.linalg.norm(high[owner] - low[owner], axis=1)
            if not len(owner) or not (gap > _OFF * size).all():
                continue
            self.report.warning(
                "far-off",
                self._line(where) or self.span,
                f"the {name} lies {plain(float(f'{gap[0]:.2g}'), 'm')} off its object, "
                f"which is about {plain(float(f'{size[0]:.2g}'), 'm')} across",
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

    def warn_of_cost(self) -> None:
        """Name the parts that the check of an object takes long for."""
        from .quality.cost import find_heavy, measure_costs  # start-up

        for cost in find_heavy(measure_costs(self.batch)):
            pairs = f", and {cost.pairs:.0f} pairs of them with pieces on other links" if cost.pairs >= 1 else ""
            if cost.shared >= 1:
                pairs += f", and {cost.shared:.0f} pairs of primitives that may overlap, which `require stable` weighs"
            self.report.warning(
                "expensive-check",
                self.span,
                f"`{cost.part}` has {cost.pieces:.0f} convex pieces in an object{pairs}: its check takes long",
                hint="use fewer or simpler primitives, or `--unchecked`; `apgc profile` shows all parts",
            )

    def warn_untested(self) -> None:
        """Name the primitives whose box does not hold them at values that their `test` ranges leave out."""
        from .quality.untested import find_untested  # start-up

        for wrong in find_untested(self.batch):
            low, high = wrong.test
            what = "a convex piece of " if wrong.piece else ""
            self.report.warning(
                "untested-values",
                self._of(wrong.part) or self.span,
                f"{what}`{wrong.part}` reaches {1000 * wrong.reach:.3g} mm out of its box: here `{wrong.parameter}` of `{wrong.primitive}` "
                f"is {wrong.value:.4g}, and its `test` range is {low:.4g} .. {high:.4g} (a length in metres, an angle in radians)",
                hint=f"give it a value in that range; if `{wrong.primitive}` is your own, state a wider `test low .. high` of "
                f"`{wrong.parameter}`, since its box is made for the values tested",
            )

    def _of(self, path: str) -> Span | None:
        return place_of(self.lowering, path, self.span)

    def _later(self, *paths: str) -> Span:
        """Where the last of these parts in the text is declared: it came to those before it. Of parts in templates that is the
        part of the category that they are in, whose place is told there, unless it is the same for all."""
        for within in (self._around, self._of):
            spans = [span for path in paths if (span := within(path)) is not None]
            if len(set(spans)) == len(set(paths)):
                break
        return max(spans, key=lambda span: span.start, default=self.span)

    def _around(self, path: str) -> Span | None:
        """Where the part of the category is declared that the part with this path is in."""
        parts = (part for part in self.lowering.context.parts if f"{path}.".startswith(f"{part.path}."))
        return min(parts, key=lambda part: len(part.path)).span

    def _line(self, where: Where | None) -> Span | None:
        """The whole of a line, if it is in the file of the category."""
        source = self.span.source
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


def why_endless(lowering: Lowering, requirement: int) -> str:
    """The operation that may make the number infinite that a requirement is about."""
    from .graph.defined import PARTIAL  # start-up

    if requirement not in lowering.context.endless:
        return ""
    span, op = lowering.context.endless[requirement]
    return f"; `{span.words}` has no value, or a very large one: {PARTIAL[op]}"


def how_to_place(part: Component) -> str:
    """How a part is placed that has its attachment already: a joint places by its own faces, a second `connect` is an error."""
    mount = next(_mounts(part), None)
    if any(attachment.joint is not None for attachment in part.attachments):
        by = "faces" if mount is None else "its port and another"
        return f"with `align`, or by {by} in its joint, as in `... -> {part.name}.{mount or 'bottom'}`"
    return f"with `connect {part.name}.{'bottom on' if mount is None else f'{mount} to'} ...` or `align`"


def _mounts(part: Component) -> Iterator[str]:
    """The ports by which a part can be mounted, whatever it is."""
    from .lower.values.kinds import Frame  # start-up
    from .syntax import ast  # start-up

    bodies = [instance.symbol.body for instance in part.instances]
    for port in bodies[0] if bodies else ():
        if isinstance(port, ast.PortDecl) and port.index is None:
            shared = all(any(isinstance(s, ast.PortDecl) and s.name == port.name for s in body) for body in bodies)
            if shared and isinstance(part.own(port.name), Frame):
                yield port.name
