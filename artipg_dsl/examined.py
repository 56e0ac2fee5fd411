"""What a few objects of a program show that is legal and perhaps not meant: what floats, collides, is buried, hardly ever valid or slow."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from .measured import Measured
from .records import dataclass
from .source import Span

if TYPE_CHECKING:
    from .lower.elaborate.part import Component
    from .lower.program import Lowering
    from .validity.floating import Solids
    from .validity.stuck import Stuck
    from .validity.tree import Tree
    from .validity.validate import Collisions

_NAMED = 6  # parts that a warning names
_APART = 1e-4  # metres: what is farther apart does not touch
_OF_ALL = {"floating-part", "colliding-links", "never-valid"}  # what is told of each of the objects
_ROUND = (
    "turn its axis round, as by `lid.back.bottom` for `lid.bottom.back`, or the signs of its range",
    "let it slide the other way, as by `along -x` for `along x`",
)


@dataclass(frozen=True, slots=True)
class Examined(Measured):
    """A few objects, and what is to be said of them and of their solids."""

    def warn(self) -> None:
        from .geometry.errors import PrimitiveError  # start-up

        self.warn_excluded()
        if not self.follow():
            return
        self.warn_of_measures()
        for look in (self.warn_of_cost, self.warn_untested, self.warn_invalid, self.warn_lifting):
            try:
                look()
            except PrimitiveError:
                return  # told elsewhere, or when objects are drawn

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

    def warn_lifting(self) -> None:
        """Report labels of what is pressed on surfaces that their joint can only move outwards from rest."""
        from .quality.dead import find_lifting  # start-up

        program = self.batch.program
        pressed = [each for each in program.labels if each.name == "press" and self._line(each.where) is not None]
        for label, joint in find_lifting(self.batch, pressed) if pressed else ():
            self.report.warning(
                "idle-press",
                self._line(label.where) or self.span,
                f"no press moves what is labelled `{label.vocabulary}.press` here: from rest, "
                f"`{program.joints[joint].path}` moves it out of its surface alone",
                hint="exchange the signs of the range of the joint, turn its axis round, or label the face on the other side",
            )

    def warn_unhandled(self, tree: Tree) -> None:
        """Report joints that no label of an affordance is about, of programs that say of others how to move them."""
        from .quality.unhandled import find_unhandled  # start-up

        for number in find_unhandled(tree):
            joint = self.batch.program.joints[number]
            self.report.warning(
                "missing-affordance",
                self._line(joint.where) or self.span,
                f"no label says how to move `{joint.path}`: nothing that it carries has an affordance",
                hint=f"write for example `label affordance.{'slide' if joint.kind == 'prismatic' else 'turn'} on ...` for what a hand takes; "
                "if another joint drives it, give it a `mimic`",
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
        from .validity.axes import find_far_axes, find_loose_loops  # start-up
        from .validity.bodies import gather  # start-up
        from .validity.floating import Solids  # start-up
        from .validity.flush import find_flush  # start-up
        from .validity.stance import find_unasked, name_feet  # start-up
        from .validity.stuck import find_driven, find_meeting, find_never, find_stuck  # start-up
        from .validity.tree import Tree  # start-up

        tree = Tree(self.batch)
        body = gather(self.batch, tree.first, tree.turn, tree.shift)
        solids = Solids(tree, body)
        self.warn_floating(solids)
        self.warn_coincident()
        self.warn_buried()
        found = find_meeting(tree, body)
        for stuck in find_stuck(tree, body, found):
            one, other = (plain_name(part) for part in stuck.parts)
            self.report.warning(
                "colliding-links",
                self._later(one, other),
                f"`{stuck.parts[0]}` and `{stuck.parts[1]}` overlap with all joints at rest, in every object examined that has both"
                + _on_links(stuck),
                hint="leave a gap, as in `align lid.bottom = body.top + 1mm`; "
                f'if the overlap is meant, write `allow overlap {one}, {other} because "..."`',
            )
        for driven in find_driven(tree, body, found):
            one, other = (plain_name(part) for part in driven.parts)
            joint = self.batch.program.joints[driven.joint]
            self.report.warning(
                "colliding-links",
                self._line(joint.where) or self._later(one, other),
                f"`{driven.parts[0]}` and `{driven.parts[1]}` collide while `{joint.path}` moves, at {driven.value}, "
                f"in every object examined that has both{_on_links(driven)}",
                hint=f"`{driven.follower}` moves them, which follows it: check its `mimic` and its axis, or shorten the ranges of both"
                if driven.follower
                else f"to the other side they would not meet: {_ROUND[joint.kind == 'prismatic']}"
                if driven.turned
                else "leave room where it moves, shorten its range, or place its axis elsewhere; "
                f'if the overlap is meant, write `allow overlap {one}, {other} because "..."`',
            )
        for flush in find_flush(tree, body, found):
            one, other = (plain_name(part) for part in flush.parts)
            joint = self.batch.program.joints[flush.joint]
            self.report.warning(
                "touching-links",
                self._line(joint.where) or self._later(one, other),
                f"`{flush.parts[0]}` and `{flush.parts[1]}` touch where `{joint.path}` moves one on the other, "
                "in every object examined that has both",
                hint="leave a gap of 0.2 mm or more, as in `gap 0.5mm` or `align lid.bottom = body.top + 0.5mm`; "
                f'if one is to rub on the other, write `allow overlap {one}, {other} because "..."`',
            )
        for axis in find_far_axes(tree, body):
            joint = self.batch.program.joints[axis.joint]
            self.report.warning(
                "far-axis",
                self._line(joint.where) or self._later(axis.child),
                f"the axis of `{joint.path}` lies {100 * axis.off:.3g} cm off `{axis.parent}`, which is to hold it, "
                f"and `{axis.child}` reaches {100 * axis.reach:.3g} cm from it",
                hint=f"place it where the two meet: is it the right edge, as `{axis.child}.back.bottom` for "
                f"`{axis.child}.front.bottom`, and is `{axis.parent}` what holds it?",
            )
        for loop in find_loose_loops(tree, body, self.lowering.context.axes):
            one, other = loop.links
            self.report.warning(
                "far-axis",
                self._line(self.batch.program.closures[loop.closure].where) or self.span,
                f"the links of `{one}` and `{other}` are {1000 * loop.gap:.3g} mm apart along the axis that this `close` keeps together",
                hint="axes meet wherever along them their places are: bring the two side by side, as by "
                f"`align {other}.right = {one}.left + 1mm`, or give one of them a pin that reaches the other",
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
        self.warn_unhandled(tree)
        if not {each.code for each in self.report.diagnostics} & _OF_ALL:
            self.warn_rare(solids, found)
        if find_unasked(tree, body):
            self.report.warning(
                "missing-stable",
                self.span,
                f"each `{self.batch.program.name}` examined tips over, and nothing requires that it stands",
                hint=f"{name_feet(tree, body, 0)}: broaden that, or bring the weight over it, and write `require stable`; "
                "if it is screwed down, label what holds it `flange` or `bracket`",
            )

    def warn_rare(self, solids: Solids, found: Collisions) -> None:
        """Report that half of the objects or more are invalid, by what fails most."""
        from .runtime.tables import plain_name  # start-up
        from .validity.rare import find_rare  # start-up

        rare = find_rare(solids, found)
        if rare is None:
            return
        topples = rare.where is not None and rare.where in {one.where for one in self.batch.program.stable}
        remedy = (
            "broaden what it stands on, or bring its weight over that"
            if topples
            else "state by `require` or by ranges what must hold"
        )
        others = "" if rare.count == rare.many else f"; {rare.many} are invalid in all"
        few = len(self.batch)
        seen = "in every object examined" if rare.count == few else f"in {rare.count} of {few} objects examined{others}"
        self.report.warning(
            "rarely-valid",
            self._line(rare.where) or self._of(plain_name(rare.part)) or self.span,
            f"{rare.worst}, {seen}",
            hint="; ".join(filter(None, (rare.example, remedy, "`apgc validate` counts all that fails"))),
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


def _on_links(stuck: Stuck) -> str:
    """On which links parts are that are not named as these."""
    from .runtime.tables import plain_name  # start-up

    names = zip(map(plain_name, stuck.parts), stuck.links, strict=True)
    on = [f"`{part}` is on the link of `{link}`" for part, link in names if not f"{part}.".startswith(f"{link}.")]
    return f" ({' and '.join(dict.fromkeys(on))})" if on else ""


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
