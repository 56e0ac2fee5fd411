"""Grasps and keypoints: families in a parameter ``t`` laid out at evenly spaced values, in the object's frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..geometry.vectors import length
from ..graph.program import MEASURES, Grasp, Keypoint
from ..records import dataclass
from ..runtime.columns import Columns
from ..runtime.fields import Field, FieldReader, read_pose, read_triples
from .frames import quaternion, reflect, rotate


@dataclass(frozen=True, slots=True, repr=False)
class GraspTable(Columns):
    """One row per grasp and value of ``t``, sorted by owner; frames at joint values 0 until they are moved.

    ``point`` (G, 3) between the fingers; the frame's axes: z ``approach`` (into the object), y ``close`` (the fingers
    move along it), x = y cross z; ``rotation`` (G, 3, 3) has them as columns; ``opening`` (G,) metres. ``hand`` (G, 8): the
    measures of the gripper that a grasp is meant for, in the order of ``MEASURES``, nan where it states none.
    """

    owner: np.ndarray
    link: np.ndarray
    family: np.ndarray
    name: list[str]
    t: np.ndarray
    point: np.ndarray
    rotation: np.ndarray
    opening: np.ndarray
    quality: np.ndarray
    hand: np.ndarray

    def take(self, at: np.ndarray) -> GraspTable:
        """The rows ``at``, ascending."""
        columns = (getattr(self, name) for name in self.__slots__)
        rows: list[Any] = [[c[k] for k in at] if isinstance(c, list) else c[at] for c in columns]
        return GraspTable(*rows)

    def moved(
        self, link_start: np.ndarray, turn: np.ndarray, shift: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Point, rotation, quaternion (w x y z) with links moved as by ``batch.pose``: turn (L, 3, 3), shift (L, 3)."""
        link = link_start[self.owner] + self.link
        rotation = np.stack([rotate(turn[link], self.rotation[..., j]) for j in range(3)], axis=-1)
        return rotate(turn[link], self.point) + shift[link], rotation, quaternion(rotation)


@dataclass(frozen=True, slots=True, repr=False)
class KeypointTable(Columns):
    """One row per keypoint, sorted by owner; ``point`` (K, 3) in the object's frame at joint values 0."""

    owner: np.ndarray
    link: np.ndarray
    name: list[str]
    point: np.ndarray


def sample_grasps(reader: FieldReader, values: int = 5) -> GraspTable:
    """All grasps of a batch, each family at ``values`` evenly spaced parameters."""
    columns: list[dict[str, np.ndarray]] = []
    names: list[str] = []
    for number, grasp in enumerate(reader.program.grasps):
        owner = np.asarray(reader.owner(grasp.scope))
        if not len(owner):
            continue
        low, high = (np.asarray(v, dtype=np.float64) for v in reader.read([grasp.low, grasp.high], grasp.scope))
        rotation, translation, mirror = read_pose(reader, grasp.frame, grasp.scope)
        size, center = read_triples(reader, [grasp.size, grasp.center], grasp.scope)
        field = Field.of(grasp.formulas)
        inputs = [np.asarray(v)[:, None] for v in reader.read(field.inputs, grasp.scope)] if field.inputs else []
        share = np.arange(values) / (values - 1) if values > 1 else np.array([0.5])
        t = low[:, None] + (high - low)[:, None] * share
        variables = {"t": t} | {f"size.{axis}": size[:, i : i + 1] for i, axis in enumerate("xyz")}
        raw = [np.asarray(v, dtype=np.float64) for v in field(inputs, variables)]
        at, approach, close = (np.stack(raw[3 * i : 3 * i + 3], axis=-1) for i in range(3))
        point = rotate(rotation[:, None], reflect(at + center[:, None], mirror)) + translation[:, None]
        approach = rotate(rotation[:, None], reflect(approach, mirror))
        close = rotate(rotation[:, None], reflect(close, mirror))
        columns.append(
            {
                "owner": np.repeat(owner, values),
                "link": np.repeat(reader.link_numbers(grasp.scope, grasp.link), values),
                "family": np.full(t.size, number),
                "t": t.ravel(),
                "point": point.reshape(-1, 3),
                "rotation": grasp_frame(approach, close).reshape(-1, 3, 3),
                "opening": raw[9].ravel(),
                "quality": raw[10].ravel(),
                "hand": _hand(grasp, raw[11:], t.size),
            }
        )
        names += [grasp.name] * t.size
    if not columns:
        none = np.zeros(0)
        count = np.zeros(0, dtype=np.int64)
        return GraspTable(
            count,
            count,
            count,
            [],
            none,
            np.zeros((0, 3)),
            np.zeros((0, 3, 3)),
            none,
            none,
            np.zeros((0, len(MEASURES))),
        )
    joined = {key: np.concatenate([column[key] for column in columns]) for key in columns[0]}
    order = np.argsort(joined["owner"], kind="stable")
    return GraspTable(name=[names[i] for i in order], **{key: value[order] for key, value in joined.items()})


def _hand(grasp: Grasp, values: list[np.ndarray], count: int) -> np.ndarray:
    """The measures that a family states, (count, 8)."""
    out = np.full((count, len(MEASURES)), np.nan)
    for (name, _), value in zip(grasp.hand, values, strict=True):
        out[:, MEASURES.index(name)] = value.ravel()
    return out


def grasp_frame(approach: np.ndarray, close: np.ndarray) -> np.ndarray:
    """Right-handed frames (..., 3, 3), columns x y z: z along ``approach``, y what of ``close`` is square to it."""
    z = approach / length(approach)
    y = close - (close[..., :1] * z[..., :1] + close[..., 1:2] * z[..., 1:2] + close[..., 2:] * z[..., 2:]) * z
    y = y / length(y)
    return np.stack([np.cross(y, z), y, z], axis=-1) + 0.0


def sample_keypoints(reader: FieldReader) -> KeypointTable:
    """All keypoints of a batch."""
    owners, links, points, names = [], [], [], []
    for keypoint in reader.program.keypoints:
        owner, point = place_keypoint(reader, keypoint)
        owners.append(owner)
        links.append(reader.link_numbers(keypoint.scope, keypoint.link))
        points.append(point)
        names += [keypoint.name] * len(owner)
    if not owners:
        count = np.zeros(0, dtype=np.int64)
        return KeypointTable(count, count, [], np.zeros((0, 3)))
    order = np.argsort(np.concatenate(owners), kind="stable")
    owner, link = np.concatenate(owners)[order], np.concatenate(links)[order]
    return KeypointTable(owner, link, [names[i] for i in order], np.concatenate(points)[order])


def place_keypoint(reader: FieldReader, keypoint: Keypoint) -> tuple[np.ndarray, np.ndarray]:
    """The objects (k,) that have a keypoint, once for each time, and where (k, 3) it is."""
    owner = np.asarray(reader.owner(keypoint.scope))
    return owner, read_triples(reader, [keypoint.point], keypoint.scope)[0].reshape(-1, 3)
