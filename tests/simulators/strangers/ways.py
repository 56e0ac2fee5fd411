"""The ways in which strangers load and drive a file: a name, the package that it takes, the file, and what drives it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from .moves import Move


@dataclass(frozen=True)
class Way:
    """``options`` are those of the ``drive`` of ``in_<package>``."""

    name: str
    package: str
    file: str
    options: dict[str, Any]

    @property
    def there(self) -> bool:
        """Whether its simulator is installed."""
        return find_spec(self.package) is not None

    def drive(self, folder: Path, most: int | None = None) -> list[Move]:
        """Every limited joint of the object in a folder, or ``most`` of them, to both ends of its range."""
        driver: Callable[..., list[Move]] = import_module(f".in_{self.package}", __package__).drive
        return driver(folder / self.file, most, **self.options)


WAYS = {
    way.name: way
    for way in (
        Way("mujoco", "mujoco", "object.xml", {}),
        Way("mujoco-constant", "mujoco", "object.xml", {"constant": True}),
        Way("mujoco-urdf", "mujoco", "object.urdf", {}),
        Way("pybullet", "pybullet", "object.urdf", {}),
        Way("pybullet-geared", "pybullet", "object.urdf", {"geared": True}),
        Way("sapien", "sapien", "object_physics.urdf", {}),
    )
}
