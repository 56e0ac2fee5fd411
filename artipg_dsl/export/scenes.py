"""Objects as trimesh scenes, for whoever goes on in Python."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np
import trimesh

from ..annotate.frames import rotate
from ..geometry.resolution import Resolution
from ..robot.robots import Robots

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..runtime.batch import Batch


def make_scenes(
    batch: Batch, states: np.ndarray | None, resolution: Resolution, details: Dressing | None
) -> list[trimesh.Scene]:
    """One scene per object with the joints at ``states`` (J,), at rest by default: a closed mesh per primitive, in ``details`` if given.

    Metres, the object's frame; a mesh is named after its part (``feet``, ``feet.2``, ... where that has several
    primitives), its metadata tells link and material.
    """
    robots = Robots(batch, resolution=resolution, physics=False, details=details)
    turn, shift = batch.pose(states)
    made = []
    for i, number in enumerate(batch.numbers.tolist()):
        scene = trimesh.Scene(metadata={"object": number, "category": batch.program.name})
        first, robot = int(robots.link_start[i]), robots.robot(i)
        taken: Counter[str] = Counter()
        for k, link in enumerate(robot.links):
            for visual in link.visuals:
                place = visual.shape.vertices + link.origin
                vertices = rotate(turn[first + k], place) + shift[first + k]
                mesh = trimesh.Trimesh(vertices, visual.shape.faces, process=False)
                red, green, blue = visual.look.colour
                colour = np.round(255 * np.array([red, green, blue, visual.look.opacity])).astype(np.uint8)
                mesh.visual = trimesh.visual.ColorVisuals(mesh, face_colors=colour)
                mesh.metadata = {"link": link.name, "material": visual.look.name}
                taken[visual.name] += 1
                count = taken[visual.name]
                name = visual.name if count == 1 else f"{visual.name}.{count}"  # a scene has one node of a name
                scene.add_geometry(mesh, node_name=name, geom_name=name)
        made.append(scene)
    return made
