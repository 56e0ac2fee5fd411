"""What a primitive is made of: its density, and its colour in one object."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

import numpy as np

from ..graph.program import Material

if TYPE_CHECKING:
    from ..runtime.batch import Batch

PLAIN = Material("plain")


def catalogue(batch: Batch) -> list[Material]:
    """Materials by index; what has none is plain: 700 kg/m3, light grey."""
    return [PLAIN, *batch.program.materials.values()]


def density(material: Material) -> float:
    """kg/m3: the middle of the range."""
    return (material.density[0] + material.density[1]) / 2


def colours(batch: Batch, material: Material) -> np.ndarray:
    """sRGB (B, 3) of a material in each object: one of its colours, the same for all its primitives in an object.

    The choice depends on the seed, the object's number and the material's name alone (a multiplicative hash). A mutant
    has the colours of the object that it was made from.
    """
    palette = np.asarray(material.colour, dtype=np.float64).reshape(-1, 3)
    with np.errstate(over="ignore"):
        key = np.asarray(batch.state.objects).astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        key ^= np.uint64(zlib.crc32(material.name.encode()) ^ (int(batch.seed) & 0xFFFFFFFF) * 0x85EBCA6B % 2**32)
        key ^= key >> np.uint64(30)
        key *= np.uint64(0xBF58476D1CE4E5B9)
        key ^= key >> np.uint64(27)
        key *= np.uint64(0x94D049BB133111EB)
        key ^= key >> np.uint64(31)
    return palette[(key % np.uint64(len(palette))).astype(np.int64)]


def linear(srgb: np.ndarray) -> np.ndarray:
    """Linear light of sRGB values in 0 .. 1 (glTF and renderers compute with the former)."""
    srgb = np.asarray(srgb, dtype=np.float64)
    return np.where(srgb <= 0.04045, srgb / 12.92, np.power((srgb + 0.055) / 1.055, 2.4))
