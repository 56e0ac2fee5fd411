"""What a renderer gets: the triangles of one object with its joints at some values, coloured by part or by material."""

from __future__ import annotations

import numpy as np

from ..annotate.frames import rotate
from ..annotate.states import open_values
from ..records import dataclass
from ..robot.materials import to_linear
from ..robot.robots import Robots

COLOURINGS = ("part", "material", "affordance")
# hues of semantic classes in the order of the vocabulary; the first word, as a rule the body, is neutral
_PALETTE = (
    "c4ccd5",
    "4a86cf",
    "e8603c",
    "62a87c",
    "f2a93b",
    "8e6bb0",
    "2fa5a8",
    "d8648f",
    "9a7256",
    "5f6f7a",
    "b3c151",
    "e9b59c",
    "3f5f9e",
    "c9473a",
    "3f7f5c",
    "c98a1b",
)
# Words that are as many places apart as there are hues share one: below 0 a share of black in it, above 0 of white
_SHADES = (0.0, -0.45, 0.25, -0.65, 0.45, -0.2, -0.85, 0.6)
_UNSAID = "efece6"  # of what has no label


@dataclass(frozen=True, slots=True)
class Scene:
    """``vertices``, ``normals`` (V, 3) in the object's frame, metres; ``faces`` (F, 3), outward.

    ``colour`` (V, 4) is linear light and opacity; ``metalness`` and ``gloss`` (1 - roughness) are (V,), all 0 .. 1.
    """

    vertices: np.ndarray
    normals: np.ndarray
    faces: np.ndarray
    colour: np.ndarray
    metalness: np.ndarray
    gloss: np.ndarray

    def split(self) -> tuple[np.ndarray, np.ndarray]:
        """Numbers of the opaque faces, and of those one sees through."""
        clear = self.colour[self.faces[:, 0], 3] < 0.999
        return np.flatnonzero(~clear), np.flatnonzero(clear)


def hex_colour(text: str) -> np.ndarray:
    """Linear light (3,) of ``rrggbb``."""
    return to_linear(np.array([int(text[i : i + 2], 16) / 255 for i in (0, 2, 4)]))


def part_colours() -> np.ndarray:
    """Linear light (P, 3) of the first P words; from there on the colours come again."""
    hues = np.array([hex_colour(text) for text in _PALETTE])
    return np.concatenate([hues * (1.0 - abs(shade)) + max(shade, 0.0) for shade in _SHADES])


def make_scene(robots: Robots, i: int, pose: tuple[np.ndarray, np.ndarray], colouring: str = "part") -> Scene:
    """Object ``i`` of a batch with its links moved by ``pose``, what ``batch.pose`` returns for the whole batch."""
    turn, shift = pose
    semantic = part_colours()
    parts: dict[str, list[np.ndarray]] = {
        n: [] for n in ("vertices", "normals", "faces", "colour", "metalness", "gloss")
    }
    first = 0
    for item in robots.visuals[i]:
        group, shading = item.group, item.group.shading
        link = int(robots.link_start[i]) + int(group.table.link[item.row])
        vertices = rotate(turn[link], group.vertices[item.k][shading.source]) + shift[link]
        look = robots.look(i, item)
        rgb = to_linear(np.array(look.colour))
        if colouring == "part":
            word = int(group.table.semantic[item.row])
            rgb = semantic[(word - 1) % len(semantic)] if word else hex_colour(_UNSAID)
        count = len(vertices)
        parts["vertices"].append(vertices)
        parts["normals"].append(rotate(turn[link], shading.normals[item.k]))
        parts["faces"].append(shading.faces + first)
        parts["colour"].append(np.broadcast_to([*rgb, look.opacity], (count, 4)))
        plain = colouring == "part"
        parts["metalness"].append(np.full(count, 0.0 if plain else look.metalness))
        parts["gloss"].append(np.full(count, 0.3 if plain and look.opacity > 0.99 else 1.0 - look.roughness))
        first += count
    return Scene(**{name: np.concatenate(arrays) for name, arrays in parts.items()})


__all__ = ["COLOURINGS", "Scene", "hex_colour", "open_values", "make_scene", "part_colours"]
