"""How the patches of a primitive hang together, found once from test values when the primitive is compiled.

Everything is compared over several test values at once, so that a coincidence of one value is none of the shape.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, Literal

import numpy as np

from ..graph.formula import compile_formula
from ..graph.primitive import Primitive
from ..records import dataclass
from ..shapes import fit
from . import facts
from .errors import PrimitiveError
from .patches import grid, position_split, surfaces, tangent_split
from .split import Params
from .trial import draw_trial, variants
from .vectors import cross, dot

_TOLERANCE = 1e-9  # relative to the extent of the instance
_PROBE = 1e-6  # how far off a surface the inside function is asked, relative too
_EDGES = ("u start", "u end", "v start", "v end")
_ALONG = np.linspace(0.0, 1.0, 9)
_ACROSS = np.linspace(0.1, 0.9, 5)
_FINE = np.linspace(0.0, 1.0, 33)
_ROWS = 8  # test values per variant


@dataclass(frozen=True, slots=True, eq=False)
class Topology:
    """The shape of one guard variant; patches are named by their patch numbers.

    ``matches`` pairs (patch, edge, patch, edge, reversed); ``collapsed`` (patch, edge) lists edges that are points.
    ``step_class`` (patches, 2) numbers the classes of directions (u, v) that share a step count, ``turn`` gives the
    angle (radians) that a class turns through (0: straight, one step), ``closed`` whether it runs full circle.
    """

    primitive: Primitive
    patches: tuple[int, ...]
    orientation: tuple[int, ...]
    matches: tuple[tuple[int, int, int, int, bool], ...]
    collapsed: tuple[tuple[int, int], ...]
    step_class: np.ndarray
    turn: np.ndarray
    closed: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Seams:
    """Where the edges of a variant meet: edge 4 * i + e is edge ``e`` (see ``_EDGES``) of patch ``patches[i]``.

    ``pairs`` (edge, edge, reversed), ``points`` (edges,) the edges that are points, ``closed`` (edges,) those that end
    where they start; ``params`` and ``scale`` are the test values compared and the extents of their instances.
    """

    patches: tuple[int, ...]
    pairs: tuple[tuple[int, int, bool], ...]
    points: np.ndarray
    closed: np.ndarray
    params: Params
    scale: np.ndarray


@lru_cache(maxsize=512)
def seams(primitive: Primitive, variant: tuple[bool, ...]) -> Seams:
    """How the edges of the variant with these patches meet; raises PrimitiveError where an edge meets no other."""
    rows = variants(primitive).get(variant)
    if rows is None:
        names = [s.name for s, there in zip(surfaces(primitive), variant, strict=True) if there]
        message = f"no test values give the surfaces {', '.join(names)} alone: widen the test ranges"
        raise PrimitiveError(primitive, None, message)
    params = {name: value[rows[:_ROWS]] for name, value in draw_trial(primitive).items()}
    patches = tuple(int(i) for i in np.flatnonzero(variant))
    if not patches:
        raise PrimitiveError(primitive, None, "there is no surface at some test values")
    curves = np.stack([_edges(primitive, patch, params) for patch in patches], axis=1)
    count, scale = curves.shape[0], _extent(curves)
    curves = curves.reshape(count, 4 * len(patches), len(_ALONG), 3) / scale[:, None, None, None]
    points = (np.abs(curves - curves[:, :, :1]).max(axis=(0, 2, 3))) < _TOLERANCE
    pairs = tuple(_match(primitive, patches, params, curves, points, scale))
    closed = np.abs(curves[:, :, 0] - curves[:, :, -1]).max(axis=(0, 2)) < _TOLERANCE
    return Seams(patches, pairs, points, closed, params, scale)


@lru_cache(maxsize=512)
def topology(primitive: Primitive, variant: tuple[bool, ...]) -> Topology:
    """The topology of the variant with these patches; raises PrimitiveError where an edge meets no other."""
    name = f"topology {''.join(str(int(there)) for there in variant)}"
    return facts.recall_fact(
        primitive, name, lambda: _found(primitive, variant), _to_data, lambda held: _read(primitive, variant, held)
    )


def _found(primitive: Primitive, variant: tuple[bool, ...]) -> Topology:
    found = seams(primitive, variant)
    patches, pairs, points = found.patches, found.pairs, found.points
    classes = _classes(len(patches), pairs)
    straight, turn = np.ones(2 * len(patches), dtype=bool), np.zeros(2 * len(patches))
    for position, patch in enumerate(patches):
        straight[2 * position : 2 * position + 2] = _straight(primitive, patch, found.params, found.scale)
        turn[2 * position : 2 * position + 2] = turns(primitive, patch)
    closed = np.zeros(2 * len(patches), dtype=bool)
    for edge in np.flatnonzero(found.closed & ~points):
        closed[2 * (edge // 4) + (1 if edge % 4 < 2 else 0)] = True
    total = classes.max() + 1
    class_turn, class_closed = np.zeros(total), np.zeros(total, dtype=bool)
    np.maximum.at(class_turn, classes, np.where(straight, 0.0, np.maximum(turn, np.pi / 4)))
    np.logical_or.at(class_closed, classes, closed)
    return Topology(
        primitive,
        patches,
        tuple(int(orientation(primitive)[p]) for p in patches),
        tuple((patches[a // 4], a % 4, patches[b // 4], b % 4, r) for a, b, r in pairs),
        tuple((patches[e // 4], int(e % 4)) for e in np.flatnonzero(points)),
        classes.reshape(-1, 2),
        class_turn,
        class_closed,
    )


def _to_data(found: Topology) -> dict[str, Any]:
    return {
        "orientation": found.orientation,
        "matches": found.matches,
        "collapsed": found.collapsed,
        "step_class": found.step_class.ravel().tolist(),
        "turn": found.turn.tolist(),
        "closed": found.closed.tolist(),
    }


def _read(primitive: Primitive, variant: tuple[bool, ...], held: Any) -> Topology:
    """Raises ValueError, TypeError or KeyError where data is no topology of these patches."""
    patches = tuple(int(i) for i in np.flatnonzero(variant))
    fit(held["orientation"], list[Literal[-1, 1]])
    fit(held["matches"], list[list[int | bool]])
    fit(held["collapsed"], list[list[int]])
    fit(held["step_class"], list[int])
    fit(held["turn"], list[float])
    fit(held["closed"], list[bool])
    edges = [pair for a, b, c, d, _ in held["matches"] for pair in ((a, b), (c, d))] + [
        (a, b) for a, b in held["collapsed"]
    ]
    classes, total = held["step_class"], len(held["turn"])
    if (
        sorted(edges) != [(patch, edge) for patch in patches for edge in range(4)]
        or len(held["orientation"]) != len(patches)
        or len(classes) != 2 * len(patches)
        or len(held["closed"]) != total
        or set(classes) != set(range(total))
        or min(held["turn"]) < 0
    ):
        raise ValueError("another shape")
    return Topology(
        primitive,
        patches,
        tuple(held["orientation"]),
        tuple((a, b, c, d, bool(reverse)) for a, b, c, d, reverse in held["matches"]),
        tuple((a, b) for a, b in held["collapsed"]),
        np.array(classes, dtype=np.int64).reshape(-1, 2),
        np.array(held["turn"], dtype=np.float64),
        np.array(held["closed"], dtype=bool),
    )


def _edges(primitive: Primitive, patch: int, params: Params) -> np.ndarray:
    """(rows, 4, samples, 3): the edges of a patch, each from the start to the end of its own direction."""
    ends = np.array([0.0, 1.0])[:, None]
    split = position_split(primitive, patch)
    by_u = grid(split, params, ends + 0.0 * _ALONG, _ALONG[None] + 0.0 * ends)
    by_v = grid(split, params, _ALONG[None] + 0.0 * ends, ends + 0.0 * _ALONG)
    return np.concatenate([by_u, by_v], axis=1)


def _extent(curves: np.ndarray) -> np.ndarray:
    flat = curves.reshape(len(curves), -1, 3)
    return np.maximum((flat.max(axis=1) - flat.min(axis=1)).max(axis=1), 1e-300)


def _match(
    primitive: Primitive,
    patches: tuple[int, ...],
    params: Params,
    curves: np.ndarray,
    points: np.ndarray,
    scale: np.ndarray,
) -> list[tuple[int, int, bool]]:
    """Pairs of edges that are the same curve, the second perhaps reversed; every edge has exactly one partner."""
    pairs = []
    middle = curves[0, :, len(_ALONG) // 2]
    may = np.abs(middle[:, None] - middle).max(axis=2) < _TOLERANCE  # edges that are apart here are no partners
    np.fill_diagonal(may, False)
    may[:, points] = False
    for edge in map(int, np.flatnonzero(~points)):
        near = np.flatnonzero(may[edge])
        forward, back = _apart(curves, edge, near)
        close = np.minimum(forward, back) < _TOLERANCE
        partners = near[close]
        if len(partners) == 1:
            other = int(partners[0])
            if edge < other:
                pairs.append((edge, other, bool((back < forward)[close][0])))
            continue
        names = [f"{_EDGES[e % 4]} of {surfaces(primitive)[patches[e // 4]].name}" for e in (edge, *partners)]
        name = surfaces(primitive)[patches[edge // 4]].name
        row = _first_alone(curves, edge, ~points)
        place = place_in_words(primitive, params, row, curves[row, edge, len(_ALONG) // 2] * scale[row])
        if len(partners):
            message = f"its edge {names[0]} is shared by {len(partners) + 1} surfaces: {', '.join(names)} ({place})"
            raise PrimitiveError(primitive, name, message)
        gap = np.minimum(*_apart(curves, edge, np.arange(curves.shape[1])))
        gap[edge], gap[points] = np.inf, np.inf
        nearest, hint = int(np.argmin(gap)), ""
        if np.isfinite(gap[nearest]):
            other_name = surfaces(primitive)[patches[nearest // 4]].name
            hint = (
                f"; the nearest is {_EDGES[nearest % 4]} of {other_name}, {100 * gap[nearest]:.3g} % of its size away"
            )
        message = f"its edge {_EDGES[edge % 4]} meets no other edge: the surface leaks there{hint} ({place})"
        raise PrimitiveError(primitive, name, message)
    return pairs


def _apart(curves: np.ndarray, edge: int, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """How far other edges are from one that runs the same way, and from it reversed."""
    own, theirs = curves[:, edge, None], curves[:, others]
    forward, back = np.abs(theirs - own), np.abs(theirs - own[:, :, ::-1])
    return forward.max(axis=(0, 2, 3)), back.max(axis=(0, 2, 3))


def _first_alone(curves: np.ndarray, edge: int, asked: np.ndarray) -> int:
    """The first row in which none of the edges ``asked`` (E,) bool is near one, 0 where there is no such row."""
    own, others = curves[:, edge, None], np.delete(curves, edge, axis=1)[:, np.delete(asked, edge)]
    apart = [np.abs(others - way).max(axis=(2, 3)) for way in (own, own[:, :, ::-1])]
    return int(np.argmax((np.minimum(*apart) >= _TOLERANCE).all(axis=1)))


def place_in_words(primitive: Primitive, params: Params, row: int, point: np.ndarray) -> str:
    """A place (3,) in metres and the test value of a row, for messages."""
    at = ", ".join(f"{round(1000 * float(c), 6) + 0.0:.4g}" for c in point)
    return f"about [{at}] mm, test value {value_in_words(primitive, params, row)}"


def value_in_words(primitive: Primitive, params: Params, row: int) -> str:
    """The test value of a row; switches, which are tested from 0 to 1, as such."""
    switches = {n for n, ends in zip(primitive.parameters, primitive.test, strict=True) if ends == (0.0, 1.0)}
    values = {n: float(params[n][row]) for n in primitive.parameters}
    return ", ".join(
        f"{n} = {('false', 'true')[int(v)] if n in switches.intersection(primitive.whole) else f'{v:.4g}'}"
        for n, v in values.items()
    )


def _classes(count: int, pairs: Sequence[tuple[int, int, bool]]) -> np.ndarray:
    """(2 * count,): the class of each direction (patch, u or v); matched edges run along directions of one class."""
    parent = list(range(2 * count))

    def find(node: int) -> int:
        while parent[node] != node:
            node = parent[node]
        return node

    for a, b, _ in pairs:
        one, other = (find(2 * (e // 4) + (1 if e % 4 < 2 else 0)) for e in (a, b))
        parent[max(one, other)] = min(one, other)
    return np.unique([find(n) for n in range(2 * count)], return_inverse=True)[1]


def _straight(primitive: Primitive, patch: int, params: Params, scale: np.ndarray) -> np.ndarray:
    """(2,) bool: whether the patch is made of straight lines along u, along v."""
    u, v = np.meshgrid(_ALONG, _ALONG, indexing="ij")
    points = grid(position_split(primitive, patch), params, u, v) / scale[:, None, None, None]
    corners = points[:, ::8, ::8].reshape(len(points), 4, 3)
    edges = corners[:, 1:] - corners[:, :1]
    twist = np.abs((cross(edges[:, 0], edges[:, 1]) * edges[:, 2]).sum(axis=1)).max()
    straight = np.empty(2, dtype=bool)
    for axis, lines in ((0, points), (1, points.transpose(0, 2, 1, 3))):
        chord = lines[:, :1] + _ALONG[None, :, None, None] * (lines[:, -1:] - lines[:, :1])
        straight[axis] = np.abs(lines - chord).max() < _TOLERANCE
    if straight.all() and twist > _TOLERANCE:
        straight[:] = False  # a twisted quad: one step would cut off its bulge
    return straight & ~_warped(primitive, patch, params)


def _warped(primitive: Primitive, patch: int, params: Params) -> np.ndarray:
    """(2,) bool: whether the normal turns along lines of u, of v: facets along the whole of a line would face askew."""
    u, v = np.meshgrid(_ACROSS, _ACROSS, indexing="ij")
    tangent = grid(tangent_split(primitive, patch), params, u, v)
    normal = cross(tangent[..., :3], tangent[..., 3:])
    length = np.sqrt((normal**2).sum(axis=-1, keepdims=True))
    normal = normal / np.maximum(length, 1e-300)
    turned = [np.abs(lines - lines[:, :1]).max() for lines in (normal, normal.transpose(0, 2, 1, 3))]
    return np.array(turned) > 1e-6


def shown_rows(primitive: Primitive, patch: int) -> Params:
    """The test values at which the patch exists."""
    rows = [r for flags, r in variants(primitive).items() if flags[patch]]
    if not rows:
        raise PrimitiveError(primitive, surfaces(primitive)[patch].name, "it does not exist at any test value")
    every = np.sort(np.concatenate(rows))
    return {name: value[every] for name, value in draw_trial(primitive).items()}


@lru_cache(maxsize=4096)
def turns(primitive: Primitive, patch: int) -> tuple[float, float]:
    """The greatest angles that lines along u and along v turn through, over all test values of all variants."""
    return facts.recall_fact(primitive, f"turns {patch}", lambda: _angles(primitive, patch), list, _read_angles)


def _read_angles(held: Any) -> tuple[float, float]:
    fit(held, list[float])
    one, other = held
    if min(one, other) < 0:
        raise ValueError("an angle of turns is not negative")
    return float(one), float(other)


def _angles(primitive: Primitive, patch: int) -> tuple[float, float]:
    u, v = np.meshgrid(_FINE, np.array([0.0, 0.5, 1.0]), indexing="ij")
    params = shown_rows(primitive, patch)
    along_u = grid(tangent_split(primitive, patch), params, u, v)[..., :3]
    along_v = grid(tangent_split(primitive, patch), params, v, u)[..., 3:]
    return _turned(along_u), _turned(along_v)


def _turned(tangents: np.ndarray) -> float:
    """The greatest sum of angles between successive tangents: (rows, steps, lines, 3), collapsed lines ignored."""
    length = np.sqrt(dot(tangents, tangents))
    good = (length > 1e-9 * length.max()).all(axis=1)
    first, second = tangents[:, :-1], tangents[:, 1:]
    turned = cross(first, second)
    angles = np.arctan2(np.sqrt(dot(turned, turned)), dot(first, second)).sum(axis=1)
    return float(np.where(good, angles, 0.0).max())


_AWAY = 100.0 * np.array([[0.9, 0.5, 0.7], [-0.8, 0.6, -0.9], [0.6, -0.7, 0.8], [-0.7, -0.9, -0.6]])  # a few places


@lru_cache(maxsize=512)
def orientation(primitive: Primitive) -> np.ndarray:
    """(patches,) +1 where du x dv points outwards, -1 where inwards, told by the inside function."""

    def read(held: Any) -> np.ndarray:
        fit(held, list[Literal[-1, 1]])
        if len(held) != len(surfaces(primitive)):
            raise ValueError("a way for each patch")
        return np.array(held, dtype=np.int64)

    return facts.recall_fact(primitive, "orientation", lambda: _outwards(primitive), np.ndarray.tolist, read)


def _outwards(primitive: Primitive) -> np.ndarray:
    inside = compile_formula((primitive.inside,), (*primitive.parameters, "p.x", "p.y", "p.z"))
    out = np.zeros(len(surfaces(primitive)), dtype=np.int64)
    u, v = (a.ravel() for a in np.meshgrid(_ACROSS, _ACROSS, indexing="ij"))
    for patch, surface in enumerate(surfaces(primitive)):
        chosen = shown_rows(primitive, patch)
        point = grid(position_split(primitive, patch), chosen, u, v)
        tangent = grid(tangent_split(primitive, patch), chosen, u, v)
        normal = cross(tangent[..., :3], tangent[..., 3:])
        length = np.sqrt((normal**2).sum(axis=-1, keepdims=True))
        normal = normal / np.maximum(length, 1e-300)
        scale = np.abs(point).max(axis=(1, 2))[:, None, None]
        # one call: a long formula takes its time for few places, too
        sides = [point + side * _PROBE * scale * normal for side in (1.0, -1.0)]
        asked = np.moveaxis(np.concatenate([*sides, _AWAY * scale], axis=1), -1, 0)
        arguments = [chosen[n][:, None] for n in primitive.parameters]
        (value,) = inside(*arguments, *np.ascontiguousarray(asked))  # what does not lie in one piece is left to NumPy
        held = np.broadcast_to(value < 0, asked.shape[1:])
        votes = held[:, : len(u)], held[:, len(u) : 2 * len(u)]
        outward, inward = (votes[1] & ~votes[0]).mean(), (votes[0] & ~votes[1]).mean()
        if max(outward, inward) < 0.75:
            fault = "both sides are" if (votes[0] & votes[1]).mean() > 0.5 else "neither side is"
            if min(outward, inward) > 0.125:
                fault = "sometimes one side, sometimes the other is"
            place = place_in_words(primitive, chosen, 0, point[0, point.shape[1] // 2])
            raise PrimitiveError(
                primitive, surface.name, f"the inside function disagrees with it: {fault} inside ({place})"
            )
        if held[:, 2 * len(u) :].any():
            words = "the inside function is negative far outside the solid: it must be negative only inside"
            raise PrimitiveError(primitive, None, words)
        out[patch] = 1 if outward > inward else -1
    return out
