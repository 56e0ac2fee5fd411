"""Objects of one category as columns, and one object."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ..arguments import read_amount, read_flag, read_whole
from ..diagnostics.suggest import did_you_mean
from ..errors import MissingName, UsageError
from ..run.schema import LARGEST, MOST
from ..runtime.columns import read_only
from .bound import Worn, choose_details
from .files import Files

if TYPE_CHECKING:
    import trimesh

    from ..annotate.cloud import Points
    from ..annotate.grasps import GraspTable, KeypointTable
    from ..annotate.gripper import Gripper
    from ..annotate.views import Views
    from ..run.comparing import Comparison
    from ..runtime.repairs import Repairs
    from ..runtime.tables import JointTable, LinkTable, PartTable
    from ..sampling.correspondence import Correspondence
    from ..sampling.trace import Step

JointStates: TypeAlias = "str | np.ndarray | None"  # such as "open=60deg", or joint values; None is at rest


_MOST_GRASPS = 10_000  # of a family; each is tested against the whole object


class Samples(Files):
    """Objects of one category as columns. Rows of all tables and arrays are in the order of ``numbers``.

    Frames are right-handed, x to the front, y to the left, z up; metres and radians. ``numbers`` and the columns of ``links``,
    ``joints`` and ``parts`` are read-only, since everything else is computed from them: ``column.copy()`` can be changed.
    """

    def __iter__(self) -> Iterator[Object]:
        """The objects one by one, in the order of their numbers."""
        return (self.object(number) for number in self.numbers.tolist())

    def object(self, number: int) -> Object:
        """The object with the given number, which need not be among these."""
        return Object(self.job.of([read_whole("number", number, 0, LARGEST - 1)]))

    @cached_property
    def words(self) -> dict[str, list[str]]:
        """What the numbers of points and views mean, as in a manifest: ``words["semantic"][3]``; also joints, grasps and materials."""
        from ..export.meanings import list_vocabularies

        return list_vocabularies(self.batch.program)

    # ------------------------------------------------------------ mutation

    def mutate(
        self,
        operations: str | Iterable[str] = "apa,dpa,cpa",
        *,
        n: int | None = None,
        variant: int = 0,
        strength: float = 1.0,
        share: float = 0.5,
        only: str = "*",
        one: str | None = None,
    ) -> Samples:
        """One mutant of each object: templates swapped (apa), counts changed (dpa), parameters perturbed (cpa).

        A mutant has the number of its original. With ``n``, there are so many of each, numbered anew from 0: those of the first, of the
        second, ..., as ``apgc mutate -n`` makes them, with ``one`` each after its original.
        All other values are kept as far as they remain legal. Another ``variant`` gives other mutants; ``only``
        limits the parts and values that may change (``"door,handle*"``), ``share`` is the fraction of eligible
        templates and counts to change, ``strength`` scales the steps of cpa. ``one`` names a single value to change
        and no other draw (if that is impossible, the object is kept). Raises NoObject, UsageError.
        """
        from ..sampling.mutation import Mutation, read_operations

        each = 1 if n is None else read_whole("n", n, 1, MOST // len(self))
        sources = None if n is None else self.job.request.numbers
        asked = Mutation(read_operations(operations), variant, strength, share, only, each=each, sources=sources)
        step = asked.focused(one)
        return Samples(self.job.mutated(step, None if n is None else np.arange(len(self) * step.group)))

    def changes(self, number: int) -> list[Step]:
        """The mutation steps that made the object with the given number; empty for an object that was drawn."""
        from ..sampling.trace import trace_objects

        return trace_objects(self.object(number).batch)[0]

    def replay(self, records: Iterable[Mapping[str, Any]]) -> Samples:
        """Repeat recorded mutations (lines of ``trace-*.jsonl``) on these objects. Raises NoObject, UsageError, UserError."""
        from ..sampling.trace import Replay, check_record

        if not isinstance(records, Iterable):
            raise UsageError(f"records is {records!r}", "give lines of trace-*.jsonl, as dictionaries")
        made = {record["object"]: record for record in map(check_record, records)}
        if not made:
            raise UsageError("there is no record to repeat", "give lines of trace-*.jsonl")
        return Samples(self.job.mutated(Replay(made), sorted(made)))

    def repairs(self) -> Repairs:
        """The values that were changed to make these objects valid: old and new value, and the requirement that failed."""
        return read_only(self.batch.repairs)

    def correspondence(self) -> Correspondence:
        """The elementary primitive of the original object to which each primitive of these corresponds, a row for each."""
        from ..sampling.correspondence import find_correspondence

        return find_correspondence(self.batch.history[0].before if self.batch.history else self.batch, self.batch)

    # ------------------------------------------------------------ real objects

    def compare(
        self,
        real: Any,
        *,
        up: str = "auto",
        front: str = "auto",
        unit: str = "auto",
        normalised: bool = False,
        map: Mapping[str, str] | None = None,
    ) -> Comparison:
        """How these compare with real objects, as ``apgc compare`` tells; the arguments are those of ``fit_objects``.

        ``likeness`` has sizes, chamfer distances both ways, and with ``map`` labels; ``names`` of the real objects, and why others
        could not be read; ``presence()`` what labels say of the draws. Raises UsageError, UserError.
        """
        from ..run.comparing import Comparison, read_all
        from ..run.fitting import tell_unmatched
        from .real import read_map, read_real

        told: list[str] = []
        items, frame = read_real(real, up, front, unit, normalised, told.append)
        words = dict(read_map(map, self.batch.program))
        known = read_all(self.batch, items, frame)
        told += [f"{name}: {lost}, and were left out" for name, lost in known.lost.items()]
        for text in filter(None, [*told, tell_unmatched(words, known.labels, "map")]):
            warnings.warn(text, stacklevel=2)
        return Comparison.of(self.batch, known, words)

    # ------------------------------------------------------------ tables

    def links(self) -> LinkTable:
        """The rigid links of all objects in one table; ``owner`` is the index of the object."""
        return read_only(self.batch.links())

    def joints(self) -> JointTable:
        """The joints; origin and axis in the object's frame at joint values 0."""
        return read_only(self.batch.joints())

    def parts(self) -> PartTable:
        """The parts with their boxes and poses."""
        return read_only(self.batch.parts())

    def annotations(self, states: JointStates = None, *, gripper: Gripper | str = "standard") -> list[dict[str, Any]]:
        """The annotation of each object as plain data: joints, parts, grasps, keypoints, drawn values.

        ``states`` (J,) or (K, J) adds poses in these joint states. ``gripper`` selects the grasps that it can execute: dimensions
        such as "stroke=8cm,width=2cm", or "any". Raises UsageError.
        """
        from ..annotate.annotation import annotate
        from ..annotate.gripper import read_gripper

        values = self._values(states)
        return annotate(self.batch, None if values is None else np.atleast_2d(values), read_gripper(gripper))

    def __contains__(self, name: Any) -> bool:
        """Whether the program draws a value of this name: ``"width" in batch``. Raises UsageError for anything but a name."""
        if not isinstance(name, str):
            raise UsageError(f"`in` looks for the name of a value, not for {name!r}", "37 in batch.numbers")
        return any(draw.column.name == name for draw in self.batch.program.draws)

    def __getitem__(self, name: str) -> np.ndarray:
        """A drawn value, one per object: ``batch["width"]`` (B,) float64, nan for objects without it.

        Choices are names, "" for objects without it. Raises MissingName, a KeyError, also if a repeat draws several values.
        """
        draws = [(k, d) for k, d in enumerate(self.batch.program.draws) if d.column.name == name]
        if not draws or any(s.kind == "repeat" for _, d in draws for s in d.column.scope.ancestors()):
            if not isinstance(name, str):
                raise UsageError(
                    f"[{name!r}] is not the name of a value",
                    'a value is batch["width"], an object batch.object(37), in turn `for one in batch`',
                )
            known = sorted({d.column.name for d in self.batch.program.draws})
            if draws:
                raise MissingName(f"an object has several of {name}", "see `drawn` of an object")
            hint = did_you_mean(name, known) or (f"there are {', '.join(known)}" if known else "it draws nothing")
            raise MissingName(f"{self.category} draws no `{name}`", hint)
        words = draws[0][1].kind == "choice"
        found = np.full(len(self), "" if words else np.nan, dtype=object if words else np.float64)
        for k, draw in draws:
            drawn = self.batch.state.values[k]
            found[self.batch.owner(draw.column.scope)] = [draw.options[int(i)] for i in drawn] if words else drawn
        return found.astype(str) if words else found

    # ------------------------------------------------------------ joint values

    def rest(self) -> np.ndarray:
        """Joint values (J,) float64 at rest, in the order of ``joints()``; radians and metres. The array is yours to change."""
        return self.batch.rest().copy()

    def opened(self) -> np.ndarray:
        """Joint values (J,) with every limited joint 80 % of the way from rest to its farther end."""
        from ..annotate.states import open_values

        return open_values(self.batch)

    def states(self, **values: float) -> np.ndarray:
        """Joint values (J,) at rest except for the named joints: ``batch.states(open=1.2)`` sets all joints of that name.

        Radians and metres; values stay within the limits of each object, and what a joint waits for is open. Raises UsageError, also where
        no object reaches a value.
        """
        from ..annotate.states import name_values

        for name, value in values.items():
            if isinstance(value, str):
                raise UsageError(
                    f"{name} is {value!r}: a number is needed, in radians or metres",
                    f'text with units goes where states are taken: batch.points(2048, "{name}={value}")',
                )
        found = [(name, read_amount(name, value, -np.inf), "") for name, value in values.items()]
        return name_values(self.batch, found)

    def joint_values(self, states: str = "random:4") -> np.ndarray:
        """Joint values (K, J) in a comma-separated list of states: "rest", "open", "random:K" within the limits."""
        from ..annotate.states import joint_values, read_states

        if not isinstance(states, str):
            raise UsageError(f"states are text, not {states!r}", "such as rest, open or random:4")
        return joint_values(self.batch, read_states(states))

    def _values(self, states: JointStates, *, several: bool = True) -> np.ndarray | None:
        from ..annotate.states import read_values

        return read_values(self.batch, states, several=several)

    # ------------------------------------------------------------ geometry

    def points(
        self,
        n: int = 2048,
        states: JointStates = None,
        *,
        motion: bool = False,
        surface: str = "boundary",
        spread: str = "random",
        per: str = "object",
        balance: str = "",
        weights: str | Mapping[str, float] | None = None,
        details: Worn = None,
        detail_strength: float = 1.0,
    ) -> Points:
        """``n`` points per object on the visible surface with normals, labels and binding, arrays (B, n, ...).

        ``states`` are joint values (J,), or text such as "open=60deg", at rest by default; with several states, (K, J) or
        "random:4", positions and normals are (B, K, n, 3). ``motion`` adds velocities due to the joints. ``surface`` is the
        "boundary" of the union of all primitives, or the part of it visible from "outside". ``spread`` is "random", or "blue"
        to keep points apart.
        ``per`` gives n points to each visible "object", "semantic" class, part "instance", "link" or "primitive"; arrays
        then have a row for each, and ``object`` says which object it belongs to. ``balance`` divides the n points of an
        object evenly over its "semantic" classes, "instance"s, "link"s or "primitive"s, or by ``weights``,
        ``{"handle": 3}``; ``area`` is the surface area that a point represents. ``details`` are a
        folder written by ``apgc bind``, or bound in memory, scaled by ``detail_strength``: objects that were fitted, and their mutants,
        wear those that were bound to them, all others borrow those of a donor; ``worn`` is the bound point that each point wears, -1
        for none. Raises UsageError, UserError.
        """
        from ..annotate.cloud import sample_points
        from ..annotate.sampling import Sampling, read_weights

        motion = read_flag("motion", motion)
        how, values = Sampling(n, surface, spread, per, balance, read_weights(weights)), self._values(states)
        worn = choose_details(details, detail_strength, self.job)
        if worn is None:
            return sample_points(self.batch, how, values, motion=motion)
        from ..details.store import dress

        return sample_points(self.batch, how, values, motion=motion, dress=partial(dress, dressing=worn))

    def rebind(
        self, points: Points | Mapping[str, np.ndarray], states: JointStates = None, *, motion: bool = False
    ) -> Points:
        """Points of other objects of the program at the corresponding places on these: ``mutant.rebind(batch.points())``.

        ``points`` may also be the arrays of a points shard. Labels are those of the new places; ``bound`` says where
        primitive and patch still exist. Raises UsageError.
        """
        from ..annotate.rebind import rebind

        return rebind(self.batch, points, self._values(states), motion=read_flag("motion", motion))

    def views(
        self,
        n: int | str | Path | Mapping[str, Any] = 8,
        *,
        states: JointStates = None,
        engine: str | None = None,
        **camera: Any,
    ) -> Views:
        """Images and partial clouds from ``n`` cameras around each object, arrays (B, n, ...) or (B, K, n, ...).

        ``n`` may be a camera file or its contents; ``camera`` gives the other entries of such a file (width=640,
        height=480, fov=35, azimuth=[-60, 60], points=2048, ...). Raises UserError, UsageError.
        """
        from ..annotate.camera_file import cameras_of
        from ..annotate.views import make_views

        return make_views(self.batch, cameras_of(n, **camera), self._values(states), engine)

    def meshes(
        self,
        states: JointStates = None,
        *,
        tolerance: float | None = None,
        triangles: int | None = None,
        details: Worn = None,
        detail_strength: float = 1.0,
    ) -> list[trimesh.Scene]:
        """One trimesh scene per object, a closed mesh per primitive, named after its part.

        ``tolerance`` is the largest distance of a mesh from the true surface, in metres; ``triangles`` the largest number
        per object, distributed by curvature. The default is 24 steps per full turn. ``details`` are worn as in ``points``. Raises
        UsageError, UserError.
        """
        from ..export.scenes import make_scenes
        from ..geometry.resolution import Resolution

        values, fine = self._values(states, several=False), Resolution(tolerance=tolerance, triangles=triangles)
        return make_scenes(self.batch, values, fine, choose_details(details, detail_strength, self.job))

    def grasps(self, values: int = 5, *, gripper: Gripper | str = "standard", states: JointStates = None) -> GraspTable:
        """Grasps of all objects, each family at ``values`` steps of its parameter; frames at joint values 0.

        Only those that the ``gripper`` can execute with the joints at ``states`` (J,), by default at rest; "any" keeps all.
        Raises UsageError.
        """
        from ..annotate.grasps import sample_grasps
        from ..annotate.gripper import judge, read_gripper

        found, hand = sample_grasps(self.batch, read_whole("values", values, 1, _MOST_GRASPS)), read_gripper(gripper)
        shown = self._values(states, several=False)
        return found if hand is None else found.take(np.flatnonzero(judge(self.batch, found, hand, shown) == 0))

    def keypoints(self) -> KeypointTable:
        """Keypoints of all objects at joint values 0."""
        from ..annotate.grasps import sample_keypoints

        return sample_keypoints(self.batch)


class Object(Samples):
    """One object; tables and arrays have only its rows."""

    @property
    def number(self) -> int:
        return int(self.numbers[0])

    @cached_property
    def annotation(self) -> dict[str, Any]:
        """The annotation of the object as plain data."""
        return self.annotations()[0]

    @cached_property
    def drawn(self) -> dict[str, Any]:
        """Drawn parameters, counts and choices; lists where a repeat draws several."""
        return self.batch.drawn(0)

    def mesh(
        self,
        states: JointStates = None,
        *,
        tolerance: float | None = None,
        triangles: int | None = None,
        details: Worn = None,
        detail_strength: float = 1.0,
    ) -> trimesh.Scene:
        """The object as a trimesh scene, see ``meshes``."""
        return self.meshes(
            states, tolerance=tolerance, triangles=triangles, details=details, detail_strength=detail_strength
        )[0]

    def _title(self) -> str:
        return f"{self.category} {self.number}, seed {self.seed}"
