"""What ``manifest.json`` may hold: checked when it is read, so that what works on a folder can rely on it."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Literal, NotRequired, TypedDict

from ..annotate.sampling import MOST as MOST_POINTS
from ..annotate.sampling import POOLS, SPREADS, SURFACES
from ..annotate.states import read_states
from ..errors import UserError
from ..geometry.resolution import COARSEST, FINEST
from ..graph.program import MEASURES
from ..sampling.mutate import OPERATIONS
from ..sampling.prior import MOST_CANDIDATES
from ..shapes import Misfit, Rule, fit, shown
from .content import Content
from .registry import FORMATS

FORMAT = 2
MOST = 100_000_000  # objects
LARGE = 2**63


def spans(value: Any) -> bool:
    """Whether runs ``[first, last]`` ascend, do not meet, and hold no more objects than a folder may."""
    ends = [end for run in value for end in run]
    ordered = all(a <= b if k % 2 == 0 else a < b for k, (a, b) in enumerate(zip(ends, ends[1:], strict=False)))
    within = not ends or 0 <= ends[0] and ends[-1] < LARGE
    return ordered and within and sum(last - first + 1 for first, last in value) <= MOST


def sampling(text: str) -> bool:
    name, _, count = text.partition(":")
    counted = re.fullmatch(r"[1-9][0-9]{0,6}", count) is not None
    return text == "sequential" or name == "prior" and counted and 2 <= int(count) <= MOST_CANDIDATES


def states(text: str) -> bool:
    try:
        return str(read_states(text)) == text
    except UserError:
        return False


def place(text: str) -> bool:
    """Whether a text can be a path at all."""
    short = len(text) <= 2048 and all(len(piece.encode()) <= 255 for piece in text.split("/"))
    return short and text.strip() != "" and "\0" not in text


def among(known: Sequence[str]) -> Any:
    return Annotated[str, Rule(f"one of {', '.join(known)}", lambda value: value in known)]


def from_to(least: float, most: float, kind: type = int) -> Any:
    noun = "a whole number" if kind is int else "a number"
    return Annotated[kind, Rule(f"{noun} from {least:g} to {most:g}", lambda value: least <= value <= most)]


Count = Annotated[int, Rule("a whole number from 0 on", lambda value: 0 <= value < LARGE)]
Run = Annotated[list[int], Rule("a first and a last number", lambda value: len(value) == 2)]
Spans = Annotated[list[Run], Rule("runs of object numbers [first, last], ascending", spans)]
Value = Annotated[float | int | str, Rule("a number or text", lambda value: not isinstance(value, bool))]
Known = Annotated[str, Rule("a format", lambda value: value in FORMATS)]
Formats = Annotated[list[Known], Rule("formats, each once", lambda value: 0 < len(value) == len(set(value)))]
Gripper = TypedDict("Gripper", {name: from_to(1e-6, 10, float) for name in MEASURES})  # type: ignore[misc]


class Replayed(TypedDict):
    replay: str


class Mutated(TypedDict):
    operations: list[among(OPERATIONS)]  # type: ignore[valid-type]
    variant: Annotated[int, Rule("a whole number", lambda value: abs(value) < 2**31)]
    strength: from_to(0, 1e6, float)  # type: ignore[valid-type]
    share: from_to(0, 1, float)  # type: ignore[valid-type]
    only: str
    one: bool
    each: from_to(1, MOST)  # type: ignore[valid-type]
    sources: (
        Annotated[list[Run], Rule("runs of object numbers [first, last], ascending", lambda v: bool(v) and spans(v))]
        | None
    )


class Made(TypedDict):
    checked: bool
    sampling: Annotated[str, Rule(f"sequential or prior:N with 2 to {MOST_CANDIDATES} candidates", sampling)]
    repair: bool
    mutations: list[Replayed | Mutated]
    values: Annotated[list[dict[str, Any]], Rule("a list of objects", lambda value: len(value) > 0)] | None


class Meshes(TypedDict):
    steps: NotRequired[from_to(3, 4096)]  # type: ignore[valid-type]
    tolerance: NotRequired[from_to(FINEST, COARSEST, float)]  # type: ignore[valid-type]
    triangles: NotRequired[from_to(1, MOST)]  # type: ignore[valid-type]


class Identity(TypedDict):
    program: str
    seed: int
    numbers: Spans
    points: from_to(1, MOST_POINTS)  # type: ignore[valid-type]
    surface: among(list(SURFACES))  # type: ignore[valid-type]
    spread: among(list(SPREADS))  # type: ignore[valid-type]
    per: among(list(POOLS))  # type: ignore[valid-type]
    balance: NotRequired[among([name for name in POOLS if name != "object"])]  # type: ignore[valid-type]
    weights: NotRequired[dict[str, from_to(1e-9, 1e9, float)]]  # type: ignore[valid-type]
    states: Annotated[str, Rule("joint states such as rest,open,random:4", states)]
    motion: bool
    views: dict[str, Any] | None
    gripper: Gripper | None
    meshes: NotRequired[Meshes]
    formats: Formats
    shard: from_to(1, MOST)  # type: ignore[valid-type]
    settings: dict[str, Value]
    made: Made
    artipg_dsl: str
    numpy: str


class Candidates(TypedDict):
    each: Count
    valid: float
    effective: float


class Counts(TypedDict):
    checked: bool
    objects: Count
    first_valid: Count
    attempts: Count
    failed: dict[str, Count]
    repaired: NotRequired[dict[str, Count]]
    declined: NotRequired[Count]
    not_preferred: NotRequired[dict[str, Count]]
    candidates: NotRequired[Candidates]


class Site(TypedDict):
    path: str
    primitive: str


class Manifest(TypedDict):
    manifest: Literal[2]
    category: str
    source: Annotated[str, Rule("the name or the file of a program", place)]
    about: str
    identity: Identity
    objects: Count
    shards: list[str]
    python: str
    cpu: str
    frame: str
    vocabularies: dict[str, list[str]]
    sites: list[Site]
    arrays: NotRequired[dict[str, dict[str, Any]]]
    views: NotRequired[dict[str, dict[str, Any]]]
    correspondence: NotRequired[dict[str, str]]
    counts: NotRequired[Counts]


def check(found: Any) -> None:
    """Raises Misfit with the key, what is there and what was expected."""
    if isinstance(found, dict) and isinstance(found.get("manifest"), int) and found["manifest"] != FORMAT:
        raise Misfit("manifest", f"version {FORMAT}, the one that this artipg_dsl writes,", shown(found["manifest"]))
    fit(found, Manifest)
    identity = found["identity"]
    size = sum(last - first + 1 for first, last in identity["numbers"])
    if found["objects"] != size:
        raise Misfit("objects", f"the {size} of identity.numbers", shown(found["objects"]))
    names = shards(size, identity["shard"])
    if found["shards"] != names:
        raise Misfit("shards", f"the {len(names)} shards of {identity['shard']} objects each", "another list")
    if ("views" in identity["formats"]) != (identity["views"] is not None):
        raise Misfit("identity.views", "cameras, where there are views,", shown(identity["views"]))
    try:
        content = Content.read(identity)
    except UserError as error:
        raise Misfit("identity.views", "a description of cameras", error.message) from None
    try:
        _ = content.sampling
    except UserError as error:
        raise Misfit("identity", "points that can be taken", error.message) from None


def shards(size: int, each: int) -> list[str]:
    """The numbers of shards as the names of their files have them."""
    return [f"{at // each:05d}" for at in range(0, size, each)]
