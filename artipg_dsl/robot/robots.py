"""The robots of a batch: what is computed of all objects at once, and each of them as a model of its own."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..annotate.frames import quaternion
from ..geometry.resolution import STANDARD, Resolution
from ..geometry.sites import join_tables
from ..graph.program import Material
from ..runtime.curves import tabulate
from ..validity.mass import Mass, masses
from ..validity.materials import list_materials, material_rows
from ..validity.meant import find_allowed
from . import materials, solids
from .colliders import make_colliders
from .dressed import NOTE, build_dressed
from .dynamics import Dynamics, complete_dynamics
from .ground import find_thrust
from .hulls import Hull
from .mechanisms import find_mechanisms
from .model import SMALLEST_MASS, Robot, RobotClosure, RobotJoint, RobotLink
from .naming import Names
from .primitives import Bar, Collider, SeenMaterial, Shape, Visual
from .principal import find_principal

if TYPE_CHECKING:
    from ..details.dressing import Dressing
    from ..runtime.batch import Batch
    from ..runtime.tables import JointTable


class Robots:
    """The robots of a batch; the numbers of all of them are computed together.

    ``physics`` False: what is seen and how it moves alone, without colliders, and masses and what follows from them 0;
    with ``colliders`` they are there all the same.
    ``details``: what is seen wears them; what collides is the structure.
    """

    def __init__(
        self,
        batch: Batch,
        *,
        resolution: Resolution = STANDARD,
        physics: bool = True,
        colliders: bool = False,
        details: Dressing | None = None,
    ):
        self.batch = batch
        self.tables = batch.sites()
        self.links, self.joints, self.parts = batch.links(), batch.joints(), batch.parts()
        joined = join_tables(self.tables)
        self.meshes = (
            solids.build_meshes(joined, resolution)
            if details is None
            else build_dressed(batch, self.tables, resolution, details)
        )
        self.note = "" if details is None else NOTE
        self.physics = physics
        self.pieces = solids.build_pieces(joined) if physics or colliders else []
        self.catalogue = list_materials(batch)
        # those of joined tables begin with the rows of the site that gives them its number
        self.material_rows = {t.number: material_rows(batch, t) for t in (*(self.tables if details else ()), *joined)}
        self.visuals = solids.group_by_object(self.meshes, len(batch))
        objects = np.arange(len(batch) + 1)
        self.link_start = np.searchsorted(self.links.owner, objects)
        self.joint_start = np.searchsorted(self.joints.owner, objects)
        self.part_start = np.searchsorted(self.parts.owner, objects)
        self._latest: tuple[int, Robot] | None = None

    @cached_property
    def origins(self) -> np.ndarray:
        """Origins (L, 3) of the link frames in the object's."""
        origins = np.zeros((len(self.links.owner), 3))
        origins[self.link_start[self.joints.owner] + self.joints.child] = self.joints.origin
        return origins

    @cached_property
    def colliders(self) -> list[list[Hull]]:
        """What collides of each object."""
        return make_colliders(self.batch, self.pieces, self.material_rows)

    @cached_property
    def mass(self) -> Mass:
        """Mass, centre and inertia in link frames, safe to print with few digits and for links of next to nothing."""
        if not self.physics:
            count = len(self.links.owner)
            return Mass(np.zeros(count), np.zeros((count, 3)), np.zeros((count, 3, 3)))
        mass = masses(self.batch)
        trace = mass.inertia[:, 0, 0] + mass.inertia[:, 1, 1] + mass.inertia[:, 2, 2]
        # a little on the diagonal keeps the tensor positive and within the triangle inequality after rounding
        spare = np.maximum(1e-6 * trace, 1e-12)
        inertia = _rounded(mass.inertia + spare[:, None, None] * np.eye(3))
        center = np.where(mass.mass[:, None] > 0, mass.center - self.origins, 0.0)
        return Mass(np.maximum(mass.mass, SMALLEST_MASS), center, inertia)

    @cached_property
    def principal(self) -> tuple[np.ndarray, np.ndarray]:
        """Principal moments (L, 3) of the links, and their axes (L, 3, 3) as columns."""
        return find_principal(self.mass.inertia)

    @cached_property
    def curves(self) -> dict[int, tuple[np.ndarray, np.ndarray]]:
        """How joints follow by formulas: by the row, values of the leader and its own at these."""
        return tabulate(self.joints)

    @cached_property
    def dynamics(self) -> Dynamics:
        """Friction, damping, effort and velocity of all joints, as given or as their kind and what they move ask for."""
        return self._complete(self.joints)

    @cached_property
    def unsprung(self) -> Dynamics:
        """The same for formats without springs."""
        if np.isnan(self.joints.stiffness).all():
            return self.dynamics
        return self._complete(replace(self.joints, stiffness=np.full_like(self.joints.stiffness, np.nan)))

    def _complete(self, joints: JointTable) -> Dynamics:
        if not self.physics:
            return Dynamics(*(np.zeros(len(joints.owner)) for _ in fields(Dynamics)))
        first, rest = self.link_start[joints.owner], self.batch.settle(joints.rest)
        together = find_mechanisms(self.batch)
        return complete_dynamics(joints, rest, first, self.placed, self.batch.pose(), together, self.thrust)

    @cached_property
    def placed(self) -> Mass:
        """The mass of every link in the object's frame with the joints at 0."""
        return Mass(self.mass.mass, self.mass.center + self.origins, self.mass.inertia)

    @cached_property
    def thrust(self) -> np.ndarray:
        """What the floor does to joints that move feet (J,)."""
        return find_thrust(self.batch, self.placed)

    @cached_property
    def overlaps(self) -> np.ndarray:
        """Pairs (k, 2) of links that the text allows to overlap, so that nothing holds their colliders apart."""
        return find_allowed(self.batch, ("overlap",))

    @cached_property
    def turns(self) -> dict[int, np.ndarray]:
        """By site, the rotation of each row as a quaternion w x y z."""
        return {group.table.number: quaternion(group.table.rotation) for group in self.pieces}

    @cached_property
    def materials(self) -> list[list[Material]]:
        """For each material of the catalogue, what it is in each object: ranges of one value."""
        return [materials.resolve_materials(self.batch, material) for material in self.catalogue]

    @cached_property
    def looks(self) -> list[list[SeenMaterial]]:
        """For each material of the catalogue, how it looks in each object."""
        return [
            [
                SeenMaterial(m.name, tuple(c), 1.0 - m.transparency[0], m.metalness[0], m.roughness[0])
                for m, c in zip(resolved, materials.draw_colours(self.batch, resolved[0]).tolist(), strict=True)
            ]
            for resolved in self.materials
        ]

    def material(self, item: solids.Item[Any]) -> int:
        """Index into ``list_materials`` of what a primitive is made of."""
        return int(self.material_rows[item.group.table.number][item.row])

    def look(self, i: int, item: solids.Item[Any]) -> SeenMaterial:
        """How a primitive of object ``i`` looks."""
        return self.looks[self.material(item)][i]

    @cached_property
    def part_names(self) -> list[str]:
        """Names of all part instances, unique within an object and fit for file names: ``handle.post_1``."""
        return [re.sub(r"[^\w.-]", "_", re.sub(r"\[(\d+)\]", r"_\1", name)) for name in self.parts.name]

    def link_word(self, i: int, link: int) -> str:
        """The class of the part that a link of object ``i`` is, else the first that something to be seen on it has, "" for none."""
        words = self.batch.program.vocabularies.get("semantic", ("",))
        parts = (int(v.item.group.table.instance[v.item.row]) for v in self.robot(i).links[link].visuals)
        seen = (int(self.parts.semantic[int(self.part_start[i]) + part]) for part in parts)
        return self.batch.link_words[int(self.link_start[i]) + link] or next((words[k] for k in seen if k), "")

    def robot(self, i: int) -> Robot:
        """Object ``i`` of the batch; asked for again for the next format, it is the same one."""
        if self._latest is None or self._latest[0] != i:
            self._latest = (i, self._robot(i))
        return self._latest[1]

    def _robot(self, i: int) -> Robot:
        names = self.links.name[self.link_start[i] : self.link_start[i + 1]]
        visuals: list[list[Visual]] = [[] for _ in names]
        pieces = Names()
        colliders: list[list[Collider]] = [[] for _ in names]
        for item in self.visuals[i]:
            visuals[int(item.group.table.link[item.row])].append(self._visual(i, item))
        for hull in self.colliders[i]:
            link = int(hull.item.group.table.link[hull.item.row])
            own_name = f"{self._name(i, hull.item)}_{len(colliders[link])}"
            colliders[link].append(self._collider(i, hull, own_name, pieces(f"{names[link]}_{own_name}")))
        first = int(self.link_start[i])
        own = Names()
        meshes = [
            {look: own(f"{name}_{look}") for look in dict.fromkeys(visual.look.name for visual in seen)}
            for name, seen in zip(names, visuals, strict=True)
        ]
        links = tuple(
            RobotLink(
                name,
                self.origins[first + k],
                float(self.mass.mass[first + k]),
                self.mass.center[first + k],
                self.mass.inertia[first + k],
                tuple(visuals[k]),
                tuple(colliders[k]),
                meshes[k],
            )
            for k, name in enumerate(names)
        )
        number = int(self.batch.numbers[i])
        name = f"{self.batch.program.name}_{number:06d}"
        overlaps = self.overlaps[self.links.owner[self.overlaps[:, 0]] == i] - first
        pairs = tuple((one, other) for one, other in overlaps.tolist() if one != other)
        return Robot(name, number, links, tuple(self._joints(i)), tuple(self._closures(i)), pairs, self.note)

    def _name(self, i: int, item: solids.Item[Any]) -> str:
        return self.part_names[int(self.part_start[i]) + int(item.group.table.instance[item.row])]

    def _origin(self, i: int, item: solids.Item[Any]) -> np.ndarray:
        return self.origins[int(self.link_start[i]) + int(item.group.table.link[item.row])]

    def _visual(self, i: int, item: solids.Item[solids.SolidGroup]) -> Visual:
        return Visual(self._name(i, item), self.look(i, item), self._origin(i, item), item)

    def _collider(self, i: int, piece: Hull, name: str, full: str) -> Collider:
        item = piece.item
        group = item.group
        origin, material = self._origin(i, item), self.materials[self.material(item)][i]
        center = group.center[item.k] - origin
        if piece.corners is not None:
            middle = (piece.vertices.min(axis=0) + piece.vertices.max(axis=0)) / 2 - origin
            shape = Shape(name, piece.vertices - origin, piece.faces)
            return Collider(name, full, material, middle, np.eye(3), np.array([1.0, 0.0, 0.0, 0.0]), hull=shape)
        rotation, turn = group.table.rotation[item.row], self.turns[group.table.number][item.row]
        if group.is_box[item.k]:
            return Collider(name, full, material, center, rotation, turn, size=tuple(group.size[item.k].tolist()))
        radius, length, capped = group.round[item.k].tolist()
        hull = Shape(name, group.vertices[item.k] - origin, group.faces)
        if radius > 0.0:
            return Collider(
                name, full, material, center, rotation, turn, bar=Bar(radius, length, bool(capped)), hull=hull
            )
        return Collider(name, full, material, center, rotation, turn, hull=hull)

    def _closures(self, i: int) -> Iterator[RobotClosure]:
        loops, first = self.batch.loops, int(self.link_start[i])
        if loops is None:
            return
        for c in np.flatnonzero(loops.owner == i).tolist():
            one, other = int(loops.link[0, c]), int(loops.link[1, c])
            points = loops.point[0, c] - self.origins[one], loops.point[1, c] - self.origins[other]
            yield RobotClosure((one - first, other - first), points)

    def _joints(self, i: int) -> list[RobotJoint]:
        joints, first, last = self.joints, int(self.joint_start[i]), int(self.joint_start[i + 1])
        made = []
        for j in range(first, last):
            kind, parent = joints.kind[j], int(joints.parent[j])
            leader = int(joints.mimic[j])
            made.append(
                RobotJoint(
                    name=joints.name[j],
                    kind=kind,
                    parent=parent,
                    child=int(joints.child[j]),
                    origin=joints.origin[j] - self.origins[int(self.link_start[i]) + parent],
                    axis=joints.axis[j],
                    low=_number_or_none(joints.low[j]),
                    high=_number_or_none(joints.high[j]),
                    rest=_number_or_none(joints.rest[j]) or 0.0,
                    effort=float(self.dynamics.effort[j]),
                    velocity=float(self.dynamics.velocity[j]),
                    damping=float(self.dynamics.damping[j]),
                    friction=float(self.dynamics.friction[j]),
                    mimic=None
                    if leader < 0
                    else (joints.name[first + leader], float(joints.multiplier[j]), float(joints.offset[j])),
                    pitch=_number(joints.pitch[j]),
                    positions=int(_number(joints.positions[j])),
                    armature=float(self.dynamics.armature[j]),
                    stiffness=_number(joints.stiffness[j]),
                    unsprung=self._unsprung(j),
                    gates=self._gates(j),
                    curve=self.curves.get(j),
                )
            )
        return made

    def _unsprung(self, j: int) -> tuple[float, float, float] | None:
        if self.unsprung is self.dynamics:
            return None
        return float(self.unsprung.friction[j]), float(self.unsprung.damping[j]), float(self.unsprung.effort[j])

    def _gates(self, j: int) -> tuple[tuple[str, float, float], ...]:
        """What the joint in row ``j`` waits for."""
        gates = self.batch.gates
        if gates is None:
            return ()
        rows = np.flatnonzero(gates.joint == j).tolist()
        return tuple((self.joints.name[gates.gate[g]], float(gates.low[g]), float(gates.high[g])) for g in rows)


def _number_or_none(value: float) -> float | None:
    return None if np.isnan(value) else float(value)


def _number(value: float) -> float:
    return 0.0 if np.isnan(value) else float(value)


def _rounded(inertia: np.ndarray) -> np.ndarray:
    """Inertia tensors (n, 3, 3) to ten decimal places of their trace: a product of inertia that is 0 but for rounding, which differs from one
    NumPy to the next, is 0 in a file."""
    trace = inertia[:, 0, 0] + inertia[:, 1, 1] + inertia[:, 2, 2]
    step = 10.0 ** (np.floor(np.log10(trace)) - 10.0)[:, None, None]
    return np.asarray(np.round(inertia / step) * step + 0.0)  # no -0
