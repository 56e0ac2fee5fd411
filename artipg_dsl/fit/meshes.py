"""Meshes of files, as trimesh reads them, each by its name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..errors import UserError


def load_meshes(path: Path) -> list[tuple[str, Any]]:
    """The meshes (or clouds) of a file, each by its name, in the frame of the file."""
    import trimesh  # start-up: what reads no meshes starts without it

    options: dict[str, Any] = {"process": False}
    if path.suffix.lower() == ".obj":
        options |= {"group_material": False, "skip_materials": True}
        options |= dict.fromkeys(("split_object", "split_objects", "split_groups"), True)  # by version of trimesh
    held: Any = trimesh.load(path, **options)
    pieces = pieces_of(held, path.stem)
    if not pieces:
        raise UserError(f"{path.name} has no surface")
    return pieces


def pieces_of(held: Any, name: str) -> list[tuple[str, Any]]:
    """The meshes (or clouds) of a scene of trimesh, each by its own name, or the one that is no scene, in the frame of all."""
    if not hasattr(held, "geometry"):
        return [(name, held)]
    pieces = []
    for node in held.graph.nodes_geometry:
        matrix, own = held.graph[node]
        mesh = held.geometry[own].copy()
        mesh.apply_transform(matrix)
        pieces.append((str(own), mesh))
    return sorted(pieces, key=lambda piece: piece[0])  # trimesh keeps no order of groups
