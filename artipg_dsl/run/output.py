"""What is written of the objects: in which formats, and what their files hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from pathlib import Path
from typing import Annotated, Any, NotRequired, TypedDict, cast

from ..annotate.camera_file import cameras_from, cameras_of
from ..annotate.cameras import Cameras
from ..annotate.gripper import Gripper, read_gripper
from ..annotate.sampling import MOST as MOST_POINTS
from ..annotate.sampling import POOLS, SPREADS, SURFACES, Sampling, read_weights
from ..annotate.states import read_states
from ..details.dressing import Dressing
from ..errors import UsageError, UserError
from ..export.content import Content
from ..export.registry import FORMATS, TABLES, Format, kinds
from ..export.remote import Place, Remote, place_of
from ..geometry.rays import best_engine
from ..geometry.resolution import COARSEST, FINEST, Resolution
from ..graph.program import MEASURES
from ..records import dataclass
from ..shapes import Rule
from .memory import USUAL, shard_bytes
from .schema import MOST, Title, at_entry, one_of, within


def _states(text: str) -> bool:
    try:
        return str(read_states(text)) == text
    except UserError:
        return False


class Meshes(TypedDict):
    steps: NotRequired[Annotated[int, within(3, 4096)]]
    tolerance: NotRequired[Annotated[float, within(FINEST, COARSEST)]]
    triangles: NotRequired[Annotated[int, within(1, MOST)]]


Hand = Annotated[
    dict[str, Annotated[float, within(1e-6, 10.0)]],
    Rule(f"the measures {', '.join(MEASURES)}", lambda value: value.keys() == set(MEASURES)),
]
Known = Annotated[str, Rule("a format", lambda value: value in FORMATS)]


class Dressed(TypedDict):
    folder: str
    mark: str
    strength: Annotated[float, within(0.0, 1.0)]
    borrowed: NotRequired[bool]


class Worn(TypedDict):
    mark: str
    strength: Annotated[float, within(0.0, 1.0)]


class Shown(TypedDict):
    """What meshes show that were written later than their folder, where that is not what the folder says."""

    meshes: Meshes
    details: Worn | None


class Written(TypedDict):
    """What the manifest keeps of an output."""

    points: Annotated[int, within(1, MOST_POINTS), Title("the number of points")]
    surface: Annotated[str, one_of(SURFACES), Title("the surface that points lie on")]
    spread: Annotated[str, one_of(SPREADS), Title("how points are spread")]
    per: Annotated[str, one_of(POOLS), Title("what the number of points is of")]
    balance: NotRequired[
        Annotated[str, one_of(name for name in POOLS if name != "object"), Title("what points are shared out over")]
    ]
    weights: NotRequired[Annotated[dict[str, Annotated[float, within(1e-9, 1e9)]], Title("the weights of points")]]
    states: Annotated[str, Rule("joint states such as rest,open,random:4", _states), Title("the joint states")]
    motion: Annotated[bool, Title("velocities of points")]
    views: Annotated[dict[str, Any] | None, Title("the cameras")]
    gripper: Annotated[Hand | None, Title("the gripper")]
    meshes: NotRequired[Annotated[Meshes, Title("the resolution of meshes")]]
    details: NotRequired[Annotated[Dressed, Title("the details")]]
    formats: Annotated[
        list[Known], Rule("formats, each once", lambda value: 0 < len(value) == len(set(value))), Title("the formats")
    ]
    shard: Annotated[int, within(1, MOST), Title("the number of objects per shard")]


@dataclass(frozen=True, slots=True)
class Output:
    """``formats`` by name; ``content`` of their files; ``shard``: how many objects share a file. Cameras are kept where
    views are written alone."""

    formats: tuple[str, ...]
    content: Content = field(default_factory=Content)
    shard: int = 0  # what is handy

    def __post_init__(self) -> None:
        cameras = (self.content.cameras or Cameras()) if "views" in self.kinds else None
        object.__setattr__(self, "content", replace(self.content, cameras=cameras))
        object.__setattr__(self, "shard", self.shard or self.content.shard_size())

    @classmethod
    def of(cls, formats: Iterable[Format], content: Content, memory: int | None = None) -> Output:
        """The output in formats that ``choose_formats`` or ``find_formats`` has found, in shards that go into the memory."""
        made = cls(tuple(entry.name for entry in formats), content)
        return replace(made, shard=made.content.shard_size(shard_bytes(memory or USUAL)))

    @property
    def kinds(self) -> list[str]:
        """What is written, whatever it is kept in."""
        return kinds(self.formats)

    @property
    def wearable(self) -> bool:
        """Whether anything is written that wears details: points, or meshes."""
        return "points" in self.kinds or any(entry.per_object for entry in self.writers)

    @property
    def writers(self) -> tuple[Format, ...]:
        """The formats themselves."""
        return tuple(FORMATS[name] for name in self.formats)

    def to_manifest(self) -> Written:
        """As the manifest keeps it, but for the place of details, which it has as seen from its folder."""
        content, points, meshes = self.content, self.content.points, self.content.resolution.plain()
        cameras, hand = content.cameras, content.gripper
        found: Written = {
            "points": int(points.count),
            "surface": points.surface,
            "spread": points.spread,
            "per": points.per,
            "states": str(content.states),
            "motion": content.motion,
            "views": None if cameras is None else cameras.plain() | {"engine": best_engine()},
            "gripper": None if hand is None else hand.plain(),
            "formats": list(self.formats),
            "shard": self.shard,
        }
        if points.balance:
            found["balance"] = points.balance
        if points.weights:
            found["weights"] = dict(points.weights)
        if content.details is not None:
            worn = content.details
            found["details"] = {"folder": worn.folder, "mark": worn.mark, "strength": worn.strength}
            if worn.borrowed:
                found["details"]["borrowed"] = True
        if meshes:
            found["meshes"] = cast(Meshes, meshes)
        return found

    @property
    def shown(self) -> Shown:
        """How fine its meshes are, and by digest and strength the details that they wear."""
        return show(self.content.resolution, self.content.details)

    @classmethod
    def from_manifest(cls, found: Written, beside: Place | str | None = None) -> Output:
        """The output that a manifest tells of; ``beside``: the folder that it lies in. Raises Misfit."""
        views, hand, weights = found["views"], found["gripper"], found.get("weights")
        cameras = None
        if views is not None:
            with at_entry("identity.views", "a description of cameras"):
                cameras = cameras_from({key: value for key, value in views.items() if key != "engine"})
        with at_entry("identity", "points that can be taken"):
            points = Sampling(
                found["points"],
                found["surface"],
                found["spread"],
                found["per"],
                found.get("balance", ""),
                read_weights(weights),
            )
        content = Content(
            points,
            read_states(found["states"]),
            found["motion"],
            cameras,
            None if hand is None else Gripper(**hand),
            Resolution(**found.get("meshes", {})),
            _dressing(found["details"], beside) if "details" in found else None,
        )
        return cls(tuple(found["formats"]), content, found["shard"])


def show(resolution: Resolution, details: Dressing | None) -> Shown:
    """What meshes of this resolution and in these details show."""
    worn: Worn | None = None if details is None else {"mark": details.mark, "strength": details.strength}
    return {"meshes": cast(Meshes, resolution.plain()), "details": worn}


def refuse_idle(output: Output, mark: str = "") -> None:
    """Refuse what no file of an output would show; ``mark`` stands before the names of options. Raises UsageError."""
    content, plain = output.content, Content()
    if "points" not in output.kinds:
        given = {"points": content.points.count != plain.points.count, "motion": content.motion} | {
            name: getattr(content.points, name) != getattr(plain.points, name)
            for name in ("surface", "spread", "per", "balance")
        }
        for name in (name for name, differs in given.items() if differs):
            raise UsageError(
                f"{mark}{name} applies to points, which are not among the formats", "add points to the formats"
            )
    if output.kinds == [TABLES]:
        for name in ("states", "gripper"):
            if getattr(content, name) != getattr(plain, name):
                raise UsageError(
                    f"{mark}{name} does not apply to values alone", "give it when their files are made: apgc sample DIR"
                )
    if content.resolution != plain.resolution and not any(entry.per_object for entry in output.writers):
        raise UsageError(
            f"{mark}tolerance and {mark}triangles apply to meshes, and none of the formats has any",
            "add a format such as glb",
        )


def _dressing(found: Dressed, beside: Place | str | None) -> Dressing:
    """The details that a manifest names as seen from its folder, or, if they are not there, from here."""
    worn = Dressing(**found)
    if beside is None or isinstance(place_of(beside), Remote):
        return worn
    there = Path(str(beside)) / worn.folder
    return replace(worn, folder=str(there)) if there.is_dir() else worn


def read_content(
    *,
    points: int = 2048,
    surface: str = "boundary",
    spread: str = "random",
    per: str = "object",
    balance: str | None = None,
    weights: str | Mapping[str, float] | None = None,
    states: str = "rest",
    motion: bool = False,
    views: int | str | Path | Mapping[str, Any] | None = None,
    gripper: Gripper | str = "standard",
    tolerance: float | None = None,
    triangles: int | None = None,
) -> Content:
    """What files are to hold, in the words of the command line or as Python gives it. Raises UsageError, UserError."""
    return Content(
        points=Sampling(points, surface, spread, per, balance or "", read_weights(weights)),
        states=read_states(states),
        motion=motion,
        cameras=None if views is None else cameras_of(views),
        gripper=read_gripper(gripper),
        resolution=Resolution(tolerance=tolerance, triangles=triangles),
    )
