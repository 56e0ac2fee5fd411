"""Joints that cannot move as they are said to: what they follow, what loops leave of them, how far they slide."""

from __future__ import annotations

import numpy as np

from ..diagnostics.suggest import any_of
from ..geometry.sites import object_boxes
from ..lower.solve.feasible import plain
from .seen import Seen, always

_NAMED = 6  # joints that a warning names
_SLACK = 1e-6  # radians or metres, by which rounding takes a joint out of its range
_FAR = 3.0  # times the size of its object: what slides farther than that has perhaps a wrong unit
_SHORT = 1e-3  # metres


def follow(seen: Seen) -> bool:
    """Whether every joint that follows another by a formula can; the first that cannot is reported."""
    from ..runtime.curves import TurnsBack  # start-up

    if all(joint.curve is None for joint in seen.batch.program.joints):
        return True
    try:
        seen.batch.joints()
    except TurnsBack as wrong:
        words = wrong.message.split(": ", 1)[1]  # the report says where
        where = seen.lowering.links.mimics[wrong.definition][1].span
        seen.report.error("bad-mimic", where, words, hint=wrong.hint)
        return False
    return True


def warn_rigid(seen: Seen) -> None:
    """Name the joints of objects whose loops leave none of them to move."""
    loops, names, links = seen.batch.loops, seen.batch.joints().name, seen.batch.links()
    if loops is None:
        return
    for number, (joints, follows) in enumerate(zip(loops.variable, loops.follows, strict=True)):
        there = joints >= 0
        if there.any() and follows[there].all():
            held = any_of([names[k] for k in joints[there][:_NAMED].tolist()], "and")
            pairs = links.definition[loops.link[:, loops.owner == number]].T.tolist()
            one, other = (f"`{seen.batch.program.links[k].path}`" for k in pairs[0])
            seen.report.warning(
                "rigid-loop",
                seen.span,
                f"no joint on the loops of `{seen.batch.program.name}` can move: `close` determines {held}",
                hint=f"it ties the link of {one} to that of {other}: a place lies on the link of the parts that its formula "
                "names; a loop of four hinges with parallel axes moves, a triangle does not: add a joint, or `connect` the parts",
            )
            return


def warn_caught(seen: Seen) -> None:
    """Name joints with `positions` whose values closed loops determine, in every object that has them."""
    loops, joints, program = seen.batch.loops, seen.batch.joints(), seen.batch.program
    if loops is None:
        return
    led = np.zeros(len(joints.name), dtype=bool)
    led[loops.variable[loops.follows]] = True
    drives = loops.driven(np.arange(len(led)))
    for number, joint in enumerate(program.joints):
        mine = np.flatnonzero(joints.definition == number)
        if joint.positions is not None and len(mine) and led[mine].all():
            lead = program.joints[joints.definition[drives[mine[0]]]].path
            seen.report.warning(
                "unknown-clause",
                seen.line(joint.where) or seen.span,
                f"the positions of `{joint.path}` have no effect: its closed loop determines where it is",
                hint=f"drop them, or give them to `{lead}`, which drives the loop",
            )


def warn_beyond(seen: Seen) -> None:
    """Name joints that what they follow takes out of their own range, in every object that has them."""
    joints = seen.batch.joints()
    led = np.flatnonzero(joints.mimic >= 0)
    leader = np.searchsorted(joints.owner, joints.owner)[led] + joints.mimic[led]
    ends = [joints.multiplier[led] * end[leader] + joints.offset[led] for end in (joints.low, joints.high)]
    least, most = np.minimum(*ends), np.maximum(*ends)
    beyond = (least < joints.low[led] - _SLACK) | (most > joints.high[led] + _SLACK)
    endless = np.isnan(joints.low[leader]) & np.isfinite(joints.low[led]) & (joints.multiplier[led] != 0.0)
    beyond |= endless
    beyond_turned = endless | (-most < joints.low[led] - _SLACK) | (-least > joints.high[led] + _SLACK)
    for number, k in always(joints.definition[led], beyond):
        joint = seen.batch.program.joints[number]
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
            lead = seen.batch.program.joints[joints.definition[leader[k]]].path
            said = f"follows `{lead}`, which turns without end"
            hint = f"give `{lead}` a range: `revolute ... range 0turn .. 3turn`"
        seen.report.warning(
            "bad-mimic",
            seen.line(joint.where) or seen.span,
            f"`{joint.path}` {said}, and its range is {own}",
            hint=hint,
        )
    one_way = (np.abs(least + most) > _SLACK) & ((least > -_SLACK) | (most < _SLACK))
    for number, k in always(joints.definition[led], one_way & ~beyond & ~beyond_turned):
        joint = seen.batch.program.joints[number]
        unit = "m" if joint.kind == "prismatic" else "rad"
        if joint.curve is None and np.isfinite(joints.low[led][k]):
            taken = f"{plain(float(least[k]), unit)} .. {plain(float(most[k]), unit)}"
            seen.report.warning(
                "bad-mimic",
                seen.line(joint.where) or seen.span,
                f"`{joint.path}` is taken through {taken} alone, and its range has as much room on the other side",
                hint=f"look at it with its joints open: if it goes the right way, state that range, `range {taken}`; "
                "else change the sign of its factor",
            )


def warn_far(seen: Seen) -> None:
    """Name joints that slide much farther than their object is large, in every object that has them."""
    joints = seen.batch.joints()
    way = joints.high - joints.low
    slides = np.array([kind == "prismatic" for kind in joints.kind], dtype=bool)
    if seen.batch.program.closures or not np.any(slides & (way > _SHORT)):
        return  # in a loop, the ends only bound where it is sought
    low, high = object_boxes(seen.batch.sites(), len(seen.batch))
    size = np.linalg.norm(np.maximum(high - low, 0.0), axis=1)
    far = slides & (way > np.maximum(_SHORT, _FAR * size[joints.owner]))
    for number, k in always(joints.definition, far):
        joint = seen.batch.program.joints[number]
        seen.report.warning(
            "far-motion",
            seen.line(joint.where) or seen.span,
            f"`{joint.path}` slides {plain(float(way[k]), 'm')}, and the whole object is about "
            f"{plain(float(f'{size[joints.owner[k]]:.2g}'), 'm')} across",
            hint="is the unit right? Shorten its range, or bound what the range is made of",
        )
