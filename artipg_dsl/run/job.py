"""A request with its program at hand: makes the objects of any numbers, and counts what failed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..diagnostics.suggest import did_you_mean
from ..errors import SettingError, UsageError, UserError
from ..graph.turn import turn
from ..records import dataclass
from ..resources import COMPILED
from ..runtime.kernels import TooMany
from ..sampling.known import evaluate_again
from ..sampling.mutate import Names
from ..sampling.mutation import Mutation
from ..sampling.sample import Sampler
from ..sampling.statistics import Exhausted, Statistics
from ..sampling.trace import Replay
from ..sampling.values import Values
from ..validity.sound import prove
from ..version import __version__
from .compiled import make_sampler, read_compiled
from .counts import Counts, count_in_words, explain_exhausted, summarize
from .params import read_values
from .prior import apply_prior
from .request import Request, is_file
from .schema import to_runs
from .settings import find_draws, resolve_settings
from .tables import Tables

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..runtime.batch import Batch

_TOGETHER = 256  # objects that are made only to be counted, at a time
_TRIED = 16  # objects that tell whether settings are to blame


class ProgramChanged(UserError):
    """Samples were made by another program than their source now compiles to; ``made`` and ``now`` are the hashes of both,
    ``version`` is the package that made them, where it is another one."""

    def __init__(self, source: str, made: str, now: str, version: str = ""):
        by = f": artipg_dsl {version} made them, and this is {__version__}" if version else ""
        super().__init__(
            f"the program {source} has changed since these samples were made{by}",
            (f"go on with them in version {version}, or " if version else "")
            + "make them again, with --force into the same folder",
        )
        self.source, self.made, self.now, self.version = source, made, now, version

    def __reduce__(self) -> tuple[Any, Any]:
        return type(self), (self.source, self.made, self.now, self.version)


@dataclass(slots=True)
class Job:
    """Made by ``prepare`` alone: ``given`` and ``values`` are those of the request by the index of their draw.

    ``sampler`` is that of the program as a prior weighs it, where there is one, and as a frame turns its objects."""

    sampler: Sampler
    request: Request
    given: dict[int, float]
    values: Values | None
    statistics: Statistics = field(default_factory=Statistics)
    tables: Tables | None = None  # where the objects are known by their values, which are valid

    @property
    def program(self) -> Program:
        return self.sampler.program

    @property
    def originals(self) -> np.ndarray:
        """The numbers of the objects that the requested ones were made from, of these themselves if nothing was mutated."""
        numbers = self.request.objects
        for step in reversed(self.request.mutations):
            numbers = step.origins(numbers)[0]
        return np.unique(numbers)

    def batch(
        self, numbers: Sequence[int] | np.ndarray | None = None, progress: Callable[[int, int], None] | None = None
    ) -> Batch:
        """The objects of the given numbers, by default all that are requested. Raises NoObject.

        ``progress(done, total)`` is called as first attempts have been checked (not for mutants or fixed values).
        """
        asked = self.request.objects if numbers is None else np.asarray(numbers, dtype=np.int64)
        try:
            made = (
                self.tables.batch(self, asked) if self.tables else self._made(asked, self.request.mutations, progress)
            )
            prove(made)
            return made
        except Exhausted as error:
            raise explain_exhausted(
                self.program, error, self.given, self.request.settings, self._valid_without
            ) from None
        except TooMany as error:
            raise UserError(f"{self.program.name}: {error}", "bound the counts of its repeats") from None

    def _valid_without(self, names: Collection[str]) -> float:
        """The share of valid first attempts at some objects where the settings of these names are left out."""
        left = {k for name in names for k in find_draws(self.program, name)}
        given = {k: value for k, value in self.given.items() if k not in left}
        return self.sampler.count_valid(np.arange(_TRIED), self.request.seed, given, self.request.checked) / _TRIED

    def _made(
        self,
        numbers: np.ndarray,
        mutations: tuple[Mutation | Replay, ...],
        progress: Callable[[int, int], None] | None = None,
    ) -> Batch:
        request, statistics = self.request, self.statistics
        if not mutations and self.values is not None:
            return self.values.batch(self.sampler, numbers, request.seed, statistics, request.checked)
        if not mutations:
            return self.sampler.batch(
                numbers,
                request.seed,
                given=self.given,
                statistics=statistics,
                checked=request.checked,
                candidates=request.candidates,
                mend=request.repair,
                progress=progress,
            )
        *before, step = mutations
        sources, variants = step.origins(numbers)
        stock, place = np.unique(sources, return_inverse=True)
        made = self.fresh()._made(stock, tuple(before))  # not counted: once or often, as the work is divided
        if len(stock) != len(numbers) or (np.diff(place) != 1).any():
            made = evaluate_again(made, place)
        return step.apply(self.sampler, made, numbers, variants, statistics, request.checks(mutations))

    def count_originals(self) -> Counts | None:
        """The statistics of the objects that mutants were made from, which are made again for it. Raises NoObject."""
        first = self.but(mutations=(), numbers=to_runs(self.originals))
        for at in range(0, len(first.request.objects), _TOGETHER):
            first.batch(first.request.objects[at : at + _TOGETHER])
        return first.counts()

    def but(self, **changes: Any) -> Job:
        """The job of the same request but for some fields, with nothing counted yet. Raises as ``prepare`` does."""
        return _prepared(self.sampler, replace(self.request, **changes), "values")

    def facing(self, degrees: int) -> Job:
        """The job of the same objects, turned by so many degrees against the program's frame in place of those it has."""
        made = self.request.turned
        assert isinstance(made, int)
        if degrees == made:
            return self
        turned = Sampler(turn(self.program, (degrees - made) // 90))
        return replace(self, sampler=turned, request=replace(self.request, turned=degrees))

    def fresh(self) -> Job:
        """The same job with nothing counted yet."""
        return replace(self, statistics=Statistics())

    def of(self, numbers: Sequence[int] | np.ndarray) -> Job:
        """The job of other objects of the same request, with nothing counted yet."""
        return replace(self, request=replace(self.request, numbers=to_runs(numbers)), statistics=Statistics())

    def mutated(self, step: Mutation | Replay, numbers: Sequence[int] | np.ndarray | None = None) -> Job:
        """The job of mutants of this one's objects, ``numbers`` of them. Raises UsageError for names that mean nothing, or nothing
        that the operations change."""
        if isinstance(step, Mutation) and not Names.unknown(step.only, self.program):
            if not Names.changed(step.only, self.program, step.operations):
                what = self.program.name if step.only == "*" else step.only
                raise UsageError(
                    f"there is nothing in {what} that {' or '.join(step.operations)} changes",
                    "apa changes templates and choices, dpa counts, cpa other numbers",
                )
        asked = self.request.numbers if numbers is None else to_runs(numbers)
        return self.but(mutations=(*self.request.mutations, step), numbers=asked)

    def failures(self) -> dict[str, int]:
        """In words what failed, with its place in the text, and in how many attempts; the worst first."""
        return count_in_words(self.program, self.statistics.failures())

    def counts(self) -> Counts | None:
        """The statistics as the manifest keeps them; None where the objects are some of those that others counted together."""
        if self.tables is not None:
            return self.tables.counts if self.tables.numbers == self.request.numbers else None
        return summarize(self.program, self.statistics, self.request.checks())


def open_job(request: Request, *, values: str = "values") -> Job:
    """The job of a request; its program is a shipped category, an .apg file, or a compiled one (.apgc), which is read
    without the parser.

    ``values``: what messages call the values of the request. Raises CompileError, SettingError, UsageError, and UserError
    for a compiled program that cannot be read.
    """
    sampler, source = open_program(request.source)
    job = prepare(sampler, replace(request, source=source), values=values)
    if job.values is not None and not request.mutations:
        try:
            job.values.check(sampler, job.request.objects, request.seed)
        except UserError as wrong:
            raise UserError(f"{values}: {wrong.message}", wrong.hint) from None
    return job


def open_program(name: str | Path) -> tuple[Sampler, str]:
    """The program of a name or file, and what a manifest calls it."""
    if Path(name).suffix == COMPILED:
        return make_sampler(read_compiled(name), name), str(name)
    from ..session import Session  # start-up: a compiled program is sampled without the parser

    session = Session.of(name)
    sampler = session.sampler
    return sampler, str(name) if session.path is None or is_file(name) else sampler.program.name


def prepare(sampler: Sampler, request: Request, *, values: str = "values") -> Job:
    """The job of a request whose program is at hand: what it fixes is checked, and put in SI units.

    Raises SettingError, UsageError, UserError.
    """
    program = sampler.program
    if request.program not in ("", program.hash):
        raise ProgramChanged(request.source, request.program, program.hash)
    known = replace(request, program=program.hash, prior=None, turned=0)
    turned = request.turned if isinstance(request.turned, int) else request.turned.of(program.name)
    prior = None if request.prior is None else request.prior.of(program.name)
    if prior is None or not prior.draws:
        return _prepared(sampler, known, values).facing(turned)
    weighted = Sampler(apply_prior(program, prior))
    resolve_settings(program, request.settings)  # what the program itself refuses is told as without a prior
    try:
        return _prepared(weighted, replace(known, prior=prior), values).facing(turned)
    except SettingError as error:
        raise SettingError(error.message, f"{prior.name} says so: set another value, or leave it out") from None


def _prepared(sampler: Sampler, request: Request, values: str) -> Job:
    """The job of a request whose program is weighted already."""
    program = sampler.program
    given, settings = resolve_settings(program, request.settings)
    held = None if request.values is None else read_values(request.values, program, values)
    for step in request.mutations:
        for name in Names.unknown(step.only, program) if isinstance(step, Mutation) else ():
            names = dict.fromkeys(d.column.name for d in program.draws)
            raise UsageError(
                f"{program.name} draws no `{name}`",
                did_you_mean(name, names)
                or (f"it draws {', '.join(list(names)[:8])}, ..." if names else "it draws nothing"),
            )
    known = replace(request, settings=settings, values=None if held is None else held.plain)
    return Job(sampler, known, given, held)
