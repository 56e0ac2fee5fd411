"""What is drawn: a program, a seed, the numbers of objects, and what is fixed of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import Annotated, Any, NotRequired, TypedDict, cast

import numpy as np

from ..arguments import read_flag, read_whole
from ..errors import UsageError
from ..export.remote import Place, Remote
from ..records import dataclass
from ..sampling.mutate import OPERATIONS
from ..sampling.mutation import Mutation
from ..sampling.prior import CANDIDATES, MOST_CANDIDATES
from ..sampling.trace import Replay
from ..shapes import Rule
from .frame import TURNS, Frame, read_frame
from .params import read_params
from .prior import Prior, PriorFile, read_prior
from .schema import LARGEST, MOST, RUNS, FirstAndLast, Runs, Title, expand, one_of, to_runs, within
from .settings import Value
from .traces import read_replay

SEQUENTIAL, PRIOR = "sequential", "prior"


class Replayed(TypedDict):
    """A mutation that repeats a trace, by the digest of its records, which lie in the same folder."""

    replay: str
    unchecked: NotRequired[bool]


class Mutated(TypedDict):
    operations: list[Annotated[str, one_of(OPERATIONS)]]
    variant: Annotated[int, within(0, 2**31 - 1)]
    strength: Annotated[float, within(0.0, 1e6)]
    share: Annotated[float, within(0.0, 1.0)]
    only: str
    one: bool
    each: Annotated[int, within(1, MOST)]
    sources: Annotated[list[FirstAndLast], Rule(RUNS.words, lambda value: bool(value) and RUNS.holds(value))] | None
    unchecked: NotRequired[bool]


class Made(TypedDict):
    """How the objects are made, apart from the parameters that were set, which may have any name."""

    checked: Annotated[bool, Title("the check of collisions")]
    sampling: Annotated[
        str,
        Rule(
            f"sequential or prior:N with 2 to {MOST_CANDIDATES} candidates", lambda text: _candidates(text) is not None
        ),
        Title("the sampling"),
    ]
    repair: Annotated[bool, Title("the repair")]
    mutations: Annotated[list[Replayed | Mutated], Title("the mutations")]
    values: Annotated[
        Annotated[list[dict[str, Any]], Rule("a list of objects", lambda value: len(value) > 0)] | None,
        Title("the values given"),
    ]
    prior: NotRequired[Annotated[dict[str, Any], Title("the prior")]]
    turned: NotRequired[Annotated[int, TURNS, Title("the frame")]]


class Objects(TypedDict):
    """Which objects of which program."""

    program: Annotated[str, Title("the compiled program")]
    seed: Annotated[int, Title("the seed")]
    numbers: Annotated[list[FirstAndLast], RUNS, Title("the objects asked for")]


class Fixed(TypedDict):
    """What is fixed of them."""

    settings: Annotated[
        dict[str, Annotated[Value, Rule("a number or text", lambda value: not isinstance(value, bool))]],
        Title("the parameters that were set"),
    ]
    made: Made


class Drawn(Objects, Fixed):
    """What the manifest keeps of a request."""


@dataclass(frozen=True, slots=True)
class Request:
    """``source`` is what the program is opened by: the name of a shipped category, or a file.

    ``numbers`` are runs of the numbers of objects. ``settings`` fix parameters by name: text with a unit, or numbers in
    SI units. ``checked``: only objects without collisions, but for mutants that say otherwise. ``candidates`` above 0: each
    object is chosen among so many attempts, to follow the declared distributions. ``repair``: what fails at first is repaired
    rather than drawn again.
    ``values``: objects given by their values, numbered from 0, instead of drawn ones. ``program`` is the hash of the
    compiled program as it is declared, once it is known. ``prior``: other weights and narrower ranges of its draws. ``turned``:
    by how many degrees the objects lie turned from x towards y, by their frame until the program is known. Raises UsageError.
    """

    source: str
    seed: int = 0
    numbers: Runs = ((0, 0),)
    settings: Mapping[str, Value] = field(default_factory=dict)
    checked: bool = True
    candidates: int = 0
    repair: bool = False
    values: tuple[Mapping[str, Any], ...] | None = None
    mutations: tuple[Mutation | Replay, ...] = ()
    program: str = ""
    prior: Prior | PriorFile | None = None
    turned: int | Frame = 0

    def __post_init__(self) -> None:
        if self.candidates and self.repair:
            raise UsageError(
                "objects that are repaired cannot follow the declared distributions",
                "leave --repair out, or --sampling prior",
            )

    @property
    def objects(self) -> np.ndarray:
        """The numbers of all objects, ascending."""
        return expand(self.numbers)

    def checks(self, mutations: Sequence[Mutation | Replay] | None = None) -> bool:
        """Whether the objects may not collide, or those that they have been after the first of their ``mutations``."""
        return self.checked and not any(step.unchecked for step in (self.mutations if mutations is None else mutations))

    def to_manifest(self) -> Drawn:
        """As the manifest keeps it; the source stands beside it, as seen from the folder."""
        made: Made = {
            "checked": self.checked,
            "sampling": f"{PRIOR}:{self.candidates}" if self.candidates else SEQUENTIAL,
            "repair": self.repair,
            "mutations": [step.plain() for step in self.mutations],  # type: ignore[misc]
            "values": None if self.values is None else [dict(entry) for entry in self.values],
        }
        if isinstance(self.prior, Prior):
            made["prior"] = dict(sorted(self.prior.draws.items()))
        if isinstance(self.turned, int) and self.turned:
            made["turned"] = self.turned
        return {
            "program": self.program,
            "seed": self.seed,
            "numbers": [list(run) for run in self.numbers],
            "settings": dict(sorted(self.settings.items())),
            "made": made,
        }

    @classmethod
    def from_manifest(cls, drawn: Drawn, source: str, folder: Place, replays: Place | None = None) -> Request:
        """The request that made a folder, with what its manifest calls the program; ``replays`` is where the traces lie that it repeats,
        if not in the folder itself. Raises UserError."""
        made, beside = drawn["made"], None if isinstance(folder, Remote) else folder / source
        own = beside is not None and (beside.is_file() or Path(source).suffix != "")  # a program of the user's
        return cls(
            source=str(beside) if own else source,
            seed=drawn["seed"],
            numbers=tuple((first, last) for first, last in drawn["numbers"]),
            settings=drawn["settings"],
            checked=made["checked"],
            candidates=read_sampling(made["sampling"]),
            repair=made["repair"],
            values=None if made["values"] is None else tuple(made["values"]),
            mutations=tuple(
                _read_step(step, replays or folder, last=k == len(made["mutations"]) - 1)
                for k, step in enumerate(made["mutations"])
            ),
            program=drawn["program"],
            prior=Prior(made["prior"]) if "prior" in made else None,
            turned=made.get("turned", 0),
        )


def _read_step(step: Replayed | Mutated, folder: Place, *, last: bool) -> Mutation | Replay:
    """A mutation, with what it repeats from the folder. Raises UserError."""
    if "replay" not in step:
        return Mutation.of(step)
    told = cast(Replayed, step)
    return read_replay(folder, told["replay"], told.get("unchecked", False), last=last)


def read_request(
    source: str | Path,
    *,
    seed: int = 0,
    n: int | None = None,
    numbers: Sequence[int] | np.ndarray | None = None,
    settings: Mapping[str, Value] | None = None,
    checked: bool = True,
    sampling: str = SEQUENTIAL,
    repair: bool = False,
    values: str | Path | Iterable[Mapping[str, Any]] | None = None,
    prior: str | Path | Mapping[str, Any] | None = None,
    frame: str | Path | None = None,
) -> Request:
    """A request in the words of the command line, or as Python gives it: the objects 0 .. n - 1 or the given ``numbers``.

    ``values``: a file of objects given by their values, or a dictionary for each. ``prior``: the name of a shipped one, a file, or
    what is said of each draw. ``frame``: the name of a shipped one, or a file. Raises UsageError, UserError.
    """
    if not isinstance(source, str | Path) or not str(source).strip() or source == Path():
        raise UsageError(
            f"a category is a name or a file, not {source!r}", 'for example "Microwave" or "desk_lamp.apg"'
        )
    if not isinstance(settings, Mapping | None) or not all(isinstance(name, str) for name in settings or ()):
        raise UsageError(f"set is {settings!r}", 'it maps names to values: {"width": "45cm"}')
    if values is None:
        asked, given = read_numbers(n, numbers), None
    else:
        if settings or sampling != SEQUENTIAL or prior is not None:
            raise UsageError(
                "objects given by their values are neither drawn nor set",
                "leave out the settings, the sampling and the prior",
            )
        given, name = read_params(values)
        asked = read_numbers(len(given) if n is None and numbers is None else n, numbers)
        if asked[-1][1] >= len(given):
            raise UsageError(f"there is no object {asked[-1][1]}: {name} gives {len(given)}, numbered from 0")
    return Request(
        str(source),
        read_whole("seed", seed),
        asked,
        settings or {},
        read_flag("checked", checked),
        read_sampling(sampling),
        read_flag("repair", repair) and given is None,
        given,
        prior=None if prior is None else read_prior(prior),
        turned=0 if frame is None else read_frame(frame),
    )


def is_file(source: str | Path) -> bool:
    """Whether a program is named by its file."""
    return Path(source).suffix != "" or Path(source).is_file()


def read_sampling(text: str) -> int:
    """How many candidates ``sequential`` (none), ``prior`` or ``prior:128`` asks for. Raises UsageError."""
    found = CANDIDATES if text == PRIOR else _candidates(text) if isinstance(text, str) else None
    if found is None:
        raise UsageError(
            f"unknown sampling `{text}`",
            f"it is {SEQUENTIAL}, {PRIOR}, or {PRIOR}:N with 2 to {MOST_CANDIDATES} candidates",
        )
    return found


def _candidates(text: str) -> int | None:
    if text == SEQUENTIAL:
        return 0
    counted = re.fullmatch(rf"{PRIOR}:([1-9][0-9]{{0,6}})", text)
    return int(counted[1]) if counted and 2 <= int(counted[1]) <= MOST_CANDIDATES else None


_NUMBERS = "numbers=[3, 7], or range(100)"


def read_numbers(n: int | None, numbers: Sequence[int] | np.ndarray | None) -> Runs:
    """The numbers 0 .. n - 1 (``n`` is 1 by default), or the ones given. Raises UsageError."""
    if numbers is None:
        count = 1 if n is None else read_whole("n", n)
        if count < 1:
            raise UsageError(f"n is {n}: there must be at least one object")
        if count > MOST:
            raise UsageError(
                f"n is {n}", f"give a number up to {MOST:,}; other `numbers` and seeds give further objects"
            )
        return ((0, count - 1),)
    if n is not None:
        raise UsageError("both n and numbers are given", "n objects are the numbers 0 .. n - 1")
    if isinstance(numbers, Sequence) and len(numbers) > MOST:  # a range, of which no array would fit into memory
        raise UsageError(f"{len(numbers):,} object numbers are given", f"give up to {MOST:,}")
    try:
        asked = np.asarray(numbers)
    except ValueError:  # lists of different lengths
        raise UsageError("object numbers are one list, not a list of lists", _NUMBERS) from None
    if asked.ndim > 1:
        raise UsageError(f"object numbers are a list, not an array of shape {asked.shape}", _NUMBERS)
    if asked.size and asked.dtype.kind not in "iu":
        first = asked.reshape(-1).tolist()[0]
        if type(first) is int:  # of so many digits that NumPy takes it for something else
            raise UsageError(f"there is no object {first}", _NUMBERS)
        raise UsageError(f"object numbers are whole numbers, not {first!r}", _NUMBERS)
    if not asked.size:
        raise UsageError("no object is asked for: `numbers` is empty", _NUMBERS)
    if (wrong := asked[(asked < 0) | (asked >= LARGEST)]).size:
        raise UsageError(f"there is no object {wrong.flat[0]}", f"they count from 0 to {LARGEST - 1:,}")
    return to_runs(np.unique(asked.astype(np.int64)))
