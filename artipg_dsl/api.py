"""The Python interface: ``apg.sample("Microwave", n=1000, seed=7)`` gives objects as arrays, meshes and files."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cached_property
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from .diagnostics.suggest import did_you_mean
from .errors import UsageError
from .run.job import Job, open_job, prepare
from .run.request import read_request
from .run.resume import reopen
from .run.settings import Value
from .session import Session, categories

if TYPE_CHECKING:
    import trimesh

    from .annotate.cloud import Points
    from .annotate.grasps import GraspTable, KeypointTable
    from .annotate.gripper import Gripper
    from .annotate.views import Views
    from .runtime.repairs import Repairs
    from .runtime.tables import JointTable, LinkTable, PartTable
    from .sampling.correspondence import Correspondence
    from .sampling.trace import Step

PICTURED = 8  # objects on the picture in a notebook


def sample(
    category: str | Path,
    n: int | None = None,
    seed: int = 0,
    *,
    numbers: Sequence[int] | np.ndarray | None = None,
    set: Mapping[str, Value] | None = None,
    checked: bool = True,
    sampling: str = "sequential",
    repair: bool = False,
    values: str | Path | Iterable[Mapping[str, Any]] | None = None,
) -> Samples:
    """Objects of a category, by the name of a shipped one or by file.

    ``n`` objects, 0 .. n - 1 (default 1), or those of the given ``numbers``: a number stands for the same object in
    any set of one seed. ``set`` fixes parameters: text with a unit, ``{"width": "45cm", "handle": "none"}``, or
    numbers in metres and radians. Objects whose links collide, at rest or while a joint moves, are drawn again unless
    ``checked`` is false. ``sampling="prior"`` resamples to the declared distributions (``"prior:128"``: among 128
    attempts for each object) where drawing in sequence shifts them. With ``repair`` what fails is put right by the least
    change instead of drawn again, and so are objects given by their ``values``: a file, or a dictionary for each,
    ``[{"width": 0.52, "handle": "BowHandle"}]`` (what they leave out is drawn); ``repairs`` tells what was moved.
    Raises CompileError, SettingError, NoObject, UserError.
    """
    request = read_request(
        category,
        seed=seed,
        n=n,
        numbers=numbers,
        settings=set,
        checked=checked,
        sampling=sampling,
        repair=repair,
        values=values,
    )
    return Samples(open_job(request, values=str(values) if isinstance(values, str | Path) else "values"))


def load(
    text: str, n: int = 1, seed: int = 0, *, set: Mapping[str, Value] | None = None, checked: bool = True
) -> Samples:
    """Objects of a category whose program is at hand as text. Raises CompileError, SettingError, NoObject."""
    if text.strip().endswith((".apg", ".apgc")) and "\n" not in text.strip():
        raise UsageError(f"load takes the text of a program, not its name, {text}", f'write sample("{text}")')
    sampler = Session.of_text(text).sampler
    request = read_request(sampler.program.name, seed=seed, n=n, settings=set, checked=checked)
    return Samples(prepare(sampler, request))


def open_samples(folder: str | Path) -> Samples:
    """The objects of a folder that ``apgc sample`` has written, made again. Raises ExportError, UserError."""
    return Samples(reopen(folder))


class Samples:
    """Objects of one category as columns: every table and array has their rows in the order of ``numbers``.

    Frames are right-handed, x to the front, y to the left, z up; metres and radians.
    """

    def __init__(self, job: Job):
        self.job = job
        self.batch = job.batch()

    def __len__(self) -> int:
        return len(self.batch)

    def __repr__(self) -> str:
        return f"<{self._title()}>"

    def _title(self) -> str:
        count = "1 object" if len(self) == 1 else f"{len(self)} objects"
        return f"{self.category}: {count}, seed {self.seed}"

    @property
    def category(self) -> str:
        return self.batch.program.name

    @property
    def seed(self) -> int:
        return self.job.request.seed

    @property
    def numbers(self) -> np.ndarray:
        """(B,) object numbers, ascending."""
        return self.batch.numbers

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
        from .sampling.mutate import Mutation, read_operations

        step = Mutation(read_operations(operations), variant, strength, share, one or only, one is not None)
        return Samples(self.job.mutated(step))

    def changes(self, number: int) -> list[Step]:
        """What made the object of a number from the one before, step by step; nothing for one that was drawn."""
        from .sampling.trace import traces

        return traces(self.object(number).batch)[0]

    def replay(self, records: Iterable[Mapping[str, Any]]) -> Samples:
        """Objects made from these as the records of traces say (lines of ``trace-*.jsonl``). Raises NoObject, UserError."""
        from .sampling.trace import Replay, checked

        made = {record["object"]: record for record in map(checked, records)}
        return Samples(self.job.mutated(Replay(made), sorted(made)))

    def repairs(self) -> Repairs:
        """Which values were moved to make these objects valid, from what to what, and which requirement asked for it."""
        return self.batch.repairs

    def correspondence(self) -> Correspondence:
        """Which elementary primitive of the objects before became which of these, a row for each of these."""
        from .sampling.correspondence import correspondence

        return correspondence(self.batch.history[0].before if self.batch.history else self.batch, self.batch)

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
        from .annotate.annotation import describe
        from .annotate.gripper import read_gripper

        return describe(self.batch, states, read_gripper(gripper))

    def __getitem__(self, name: str) -> np.ndarray:
        """A drawn value, one per object: ``batch["width"]`` (B,) float64, nan where an object has none of the name.

        Choices are names, "" where there is none. Raises KeyError, also for values that a repeat draws several of.
        """
        draws = [(k, d) for k, d in enumerate(self.batch.program.draws) if d.column.name == name]
        if not draws or any(s.kind == "repeat" for _, d in draws for s in d.column.scope.ancestors()):
            if not isinstance(name, str):
                raise UsageError(
                    f"[{name!r}] names no value",
                    'a value is batch["width"], an object batch.object(37), in turn `for one in batch`',
                )
            known = sorted({d.column.name for d in self.batch.program.draws})
            why = "an object has several; the annotation lists all" if draws else did_you_mean(name, known)
            raise KeyError(f"{name}: " + (why or "there is no such value; the annotation lists all"))
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
        from .annotate.states import opened

        return opened(self.batch)

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
        from .annotate.states import joint_values, read_states

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
        from .annotate.cloud import sample_points
        from .annotate.sampling import Sampling, read_weights

        how = Sampling(n, surface, spread, per, balance, read_weights(weights))
        return sample_points(self.batch, how, states, motion=motion)

    def rebind(
        self, points: Points | Mapping[str, np.ndarray], states: np.ndarray | None = None, *, motion: bool = False
    ) -> Points:
        """Points of other objects of the program at the same places on these: ``mutant.rebind(batch.points())``.

        ``points`` may be the arrays of a points shard, too. Labels are those of the new places; ``bound`` tells where
        primitive and patch still exist. Raises UsageError.
        """
        from .annotate.rebind import rebind

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
        from .annotate.camera_file import cameras_of
        from .annotate.views import make_views

        return make_views(self.batch, cameras_of(n, **camera), states, engine)

    def meshes(
        self, states: np.ndarray | None = None, *, tolerance: float | None = None, triangles: int | None = None
    ) -> list[trimesh.Scene]:
        """One trimesh scene per object, a closed mesh per primitive, named after its part.

        ``tolerance``: how far a mesh may lie off the true surface, metres; ``triangles``: the most that an object may
        have, spread by curvature. Neither: 24 steps per full turn. Raises UsageError.
        """
        from .export.scenes import scenes
        from .geometry.resolution import Resolution

        return scenes(self.batch, states, Resolution(tolerance=tolerance, triangles=triangles))

    def grasps(
        self, values: int = 5, *, gripper: Gripper | str = "standard", states: np.ndarray | None = None
    ) -> GraspTable:
        """Grasps of all objects, each family at ``values`` places; frames at joint values 0.

        Only those that the ``gripper`` can make with the joints at ``states`` (J,), by default at rest; "any": all.
        """
        from .annotate.grasps import sample_grasps
        from .annotate.gripper import judge, read_gripper

        found, hand = sample_grasps(self.batch, values), read_gripper(gripper)
        return found if hand is None else found.take(np.flatnonzero(judge(self.batch, found, hand, states) == 0))

    def keypoints(self) -> KeypointTable:
        """Keypoints of all objects at joint values 0."""
        from .annotate.grasps import sample_keypoints

        return sample_keypoints(self.batch)

    # ------------------------------------------------------------ files

    def to(
        self,
        folder: str | Path,
        formats: str | Iterable[str] | None = None,
        *,
        points: int = 2048,
        states: str = "rest",
        motion: bool = False,
        views: int | str | Path | Mapping[str, Any] | None = None,
        surface: str = "boundary",
        spread: str = "random",
        per: str = "object",
        balance: str = "",
        weights: str | Mapping[str, float] | None = None,
        tolerance: float | None = None,
        triangles: int | None = None,
        force: bool = False,
    ) -> Path:
        """Write what ``apgc sample`` writes: shards, a folder per object where a format asks for it, the manifest.

        The options are those of the command, of ``points`` and of ``meshes``: ``states`` such as "open,random:4",
        ``views`` a number or cameras.
        """
        from .export.registry import choose
        from .run.dataset import write_dataset
        from .run.output import Output, read_content

        names = formats if formats is None or isinstance(formats, str) else list(formats)
        content = read_content(
            points=points,
            surface=surface,
            spread=spread,
            per=per,
            balance=balance,
            weights=weights,
            states=states,
            motion=motion,
            views=views,
            tolerance=tolerance,
            triangles=triangles,
        )
        write_dataset(self.job, folder, Output.of(choose(names, views=views is not None), content), force=force)
        return Path(folder)

    def export(
        self,
        folder: str | Path,
        formats: str | Iterable[str],
        *,
        tolerance: float | None = None,
        triangles: int | None = None,
        force: bool = False,
    ) -> list[Path]:
        """Files per object, ``batch.export("robots", "urdf,glb")``; returns the folders ``objects/<number>``.

        Formats are those of ``apgc export``, ``tolerance`` and ``triangles`` as in ``meshes``. What is there is refused
        unless ``force``. Raises ExportError.
        """
        from .export.objects import object_folder, write_objects
        from .export.registry import named, per_object
        from .geometry.resolution import Resolution

        chosen = named(formats if isinstance(formats, str) else list(formats))
        for entry in chosen:
            if not entry.per_object:
                raise UsageError(f"{entry.name} is written by `to`", f"export writes {', '.join(per_object())}")
        fine = Resolution(tolerance=tolerance, triangles=triangles)
        write_objects(self.batch, Path(folder), chosen, force=force, resolution=fine)
        return [object_folder(Path(folder), n) for n in self.numbers.tolist()]

    def to_urdf(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """A robot description with its meshes per object; returns the paths of ``object.urdf``."""
        return self._objects(folder, "urdf", force)

    def to_glb(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """A binary glTF per object; returns the paths of ``object.glb``."""
        return self._objects(folder, "glb", force)

    def to_usd(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """OpenUSD with a physics articulation per object; returns the paths of ``object.usda``."""
        return self._objects(folder, "usd", force)

    def to_mjcf(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """MuJoCo's own format per object; returns the paths of ``object.xml``."""
        return self._objects(folder, "mjcf", force)

    def to_sdf(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """SDFormat per object; returns the paths of ``model.sdf``."""
        return self._objects(folder, "sdf", force)

    def to_obj(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """A Wavefront OBJ per link with the object's materials; returns the paths of ``obj/object.mtl``."""
        return self._objects(folder, "obj", force)

    def to_partnet_mobility(self, folder: str | Path, *, force: bool = False) -> list[Path]:
        """The folder of PartNet-Mobility per object; returns the paths of ``mobility.urdf``."""
        return self._objects(folder, "partnet-mobility", force)

    def _objects(self, folder: str | Path, name: str, force: bool) -> list[Path]:
        from .export.registry import FORMATS

        return [made / FORMATS[name].file for made in self.export(folder, name, force=force)]

    # ------------------------------------------------------------ pictures

    def sheet(self, path: str | Path, **options: Any) -> Path:
        """Draw all objects to a PNG; the options are those of ``view.sheet.sheet`` (colour, tile, columns, states, view)."""
        from .view.sheet import write_sheet

        if Path(path).suffix.lower() != ".png":
            raise UsageError(f"the picture is written as PNG, not to {path}", "choose a name that ends in .png")
        write_sheet(self.batch, path, force=True, **options)
        return Path(path)

    @cached_property
    def _picture(self) -> bytes:
        from .view.png import png_bytes
        from .view.sheet import sheet

        return png_bytes(sheet(self.job.batch(self.numbers[:PICTURED]), tile=220))

    def _repr_png_(self) -> bytes:
        return self._picture

    def _repr_html_(self) -> str:
        picture = base64.b64encode(self._picture).decode("ascii")
        more = f", the first {PICTURED} shown" if len(self) > PICTURED else ""
        title = escape(self._title())
        return f'<img alt="{title}" src="data:image/png;base64,{picture}"><p>{title}{more}</p>'


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


__all__ = ["Object", "Samples", "categories", "load", "open_samples", "sample"]
