"""``apgc mutate``: new objects from those of a folder, from values in a file, or again from a trace; what sets two apart."""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError, UserError, plural
from ..export.remote import Place, is_same, place_of
from ..run.progress import Progress, took
from ..run.settings import show_value
from .messages import say
from .sample import refuse_file, show_statistics, tell_repairs
from .sample import write as write_folder
from .wanted import read_strength, wear

if TYPE_CHECKING:
    from ..run.job import Job
    from ..run.output import Output
    from ..sampling.mutation import Mutation
    from ..sampling.trace import Step

_TOLD = ("trace", "correspondence")
_CALLED = {"operations": "ops", "variant": "variant", "strength": "strength", "share": "share", "only": "parts"}
"""Fields of a mutation, and the options that tell of them."""
_MUTATING = (*_CALLED.values(), "one", "number")
_WRITING = ("out", "stats", "unchecked", "force", "workers", "memory", "cluster", "shard", "backend")
_MAKING = (
    "folder",
    "only",
    "params",
    "replay",
    "format",
    "points",
    "details",
    "detail_strength",
    *_MUTATING,
    "distinct",
    *_WRITING,
)
_SHORT = {"number": "-n", "out": "-o"}
_IDLE = (None, False, "", "mutants", (1, 1))  # what options have by default that nobody has given
_ALIKE = "--diff compares samples and their mutants, or two ways to make objects of the same numbers"
_SHOWN = 12  # differences of one object that are told without --all


def run(options: argparse.Namespace) -> int:
    if options.diff:
        _refuse_idle(options, _MAKING, "--diff compares what is there and makes nothing")
        return _compare(*options.diff, everything=options.all)
    if options.all:
        raise UsageError("--all applies to what --diff shows", "add --diff A B, or leave out --all")
    if options.folder is None:
        raise UsageError("there is nothing to mutate", "give a folder of samples: apgc mutate out -o mutants")
    return _write(options)


def _refuse_idle(options: argparse.Namespace, names: Iterable[str], why: str) -> None:
    """Refuse options that would change nothing. Raises UsageError."""
    for name in names:
        value = getattr(options, name)
        if value not in _IDLE:
            said = options.folder if name == "folder" else _SHORT.get(name, f"--{name.replace('_', '-')}")
            raise UsageError(f"{why}, so {said} does not apply", f"leave out {said}")


# ---------------------------------------------------------------- writing


def _write(options: argparse.Namespace) -> int:
    """Write the mutants of a folder to another one."""
    from ..export.registry import choose_formats, kinds
    from ..export.write import ExportError
    from ..run.output import Output

    begun = time.monotonic()
    if options.replay is not None:
        _refuse_idle(options, _MUTATING, "a trace already says which mutants there are")
    for name, why in (("replay", "a trace already says which mutants there are"), ("one", "its groups are complete")):
        if options.distinct and getattr(options, name) is not None:
            raise UsageError(f"--distinct does not apply with --{name}: {why}", "leave out --distinct")
    job, output = _open_originals(options)
    out = place_of(options.out)
    refuse_file(out)
    if is_same(out, place_of(options.folder)):
        raise UsageError(f"the mutants cannot go into {out}, where their originals are", "name another folder with -o")
    named = output.formats if options.format is None else [n.strip() for n in options.format.split(",")]
    if options.details is not None and options.format is None and "points" not in output.kinds:
        named = [*named, "points"]  # what wears them
    try:
        formats = choose_formats([*named, *_TOLD])
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    content = output.content
    if options.points is not None:
        if "points" not in kinds([entry.name for entry in formats]):
            raise UsageError("--points applies to points, which are not among the formats", "add points to --format")
        content = replace(content, points=replace(content.points, count=options.points))
    strength = read_strength(options)
    if options.details is not None:
        content = replace(content, details=wear(options.details, strength, job))
    job = _open_mutants(options, job)
    if options.distinct:
        job = _leave_out(options, job, out)
    made, number = write_folder(job, out, Output.of(formats, content, options.memory), options)
    if options.params is not None:
        tell_repairs(job, made)
    if options.stats:
        print(show_statistics(job, made))
    say(f"{plural(number, 'object')} in {out} {took(begun)}")
    return 0


def _leave_out(options: argparse.Namespace, job: Job, out: Place) -> Job:
    """The job without the mutants that are nearly the same as another of their original."""
    from ..run.distinct import leave_out_near_duplicates, recall_distinct

    if not options.force and (found := recall_distinct(job, out)) is not None:
        say(f"{plural(found.statistics.near_duplicates, 'near-duplicate')} left out")
        return found
    with Progress(job.program.name) as progress:
        progress.stage("comparing mutants")
        job, left_out = leave_out_near_duplicates(job, options.workers, progress)
    say(f"{plural(left_out, 'near-duplicate')} left out")
    return job


def _open_originals(options: argparse.Namespace) -> tuple[Job, Output]:
    """The job of the originals, and how they are written. Raises UserError."""
    from ..export.registry import DEFAULT
    from ..run.job import open_job
    from ..run.output import Output
    from ..run.request import read_request
    from ..run.resume import read_folder_manifest, remake

    if options.params is not None:
        request = read_request(options.folder, checked=not options.unchecked, values=options.params)
        job, output = open_job(request, values=options.params), Output(DEFAULT)
    elif place_of(options.folder).is_dir():
        manifest = read_folder_manifest(options.folder)
        job, output = remake(options.folder, manifest), Output.from_manifest(manifest["identity"], options.folder)
    else:
        raise UserError(
            f"{options.folder} is not a folder of samples",
            "make one with apgc sample, or give values with --params FILE",
        )
    return (job if options.only is None else _pick(job, options.only, options.folder)), output


def _pick(job: Job, wanted: list[int], folder: str) -> Job:
    """The job of some of the objects alone. Raises UserError."""
    missing = sorted(set(wanted) - set(job.request.objects.tolist()))
    if missing:
        raise UserError(f"{folder} has no object {missing[0]}", "see `numbers` in its manifest.json")
    return job.of(wanted)


def _open_mutants(options: argparse.Namespace, job: Job) -> Job:
    """The job of the mutants of a job's objects. Raises UserError."""
    from ..run.traces import gather_traces
    from ..sampling.trace import Replay

    if options.replay is None:
        step = _read_mutation(options, job)
        return job.mutated(step, np.arange(len(job.request.objects) * step.group))
    there = set(job.request.objects.tolist())
    records = gather_traces(options.replay)
    if options.only is not None:
        records = {n: r for n, r in records.items() if r["source"] in there}
        if not records:
            raise UserError(f"{options.replay} has no mutant of object {min(there)}", "choose others with --only")
    strange = sorted({r["source"] for r in records.values()} - there)
    if strange:
        raise UserError(
            f"{options.folder} has no object {strange[0]}, which the trace starts from",
            "give the folder of the originals, as it was when they were mutated",
        )
    return job.mutated(Replay(records, options.unchecked), sorted(records))


def _read_mutation(options: argparse.Namespace, job: Job) -> Mutation:
    """The mutation that the options ask for. Raises UsageError."""
    from ..sampling.mutation import Mutation, read_operations

    told = {field: getattr(options, name) for field, name in _CALLED.items() if getattr(options, name) is not None}
    if options.ops is not None:
        told["operations"] = read_operations(options.ops)
    asked = Mutation(**told, each=options.number or 1, sources=job.request.numbers, unchecked=options.unchecked)
    return asked.focused(options.one, {field: f"--{name}" for field, name in _CALLED.items()} | {"one": "--one"})


# ---------------------------------------------------------------- comparing


def _compare(first: str, second: str, *, everything: bool) -> int:
    """Tell what sets the objects of two folders, or the steps of two traces, apart."""
    for place in (first, second):
        if not Path(place).exists():
            raise UserError(f"there is no file or folder {place}", "give two folders of samples, or two traces")
    lines = (
        list(_compare_folders(first, second, everything))
        if all(Path(p).is_dir() for p in (first, second))
        else list(_compare_traces(first, second))
    )
    print("\n".join(lines) if lines else "no difference")
    return 0


def _compare_folders(first: str, second: str, everything: bool) -> list[str]:
    """The differences of the objects of two folders, those of the same number or a mutant and its original."""
    from ..run.resume import reopen
    from ..sampling.known import evaluate_again
    from ..sampling.trace import compare_batches

    a, b = reopen(first), reopen(second)
    if a.program.hash != b.program.hash:
        raise UserError(f"{first} and {second} hold objects of different programs", _ALIKE)
    if a.request.prior != b.request.prior:
        raise UserError(f"{first} and {second} hold objects drawn by other priors", _ALIKE)
    if a.request.turned != b.request.turned:
        raise UserError(f"{first} and {second} hold objects in different frames", _ALIKE)
    a = replace(a, sampler=b.sampler)  # tables are told apart by the program object they belong to
    numbers, others, steps = a.request.objects, b.request.objects, b.request.mutations
    deeper = len(steps) - len(a.request.mutations)
    if deeper < 0:
        raise UserError(
            f"{first} has been mutated more often than {second}", "give the originals first, then the mutants"
        )
    if deeper > 1:
        raise UserError(f"{second} has been mutated {deeper} times more than {first}", _ALIKE)
    sources = steps[-1].origins(others)[0] if deeper else others
    both = np.isin(sources, numbers)
    if not both.any():
        raise UserError(f"{first} and {second} have no object in common", _ALIKE)
    after = b.batch(others[both])
    stock, place = np.unique(sources[both], return_inverse=True)
    before = evaluate_again(a.batch(stock), place)
    units = {draw.address: draw.unit for draw in a.program.draws}
    lines: list[str] = []
    for number, source, changes in zip(
        others[both].tolist(), sources[both].tolist(), compare_batches(before, after), strict=True
    ):
        if not changes:
            continue
        lines.append(f"object {number}" + (f" of {source}" if number != source else ""))
        told = changes if everything else changes[:_SHOWN]
        lines += [f"  {_show_step(change, units)}" for change in told]
        if len(told) < len(changes):
            lines.append(f"  and {len(changes) - len(told)} more (--all shows them)")
    return lines


def _compare_traces(first: str, second: str) -> list[str]:
    """The steps that only one of two traces has, or that end elsewhere."""
    from ..run.traces import gather_traces

    a, b = gather_traces(first), gather_traces(second)
    lines: list[str] = []
    for number in sorted(a.keys() | b.keys()):
        one, other = ({(s["op"], s["path"]): s for s in t.get(number, {"steps": []})["steps"]} for t in (a, b))
        found = []
        for name in dict.fromkeys([*one, *other]):
            s, t = one.get(name), other.get(name)
            if s is None or t is None or s["to"] != t["to"]:
                ends = " | ".join("-" if x is None else f"{x['from']} -> {x['to']}" for x in (s, t))
                found.append(f"  {name[0]} {name[1]}: {ends}")
        if found:
            lines += [f"object {number}", *found]
    return lines


def _show_step(step: Step, units: dict[str, str]) -> str:
    """``handle: BarHandle -> BowHandle``, lengths and angles in the units that people use."""

    def said(value: Any) -> str:
        return show_value(value, units.get(step.draw or "", "m")) if isinstance(value, float) else str(value)

    if step.how == "gone":
        return f"{step.path}: {said(step.before)}, gone"
    if step.how == "new":
        return f"{step.path}: {said(step.after)}, new"
    follows = "  (follows)" if step.how == "determined" else ""
    return f"{step.path}: {said(step.before)} -> {said(step.after)}{follows}"
