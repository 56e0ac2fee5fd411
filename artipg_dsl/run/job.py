"""One run of the main job: a program, a seed, what is fixed of it; objects by number, in memory or in a folder."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from operator import index
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..diagnostics.suggest import did_you_mean
from ..errors import NoObject, UsageError, UserError
from ..runtime.kernels import TooMany
from ..runtime.repairs import Cause, in_short
from ..sampling.mutate import Mutation, Names
from ..sampling.prior import CANDIDATES, MOST_CANDIDATES
from ..sampling.sample import Sampler
from ..sampling.settled import again
from ..sampling.statistics import Exhausted, Statistics
from ..sampling.trace import Replay, read_traces
from ..sampling.values import Values
from ..validity.sound import prove
from .compiled import COMPILED, planned, read_compiled
from .settings import Settings, Value, resolve

if TYPE_CHECKING:
    from ..export.content import Content
    from ..export.dataset import Run
    from ..export.registry import Format
    from ..geometry.resolution import Resolution
    from ..runtime.batch import Batch

NARROW = "widen the ranges, or state what one value leaves to the next"
TURNED = "leave room where it turns or slides, or turn its axis round: `lid.back.bottom` for `lid.bottom.back`"
SEQUENTIAL, PRIOR = "sequential", "prior"


@dataclass(slots=True)
class Job:
    """``source`` is what the program was opened by: the name of a shipped category, or a file."""

    sampler: Sampler
    source: str
    seed: int = 0
    settings: Settings = field(default_factory=dict)
    given: dict[int, float] = field(default_factory=dict)
    statistics: Statistics = field(default_factory=Statistics)
    mutations: tuple[Mutation | Replay, ...] = ()
    checked: bool = True  # only objects without collisions
    candidates: int = 0  # above 0: each object is one of so many attempts, resampled to the declared distributions
    values: Values | None = None  # objects given by their values, numbered from 0, instead of drawn ones
    repair: bool = False  # what fails at first is repaired rather than drawn again

    def batch(self, numbers: Sequence[int] | np.ndarray) -> Batch:
        """The objects of the given numbers, or what the mutations make of them. Raises NoObject."""
        try:
            made = self._made(np.asarray(numbers, dtype=np.int64), self.mutations)
            prove(made)
            return made
        except Exhausted as error:
            raise self.exhausted(error) from None
        except TooMany as error:
            raise UserError(f"{self.sampler.program.name}: {error}", "bound the counts of its repeats") from None

    def _made(self, numbers: np.ndarray, mutations: tuple[Mutation | Replay, ...]) -> Batch:
        if not mutations and self.values is not None:
            return self.values.batch(self.sampler, numbers, self.seed, self.statistics, self.checked)
        if not mutations:
            return self.sampler.batch(
                numbers, self.seed, given=self.given, statistics=self.statistics, checked=self.checked,
                candidates=self.candidates, mend=self.repair,
            )  # fmt: skip
        *before, step = mutations
        sources, variants = step.origins(numbers)
        stock, place = np.unique(sources, return_inverse=True)
        made = self._made(stock, tuple(before))
        if len(stock) != len(numbers) or (np.diff(place) != 1).any():
            made = again(made, place)
        return step.apply(self.sampler, made, numbers, variants, self.statistics, self.checked)

    def mutated(self, step: Mutation | Replay) -> Job:
        """The job of the mutants of this one's objects. Raises UsageError for names that mean nothing."""
        program = self.sampler.program
        for name in Names.unknown(step.only, program) if isinstance(step, Mutation) else ():
            names = dict.fromkeys(d.column.name for d in program.draws)
            raise UsageError(
                f"{program.name} draws no `{name}`",
                did_you_mean(name, names) or f"it draws {', '.join(list(names)[:8])}, ...",
            )
        return replace(self, mutations=(*self.mutations, step), statistics=Statistics())

    def made(self) -> dict[str, Any]:
        """How the objects are made, as the manifest keeps it beside the parameters that were set."""
        return {
            "checked": self.checked,
            "sampling": f"{PRIOR}:{self.candidates}" if self.candidates else SEQUENTIAL,
            "repair": self.repair,
            "mutations": [step.plain() for step in self.mutations],
            "values": None if self.values is None else [dict(entry) for entry in self.values.plain],
        }

    def exhausted(self, error: Exhausted) -> NoObject:
        """What the requirements leave nothing of, and which of them are to blame."""
        shown = ", ".join(map(str, error.numbers[:3].tolist())) + (", ..." if len(error.numbers) > 3 else "")
        counted = "object" if len(error.numbers) == 1 else f"{len(error.numbers)} objects"
        shapes = {
            in_short(self.sampler.program, ("collision", key)): words
            for key, words in error.statistics.examples.items()
        }
        lines = [
            f"  {count:>8} times: {reason}" + (f"\n{'':17}{shapes[reason]}" if shapes.get(reason) else "")
            for reason, count in list(self.failures().items())[:3]
        ]
        fixed = " with what was set" if self.settings else ""
        return NoObject(
            (
                f"what was set leaves no valid {self.sampler.program.name}; "
                if error.hopeless
                else f"no valid {self.sampler.program.name} in {error.attempts} attempts{fixed} for {counted} {shown}; "
            )
            + "what failed most:\n"
            + "\n".join(lines),
            "set other values" if self.settings else TURNED if " collide while " in lines[0] else NARROW,
        )

    def failures(self) -> dict[str, int]:
        """In words what failed, with its place in the text, and in how many attempts; the worst first."""
        return self.told(self.statistics.failures())

    def told(self, counted: Mapping[Cause, int]) -> dict[str, int]:
        """Counts of causes in words, the most frequent first."""
        found: dict[str, int] = {}
        for cause, count in counted.items():
            words = in_short(self.sampler.program, cause)
            found[words] = found.get(words, 0) + count
        return dict(sorted(found.items(), key=lambda item: (-item[1], item[0])))

    def counts(self) -> dict[str, Any]:
        """The statistics as the manifest keeps them."""
        made = self.statistics
        found: dict[str, Any] = {
            "checked": self.checked,
            "objects": made.objects,
            "first_valid": made.first_valid,
            "attempts": made.attempts,
        }
        found["failed"] = self.failures()
        if made.repaired:
            found["repaired"] = self.told(made.repaired)
        program = self.sampler.program
        if program.preferences and not made.candidates:  # else they are part of the weights
            found["declined"] = made.declined
            kept_not = ((program.preferences[k], count) for k, count in made.unkept.items())
            found["not_preferred"] = {f"{one.where}: prefer {one.text}": count for one, count in kept_not}
        if made.candidates:
            attempts = max(1, made.attempts)
            found["candidates"] = {
                "each": made.candidates, "valid": made.candidates_valid / attempts,
                "effective": made.effective * made.candidates / attempts,
            }  # fmt: skip
        return found

    def write(
        self,
        out: Path | str,
        numbers: np.ndarray,
        formats: Sequence[Format],
        *,
        content: Content | None = None,
        force: bool = False,
        part: tuple[int, int] = (1, 1),
        progress: Callable[[int, int], None] | None = None,
        workers: int = 1,
    ) -> dict[str, Any]:
        """Write objects to a folder, or the k-th of n parts of its shards; returns the manifest. Raises ExportError.

        ``workers``: how many processes share the work.
        """
        from ..export.content import STANDARD
        from ..export.dataset import write_dataset

        return write_dataset(
            self.sampler.program, self.batch, out, seed=self.seed, numbers=numbers, formats=formats,
            content=content or STANDARD, settings=self.settings, made=self.made(), source=relative(self.source, out), part=part,
            force=force, progress=progress,
            counts=self.counts, run=self._run(workers),
        )  # fmt: skip

    def add(
        self,
        out: Path | str,
        numbers: np.ndarray,
        formats: Sequence[Format],
        *,
        resolution: Resolution | None = None,
        force: bool = False,
        progress: Callable[[int, int], None] | None = None,
        workers: int = 1,
    ) -> None:
        """Write further files for the objects of a folder of samples. Raises ExportError."""
        from ..export.dataset import add_formats

        add_formats(
            self.batch, Path(out), numbers, formats, force=force, progress=progress, resolution=resolution,
            run=self._run(workers),
        )  # fmt: skip

    def _run(self, workers: int) -> Run | None:
        if workers == 1:
            return None
        from .workers import share

        return partial(share, self, workers)


def open_job(
    name: str | Path, seed: int = 0, settings: Mapping[str, Value] | None = None, *, checked: bool = True,
    sampling: str = SEQUENTIAL, repair: bool = False,
) -> Job:  # fmt: skip
    """The job of a category given by name or file; a compiled one (.apgc) is read without the parser.

    ``checked``: only objects whose links do not penetrate one another, at rest and while each joint moves.
    ``sampling`` is "sequential" or "prior", perhaps with a number of candidates: "prior:128".
    ``repair``: what fails is put right with the least change, not drawn again.
    Raises CompileError, SettingError, and UserError for a compiled program that cannot be read.
    """
    if Path(name).suffix == COMPILED:
        return make_job(
            planned(read_compiled(name), name),
            str(name),
            seed,
            settings,
            checked=checked,
            sampling=sampling,
            repair=repair,
        )
    from ..session import Session

    session = Session.of(name)
    sampler = session.sampler
    source = str(name) if session.path is None or is_file(name) else sampler.program.name
    return make_job(sampler, source, seed, settings, checked=checked, sampling=sampling, repair=repair)


def make_job(
    sampler: Sampler, source: str, seed: int, settings: Mapping[str, Value] | None = None, *, checked: bool = True,
    sampling: str = SEQUENTIAL, repair: bool = False,
) -> Job:  # fmt: skip
    candidates = read_sampling(sampling)
    if candidates and repair:
        raise UsageError(
            "objects that are repaired cannot follow the declared distributions",
            "leave --repair out, or --sampling prior",
        )
    if settings is not None and not isinstance(settings, Mapping):
        raise UsageError(f"set is {settings!r}", 'it maps names to values: {"width": "45cm"}')
    given, plain = resolve(sampler.program, settings or {})
    return Job(
        sampler, source, whole("seed", seed), plain, given, checked=checked, candidates=candidates, repair=repair
    )


def whole(name: str, value: Any) -> int:
    """A whole number, of Python's or NumPy's types. Raises UsageError."""
    try:
        return index(value)
    except TypeError:
        raise UsageError(f"{name} is {value!r}: a whole number is needed") from None


def read_sampling(text: str) -> int:
    """How many candidates ``sequential`` (none), ``prior`` or ``prior:128`` asks for. Raises UsageError."""
    if text in (SEQUENTIAL, PRIOR):
        return CANDIDATES if text == PRIOR else 0
    name, _, count = text.partition(":")
    if name != PRIOR or not (count.isdecimal() and 2 <= int(count) <= MOST_CANDIDATES):
        raise UsageError(
            f"there is no sampling `{text}`",
            f"it is {SEQUENTIAL}, {PRIOR}, or {PRIOR}:N with 2 to {MOST_CANDIDATES} candidates",
        )
    return int(count)


def is_file(name: str | Path) -> bool:
    """Whether a program was named by its file."""
    return Path(name).suffix != "" or Path(name).exists()


def relative(source: str, out: Path | str) -> str:
    """A file as seen from the folder of samples, so that both can be moved together; a name stays as it is."""
    if not is_file(source):
        return source
    return Path(os.path.relpath(Path(source).resolve(), Path(out).resolve())).as_posix()


def traces_of(place: Path | str) -> dict[int, dict[str, Any]]:
    """The traces in a folder that ``apgc mutate`` wrote, or in one of its files, by number of the object. Raises UserError."""
    place = Path(place)
    files = sorted(place.glob("trace-*.jsonl")) if place.is_dir() else [place]
    found: dict[int, dict[str, Any]] = {}
    for file in files:
        try:
            found |= read_traces(file.read_text(encoding="utf-8"), str(file))
        except (OSError, UnicodeDecodeError) as error:
            raise UserError(f"{file} cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if not found:
        raise UserError(
            f"{place} holds no traces", "give a folder that `apgc mutate` has written, or a trace-*.jsonl of it"
        )
    return found


def reopen(folder: Path | str) -> tuple[Job, np.ndarray]:
    """The job that a folder of samples was made by, and the numbers of its objects. Raises ExportError, UserError."""
    from ..export import manifest as manifests

    folder = Path(folder)
    manifest = manifests.read(folder)
    if manifest is None:
        raise UserError(f"{folder} holds no {manifests.NAME}", manifests.WANTED)
    identity, made = manifest["identity"], manifest["identity"]["made"]
    source = manifest["source"]
    if (folder / source).is_file():  # a program of the user's, found from the folder
        source = str(folder / source)
    try:
        job = open_job(
            source,
            identity["seed"],
            identity["settings"],
            checked=made["checked"],
            sampling=made["sampling"],
            repair=made["repair"],
        )
        if made["values"] is not None:
            from .params import values_of

            job = replace(job, values=values_of(made["values"], job.sampler.program, "values"))
        for step in made["mutations"]:
            job = job.mutated(Replay(traces_of(folder)) if "replay" in step else Mutation.of(step))
    except UsageError as error:  # what the manifest says, nobody has typed
        raise UserError(f"{folder / manifests.NAME}: {error.message}", error.hint) from None
    if job.sampler.program.hash != identity["program"]:
        raise UserError(
            f"the program {source} has changed since the samples in {folder} were made",
            "sample it again, with --force into the same folder",
        )
    numbers = [np.arange(first, last + 1) for first, last in identity["numbers"]]
    return job, np.concatenate(numbers) if numbers else np.zeros(0, dtype=np.int64)
