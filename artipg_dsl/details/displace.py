"""Closed meshes of objects in the details that their points wear.

Each corner of each patch asks for its detail as a point at the same (patch, u, v) does. Corners of one vertex whose normals are alike
are one node, and ways are smoothed from node to node: so nothing is smoothed across an edge. What wears nothing goes with the nearest
of its element that does, ever less the farther it is: the inner wall of a bottle goes with the outer one. In the end the nodes of a
vertex meet, each along its own normal where it wants to be, and the vertex is moved once: what was closed stays closed. What lay behind
another primitive in the original, as the neck of a bottle in its collar, stays where it is, and so does what another primitive of the
object covers, whatever the original was like.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ..geometry.nearest import Nearest
from ..geometry.vectors import cross, dot
from .cover import hold
from .skin import Grid, Skin, gather, neighbours, tie_breakers, total
from .suits import Suits
from .unfold import keep_apart, unfold
from .wear import Wardrobe, find_offsets

_ALIKE = np.cos(np.radians(35.0))  # normals that differ by less are of one smooth surface, as in shading
_FOLLOWS = 0.06  # diagonals: so far from what wears a detail the rest goes along
_ROUNDS = 3  # of smoothing, each by half
_LOOSE = 0.1  # the weight of the mean of all nodes against what each wants along its normal
_APART = 10.0  # diagonals between elements


def displace(
    grids: Sequence[Grid], wardrobe: Wardrobe, suits: Suits, scale: np.ndarray, strength: float = 1.0
) -> list[np.ndarray]:
    """The vertices (k, V, 3) of each of the meshes in the details that ``suits`` says; ``scale`` (B,): the diagonals of the objects."""
    skin = gather(grids, suits.elements)
    moved = skin.place + _find_ways(skin, wardrobe, suits, scale, strength)
    ends = np.cumsum([grid.vertices.shape[0] * grid.vertices.shape[1] for grid in grids])
    parts = np.split(moved, ends[:-1])
    return [part.reshape(grid.vertices.shape) for part, grid in zip(parts, grids, strict=True)]


def _find_ways(skin: Skin, wardrobe: Wardrobe, suits: Suits, scale: np.ndarray, strength: float) -> np.ndarray:
    """How far each vertex (V, 3) is moved, metres."""
    own = skin.element[skin.vertex]
    moved, normal, worn, behind = find_offsets(wardrobe, suits, own, skin.patch, skin.u, skin.v, strength)
    node = _join(skin.vertex, normal)
    count = int(node.max()) + 1
    vertex = np.empty(count, dtype=np.int64)
    vertex[node] = skin.vertex
    outward = total(node, normal, count)
    outward /= np.maximum(np.sqrt(dot(outward, outward)), 1e-12)[:, None]
    told = np.bincount(node, worn, count)
    way = total(node, moved, count) / np.maximum(told, 1.0)[:, None]
    place, element = skin.place[vertex], skin.element[vertex]
    size = scale[suits.elements.owner[element]]
    free = np.bincount(node, ~behind, count) > 0.0
    way = _followed(place / size[:, None], element, way, told > 0.0, free)
    means = neighbours(node[skin.corners], place)
    for _ in range(_ROUNDS):
        way = 0.5 * way + 0.5 * (means @ way)
    held, kept = hold(place, outward, way, element, suits.elements, wardrobe.solids, size)
    way[held] = kept
    for _ in range(_ROUNDS):  # no wall around it, which would fold
        way = 0.5 * way + 0.5 * (means @ way)
        way[held] = kept
    firm = told > 0.0
    firm[held] = True
    way = keep_apart(place, outward, way, firm, element, size)
    return unfold(skin.place, _met(vertex, outward, way, len(skin)), skin.faces, skin.element)


def _join(vertex: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """(C,) the node of each corner: corners of one ``vertex`` (C,) whose normals (C, 3) are alike are one."""
    order = np.argsort(vertex, kind="stable")
    ranked = vertex[order]
    pairs = [np.empty((2, 0), dtype=np.int64)]
    for shift in range(1, int(np.bincount(vertex).max())):  # the patches that meet at a vertex, a handful
        at = np.flatnonzero(ranked[shift:] == ranked[:-shift])
        one, other = order[at], order[at + shift]
        pairs.append(np.stack([one, other])[:, dot(normal[one], normal[other]) > _ALIKE])
    one, other = np.concatenate(pairs, axis=1)
    count = len(vertex)
    graph = csr_matrix((np.ones(len(one)), (one, other)), shape=(count, count))
    return np.asarray(connected_components(graph, directed=False)[1])


def _followed(
    place: np.ndarray, element: np.ndarray, way: np.ndarray, told: np.ndarray, free: np.ndarray
) -> np.ndarray:
    """The ways (m, 3) of places, in diagonals, where those ``free`` to go that nothing is ``told`` of go with the nearest of
    their element."""
    bare, worn = np.flatnonzero(~told & free), np.flatnonzero(told)
    if not len(bare) or not len(worn):
        return way
    asked, marked = (
        np.concatenate([place, mark], axis=1) for mark in (np.zeros((len(place), 1)), tie_breakers(element))
    )
    apart, near = Nearest(marked[worn], element[worn], _APART).find(asked[bare], element[bare], _FOLLOWS)
    found = np.isfinite(apart)
    share = 1.0 - apart[found] / _FOLLOWS
    way = way.copy()
    way[bare[found]] = way[worn[near[found]]] * (share * share * (3.0 - 2.0 * share))[:, None]
    return way


def _met(vertex: np.ndarray, normal: np.ndarray, way: np.ndarray, count: int) -> np.ndarray:
    """One way for each of ``count`` vertices: the least squares of what each of its nodes (m,) wants along its ``normal`` (m, 3), and, with
    little weight, of the mean of their ways (m, 3)."""
    several = np.bincount(vertex, minlength=count)
    mean = total(vertex, way, count) / np.maximum(several, 1)[:, None]
    along = dot(way - mean[vertex], normal)[:, None] * normal
    right = total(vertex, along, count)
    a, b, c = (total(vertex, normal * normal[:, k : k + 1], count) + _LOOSE * np.eye(3)[k] for k in range(3))
    bulk = dot(a, cross(b, c))  # Cramer's rule: the same bits on any machine
    found = np.stack([dot(right, cross(b, c)), dot(a, cross(right, c)), dot(a, cross(b, right))], axis=-1)
    return mean + np.where((several > 1)[:, None], found / bulk[:, None], 0.0)
