"""Camera files: what they may say, and what is wrong with them in words."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..arguments import read_whole, to_plain
from ..errors import UsageError, UserError
from ..files import read_json
from .cameras import Cameras

MOST_VIEWS, MOST_PIXELS, MOST_POINTS = 1000, 8192, 1_000_000
_EXAMPLE = '{"views": 8, "width": 640, "height": 480, "fov": 35}'
_POSE = '{"eye": [2, 0.5, 0.8]}'


def read_cameras(text: str) -> Cameras:
    """A number of views, or the path of a camera file. Raises UsageError, UserError."""
    if re.fullmatch(r"\s*[-+]?[0-9]{1,18}\s*", text):
        return _checked(Cameras(count=int(text)))
    hint = f"give a number of views, or a JSON file such as {_EXAMPLE}"
    try:
        described = read_json(text, hint)
    except FileNotFoundError:
        raise UsageError(f"there is no camera file {text}", hint) from None
    return cameras_from(described, text)


def cameras_of(views: int | str | Path | Mapping[str, Any], **more: Any) -> Cameras:
    """Cameras as a number, the name of a camera file or its contents tell them; ``more`` overrules what these say.

    Raises UsageError, UserError.
    """
    if isinstance(views, str | Path):
        found = read_cameras(str(views))
        if not more:
            return found
        views = found.plain()
    described = dict(views) if isinstance(views, Mapping) else {"views": read_whole("the number of views", views)}
    return cameras_from(to_plain(described | more))


def cameras_from(described: Any, name: str = "the cameras") -> Cameras:
    """Cameras from what a camera file holds. Raises UserError."""
    if not isinstance(described, dict):
        raise UserError(f"{name}: an object is needed, {{ ... }}", f"for example {_EXAMPLE}")
    known = ("views", "width", "height", "fov", "azimuth", "elevation", "distance", "points", "poses")
    made: dict[str, Any] = {}
    for key, value in described.items():
        if key not in known:
            raise UserError(f"{name}: `{key}` is not known", f"known are {', '.join(known)}")
        if key in ("views", "width", "height", "points"):
            if not isinstance(value, int) or isinstance(value, bool):
                raise UserError(f"{name}: `{key}` is {_shown(value)}: a whole number is needed")
            made["count" if key == "views" else key] = value
        elif key == "fov":
            made[key] = _numbers([value], 1, f"{name}: `fov`", "degrees")[0]
        elif key == "poses":
            made[key] = _poses(value, name)
        else:
            ends = [value, value] if isinstance(value, int | float) else value
            made[key] = _numbers(ends, 2, f"{name}: `{key}`", "a number, or two: lowest and highest,")
    if "poses" in made:
        for key in ("count", "azimuth", "elevation", "distance"):
            if key in made:
                shown = "views" if key == "count" else key
                raise UserError(f"{name}: `{shown}` beside `poses`", "leave one of them out")
        made["count"] = len(made["poses"])
    return _checked(replace(Cameras(), **made), name)


def _numbers(value: Any, count: int, what: str, wanted: str) -> tuple[float, ...]:
    fine = isinstance(value, list) and len(value) == count
    if not fine or not all(isinstance(v, int | float) and not isinstance(v, bool) and abs(v) < 1e300 for v in value):
        shown = _shown(value[0] if isinstance(value, list) and count == 1 else value)
        raise UserError(f"{what} is {shown}: {wanted} {'is' if count == 1 else 'are'} needed")
    return tuple(float(v) for v in value)


def _shown(value: Any) -> str:
    return json.dumps(value, default=repr)


def _poses(value: Any, name: str) -> tuple[Any, ...]:
    if not isinstance(value, list) or not value:
        raise UserError(f"{name}: `poses` is a list of at least one pose", f"for example [{_POSE}]")
    made = []
    for i, pose in enumerate(value):
        what = f"{name}: pose {i}"
        if not isinstance(pose, dict) or "eye" not in pose or set(pose) - {"eye", "target", "up"}:
            raise UserError(f"{what}: `eye` is needed, `target` and `up` may follow", f"for example {_POSE}")
        eye, target, up = (
            _numbers(pose[k], 3, f"{what}: `{k}`", "three numbers (metres)") if k in pose else None
            for k in ("eye", "target", "up")
        )
        if target == eye:
            raise UserError(f"{what} looks nowhere: `eye` and `target` are the same point")
        if up == (0.0, 0.0, 0.0):
            raise UserError(f"{what}: `up` has no direction")
        made.append((eye, target, up or (0.0, 0.0, 1.0)))
    return tuple(made)


def _checked(cameras: Cameras, name: str | None = None) -> Cameras:
    """The cameras, if their numbers make sense. Raises UsageError, or UserError about the file ``name``."""

    def refuse(what: str, hint: str) -> None:
        raise UserError(f"{name}: {what}", hint) if name else UsageError(what, hint)

    def whole(label: str, value: int, most: int) -> None:
        if not 1 <= value <= most:
            refuse(f"`{label}` is {value}", f"give a number from 1 to {most}")

    whole("views", cameras.count, MOST_VIEWS)
    whole("width", cameras.width, MOST_PIXELS)
    whole("height", cameras.height, MOST_PIXELS)
    whole("points", cameras.points, MOST_POINTS)
    if not 1 <= cameras.fov <= 170:
        refuse(f"`fov` is {cameras.fov:g}", "give 1 to 170 degrees, from the upper edge of the picture to the lower")
    bounds = {"azimuth": (-360.0, 360.0), "elevation": (-90.0, 90.0), "distance": (0.5, 1000.0)}
    for label, (low, high) in bounds.items():
        first, last = getattr(cameras, label)
        if first > last:
            refuse(f"`{label}` runs from {first:g} down to {last:g}", "write the lower end first")
        if first < low or last > high:
            more = ": 1 is where the object just fits the picture" if label == "distance" else " degrees"
            refuse(f"`{label}` is {first:g} .. {last:g}", f"it lies within {low:g} .. {high:g}{more}")
    narrow = min(1.0, cameras.width / cameras.height)
    nearest = float(np.sin(np.arctan(np.tan(np.radians(cameras.fov / 2)) * narrow)))
    if not cameras.poses and cameras.distance[0] <= nearest:
        refuse(f"`distance` {cameras.distance[0]:g} is within the object", f"here it is more than {nearest:.3g}")
    return cameras
