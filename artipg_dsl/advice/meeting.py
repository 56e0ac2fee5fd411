"""Links that meet or leave one another, and axes that lie off what is to hold them."""

from __future__ import annotations

from ..runtime.tables import plain_name
from ..validity.axes import find_far_axes, find_loose_loops
from ..validity.floating import Solids
from ..validity.flush import find_flush
from ..validity.guides import find_unguided
from ..validity.stuck import Stuck, find_driven, find_stuck
from ..validity.validate import Collisions
from .seen import Seen

_ROUND = (
    "turn its axis round, as by `lid.back.bottom` for `lid.bottom.back`, or the signs of its range",
    "let it slide the other way, as by `along -x` for `along x`",
)


def warn_stuck(seen: Seen, solids: Solids, found: Collisions) -> None:
    """Report links that overlap at rest, in each of the objects that have both."""
    for stuck in find_stuck(solids.tree, solids.body, found):
        one, other = (plain_name(part) for part in stuck.parts)
        seen.report.warning(
            "colliding-links",
            seen.later(one, other),
            f"`{stuck.parts[0]}` and `{stuck.parts[1]}` overlap with all joints at rest, in every object examined that has both"
            + _on_links(stuck),
            hint="leave a gap, as in `align lid.bottom = body.top + 1mm`; "
            f'if the overlap is meant, write `allow overlap {one}, {other} because "..."`',
        )


def warn_driven(seen: Seen, solids: Solids, found: Collisions) -> None:
    """Report links that a joint drives into one another, in each of the objects that have both."""
    for driven in find_driven(solids.tree, solids.body, found):
        one, other = (plain_name(part) for part in driven.parts)
        joint = seen.batch.program.joints[driven.joint]
        seen.report.warning(
            "colliding-links",
            seen.line(joint.where) or seen.later(one, other),
            f"`{driven.parts[0]}` and `{driven.parts[1]}` collide while `{joint.path}` moves, at {driven.value}, "
            f"in every object examined that has both{_on_links(driven)}",
            hint=f"`{driven.follower}` moves them, which follows it: check its `mimic` and its axis, or shorten the ranges of both"
            if driven.follower
            else f"to the other side they would not meet: {_ROUND[joint.kind == 'prismatic']}"
            if driven.turned
            else "leave room where it moves, shorten its range, or place its axis elsewhere; "
            f'if the overlap is meant, write `allow overlap {one}, {other} because "..."`',
        )


def warn_flush(seen: Seen, solids: Solids, found: Collisions) -> None:
    """Report links that touch where one moves on the other."""
    for flush in find_flush(solids.tree, solids.body, found):
        one, other = (plain_name(part) for part in flush.parts)
        joint = seen.batch.program.joints[flush.joint]
        seen.report.warning(
            "touching-links",
            seen.line(joint.where) or seen.later(one, other),
            f"`{flush.parts[0]}` and `{flush.parts[1]}` touch where `{joint.path}` moves one on the other, "
            "in every object examined that has both",
            hint="leave a gap of 0.2 mm or more, as in `gap 0.5mm` or `align lid.bottom = body.top + 0.5mm`; "
            f'if one is to rub on the other, write `allow overlap {one}, {other} because "..."`',
        )


def warn_far_axes(seen: Seen, solids: Solids) -> None:
    """Report hinges whose axis lies off what is to hold them."""
    for axis in find_far_axes(solids.tree, solids.body):
        joint = seen.batch.program.joints[axis.joint]
        seen.report.warning(
            "far-axis",
            seen.line(joint.where) or seen.later(axis.child),
            f"the axis of `{joint.path}` lies {100 * axis.off:.3g} cm off `{axis.parent}`, which is to hold it, "
            f"and `{axis.child}` reaches {100 * axis.reach:.3g} cm from it",
            hint=f"place it where the two meet: is it the right edge, as `{axis.child}.back.bottom` for "
            f"`{axis.child}.front.bottom`, and is `{axis.parent}` what holds it?",
        )


def warn_unguided(seen: Seen, solids: Solids) -> None:
    """Report drawers that are pulled all the way out of what holds them."""
    for drawer in find_unguided(solids.tree, solids.body):
        joint = seen.batch.program.joints[drawer.joint]
        seen.report.warning(
            "unguided",
            seen.line(joint.where) or seen.later(drawer.child),
            f"`{joint.path}` takes `{drawer.child}` all the way out of `{drawer.parent}`, and {1000 * drawer.out:.3g} mm farther, "
            "in every object examined that has both",
            hint="shorten its range: the rear end of a drawer, an eighth of it or more, stays in its guides",
        )


def warn_loose_loops(seen: Seen, solids: Solids) -> None:
    """Report loops whose links lie apart along their axis."""
    for loop in find_loose_loops(solids.tree, solids.body, seen.lowering.context.axes):
        one, other = loop.links
        seen.report.warning(
            "far-axis",
            seen.line(seen.batch.program.closures[loop.closure].where) or seen.span,
            f"the links of `{one}` and `{other}` are {1000 * loop.gap:.3g} mm apart along the axis that this `close` keeps together",
            hint="axes meet wherever along them their places are: bring the two side by side, as by "
            f"`align {other}.right = {one}.left + 1mm`, or give one of them a pin that reaches the other",
        )


def _on_links(stuck: Stuck) -> str:
    """On which links parts are that are not named as these."""
    names = zip(map(plain_name, stuck.parts), stuck.links, strict=True)
    on = [f"`{part}` is on the link of `{link}`" for part, link in names if not f"{part}.".startswith(f"{link}.")]
    return f" ({' and '.join(dict.fromkeys(on))})" if on else ""
