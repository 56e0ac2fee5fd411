"""Objects of one category as columns, and one object."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError
from .files import Files

if TYPE_CHECKING:
    import trimesh

    from ..annotate.cloud import Points
    from ..annotate.grasps import GraspTable, KeypointTable
    from ..annotate.gripper import Gripper
    from ..annotate.views import Views
    from ..runtime.repairs import Repairs
    from ..runtime.tables import JointTable, LinkTable, PartTable
    from ..sampling.correspondence import Correspondence
    from ..sampling.trace import Step


class Samples(Files):
    """Objects of one category as columns: every table and array has their rows in the order of ``numbers``.

    Frames are right-handed, x to the front, y to the left, z up; metres and radians.
    """

    def __iter__(self) -> Iterator[Object]:
        """The objects one by one, in the order of their numbers."""
        return (self.object(number) for number in self.numbers.tolist())

    def object(self, number: int) -> Object:
        """The object of a number, the same whether it is among these or not."""
        return Object(self.job.of([number]))

    # ------------------------------------------------------------ mutation

    def mutate(
        self,
        operations: str | Iterable[str] = "apa,dpa,cpa",
        *,
        variant: int = 0,
        strength: float = 1.0,
        share: float = 0.5,
        only: str = "*",
        one: str | None = None,
    ) -> Samples:
        """New objects from these, one of each: templates swapped (apa), counts changed (dpa), parameters perturbed (cpa).

        What is not changed on purpose keeps its value as far as it still fits. Another ``variant`` makes others;
        ``only`` names parts and values (``"door,handle*"``), ``share`` how many of the eligible templates and counts
        change, ``strength`` scales the steps of cpa. ``one`` names a value: that one changes and no other draw (where
        that cannot be, the object stays as it is). Raises NoObject, UsageError.
        """
        from ..sampling.mutate import Mutation, read_operations

        step = Mutation(read_operations(operations), variant, strength, share, one or only, one is not None)
        return Samples(self.job.mutated(step))

    def changes(self, number: int) -> list[Step]:
        """What made the object of a number from the one before, step by step; nothing for one that was drawn."""
        from ..sampling.trace import trace_objects

        return trace_objects(self.object(number).batch)[0]

    def replay(self, records: Iterable[Mapping[str, Any]]) -> Samples:
        """Objects made from these as the records of traces say (lines of ``trace-*.jsonl``). Raises NoObject, UserError."""
        from ..sampling.trace import Replay, check_record

        made = {record["object"]: record for record in map(check_record, records)}
        return Samples(self.job.mutated(Replay(made), sorted(made)))

    def repairs(self) -> Repairs:
        """Which values were moved to make these objects valid, from what to what, and which requirement asked for it."""
        return self.batch.repairs

    def correspondence(self) -> Correspondence:
        """Which elementary primitive of the objects before became which of these, a row for each of these."""
        from ..sampling.correspondence import find_correspondence

        return find_correspondence(self.batch.history[0].before if self.batch.history else self.batch, self.batch)

    # ------------------------------------------------------------ tables

    def links(self) -> LinkTable:
        """The rigid links, all objects' in one table; ``owner`` is the index of the object."""
        return self.batch.links()

    def joints(self) -> JointTable:
        """The joints; origin and axis in the object's frame at joint values 0."""
        return self.batch.joints()

    def parts(self) -> PartTable:
        """The parts with their boxes and poses."""
        return self.batch.parts()

    def annotations(
        self, states: np.ndarray | None = None, *, gripper: Gripper | str = "standard"
    ) -> list[dict[str, Any]]:
        """All that is known of each object as plain data: joints, parts, grasps, keypoints, what was drawn.

        ``states`` (K, J) adds what is elsewhere in each of them. Grasps are those that the ``gripper`` can make: measures
        such as "stroke=8cm,width=2cm", or "any". Raises UsageError.
        """
        from ..annotate.annotation import annotate
        from ..annotate.gripper import read_gripper

        return annotate(self.batch, states, read_gripper(gripper))

    def __getitem__(self, name: str) -> np.ndarray:
        """A drawn value, one per object: ``batch["width"]`` (B,) float64, nan where an object has none of the name.

        Choices are names, "" where there is none. Raises KeyError, also for values that a repeat draws several of.
        """
        draws = [(k, d) for k, d in enumerate(self.batch.program.draws) if d.column.name == name]
        if not draws or any(s.kind == "repeat" for _, d in draws for s in d.column.scope.ancestors()):
            if not isinstance(name, str):
                raise UsageError(
                    f"[{name!r}] is not the name of a value",
                    'a value is batch["width"], an object batch.object(37), in turn `for one in batch`',
                )
            known = sorted({d.column.name for d in self.batch.program.draws})
            why = "an object has several of it; see the annotation" if draws else did_you_mean(name, known)
            raise KeyError(f"{name}: " + (why or "there is no such value; see the annotation"))
        words = draws[0][1].kind == "choice"
        found = np.full(len(self), "" if words else np.nan, dtype=object if words else np.float64)
        for k, draw in draws:
            drawn = self.batch.state.values[k]
            found[self.batch.owner(draw.column.scope)] = [draw.options[int(i)] for i in drawn] if words else drawn
        return found.astype(str) if words else found

    # ------------------------------------------------------------ joint values

    def rest(self) -> np.ndarray:
        """Joint values (J,) at rest, in the order of ``joints()``."""
        return self.batch.rest()

    def opened(self) -> np.ndarray:
        """Joint values (J,) with every limited joint four fifths of its way open."""
        from ..annotate.states import open_values

        return open_values(self.batch)

    def states(self, **values: float) -> np.ndarray:
        """Joint values (J,) at rest but for the joints named: ``batch.states(open=1.2)``, all that bear the name."""
        joints, found = self.joints(), self.rest().copy()
        names = [self.batch.program.joints[d].name for d in joints.definition]
        for name, value in values.items():
            rows = [i for i, (own, kind) in enumerate(zip(joints.name, names, strict=True)) if name in (own, kind)]
            if not rows:
                known = list(dict.fromkeys(names))
                raise UsageError(
                    f"{self.category} has no joint `{name}`",
                    did_you_mean(name, known) or f"its joints are {', '.join(known)}",
                )
            found[rows] = value
        return found

    def joint_values(self, states: str = "random:4") -> np.ndarray:
        """Joint values (K, J) in the states named: "rest", "open", "random:K" within the limits, with commas between."""
        from ..annotate.states import joint_values, read_states

        if not isinstance(states, str):
            raise UsageError(f"states are text, not {states!r}", "such as rest, open or random:4")
        return joint_values(self.batch, read_states(states))

    # ------------------------------------------------------------ geometry

    def points(
        self,
        n: int = 2048,
        states: np.ndarray | None = None,
        *,
        motion: bool = False,
        surface: str = "boundary",
        spread: str = "random",
        per: str = "object",
        balance: str = "",
        weights: str | Mapping[str, float] | None = None,
    ) -> Points:
        """``n`` points per object on the visible surface with normals, labels and binding, arrays (B, n, ...).

        With the joints at ``states`` (J,), at rest by default. In several ``states`` (K, J) positions and normals are
        (B, K, n, 3); ``motion``: velocities by the own joint. ``surface``: "boundary" of the union of all primitives,
        or what of it can be seen from "outside". ``spread``: "random", or "blue" to keep points apart. ``per``: n for
        each "object", "semantic" class, part "instance", "link" or "primitive" that shows itself; arrays then have a
        row for each of these, and ``object`` tells whose it is. ``balance``: the n points of an object are shared out
        evenly over its "semantic" classes, "instance"s, "link"s or "primitive"s, or by their ``weights``,
        ``{"handle": 3}``; ``area`` tells what surface a point stands for. Raises UsageError, UserError.
        """
        from ..annotate.cloud import sample_points
        from ..annotate.sampling import Sampling, read_weights

        how = Sampling(n, surface, spread, per, balance, read_weights(weights))
        return sample_points(self.batch, how, states, motion=motion)

    def rebind(
        self, points: Points | Mapping[str, np.ndarray], states: np.ndarray | None = None, *, motion: bool = False
    ) -> Points:
        """Points of other objects of the program at the same places on these: ``mutant.rebind(batch.points())``.

        ``points`` may be the arrays of a points shard, too. Labels are those of the new places; ``bound`` tells where
        primitive and patch still exist. Raises UsageError.
        """
        from ..annotate.rebind import rebind

        return rebind(self.batch, points, states, motion=motion)

    def views(
        self,
        n: int | str | Path | Mapping[str, Any] = 8,
        *,
        states: np.ndarray | None = None,
        engine: str | None = None,
        **camera: Any,
    ) -> Views:
        """Images and partial clouds from ``n`` cameras around each object, arrays (B, n, ...) or (B, K, n, ...).

        ``n`` may be a camera file or its contents; ``camera``: what such a file says beside ``views`` (width=640,
        height=480, fov=35, azimuth=[-60, 60], points=2048, ...). Raises UserError, UsageError.
        """
        from ..annotate.camera_file import cameras_of
        from ..annotate.views import make_views

        return make_views(self.batch, cameras_of(n, **camera), states, engine)

    def meshes(
        self, states: np.ndarray | None = None, *, tolerance: float | None = None, triangles: int | None = None
    ) -> list[trimesh.Scene]:
        """One trimesh scene per object, a closed mesh per primitive, named after its part.

        ``tolerance``: how far a mesh may lie off the true surface, metres; ``triangles``: the most that an object may
        have, spread by curvature. Neither: 24 steps per full turn. Raises UsageError.
        """
        from ..export.scenes import make_scenes
        from ..geometry.resolution import Resolution

        return make_scenes(self.batch, states, Resolution(tolerance=tolerance, triangles=triangles))

    def grasps(
        self, values: int = 5, *, gripper: Gripper | str = "standard", states: np.ndarray | None = None
    ) -> GraspTable:
        """Grasps of all objects, each family at ``values`` places; frames at joint values 0.

        Only those that the ``gripper`` can make with the joints at ``states`` (J,), by default at rest; "any": all.
        """
        from ..annotate.grasps import sample_grasps
        from ..annotate.gripper import judge, read_gripper

        found, hand = sample_grasps(self.batch, values), read_gripper(gripper)
        return found if hand is None else found.take(np.flatnonzero(judge(self.batch, found, hand, states) == 0))

    def keypoints(self) -> KeypointTable:
        """Keypoints of all objects at joint values 0."""
        from ..annotate.grasps import sample_keypoints

        return sample_keypoints(self.batch)


class Object(Samples):
    """One object; tables and arrays have its rows alone."""

    @property
    def number(self) -> int:
        return int(self.numbers[0])

    @cached_property
    def annotation(self) -> dict[str, Any]:
        """All that is known of the object as plain data."""
        return self.annotations()[0]

    @cached_property
    def drawn(self) -> dict[str, Any]:
        """Parameters, counts and choices; lists where a repeat draws several."""
        return self.batch.drawn(0)

    def mesh(
        self, states: np.ndarray | None = None, *, tolerance: float | None = None, triangles: int | None = None
    ) -> trimesh.Scene:
        """The object as a trimesh scene, see ``meshes``."""
        return self.meshes(states, tolerance=tolerance, triangles=triangles)[0]

    def _title(self) -> str:
        return f"{self.category} {self.number}, seed {self.seed}"
