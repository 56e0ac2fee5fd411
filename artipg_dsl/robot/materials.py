"""How a material is and looks in one object."""

from __future__ import annotations

import zlib
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ..graph.program import Material
from ..validity.materials import RANGES, draw_property

if TYPE_CHECKING:
    from ..runtime.batch import Batch


def resolve_materials(batch: Batch, material: Material) -> list[Material]:
    """The material as it is in each object: every range is one value."""
    ranges = [name for name in RANGES if getattr(material, name)[0] != getattr(material, name)[1]]
    if not ranges:
        return [material] * len(batch)
    values: dict[str, Any] = {name: draw_property(batch, material, name).tolist() for name in ranges}
    each: list[dict[str, Any]] = [{name: (v[i], v[i]) for name, v in values.items()} for i in range(len(batch))]
    return [replace(material, **one) for one in each]


def draw_colours(batch: Batch, material: Material) -> np.ndarray:
    """sRGB (B, 3) of a material in each object: one of its colours, the same for all its primitives in an object.

    The choice depends on the seed, the object's number and the material's name alone (a multiplicative hash). A mutant
    has the colours of the object that it was made from.
    """
    palette = np.asarray(material.colour, dtype=np.float64).reshape(-1, 3)
    with np.errstate(over="ignore"):
        mixed = np.asarray(batch.state.objects).astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
        mixed ^= np.uint64(zlib.crc32(material.name.encode()) ^ (int(batch.seed) & 0xFFFFFFFF) * 0x85EBCA6B % 2**32)
        mixed ^= mixed >> np.uint64(30)
        mixed *= np.uint64(0xBF58476D1CE4E5B9)
        mixed ^= mixed >> np.uint64(27)
        mixed *= np.uint64(0x94D049BB133111EB)
        mixed ^= mixed >> np.uint64(31)
    return palette[(mixed % np.uint64(len(palette))).astype(np.int64)]


def to_linear(srgb: np.ndarray) -> np.ndarray:
    """Linear light of sRGB values in 0 .. 1 (glTF and renderers compute with the former)."""
    srgb = np.asarray(srgb, dtype=np.float64)
    return np.where(srgb <= 0.04045, srgb / 12.92, np.power((srgb + 0.055) / 1.055, 2.4))
