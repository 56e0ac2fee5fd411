"""Clouds of objects of ours, with the truth that they come with."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

import artipg_dsl as apg
from artipg_dsl.annotate.cloud import Points
from artipg_dsl.annotate.states import joint_twist
from artipg_dsl.run.prior import PriorFile, read_prior

from .clouds import Clouds, join, normalise, unit
from .part import Part, part_arrays

STATES = "rest,random:1"
HINGES = ("revolute", "continuous")
LEAST = 0.03  # of the surface: people who describe objects leave smaller parts to what they are on


def our_shapes(known: tuple[str, ...], each: int, n: int, seed: int) -> Clouds:
    """Fresh objects of the categories at rest, points alone."""
    points, names = [], []
    for category in known:
        objects = apg.sample(category, n=each, seed=seed)
        points.append(normalise(objects.points(n, surface="outside").position))
        names += [f"{category} {number}" for number in objects.numbers]
    return _clouds({"points": np.concatenate(points)}, np.repeat(np.arange(len(known)), each), known, names)


def our_motion(known: tuple[str, ...], each: int, n: int, seed: int, prior: str | None = None) -> Clouds:
    """Fresh objects of the categories, each at rest and in a random state; ``moves`` (K, n) tells what moves. Categories that the file
    ``prior`` does not speak of are drawn as declared."""
    said = None if prior is None else read_prior(prior)
    draws = said.categories if isinstance(said, PriorFile) else {}
    made = []
    for category in known:
        objects = apg.sample(category, n=each, seed=seed, prior=draws.get(category))
        made.append((objects, objects.points(n, objects.joint_values(STATES), surface="outside"), category, -1))
    return motion_clouds(made, known)


def motion_clouds(made: Sequence[tuple[apg.Samples, Points, str, int]], known: tuple[str, ...]) -> Clouds:
    """Clouds of objects with their points (B, 2, n) in STATES, what they are called, and the real object they were made from, -1 for none."""
    points, moves, category, names, origin = [], [], [], [], []
    for objects, drawn, title, of in made:
        for k, state in enumerate(("at rest", "open")):
            points.append(normalise(drawn.position[:, k]))
            moves.append(moving(objects, drawn.link))
            names += [f"{title} {number} {state}" for number in objects.numbers]
        category += [known.index(objects.category)] * (2 * len(objects))
        origin += [of] * (2 * len(objects))
    arrays = {"points": np.concatenate(points), "moves": np.concatenate(moves)}
    return Clouds(arrays, np.array(category), known, tuple(names), np.array(origin))


def _clouds(
    arrays: dict[str, np.ndarray], category: np.ndarray, known: tuple[str, ...], names: Sequence[str]
) -> Clouds:
    return Clouds(arrays, category, known, tuple(names), np.full(len(names), -1))


def our_parts(known: tuple[str, ...], each: int, n: int, seed: int) -> Clouds:
    """The parts of fresh objects that a hinge or a slide moves, each object at rest and in a random state; ``n`` points of an object."""
    found = []
    for kind, category in enumerate(known):
        objects = apg.sample(category, n=each, seed=seed)
        states = objects.joint_values(STATES)
        made = objects.points(n, states, surface="outside")
        by = np.take_along_axis(carriers(objects, made.link), made.link, axis=1)
        parts, names = [], []
        for k, state in enumerate(("at rest", "open")):
            for row, joint, part in _parts(objects, states[k], made.position[:, k], by):
                parts.append(part)
                names.append(f"{category} {objects.numbers[row]} {objects.joints().name[joint]} {state}")
        if parts:
            found.append(_clouds(part_arrays(parts), np.full(len(parts), kind), known, names))
    return join(found)


def our_ways(known: tuple[str, ...], each: int, n: int, seed: int) -> Clouds:
    """Fresh objects of the categories at rest; ``opens`` (K, n, 3) is the unit vector along which each point opens, 0 where nothing moves it;
    ``both`` (K, n): whether it goes the other way, too."""
    points, opens, both, names = [], [], [], []
    for category in known:
        objects = apg.sample(category, n=each, seed=seed)
        made = objects.points(n, surface="outside")
        by = np.take_along_axis(carriers(objects, made.link), made.link, axis=1)
        joints, moved = objects.joints(), by >= 0
        ways = joint_twist(objects.batch).at(by, made.position) * _opening(objects)[by][..., None]
        points.append(normalise(made.position))
        opens.append(unit(np.where(moved[..., None], ways, 0.0)))
        ends = (joints.rest <= joints.low) | (joints.rest >= joints.high)  # none, where a limit is nan
        both.append(moved & ~ends[by])
        names += [f"{category} {number}" for number in objects.numbers]
    arrays = {"points": np.concatenate(points), "opens": np.concatenate(opens), "both": np.concatenate(both)}
    return _clouds(arrays, np.repeat(np.arange(len(known)), each), known, names)


def _opening(objects: apg.Samples) -> np.ndarray:
    """(J,) 1 for joints that have more room above their rest than below it, else -1."""
    joints = objects.joints()
    return np.where(joints.rest - joints.low > joints.high - joints.rest, -1.0, 1.0)


def _parts(
    objects: apg.Samples, states: np.ndarray, points: np.ndarray, by: np.ndarray
) -> Iterator[tuple[int, int, Part]]:
    """The row of an object, a joint and the part that it moves; ``by`` (B, n) tells by which joint each of the points (B, n, 3) goes."""
    joints, motion = objects.joints(), joint_twist(objects.batch, states)
    opening = _opening(objects)
    for joint, kind in enumerate(joints.kind):
        row = int(joints.owner[joint])
        own = by[row] == joint
        turn, shift = motion.turn[joint], motion.shift[joint]
        if kind not in HINGES and kind != "prismatic" or own.mean() < LEAST:
            continue
        axis = shift if kind == "prismatic" else turn
        hinge = None if kind == "prismatic" else np.cross(turn, shift)
        yield row, joint, Part(points[row], own, opening[joint] * axis, hinge)


def moving(objects: apg.Samples, link: np.ndarray) -> np.ndarray:
    """(B, n) bool for points on links: whether a joint moves them that carries enough of the surface to be counted."""
    return np.take_along_axis(carriers(objects, link), link, axis=1) >= 0


def carriers(objects: apg.Samples, link: np.ndarray) -> np.ndarray:
    """(B, links) the last joint (its row) before each link that carries enough of the surface to be counted, or -1, by points on
    links (B, n)."""
    links, joints, count = objects.links(), objects.joints(), len(objects)
    size = int(links.number.max()) + 1
    share = np.stack([np.bincount(row, minlength=size) for row in link]) / link.shape[1]
    parent, by = np.full((count, size), -1), np.full((count, size), -1)
    parent[joints.owner, joints.child] = joints.parent
    free = np.array([kind != "fixed" for kind in joints.kind], dtype=bool)
    by[joints.owner[free], joints.child[free]] = np.flatnonzero(free)
    carried, above = share.copy(), parent.copy()
    owner = np.broadcast_to(np.arange(count)[:, None], above.shape)
    while (above >= 0).any():  # what a link carries, those on it too
        at = above >= 0
        np.add.at(carried, (owner[at], above[at]), share[at])
        above = np.where(at, parent[owner, above], -1)
    counted = (by >= 0) & (carried >= LEAST)
    found, above = np.full((count, size), -1), np.broadcast_to(np.arange(size), counted.shape)
    for _ in range(size):
        found = np.where((found < 0) & (above >= 0) & counted[owner, above], by[owner, above], found)
        above = np.where(above >= 0, parent[owner, above], -1)
    return found
