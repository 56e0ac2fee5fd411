"""Partial views: what cameras around the objects of a batch see, as images and as clouds of exactly k points."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np

from .. import random
from ..errors import UsageError, UserError
from ..extras import EMBREE
from ..geometry.rays import ENGINES, NEAR, Caster, Grid, best_engine, intersect, rotate_vectors
from ..records import dataclass
from ..runtime.columns import Columns
from .cameras import Cameras, extrinsics
from .points import field_kinds
from .seen import SoupHits, bind_hits, carry_vectors, is_amid_solids, part_coordinates, read_classes, read_labels
from .soup import Soup, make_soup

if TYPE_CHECKING:
    from ..runtime.batch import Batch

NONE = 0xFFFF  # a pixel that shows nothing, in images of numbers
_PIXELS = 1_300_000  # of a block of objects: arrays over its pixels are used many times
_MOST_RAYS = 4_000_000  # for one cloud
Arrays = dict[str, np.ndarray]


@dataclass(frozen=True, slots=True, repr=False)
class Views(Columns):
    """What B objects (in K states) look like from V cameras each. ``...`` is B, V; with states B, K, V.

    ``intrinsics`` (..., 3, 3); ``extrinsics`` (..., 4, 4) from the object's frame to the camera's (x right, y down, z
    forward). ``images`` (..., H, W), one number or three for each pixel: ``depth`` along z in metres, 0 where nothing
    is; ``normal`` in the object's frame and ``npcs``, the normalised coordinates of ``instance`` (as in ``poses``), 0
    where nothing is; ``semantic``, ``instance`` (part number), ``link``, ``NONE`` where nothing is. ``cloud`` (..., k):
    ``points`` and ``normals`` in the object's frame, ``camera`` in the camera's, ``pixel`` (row, column), ``npcs`` and
    numbers as in the images, and the labels by name.
    """

    intrinsics: np.ndarray
    extrinsics: np.ndarray
    images: Arrays
    cloud: Arrays


def make_views(
    batch: Batch, cameras: Cameras | None = None, states: np.ndarray | None = None, engine: str | None = None
) -> Views:
    """Views of every object, with joints at ``states`` (J,) or (K, J), at rest by default.

    The cameras of an object are the same in any batch and in all of its states, but for their distance, which follows
    its size. ``engine``: "embree" or "numpy", the best there is by default. Raises UserError if a camera sees nothing,
    or stands within a solid.
    """
    made = _Views(batch, cameras or Cameras(), states, _find_engine(engine))
    made.fill()
    return made.views()


def see_points(
    batch: Batch, cameras: Cameras, states: np.ndarray | None = None, engine: str | None = None
) -> np.ndarray:
    """Of ``make_views`` the ``points`` of its clouds alone, (..., k, 3) float32, in a part of the time. Raises as it does."""
    made = _Places(batch, cameras, states, _find_engine(engine))
    made.fill()
    return made.points.reshape(*made.lead, cameras.points, 3)


def _find_engine(engine: str | None) -> str:
    """The best there is where none is named. Raises UsageError, UserError."""
    engine = engine or best_engine()
    if engine not in ENGINES:
        raise UsageError(f"there is no engine `{engine}` to cast rays with", f"there are {', '.join(ENGINES)}")
    if engine == "embree" and best_engine() != "embree":
        raise EMBREE.missing("the engine `embree`")
    return engine


def _enter(array: np.ndarray, at: np.ndarray, values: np.ndarray) -> None:
    """``array[at] = values``, the columns of vectors one by one, which takes a sixth of the time."""
    if array.ndim == 1:
        array[at] = values
        return
    for k in range(array.shape[1]):
        array[:, k][at] = values[:, k]


class _Shots(ABC):
    """A *shot* is one object in one state seen by one camera; ``lead`` is their shape. Arrays are filled some objects at a time."""

    def __init__(self, batch: Batch, cameras: Cameras, states: np.ndarray | None, engine: str):
        self.batch, self.cameras, self.caster = batch, cameras, ENGINES[engine]
        several = states is not None and np.ndim(states) == 2
        self.poses = [batch.pose(one) for one in (np.asarray(states) if several else [states])]
        self.each = len(self.poses)
        self.lead = (len(batch), self.each, cameras.count) if several else (len(batch), cameras.count)
        self.count = len(batch) * self.each * cameras.count
        self.turn, self.eye = np.zeros((self.count, 3, 3)), np.zeros((self.count, 3))
        self.key = random.key(batch.seed, "views")

    def fill(self) -> None:
        """All objects."""
        pixels = self.each * self.cameras.count * self.cameras.width * self.cameras.height
        step = min(max(1, _PIXELS // pixels), 16)
        for first in range(0, len(self.batch), step):
            self._fill_some(first, min(first + step, len(self.batch)))

    def _fill_some(self, first: int, stop: int) -> None:
        """The objects ``first .. stop - 1``."""
        made = make_soup(self.batch, first, stop)
        shots: list[_Shot] = []
        for i in range(first, stop):
            span = slice(int(made.start[i - first]), int(made.start[i - first + 1]))
            for k, (rotation, translation) in enumerate(self.poses):
                corner = carry_vectors(rotation, translation, made.link[span], made.corner[span])
                ends = np.array([[corner[..., axis].min(), corner[..., axis].max()] for axis in range(3)])
                half = (ends[:, 1] - ends[:, 0]) / 2
                radius = np.sqrt(half[:1] * half[:1] + half[1:2] * half[1:2] + half[2:] * half[2:])
                target = _Target(int(self.batch.numbers[i]), corner, ends, span.start, self.caster(corner))
                turn, eye = self.cameras.place(self.key, target.address[None], (ends[:, 0] + half)[None], radius)
                at = (i * self.each + k) * self.cameras.count
                self.turn[at : at + self.cameras.count], self.eye[at : at + self.cameras.count] = turn[0], eye[0]
                if self.cameras.poses:  # others stand outside the sphere around the object
                    amid = np.flatnonzero(is_amid_solids(made, i - first, rotation, translation, eye[0]))
                    if len(amid):
                        raise UserError(
                            f"view {amid[0]} of object {target.number} is taken from within one of its solids",
                            "move the camera's `eye` out of it",
                        )
                for v in range(self.cameras.count):
                    shots.append(_Shot(self, target, at + v, v))
        self._write(made, shots)

    @abstractmethod
    def _write(self, made: Soup, shots: list[_Shot]) -> None:
        """What is wanted of some shots, everything that does not depend on the shot for all of them at once."""

    def _moved(self, shots: list[_Shot], shot: np.ndarray, link: np.ndarray) -> np.ndarray:
        """The rows (n,) in all poses, one after the other, of points on the link rows ``link`` (n,) in the shots ``shot`` (n,)."""
        state = np.array([s.number // self.cameras.count % self.each for s in shots])[shot]
        return np.asarray(state * len(self.poses[0][0]) + link)

    def _slots(self, shots: list[_Shot]) -> np.ndarray:
        """Where the points of the clouds of some shots are among those of all."""
        k = self.cameras.points
        return (np.array([s.number for s in shots])[:, None] * k + np.arange(k)).ravel()


class _Places(_Shots):
    """Where the points of the clouds are, and nothing else."""

    def __init__(self, batch: Batch, cameras: Cameras, states: np.ndarray | None, engine: str):
        super().__init__(batch, cameras, states, engine)
        self.points = np.zeros((self.count * cameras.points, 3), np.float32)

    def _write(self, made: Soup, shots: list[_Shot]) -> None:
        chosen = [s.hits.take(s.chosen) for s in shots]
        hits = SoupHits(*(np.concatenate([getattr(one, name) for one in chosen]) for name in SoupHits.__slots__))
        row = self._moved(shots, np.repeat(np.arange(len(shots)), self.cameras.points), made.link[hits.triangle])
        turn, shift = (np.concatenate(parts) for parts in zip(*self.poses, strict=True))
        self.points[self._slots(shots)] = carry_vectors(turn, shift, row, hits.blend(made.corner))


class _Views(_Shots):
    """All that ``Views`` has."""

    def __init__(self, batch: Batch, cameras: Cameras, states: np.ndarray | None, engine: str):
        super().__init__(batch, cameras, states, engine)
        pixels, k = cameras.width * cameras.height, cameras.points
        self.images = self._arrays(self.count * pixels, {"depth": 1, "normal": 3, "npcs": 3})
        more = {"points": 3, "camera": 3, "normals": 3, "npcs": 3}
        self.cloud = self._arrays(self.count * k, more)
        self.cloud["pixel"] = np.zeros((self.count * k, 2), np.uint16)
        kinds = field_kinds(batch.program.labels)
        self.cloud |= {
            n: np.zeros(
                (self.count * k, 3) if kind == "vectors" else self.count * k, bool if kind == "mask" else np.float32
            )
            for n, kind in kinds.items()
        }

    @staticmethod
    def _arrays(size: int, vectors: dict[str, int]) -> Arrays:
        made = {n: np.zeros((size, width) if width > 1 else size, np.float32) for n, width in vectors.items()}
        return made | {name: np.full(size, NONE, np.uint16) for name in ("semantic", "instance", "link")}

    def views(self) -> Views:
        """The arrays in their final shapes."""
        c, lead = self.cameras, self.lead
        images = {n: a.reshape(*lead, c.height, c.width, *a.shape[1:]) for n, a in self.images.items()}
        cloud = {n: a.reshape(*lead, c.points, *a.shape[1:]) for n, a in self.cloud.items()}
        inside = np.broadcast_to(c.intrinsics(), (*lead, 3, 3)).copy()
        outside = extrinsics(self.turn, self.eye).reshape(*lead, 4, 4)
        return Views(inside, outside, images, cloud)

    def _write(self, made: Soup, shots: list[_Shot]) -> None:
        hits = SoupHits(*(np.concatenate([getattr(s.hits, name) for s in shots]) for name in SoupHits.__slots__))
        shot = np.repeat(np.arange(len(shots)), [len(s.hits.triangle) for s in shots])
        bound = bind_hits(made, hits)
        link, part = made.link[hits.triangle], made.part[hits.triangle]
        row = self._moved(shots, shot, link)
        turn, shift = (np.concatenate(parts) for parts in zip(*self.poses, strict=True))
        every = {
            "normal": carry_vectors(turn, None, row, bound.normal),
            "npcs": part_coordinates(self.batch, part, bound.position),
            "semantic": read_classes(self.batch, bound),
            "instance": np.asarray(self.batch.parts().number)[part],
            "link": np.asarray(self.batch.links().number)[link],
        }
        depth = np.concatenate([s.depth for s in shots])
        pixels = self.cameras.width * self.cameras.height
        place = np.concatenate([s.number * pixels + s.pixel for s in shots])
        within = np.concatenate([np.arange(len(s.pixel)) < s.in_image for s in shots])
        seen = slice(None) if within.all() else within
        shown = place[seen]
        self.images["depth"][shown] = depth[seen]
        for name, values in every.items():
            _enter(self.images[name], shown, values[seen])

        begins = np.cumsum([0, *(len(s.pixel) for s in shots[:-1])])
        chosen = np.concatenate([begin + s.chosen for begin, s in zip(begins, shots, strict=True)])
        slot = self._slots(shots)
        every["normals"] = every.pop("normal")
        position = carry_vectors(turn, shift, row[chosen], bound.position[chosen])
        which = np.array([s.number for s in shots])[shot[chosen]]
        camera = carry_vectors(self.turn, None, which, position - self.eye[which])
        line, column = np.divmod(place[chosen] % pixels, self.cameras.width)
        for name, values in every.items():
            _enter(self.cloud[name], slot, values[chosen])
        _enter(self.cloud["points"], slot, position)
        _enter(self.cloud["camera"], slot, camera)
        self.cloud["pixel"][slot] = np.stack([line, column], axis=-1)
        for name, values in read_labels(self.batch, bound.take(chosen)).fields.items():
            if values.ndim == 2:
                values = carry_vectors(turn, None, row[chosen], values)
            _enter(self.cloud[name], slot, values)


@dataclass(frozen=True, slots=True)
class _Target:
    """An object in one state: its triangles ``corner`` (T, 3, 3), ``first`` the number of their first in the soup, and
    the ``ends`` (3, 2) of its box."""

    number: int
    corner: np.ndarray
    ends: np.ndarray
    first: int
    caster: Caster

    @property
    def address(self) -> np.ndarray:
        return np.asarray(self.number, dtype=np.uint64)


class _Shot:
    """The hits of one camera: first those of the ``in_image`` pixels, then those that a cloud needs beside them."""

    def __init__(self, of: _Shots, target: _Target, number: int, view: int):
        self.target, self.number, self.view = target, number, view
        self.turn, self.eye, self.cameras = of.turn[number], of.eye[number], of.cameras
        self.draw = of.key, random.mix(target.address, view)
        c = self.cameras
        low, high = self._window(target.ends)
        columns, rows = (high - low).tolist()
        grid = self._grid(low[0] + 0.5, low[1] + 0.5, 1.0, columns, rows)
        self.local = rotate_vectors(self.turn, target.corner - self.eye)  # (T, 3, 3) in the camera's frame
        triangle, weights, depth, at = self._cast(grid)
        y, x = np.divmod(at, max(columns, 1))
        self.pixel = (y + low[1]) * c.width + (x + low[0])
        self.in_image = len(at)
        if not len(at):
            raise UserError(
                f"view {view} of object {target.number} does not see it",
                "turn the camera towards the object, or bring it nearer",
            )
        if len(at) < c.points:
            more = self._between(c.points - len(at))
            triangle, weights = np.concatenate([triangle, more[0]]), np.concatenate([weights, more[1]])
            depth, self.pixel = np.concatenate([depth, more[2]]), np.concatenate([self.pixel, more[3]])
        key, address = self.draw
        self.chosen = random.orders(random.streams(key, address.reshape(1)), len(triangle))[0, : c.points]
        self.depth = depth
        self.hits = SoupHits(triangle + target.first, weights)

    def _window(self, ends: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The pixels [low, high) that the picture of the object's box, ``ends`` (3, 2), lies within."""
        size = np.array([self.cameras.width, self.cameras.height])
        corners = np.stack(np.meshgrid(*ends, indexing="ij"), axis=-1).reshape(-1, 3)
        local = rotate_vectors(self.turn, corners - self.eye)
        if local[:, 2].min() <= NEAR:
            return np.zeros(2, np.int64), size
        place = local[:, :2] / local[:, 2:] * self.cameras.focal + size / 2
        low, high = np.floor(place.min(axis=0)), np.ceil(place.max(axis=0))
        return np.clip(low, 0, size).astype(np.int64), np.clip(high, 0, size).astype(np.int64)

    def _grid(self, left: float, top: float, step: float, columns: int, rows: int) -> Grid:
        c = self.cameras
        return Grid((c.focal, c.focal), (c.width / 2, c.height / 2), float(left), float(top), step, columns, rows)

    def _cast(self, grid: Grid) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Triangles, barycentric weights, depths along z and numbers of the rays of a grid that meet the object."""
        found = self.target.caster.first(self.turn, self.eye, grid)
        at = np.flatnonzero(found >= 0)
        hits = SoupHits(found[at], intersect(self.local, found[at], grid.directions()[at]))
        return hits.triangle, hits.weights, hits.blend(self.local[..., 2:])[:, 0], at

    def _some(self, count: int, of: int) -> np.ndarray:
        """``count`` of the numbers 0 .. ``of`` - 1 at random, ascending."""
        key, address = self.draw
        return np.sort(random.orders(random.streams(key, address.reshape(1), 2), of)[0, :count])

    def _between(self, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """``count`` more hits of rays through the pixels that show the object: triangles, weights, depths, pixels."""
        width = self.cameras.width
        y, x = np.divmod(self.pixel, width)
        low, high = np.array([x.min(), y.min()]), np.array([x.max() + 1, y.max() + 1])
        visible = np.zeros(width * self.cameras.height, dtype=bool)
        visible[self.pixel] = True
        offset = random.pair(*self.draw, 0, 1)
        fine = int(np.ceil(np.sqrt(1.5 * count / len(self.pixel)))) + 1
        while True:
            columns, rows = ((high - low) * fine).tolist()
            if columns * rows > _MOST_RAYS:
                raise UserError(
                    f"view {self.view} of object {self.target.number} sees next to nothing of it",
                    "bring the camera nearer, or ask for fewer points",
                )
            left, top = (float(low[i] + offset[i].item() / fine) for i in range(2))
            triangle, weights, depth, at = self._cast(self._grid(left, top, 1.0 / fine, columns, rows))
            j, i = np.divmod(at, columns)
            pixel = (low[1] + j // fine) * width + low[0] + i // fine
            kept = np.flatnonzero(visible[pixel])
            if len(kept) >= count:
                kept = kept[self._some(count, len(kept))]
                return triangle[kept], weights[kept], depth[kept], pixel[kept]
            fine *= 2
