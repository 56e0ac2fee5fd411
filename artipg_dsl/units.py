"""The units of the language: a factor to SI (metre, radian, kilogram, second) and a dimension each."""

from __future__ import annotations

from math import pi
from typing import TYPE_CHECKING, NamedTuple

if TYPE_CHECKING:
    from fractions import Fraction


class Dimension(NamedTuple):
    """Exponents of the four base dimensions."""

    length: int | Fraction = 0
    angle: int | Fraction = 0
    mass: int | Fraction = 0
    time: int | Fraction = 0


_NONE = Dimension()
_LENGTH = Dimension(length=1)
_ANGLE = Dimension(angle=1)
_MASS = Dimension(mass=1)
_TIME = Dimension(time=1)
_DENSITY = Dimension(mass=1, length=-3)
_SPEED = Dimension(length=1, time=-1)
_TURNING = Dimension(angle=1, time=-1)
_FORCE = Dimension(mass=1, length=1, time=-2)
_TORQUE = Dimension(mass=1, length=2, time=-2)

UNITS: dict[str, tuple[float, Dimension]] = {
    "%": (0.01, _NONE),
    "mm": (0.001, _LENGTH),
    "cm": (0.01, _LENGTH),
    "m": (1.0, _LENGTH),
    "km": (1000.0, _LENGTH),
    "deg": (pi / 180, _ANGLE),
    "rad": (1.0, _ANGLE),
    "turn": (2 * pi, _ANGLE),
    "kg": (1.0, _MASS),
    "g": (0.001, _MASS),
    "s": (1.0, _TIME),
    "ms": (0.001, _TIME),
    "N": (1.0, _FORCE),
    "kg/m3": (1.0, _DENSITY),
    "g/cm3": (1000.0, _DENSITY),
    "g/m3": (0.001, _DENSITY),
    "m/s": (1.0, _SPEED),
    "cm/s": (0.01, _SPEED),
    "mm/s": (0.001, _SPEED),
    "m/s2": (1.0, Dimension(length=1, time=-2)),
    "rad/s": (1.0, _TURNING),
    "deg/s": (pi / 180, _TURNING),
    "turn/s": (2 * pi, _TURNING),
    "Nm": (1.0, _TORQUE),
    "N*m": (1.0, _TORQUE),
    "N/m": (1.0, Dimension(mass=1, time=-2)),
    "N/m2": (1.0, Dimension(mass=1, length=-1, time=-2)),
    "Ns/m": (1.0, Dimension(mass=1, time=-1)),
    "N*s/m": (1.0, Dimension(mass=1, time=-1)),
    "Nm/rad": (1.0, Dimension(mass=1, length=2, time=-2, angle=-1)),
    "N*m/rad": (1.0, Dimension(mass=1, length=2, time=-2, angle=-1)),
    "Nms": (1.0, Dimension(mass=1, length=2, time=-1)),
    "N*m*s": (1.0, Dimension(mass=1, length=2, time=-1)),
    "Nms/rad": (1.0, Dimension(mass=1, length=2, time=-1, angle=-1)),
    "N*m*s/rad": (1.0, Dimension(mass=1, length=2, time=-1, angle=-1)),
}
"""Unit as written after a number -> (factor to SI, dimension). A blank unit is a plain number."""

SI_UNITS = {
    "length": "m",
    "angle": "rad",
    "mass": "kg",
    "density": "kg/m3",
    "time": "s",
    "speed": "m/s",
    "force": "N",
    "torque": "Nm",
}
"""Type of a parameter -> the unit its values are in inside."""
