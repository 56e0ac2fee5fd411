"""Wavefront OBJ text, 9 significant digits, metres: meshes for robot formats, and a file per link to be seen."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from itertools import accumulate
from typing import TYPE_CHECKING

import numpy as np

from ..native.digits import print_blocks, print_rows
from ..robot.naming import Names
from ..robot.pose import rest_poses
from ..robot.primitives import Collider, SeenMaterial, Shape, Visual

if TYPE_CHECKING:
    from ..robot.model import Robot

_LIBRARY = "object.mtl"
_FEW = 1024  # faces, up to which their text is kept
_VERTEX, _NORMAL, _FACE = (("v ", " ", " ", "\n"), ("vn ", " ", " ", "\n"), ("f ", " ", " ", "\n"))
_SHADED = ("f ", "//", " ", "//", " ", "//", "\n")


def obj_texts(
    files: Sequence[tuple[Sequence[Shape], Sequence[str]]],
    place: Callable[[np.ndarray], np.ndarray] = np.asarray,
    turn: Callable[[np.ndarray], np.ndarray] = np.asarray,
    names: Sequence[str] | None = None,
) -> list[str]:
    """The text of several files: shapes one after the other (each closed by itself, none shares a vertex), and where there are
    ``looks``, the material of each, by its name in the library of materials. Each shape is an ``o`` of its own; where files have
    ``names``, all shapes of one are an ``o`` of this name, and comments tell of theirs: MuJoCo drops what comes after the first
    ``o``. All vertices (V, 3) of all files are placed at once, and all normals (W, 3) turned."""
    every = [shape for shapes, _ in files for shape in shapes]
    shaded = [shape.normals[0] for shape in every if shape.normals is not None]
    vertices = iter(_lines([shape.vertices for shape in every], place, "%.9g", _VERTEX))
    normals = iter(_lines(shaded, lambda rows: np.round(turn(rows), 6), "%.6g", _NORMAL))
    found = []
    for n, (shapes, looks) in enumerate(files):
        parts: list[str] = [] if names is None else [f"o {names[n]}\n"]
        first = first_normal = 1  # OBJ counts vertices of the whole file from 1
        for k, shape in enumerate(shapes):
            parts.append(f"{'o' if names is None else '#'} {shape.name}\n")
            parts.append(next(vertices))
            if shape.normals is not None:
                parts.append(next(normals))
            if looks:
                parts.append(f"usemtl {looks[k]}\n")
            if shape.normals is None:
                parts.append(_faces_text(shape.faces, first))
            else:
                parts.append(_faces_text(shape.faces, first, shape.normals[1], first_normal))
                first_normal += len(shape.normals[0])
            first += len(shape.vertices)
        found.append("".join(parts))
    return found


def _lines(
    blocks: Sequence[np.ndarray], moved: Callable[[np.ndarray], np.ndarray], form: str, marks: Sequence[str]
) -> list[str]:
    """The lines of each of several blocks (n, 3) of numbers, which are ``moved`` all at once."""
    if not blocks:
        return []
    rows = moved(np.concatenate(blocks, dtype=np.float64)) + 0.0  # + 0.0: no "-0"
    return print_blocks(rows, [0, *accumulate(map(len, blocks))], form, marks)


def _faces_text(faces: np.ndarray, first: int, corners: np.ndarray | None = None, first_normal: int = 0) -> str:
    """Triangles (F, 3) with the number of the ``first`` vertex, and which normals their ``corners`` (F, 3) have."""
    given = [np.ascontiguousarray(array, dtype=np.int64).tobytes() for array in (faces, corners) if array is not None]
    make = _numbered if len(faces) <= _FEW else _numbered.__wrapped__
    return make(tuple(given), (first, first_normal))


@lru_cache(maxsize=512)
def _numbered(faces: tuple[bytes, ...], first: tuple[int, int]) -> str:
    """Lines of faces; those of a primitive are alike in all objects that have as many before it."""
    numbers = [np.frombuffer(data, dtype=np.int64) + start for data, start in zip(faces, first, strict=False)]
    return print_rows(
        np.stack(numbers, axis=-1).reshape(-1, 3 * len(faces)), "%d", _SHADED if len(faces) > 1 else _FACE
    )


def obj_bytes(shapes: Sequence[Shape]) -> bytes:
    (text,) = obj_texts([(shapes, ())])
    return text.encode("utf-8")


Mesh = tuple[str, "SeenMaterial", bytes]  # the name of a file, how it looks, its text


def link_meshes(robot: Robot) -> dict[str, list[Mesh]]:
    """For each link, by its name, one OBJ for each material, in the link's frame."""
    own: dict[tuple[str, str], list[Visual]] = {}
    for link in robot.links:
        for visual in link.visuals:
            own.setdefault((link.name, link.meshes[visual.look.name]), []).append(visual)
    texts = obj_texts([([visual.shape for visual in same], ()) for same in own.values()], names=[f for _, f in own])
    found: dict[str, list[Mesh]] = {link.name: [] for link in robot.links}
    for ((name, file), same), text in zip(own.items(), texts, strict=True):
        found[name].append((file, same[0].look, text.encode("utf-8")))
    return found


def piece_meshes(robot: Robot, told: Callable[[Collider], bool]) -> dict[str, bytes]:
    """An OBJ for the hull of each collider, by its full name, in the link's frame; none of those that are ``told`` without."""
    hulls = {c.full: c.hull for link in robot.links for c in link.colliders if c.hull is not None and not told(c)}
    texts = obj_texts([([Shape("piece", hull.vertices, hull.faces)], ()) for hull in hulls.values()])
    return {name: text.encode("utf-8") for name, text in zip(hulls, texts, strict=True)}


def obj_files(robot: Robot) -> dict[str, bytes]:
    """``obj/<link>.obj`` for every link with something to see, in the object's frame at rest, and their materials.

    z up, x front, metres: the files of an object loaded together show it as it stands.
    """
    files: dict[str, bytes] = {}
    own = Names()
    seen = [(link, pose) for link, pose in zip(robot.links, rest_poses(robot), strict=True) if link.visuals]
    texts = obj_texts(
        [([_placed(v, *pose) for v in link.visuals], [v.look.name for v in link.visuals]) for link, pose in seen]
    )
    for (link, _), text in zip(seen, texts, strict=True):
        files[f"obj/{own(link.name)}.obj"] = f"mtllib {_LIBRARY}\n{text}".encode()
    looks = dict.fromkeys(visual.look for link in robot.links for visual in link.visuals)
    told = f"# {robot.note}\n" if robot.note else ""
    files[f"obj/{_LIBRARY}"] = (told + mtl_text(looks)).encode("utf-8")
    return files


def _placed(visual: Visual, turn: np.ndarray, shift: np.ndarray) -> Shape:
    """A visual with the pose of its link."""
    shading, still = visual.item.group.shading, np.zeros(3)
    normals = move_points(shading.normals[visual.item.k], turn, still), shading.faces
    shape = visual.shape
    return Shape(visual.name, move_points(shape.vertices, turn, shift), shape.faces, normals)


def move_points(points: np.ndarray, turn: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """Points (n, 3) turned by (3, 3) and shifted by (3,), without BLAS: the same bits everywhere."""
    return points[:, :1] * turn[:, 0] + points[:, 1:2] * turn[:, 1] + points[:, 2:] * turn[:, 2] + shift


def mtl_text(looks: Iterable[SeenMaterial]) -> str:
    """Materials: sRGB colour and opacity as every reader takes them, and Pr, Pm (roughness, metalness) for newer ones.

    The shininess of older readers is the Phong exponent that spreads light like the roughness r: 2 / r^4 - 2
    (B. Walter and others, Microfacet models for refraction, 2007, with the width of the lobe r^2), at most 1000.
    """
    blocks = []
    for look in looks:
        shine = min(2.0 / max(look.roughness, 0.1) ** 4 - 2.0, 1000.0)
        mirror = [look.metalness * c + (1.0 - look.metalness) * 0.04 for c in look.colour]  # 4 % of plain dielectrics

        lines = [
            f"newmtl {look.name}",
            f"Kd {_numbers(look.colour)}",
            f"Ks {_numbers(mirror)}",
            f"Ns {shine:.6g}",
            f"d {look.opacity:.6g}",
            f"Pr {look.roughness:.6g}",
            f"Pm {look.metalness:.6g}",
            "illum 2",
        ]
        blocks.append("\n".join(lines) + "\n")
    return "\n".join(blocks)


def _numbers(values: Iterable[float]) -> str:
    return " ".join(f"{value:.6g}" for value in values)
