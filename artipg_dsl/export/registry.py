"""The formats that objects can be written in. A new one is one entry here and one file beside it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from .content import Content
from .glb import write_glb
from .robot import Robot
from .shards import annotation_shard, points_shard, views_shard
from .urdf import write_urdf
from .write import ExportError

if TYPE_CHECKING:
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class Format:
    """``shard(batch, content)`` gives the bytes of one file for a run of objects, named ``<name>-<shard><suffix>``;
    ``robot(robot, folder)`` writes the files of one object into its folder. A format has one of the two.
    """

    name: str
    title: str
    suffix: str = ""
    shard: Callable[[Batch, Content], bytes] | None = None
    robot: Callable[[Robot, Path], None] | None = None


FORMATS: dict[str, Format] = {
    entry.name: entry
    for entry in (
        Format("points", "labelled points with their analytic binding, NumPy", ".npz", shard=points_shard),
        Format("annotation", "joints, parts, grasps, parameters, one JSON line each", ".jsonl", shard=annotation_shard),
        Format("views", "images and partial clouds from cameras around the object, NumPy", ".npz", shard=views_shard),
        Format("urdf", "robot description with OBJ meshes, for simulators", robot=write_urdf),
        Format("glb", "binary glTF with materials and an opening animation, for viewers", robot=write_glb),
    )
}
DEFAULT = ("points", "annotation")


def choose(names: str | list[str] | tuple[str, ...] | None, *, views: bool = False) -> list[Format]:
    """Formats by name, ``"points,urdf"`` or a list; annotations go with any of them. None: the default ones.

    ``views``: those too, whether they are named or not.
    """
    if names is None:
        names = DEFAULT
    wanted = [name.strip() for name in (names.split(",") if isinstance(names, str) else names)]
    wanted = [name for name in wanted if name]
    for name in wanted:
        if name not in FORMATS:
            known = ", ".join(FORMATS)
            raise ExportError(f"unknown format {name!r}", f"the formats are {known}")
    if not wanted:
        raise ExportError("no format given", f"the formats are {', '.join(FORMATS)}")
    wanted += ["annotation", *(["views"] if views else [])]
    return [entry for name, entry in FORMATS.items() if name in wanted]
