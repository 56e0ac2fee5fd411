"""The closed list of units: what a number's unit is in SI, and which dimension it gives."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import NamedTuple

Power = int | Fraction


class Dimension(NamedTuple):
    """Exponents of the base dimensions. Angles are a dimension of their own."""

    length: Power
    angle: Power
    mass: Power
    time: Power


_RATIO = Dimension(0, 0, 0, 0)
_LENGTH = Dimension(1, 0, 0, 0)
_ANGLE = Dimension(0, 1, 0, 0)
_MASS = Dimension(0, 0, 1, 0)
_TIME = Dimension(0, 0, 0, 1)
_DENSITY = Dimension(-3, 0, 1, 0)

UNITS: dict[str, tuple[float, Dimension]] = {
    "mm": (1e-3, _LENGTH),
    "cm": (1e-2, _LENGTH),
    "m": (1.0, _LENGTH),
    "deg": (math.pi / 180, _ANGLE),
    "rad": (1.0, _ANGLE),
    "turn": (2 * math.pi, _ANGLE),
    "%": (0.01, _RATIO),
    "g": (1e-3, _MASS),
    "kg": (1.0, _MASS),
    "ms": (1e-3, _TIME),
    "s": (1.0, _TIME),
    "kg/m3": (1.0, _DENSITY),
    "g/cm3": (1e3, _DENSITY),
    "N": (1.0, Dimension(1, 0, 1, -2)),
    "Nm": (1.0, Dimension(2, 0, 1, -2)),
    "m/s": (1.0, Dimension(1, 0, 0, -1)),
    "cm/s": (1e-2, Dimension(1, 0, 0, -1)),
    "rad/s": (1.0, Dimension(0, 1, 0, -1)),
    "deg/s": (math.pi / 180, Dimension(0, 1, 0, -1)),
    "Ns/m": (1.0, Dimension(0, 0, 1, -1)),
    "Nms/rad": (1.0, Dimension(2, -1, 1, -1)),
    "Nm/rad": (1.0, Dimension(2, -1, 1, -2)),
    "N/m": (1.0, Dimension(0, 0, 1, -2)),
}
"""Unit as written -> (factor to SI, dimension)."""
