"""Real objects as Python gives them: files, meshes and clouds of trimesh, arrays. What cannot be meant is refused before anything is fitted;
what has no shape is told of when its turn comes, as of files.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

from ..arguments import read_path
from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError, UserError
from .finding import find_files
from .meshes import pieces_of
from .reading import Cloud, Solid, join_meshes, points_of, solid_of
from .sources import File, Held, Item, name_files, own_name

_KINDS = 'a file, a mesh of trimesh, (vertices, faces), points (n, 3), or {"points": ..., "normals": ...}'
_ARRAYS = ("points", "normals", "vertices", "faces", "label", "label_names", "link_id", "link_names")


def read_objects(given: Any, tell: Callable[[str], None]) -> list[Item]:
    """The real objects that Python gives: one, several, or several by their names. Files are called as the command line calls them, what is in
    memory ``object`` and its place. ``tell`` is told which files of a folder are left out. Raises UsageError, UserError."""
    if isinstance(given, Mapping) and not given.keys() & set(_ARRAYS):
        return [_named(name, one) for name, one in given.items()] or _none()
    several = [given] if _is_one(given) else list(given) if isinstance(given, Iterable) else [given]
    places: dict[Path | Held, None] = {}  # in their order, each once
    for one in several:
        if isinstance(one, str | Path):
            places |= dict.fromkeys(find_files([str(read_path("a real object", one, '"chair.obj"'))], tell))
        else:
            places[_hold(one, f"object{len(places)}")] = None
    if not places:
        _none()
    files = name_files([place for place in places if isinstance(place, Path)])
    taken, named = {item.name for item in files}, iter(files)
    return [next(named) if isinstance(one, Path) else Item(own_name(one.name, taken), one) for one in places]


def _none() -> NoReturn:
    raise UsageError("there is nothing to fit: no object is given", f"give {_KINDS}, or a list of these")


def _is_one(given: Any) -> bool:
    """Whether this is one real object, and not several. Two arrays in a tuple are vertices and faces."""
    if isinstance(given, str | bytes | Path | Mapping) or hasattr(given, "vertices") or hasattr(given, "geometry"):
        return True
    if isinstance(given, tuple):
        return len(given) == 2 and all(_is_array(one) for one in given)
    return _is_array(given) and np.ndim(given) < 3


def _is_array(given: Any) -> bool:
    return hasattr(given, "__array__") and not hasattr(given, "vertices")


def _named(name: Any, one: Any) -> Item:
    if not isinstance(name, str) or not name.strip() or not name.isprintable() or set(name) & set("/\\"):
        raise UsageError(f"{name!r} is no name of an object", 'it is text without slashes: {"antique": mesh}')
    if own_name(name, set()) != name:
        raise UsageError(f"no object can be called {name!r:.40}", "choose another, shorter name: files are named by it")
    if not isinstance(one, str | Path):
        return Item(name, _hold(one, name))
    path = read_path("a real object", one, '"chair.obj"')
    if path.is_dir():
        raise UsageError(f"{name} is to be one object, and {path} is a folder", "give its files, or the folder alone")
    find_files([str(path)])
    return Item(name, File(path))


def _hold(given: Any, name: str) -> Held:
    """What Python gives as one real object. Raises UsageError for what cannot be meant."""
    if isinstance(given, Mapping):
        return Held(name, _of_names(given, name))
    if hasattr(given, "geometry") or (hasattr(given, "vertices") and not hasattr(given, "faces")):
        solid = join_meshes(pieces_of(given, name))
        if len(solid.faces):
            return Held(name, solid)
        known = {"points": solid.vertices, "normals": solid.normals}
        return Held(name, _of_names({key: array for key, array in known.items() if array is not None}, name))
    if hasattr(given, "vertices"):
        given = (given.vertices, given.faces)
    if isinstance(given, tuple) and len(given) == 2:
        return Held(name, _triangles({"vertices": given[0], "faces": given[1]}, name))
    if not _is_array(given):
        raise UsageError(f"{name} is {_short(given)}, and no real object", f"give {_KINDS}")
    return Held(name, _of_names({"points": given}, name))


def _short(given: Any) -> str:
    return f"a {type(given).__name__}" if isinstance(given, list | tuple | set) else repr(given)[:80]


def _of_names(given: Mapping[str, Any], name: str) -> Cloud | Solid:
    """Arrays by name, as an ``.npz`` has them, or those of a mesh."""
    for key in given:
        near = None if key in _ARRAYS else did_you_mean(str(key), _ARRAYS)
        if near:
            raise UsageError(f"{name} has an array `{key}`, which means nothing", near)
    for ids, words in (("label", "label_names"), ("link_id", "link_names")):
        if (ids in given) != (words in given):
            there, lacking = (ids, words) if ids in given else (words, ids)
            raise UsageError(f"{name} has `{there}`, and no `{lacking}`", f'add "{lacking}", or leave out "{there}"')
        if words in given and (np.ndim(given[words]) != 1 or not all(isinstance(one, str) for one in given[words])):
            raise UsageError(f"{name}: `{words}` is {given[words]!r:.80}", 'it is a list of names: ["seat", "back"]')
    if "vertices" in given:
        if "points" in given:
            raise UsageError(f"{name} has both `points` and `vertices`", "give a cloud or a mesh")
        return _triangles(given, name)
    if "faces" in given:
        raise UsageError(f"{name} has `faces` of `points`", 'those of a mesh are "vertices"')
    known = {**given, **{key: _numbers(given[key], key, name) for key in ("points", "normals") if key in given}}
    try:
        return points_of(_labelled(known, name), name)
    except UserError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None


def _triangles(given: Mapping[str, Any], name: str) -> Solid:
    """A mesh with labels of its faces, or with its name as the label of all."""
    kinds = {"vertices": "fiu", "faces": "iu"}
    arrays = {key: _numbers(given[key], key, name, kind) for key, kind in kinds.items() if key in given}
    try:
        return solid_of(_labelled({**given, **arrays}, name), name, name)
    except UserError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None


def _labelled(given: Mapping[str, Any], name: str) -> dict[str, Any]:
    """The same with labels that are whole numbers. Raises UsageError."""
    return {
        key: _numbers(value, key, name, "iu") if key in ("label", "link_id") else value for key, value in given.items()
    }


def _numbers(given: Any, key: str, name: str, kinds: str = "fiu") -> np.ndarray:
    """An array of numbers, of those ``kinds`` of NumPy's. Raises UsageError."""
    try:
        array = np.asarray(given)
    except Exception as wrong:  # noqa: BLE001 - lists of different lengths, and what other libraries hold elsewhere
        raise UsageError(f"{name}: `{key}` is no array: {str(wrong)[:120]}") from None
    if array.dtype.kind not in kinds and array.size:
        wanted = "numbers" if kinds == "fiu" else "whole numbers"
        raise UsageError(f"{name}: `{key}` is of type {array.dtype}", f"{wanted} are needed")
    return array.astype(np.float64 if kinds == "fiu" else np.int64, copy=False)
