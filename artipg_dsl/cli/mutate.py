"""``apgc mutate``: new objects from those of a folder, from values in a file, or again from a trace; what sets two apart."""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError, UserError
from ..run.settings import shown
from .messages import say
from .progress import Progress
from .sample import in_the_way, statistics

if TYPE_CHECKING:
    from ..run.job import Job
    from ..sampling.mutate import Mutation
    from ..sampling.trace import Step

TOLD = ("trace", "correspondence")
PLAIN = "apa,dpa,cpa", 1.0, 0.5  # operations, strength and share where nothing is said of them
SHOWN = 12  # differences of one object that are told without --all


def run(options: argparse.Namespace) -> int:
    if options.diff:
        return compare(*options.diff, everything=options.all)
    if options.folder is None:
        raise UsageError("there is nothing to mutate", "give a folder of samples: apgc mutate out -o mutants")
    return write(options)


# ---------------------------------------------------------------- writing


def write(options: argparse.Namespace) -> int:
    """Write the mutants of a folder to another one."""
    from ..export.content import Content
    from ..export.registry import choose
    from ..export.write import ExportError

    begun = time.monotonic()
    job, numbers, manifest = opened(options)
    out = Path(options.out)
    in_the_way(out)
    if Path(options.folder).is_dir() and out.resolve() == Path(options.folder).resolve():
        raise UsageError(f"the mutants cannot go into {out}, where their originals are", "name another folder with -o")
    if options.only is not None:
        numbers = among(numbers, options.only, options.folder)
    named = manifest["formats"] if options.format is None else [n.strip() for n in options.format.split(",")]
    try:
        formats = choose([*named, *TOLD])
        content = Content.read(manifest)
        content = content if options.points is None else replace(content, points=options.points)
    except ExportError as wrong:
        raise UsageError(wrong.message, wrong.hint) from None
    job, numbers = planned(options, job, numbers)
    with Progress(job.sampler.program.name) as progress:
        progress(0, len(numbers))
        made = job.write(
            out, numbers, formats, content=content, force=options.force, part=options.shard, progress=progress,
            workers=options.workers,
        )  # fmt: skip
    if options.stats:
        print(statistics(job, made))
    done = "1 object" if len(numbers) == 1 else f"{len(numbers)} objects"
    say(f"{done} in {out} ({time.monotonic() - begun:.1f} s)")
    return 0


def opened(options: argparse.Namespace) -> tuple[Job, np.ndarray, dict[str, Any]]:
    """The originals: a job, their numbers, and what is known of how they were written."""
    from ..export import manifest as manifests
    from ..export.content import STANDARD
    from ..export.registry import DEFAULT
    from ..run.job import open_job, reopen

    if options.params is not None:
        from ..run.params import read_params

        job = open_job(options.folder, 0, checked=not options.unchecked)
        values = read_params(options.params, job.sampler.program)
        return (
            replace(job, values=values),
            np.arange(len(values.records)),
            {"formats": [*DEFAULT], **STANDARD.identity()},
        )
    folder = Path(options.folder)
    if not folder.is_dir():
        raise UserError(
            f"{folder} is no folder of samples", "make one with apgc sample, or give values with --params FILE"
        )
    job, numbers = reopen(folder)
    manifest = manifests.read(folder)
    assert manifest is not None
    return (replace(job, checked=False) if options.unchecked else job), numbers, manifest["identity"]


def among(numbers: np.ndarray, wanted: list[int], folder: str) -> np.ndarray:
    missing = sorted(set(wanted) - set(numbers.tolist()))
    if missing:
        raise UserError(f"{folder} holds no object {missing[0]}", "see `numbers` in its manifest.json")
    return np.array(wanted, dtype=np.int64)


def planned(options: argparse.Namespace, job: Job, numbers: np.ndarray) -> tuple[Job, np.ndarray]:
    """The job of the mutants, and their numbers."""
    from ..run.job import traces_of
    from ..sampling.trace import Replay

    if options.replay is not None:
        records = traces_of(options.replay)
        if options.only is not None:
            records = {n: r for n, r in records.items() if r["source"] in set(numbers.tolist())}
        strange = sorted({r["source"] for r in records.values()} - set(numbers.tolist()))
        if strange:
            raise UserError(f"{options.folder} holds no object {strange[0]}, which the trace begins from")
        return job.mutated(Replay(records)), np.array(sorted(records), dtype=np.int64)
    step = mutation(options, numbers)
    return job.mutated(step), np.arange(len(numbers) * step.group)


def mutation(options: argparse.Namespace, numbers: np.ndarray) -> Mutation:
    """The mutation that the options ask for. Raises UsageError."""
    from ..export.manifest import spans
    from ..sampling.mutate import OPERATIONS, Mutation

    wanted = tuple(name.strip() for name in options.ops.split(","))
    unknown = [name for name in wanted if name not in OPERATIONS]
    if unknown:
        raise UsageError(f"there is no operation `{unknown[0]}`", f"the operations are {', '.join(OPERATIONS)}")
    if options.one is not None and options.parts != "*":
        raise UsageError("--one names the value itself: --parts has no meaning beside it")
    if options.one is not None and (options.ops, options.strength, options.share) != PLAIN:
        raise UsageError("--one draws its value anew: --ops, --strength and --share have no meaning beside it")
    return Mutation(
        wanted, options.variant, options.strength, options.share, options.one or options.parts, options.one is not None,
        options.number or 1, tuple((first, last) for first, last in spans(numbers)),
    )  # fmt: skip


# ---------------------------------------------------------------- comparing


def compare(first: str, second: str, *, everything: bool) -> int:
    """Tell what sets the objects of two folders, or the steps of two traces, apart."""
    for place in (first, second):
        if not Path(place).exists():
            raise UserError(f"there is no folder and no file {place}")
    lines = (
        list(folders(first, second, everything))
        if all(Path(p).is_dir() for p in (first, second))
        else list(files(first, second))
    )
    print("\n".join(lines) if lines else "no difference")
    return 0


def folders(first: str, second: str, everything: bool) -> list[str]:
    """The differences of the objects of two folders, those of the same number or a mutant and its original."""
    from ..run.job import reopen
    from ..sampling.settled import again
    from ..sampling.trace import difference

    (a, numbers), (b, others) = reopen(first), reopen(second)
    if a.sampler.program.hash != b.sampler.program.hash:
        raise UserError(f"{first} and {second} hold objects of different programs")
    a = replace(a, sampler=b.sampler)  # tables are told apart by the program object they belong to
    sources = b.mutations[-1].origins(others)[0] if len(b.mutations) == len(a.mutations) + 1 else others
    both = np.isin(sources, numbers)
    if not both.any():
        raise UserError(f"{first} and {second} have no object in common")
    after = b.batch(others[both])
    stock, place = np.unique(sources[both], return_inverse=True)
    before = again(a.batch(stock), place)
    units = {draw.address: draw.unit for draw in a.sampler.program.draws}
    lines: list[str] = []
    for number, source, steps in zip(
        others[both].tolist(), sources[both].tolist(), difference(before, after), strict=True
    ):
        if not steps:
            continue
        lines.append(f"object {number}" + (f" of {source}" if number != source else ""))
        told = steps if everything else steps[:SHOWN]
        lines += [f"  {in_words(step, units)}" for step in told]
        if len(told) < len(steps):
            lines.append(f"  and {len(steps) - len(told)} more: --all tells them")
    return lines


def files(first: str, second: str) -> list[str]:
    """The steps that only one of two traces has, or that end elsewhere."""
    from ..run.job import traces_of

    a, b = traces_of(first), traces_of(second)
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


def in_words(step: Step, units: dict[str, str]) -> str:
    """``handle: BarHandle -> BowHandle``, lengths and angles in the units that people use."""

    def said(value: Any) -> str:
        return shown(value, units.get(step.draw or "", "m")) if isinstance(value, float) else str(value)

    if step.how == "gone":
        return f"{step.path}: {said(step.before)}, gone"
    if step.how == "new":
        return f"{step.path}: {said(step.after)}, new"
    follows = "  (follows)" if step.how == "determined" else ""
    return f"{step.path}: {said(step.before)} -> {said(step.after)}{follows}"
