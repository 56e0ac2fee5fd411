"""Which links a joint or a closed loop holds together, so that simulators are told not to let them collide."""

from __future__ import annotations

from .robot import Robot


def adjacent(robot: Robot) -> list[tuple[str, str]]:
    """Names of pairs of links that a joint or a loop's closing holds together. Links that fixed joints hold together count as one."""
    fixed_to = {joint.child: joint.parent for joint in robot.joints if joint.kind == "fixed"}
    welded = list(range(len(robot.links)))
    for link in welded:
        while welded[link] in fixed_to:
            welded[link] = fixed_to[welded[link]]
    groups: dict[int, list[int]] = {}
    for link, group in enumerate(welded):
        groups.setdefault(group, []).append(link)
    held = [(joint.parent, joint.child) for joint in robot.joints if joint.kind != "fixed"]
    held += [closure.links for closure in robot.closures]
    pairs = [(a, b) for one, other in held for a in groups[welded[one]] for b in groups[welded[other]]]
    pairs += [(a, b) for group in groups.values() for i, a in enumerate(group) for b in group[i + 1 :]]
    return [(robot.links[a].name, robot.links[b].name) for a, b in dict.fromkeys(pairs)]
