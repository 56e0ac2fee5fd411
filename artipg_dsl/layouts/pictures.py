"""What cameras see of objects, pixel by pixel: colours, depth, and points with the links and parts that they lie on."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..annotate.views import NONE, make_views
from ..records import dataclass
from ..robot.robots import Robots
from .clouds import norms

if TYPE_CHECKING:
    from ..annotate.cameras import Cameras
    from ..runtime.batch import Batch

_AMBIENT = 0.35  # of the light; the rest comes from the camera


@dataclass(frozen=True, slots=True)
class Picture:
    """Object ``i`` of a batch in a ``state`` of its joints, from a ``view``.

    ``rgb`` (H, W, 3) uint8, white where nothing is; ``depth`` (H, W) metres, 0 there. Of the n pixels that show the object, row by row:
    ``pixel`` (n, 2) row and column; ``camera`` (n, 3) in the camera's frame (x right, y down, z forward), metres; ``position``
    (n, 3) and ``normal`` (n, 3) in the object's; ``link`` and ``instance`` (n,). ``turn`` (3, 3) and ``eye`` (3,) place the camera
    in the object's frame.
    """

    i: int
    state: int
    view: int
    rgb: np.ndarray
    depth: np.ndarray
    pixel: np.ndarray
    camera: np.ndarray
    position: np.ndarray
    link: np.ndarray
    instance: np.ndarray
    normal: np.ndarray
    turn: np.ndarray
    eye: np.ndarray


def pictures(batch: Batch, robots: Robots, cameras: Cameras, values: np.ndarray) -> Iterator[Picture]:
    """What each camera sees of each object of a batch with joints at ``values`` (K, J)."""
    made = make_views(batch, cameras, values)
    images = made.images
    for i in range(len(batch)):
        colours = part_colours(robots, i)
        for state in range(len(values)):
            for view in range(cameras.count):
                at = i, state, view
                depth = images["depth"][at].astype(np.float64)
                row, column = np.nonzero(images["link"][at] != NONE)
                z = depth[row, column]
                place = np.stack(
                    [
                        (column + 0.5 - cameras.width / 2) * z / cameras.focal,
                        (row + 0.5 - cameras.height / 2) * z / cameras.focal,
                        z,
                    ],
                    axis=-1,
                )
                turn, eye = made.extrinsics[at][:3, :3], _camera_place(made.extrinsics[at])
                instance = images["instance"][at][row, column].astype(np.int64)
                normal = images["normal"][at][row, column].astype(np.float64)
                rgb = np.full((*depth.shape, 3), 255, dtype=np.uint8)
                rgb[row, column] = _lit(colours[instance], normal, turn_points(place, turn.T))
                yield Picture(
                    i,
                    state,
                    view,
                    rgb,
                    depth,
                    np.stack([row, column], axis=-1),
                    place,
                    turn_points(place, turn.T) + eye,
                    images["link"][at][row, column].astype(np.int64),
                    instance,
                    normal,
                    turn,
                    eye,
                )


def _camera_place(extrinsic: np.ndarray) -> np.ndarray:
    """Where a camera stands, by its matrix (4, 4) from the object's frame."""
    return -turn_points(extrinsic[None, :3, 3], extrinsic[:3, :3].T)[0]


def turn_points(points: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Points (n, 3) turned by (3, 3), or each by its own (n, 3, 3)."""
    return points[:, :1] * turn[..., 0] + points[:, 1:2] * turn[..., 1] + points[:, 2:] * turn[..., 2]


def _lit(colour: np.ndarray, normal: np.ndarray, ray: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of surfaces that are lit from the camera, 0 .. 255."""
    slope = np.abs((normal * ray).sum(axis=1)) / np.maximum(norms(normal) * norms(ray), 1e-12)
    return np.round(255 * colour * (_AMBIENT + (1 - _AMBIENT) * slope[:, None])).astype(np.uint8)


def part_colours(robots: Robots, i: int) -> np.ndarray:
    """The colour (P, 3), 0 .. 1, of each part instance of an object: that of its largest piece."""
    found = np.full((int(robots.part_start[i + 1] - robots.part_start[i]), 3), 0.5)
    most = np.zeros(len(found))
    for link in robots.robot(i).links:
        for visual in link.visuals:
            k = int(visual.item.group.table.instance[visual.item.row])
            size = float(norms(np.ptp(visual.shape.vertices, axis=0)))
            if size > most[k]:
                most[k], found[k] = size, visual.look.colour
    return found
