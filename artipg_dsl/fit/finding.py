"""Which files of a folder are real objects: a URDF stands for its meshes, one of several ways to write it for all of them, and a mesh for
the cloud beside it."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path

from ..errors import UserError

_MESHES = (".obj", ".ply", ".glb", ".gltf", ".stl", ".off")
CLOUDS = (".npz", ".xyz")
ROBOT = ".urdf"
KINDS = (*_MESHES, *CLOUDS, ROBOT)
"""What the names of files that can be read end in."""
_FITS, _OURS = "fit.json", ("kept", "objects")  # of a folder of fits, and its folders of arrays and meshes


def find_files(places: list[str], tell: Callable[[str], None] | None = None) -> list[Path]:
    """The files that are named, and those in folders that are, in the order of their names. With ``tell``, which is told so, only
    one URDF of each object in a folder. Raises UserError.
    """
    found: list[Path] = []
    for name in places:
        place = Path(name)
        if place.is_dir():
            ours = _fitted(place)
            inside = sorted(
                p for p in place.rglob("*") if p.suffix.lower() in KINDS and _is_given(p) and not ours(p.parent)
            )
            robots = [p for p in inside if _is_robot(p)]
            apart = robots + _outside(inside, {p.parent for p in robots}) if robots else inside
            stray = _strays(inside, robots, apart) if tell is not None and robots else []
            if tell is not None and stray:
                tell(
                    f"{len(stray)} of the files in {place} lie beside or below a URDF that does not name them, and are not read: "
                    f"{stray[0]}, for example"
                )
            doubled = _doubled(apart)
            inside = sorted(p for p in apart if p not in doubled)
            variants = _variants(robots)
            if tell is not None and variants:
                first, of = next(iter(variants.items()))
                tell(
                    f"{len(variants)} URDF files are other ways to write objects of {place}: {first.name}, for example, is {of.name}"
                )
                inside = [p for p in inside if p not in variants]
            if not inside:
                raise UserError(f"{place} has no file that can be fitted", f"the kinds are {', '.join(KINDS)}")
            found += inside
        elif place.exists():
            found.append(place)
        else:
            raise UserError(
                f"there is no file or folder {place}", f"give files ({', '.join(KINDS)}), or folders of them"
            )
    return list(dict.fromkeys(found))


def _fitted(place: Path) -> Callable[[Path], bool]:
    """Whether a folder in a place holds what was fitted, such as an earlier run's results that lie among the scans."""

    @cache
    def ours(folder: Path) -> bool:
        if folder == place:
            return False
        return folder.name in _OURS and (folder.parent / _FITS).is_file() or ours(folder.parent)

    return ours


def _is_given(path: Path) -> bool:
    """Whether there is a file, or a link that leads nowhere: it is listed among what could not be read."""
    return path.is_file() or (path.is_symlink() and not path.exists())


def _is_robot(path: Path) -> bool:
    return path.suffix.lower() == ROBOT


def _outside(files: list[Path], folders: set[Path]) -> list[Path]:
    """The files that lie in none of some folders, nor below."""
    within = {parent: bool(folders & {parent, *parent.parents}) for parent in {p.parent for p in files}}
    return [p for p in files if not within[p.parent]]


def _strays(inside: list[Path], robots: list[Path], apart: list[Path]) -> list[Path]:
    """The files of a folder that are left to URDF files, and that none of these names."""
    named: set[str] = set()
    for robot in robots:
        with suppress(OSError):  # it is told where the file is read
            text = robot.read_text(encoding="utf-8", errors="replace")
            named.update(Path(name).name for name in re.findall(r"""filename\s*=\s*["']([^"']*)["']""", text))
    known = set(apart)
    return [p for p in inside if p not in known and p.name not in named]


def _doubled(files: list[Path]) -> set[Path]:
    """The clouds that stand beside one mesh, alone with it: then both are of one object."""
    beside: dict[Path, list[Path]] = {}
    for path in files:
        beside.setdefault(path.parent, []).append(path)
    pairs = [sorted(pair, key=lambda p: p.suffix.lower() in CLOUDS) for pair in beside.values() if len(pair) == 2]
    return {two for one, two in pairs if one.suffix.lower() in _MESHES and two.suffix.lower() in CLOUDS}


def _variants(robots: list[Path]) -> dict[Path, Path]:
    """What is written otherwise, with the file of the same object: ``object_fixed.urdf`` beside ``object.urdf``, as `apgc export` writes
    them. One of them is enough."""
    stems: dict[tuple[Path, str], Path] = {}
    for path in robots:
        stems.setdefault((path.parent, path.stem), path)
    found = {}
    for path in robots:
        cuts = [match.start() for match in re.finditer("_", path.stem)]
        of = next((stems[key] for cut in cuts if (key := (path.parent, path.stem[:cut])) in stems), None)
        if of is not None:
            found[path] = of
    return found
