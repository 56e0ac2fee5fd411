"""Where one acts on an object: its surface coloured by the words of a vocabulary, as labels hold from place to place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..annotate.points import field_name, label_points
from ..annotate.seen import BoundHits, SoupHits, bind_hits, carry_vectors
from ..annotate.soup import Soup, make_soup
from .scene import Scene, hex_colour

if TYPE_CHECKING:
    from ..graph.program import Label
    from ..robot.robots import Robots
    from ..runtime.batch import Batch

_NEUTRAL = "d5d9de"
#: one colour per word of a vocabulary, in its order; place 0 is no word
COLOURS = (
    "2f6fd0",
    "9b59b6",
    "e4572e",
    "f2c12e",
    "f28e1c",
    "12a594",
    "7bb32e",
    "d6409f",
    "8c6d4f",
    "5b6b7d",
    "7d2ae8",
    "2aa8e0",
    "b0215a",
    "a03030",
    "3f7f5c",
    "101418",
    "1c3f6e",
    "e58fb0",
    "8fd0c0",
    "b58900",
)
_FINE = 24  # pieces along the diagonal of a primitive
_LEAST = 200  # pieces along that of the object, at most
_STRIPE = 3.0  # pieces to a stripe where several words hold


def words_said(batch: Batch, vocabulary: str) -> list[str]:
    """The words of a vocabulary that some label of the program says, in its order."""
    said = {label.name for label in batch.program.labels if label.vocabulary == vocabulary}
    return [word for word in batch.program.vocabularies.get(vocabulary, ()) if word in said]


def colours_of(batch: Batch, vocabulary: str) -> dict[str, np.ndarray]:
    """The colour of each word that is said, linear light (3,)."""
    every = list(batch.program.vocabularies.get(vocabulary, ()))
    return {word: hex_colour(COLOURS[(every.index(word) - 1) % len(COLOURS)]) for word in words_said(batch, vocabulary)}


def find_regions(
    batch: Batch, robots: Robots, i: int, pose: tuple[np.ndarray, np.ndarray], vocabulary: str
) -> tuple[Scene, set[str]]:
    """Object ``i`` with its links moved by ``pose``, and the words that hold somewhere on it.

    Each labelled primitive is cut into small triangles, and a triangle has the colour of what holds in its middle: mixed
    with the neutral colour by the degree of a graded label, in stripes where several words hold.
    """
    labels = [label for label in batch.program.labels if label.vocabulary == vocabulary]
    made = make_soup(batch, i, i + 1)
    triangle, weights, edge = _cut(made, [target.site for label in labels for target in label.targets])
    middle = SoupHits(triangle, weights.mean(axis=1))
    at = bind_hits(made, middle)
    shares = _degrees(batch, labels, at)
    tint, painted = paint(list(colours_of(batch, vocabulary).values()), shares, at.position, _STRIPE * edge)
    opacity = np.where(painted, 1.0, _opacities(robots, i, made)[triangle])
    kept, weights = _join(triangle, weights, tint)
    triangle, tint, opacity = triangle[kept], tint[kept], opacity[kept]

    corner = np.einsum("sck,skx->scx", weights, made.corner[triangle])
    inner = (0.97 * weights + 0.03 * weights.mean(axis=1, keepdims=True)).reshape(-1, 3)  # the very pole has no normal
    normal = bind_hits(made, SoupHits(np.repeat(triangle, 3), inner)).normal
    turn, shift = pose
    link = np.repeat(made.link[triangle], 3)
    colour = np.concatenate([tint, opacity[:, None]], axis=1).repeat(3, axis=0)
    count = len(link)
    shown = Scene(
        carry_vectors(turn, shift, link, corner.reshape(-1, 3)),
        carry_vectors(turn, None, link, normal),
        np.arange(count).reshape(-1, 3),
        colour,
        np.zeros(count),
        np.full(count, 0.2),
    )
    return shown, {word for word, share in shares.items() if share.any()}


def _cut(made: Soup, labelled: Sequence[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Small triangles: the one that each lies in (S,), barycentric weights of its corners (S, 3, 3), its length (S,).

    Triangles of primitives that no label is on stay whole.
    """
    corner = made.corner
    sides = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2).max(axis=1)
    low, high = (reduce(corner, axis=(0, 1)) for reduce in (np.min, np.max))
    of_row = np.zeros(len(made.rows.owner))
    np.maximum.at(of_row, made.row, sides)
    edge = np.maximum(of_row[made.row] / _FINE, np.linalg.norm(high - low) / _LEAST)
    pieces = np.where(np.isin(made.rows.site[made.row], labelled), np.ceil(sides / edge), 1.0)
    pieces = 2 ** np.ceil(np.log2(np.maximum(pieces, 1.0))).astype(np.int64)
    found = []
    for n in np.unique(pieces).tolist():
        which = np.flatnonzero(pieces == n)
        grid = subdivide(n)
        found.append((np.repeat(which, len(grid)), np.tile(grid, (len(which), 1, 1))))
    triangle = np.concatenate([f[0] for f in found])
    return triangle, np.concatenate([f[1] for f in found]), edge[triangle]


def subdivide(n: int) -> np.ndarray:
    """(n * n, 3, 3): weights of the corners of the triangles that ``n`` cuts along each side make."""
    a, b = (x.ravel() for x in np.mgrid[0:n, 0:n])
    up, down = a + b < n, a + b < n - 1
    upward = [(a[up], b[up]), (a[up] + 1, b[up]), (a[up], b[up] + 1)]
    downward = [(a[down] + 1, b[down]), (a[down] + 1, b[down] + 1), (a[down], b[down] + 1)]
    made = [
        np.stack([np.stack([n - x - y, x, y], axis=-1) for x, y in corners], axis=1) for corners in (upward, downward)
    ]
    return np.concatenate(made) / n


def _degrees(batch: Batch, labels: list[Label], at: BoundHits) -> dict[str, np.ndarray]:
    """How far each word holds at the places, 0 .. 1."""
    fields = label_points(batch, batch.sites(), at, labels).fields
    ordered = words_said(batch, labels[0].vocabulary) if labels else []
    names = {label.name: field_name(label) for label in labels}
    return {word: np.clip(np.nan_to_num(fields[names[word]].astype(np.float64)), 0.0, 1.0) for word in ordered}


def paint(
    tints: list[np.ndarray], shares: dict[str, np.ndarray], position: np.ndarray, stripe: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Colours (S, 3), and whether any word holds (S,)."""
    plain = np.broadcast_to(hex_colour(_NEUTRAL), position.shape)
    if not shares:
        return plain, np.zeros(len(position), dtype=bool)
    degree = np.stack(list(shares.values()))
    holds = degree > 0.0
    many = holds.sum(axis=0)
    turn = np.floor((position[:, 0] + position[:, 1] + position[:, 2]) / (1.7 * stripe)).astype(np.int64)
    chosen = (holds & (holds.cumsum(axis=0) == turn % np.maximum(many, 1) + 1)).argmax(axis=0)
    share = degree[chosen, np.arange(len(chosen))][:, None]
    return plain + share * (np.array(tints)[chosen] - plain), many > 0


def _join(triangle: np.ndarray, weights: np.ndarray, tint: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Take together again what was cut for nothing: the small triangles to keep, and their weights. Those of one large
    triangle follow one another; where all have one colour the first is kept, as large as the whole."""
    first = np.flatnonzero(np.diff(triangle, prepend=-1))
    plain = (np.maximum.reduceat(tint, first) == np.minimum.reduceat(tint, first)).all(axis=1)
    kept = ~np.repeat(plain, np.diff(first, append=len(triangle)))
    kept[first] = True
    weights = weights.copy()
    weights[first[plain]] = np.eye(3)
    return np.flatnonzero(kept), weights[kept]


def _opacities(robots: Robots, i: int, made: Soup) -> np.ndarray:
    """The opacity of each triangle (T,): one looks through panes here as in pictures of materials."""
    places = [(item.group.table, item.row, item) for item in robots.visuals[i]]
    known = {(int(table.site[k]), int(table.row[k])): robots.look(i, item).opacity for table, k, item in places}
    of_row = [known.get(place, 1.0) for place in zip(made.rows.site.tolist(), made.rows.row.tolist(), strict=True)]
    return np.array(of_row)[made.row]
