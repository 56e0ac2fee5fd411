"""What a link of a robot consists of: primitives to be seen, with what they look like, and convex pieces that collide."""

from __future__ import annotations

from dataclasses import field

import numpy as np

from ..graph.program import Material
from ..records import dataclass
from . import solids


@dataclass(frozen=True, slots=True)
class Shape:
    """A closed triangle mesh: ``vertices`` (V, 3) metres, ``faces`` (F, 3) turning outwards.

    ``normals``: unit normals (W, 3), and which of them each corner of each face has (F, 3).
    """

    name: str
    vertices: np.ndarray
    faces: np.ndarray
    normals: tuple[np.ndarray, np.ndarray] | None = None


@dataclass(frozen=True, slots=True)
class SeenMaterial:
    """A material as it is seen in one object: sRGB colour and opacity in 0 .. 1."""

    name: str
    colour: tuple[float, float, float]
    opacity: float
    metalness: float
    roughness: float


@dataclass(frozen=True, slots=True)
class Visual:
    """A primitive to be seen, on a link with ``origin`` (3,)."""

    name: str
    look: SeenMaterial
    origin: np.ndarray
    item: solids.Item[solids.SolidGroup] = field(repr=False)  # refers to the whole batch

    @property
    def shape(self) -> Shape:
        """Vertices and faces in the link's frame, closed."""
        group = self.item.group
        return Shape(self.name, group.vertices[self.item.k] - self.origin, group.faces)


@dataclass(frozen=True, slots=True)
class Bar:
    """A cylinder about z, or with ``capped`` a capsule, whose ``length`` does not count its ends; a ball has none."""

    radius: float
    length: float
    capped: bool

    @property
    def kind(self) -> str:
        """Its name in most formats: cylinder, sphere or capsule."""
        if not self.capped:
            return "cylinder"
        return "capsule" if self.length > 0.0 else "sphere"


@dataclass(frozen=True, slots=True)
class Collider:
    """A convex piece in the link's frame: a box of ``size``, a ``bar`` or a ``hull``, which bars have, too.

    ``name`` is its own in the link, ``full`` in the object. Boxes and bars stand about ``center``, turned by ``rotation``,
    which is ``turn`` as a quaternion w x y z.
    """

    name: str
    full: str  # the name in the whole object
    material: Material
    center: np.ndarray
    rotation: np.ndarray
    turn: np.ndarray
    size: tuple[float, float, float] | None = None
    bar: Bar | None = None
    hull: Shape | None = None
