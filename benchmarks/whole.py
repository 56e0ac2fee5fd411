# ruff: noqa: E402 - the number of threads is set before NumPy is loaded
"""What users wait for, category by category: from text to a plan, the first object, samples by stage, every export, memory.

CPU seconds of one thread. *Cold*, in a process of its own: `plan`, from the text of a category to what objects are evaluated
with; `first`, from there to the first checked, labelled object, its points and its annotation; `second`, the next one; the same again
with what the first process has kept: `kept plan` and so on. *Warm*,
milliseconds an object, with everything that is made once for a program there: `unchecked`, objects drawn with their joints;
`check`, what objects that are also looked at take beyond that, those drawn again included; `points` and `annotation`, as
files have them; `sample`, all four together, which is what `apgc sample` takes; then each format that has files per object, of
objects that are there, each with a model of links and joints of its own; `render`, a tile of a contact sheet, 128 pixels wide.
`memory`: the most that the process held, MB. With `--command`, CPU seconds of whole processes of `apgc sample NAME -n N`, with
everything kept that an earlier one has left.
`counts`, per category: plans made, sets of pieces built, hulls computed, pairs asked for a plane between them, rounds of loops.

`--against PATH` measures another checkout beside this one, in processes that take turns, and prints ratios: its time by ours,
the median of the rounds. `-o FILE` keeps all figures as JSON.

    python benchmarks/whole.py [-n 128] [--rounds 3] [--against PATH] [-o whole.json] [--no-exports] [--no-cold] [--command] [Microwave ...]
"""

from __future__ import annotations

import os

for _variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[_variable] = "1"

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from statistics import median
from typing import Any

HERE = Path(__file__).resolve().parent.parent
COLD, WARM = ("plan", "first", "second"), ("unchecked", "check", "points", "annotation", "sample")
FEW = 32  # objects of which files are written
DRAWN = 4  # objects of which pictures are drawn
TILE = 128  # pixels
COUNTED = {
    "plans": ("runtime.plan", "make_plan"),
    "pieces": ("geometry.pieces", "clouds"),
    "hulls": ("geometry.hulls", "hull_of"),
    "pairs": ("geometry.collide", "separate"),
    "loops": ("runtime.loops", "Loops.slopes"),
}


# ---------------------------------------------------------------- in a process of one checkout


def clock(do: Callable[[], Any]) -> tuple[float, Any]:
    begun = time.process_time()
    made = do()
    return time.process_time() - begun, made


def cold(category: str) -> dict[str, float]:
    """Seconds from nothing, the imports included."""
    from artipg_dsl.session import Session

    sampler = Session.of(category).sampler
    sampler.plan.function  # noqa: B018 - a plan is compiled when it is first asked for its function
    found = {"plan": time.process_time()}
    for number, name in enumerate(COLD[1:]):
        found[name] = clock(lambda number=number: labelled(sampler.batch(numbers(number, 1), 7, checked=True)))[0]
    return found


def numbers(first: int, count: int) -> Any:
    import numpy as np

    return np.arange(first, first + count)


def labelled(batch: Any) -> tuple[float, float]:
    """Seconds for points and for the annotation of a batch."""
    from artipg_dsl.export.content import Content
    from artipg_dsl.export.registry import FORMATS

    content = Content()
    points, annotation = (
        clock(lambda f=f: FORMATS[f].shard_bytes(batch, content))[0] for f in ("points", "annotation")
    )
    return points, annotation


def warm(sampler: Any, count: int, seed: int, exports: bool) -> dict[str, float]:
    """Milliseconds an object."""
    from artipg_dsl.export.registry import FORMATS
    from artipg_dsl.robot.robots import Robots

    asked = numbers(0, count)
    plain, _ = clock(lambda: sampler.batch(asked, seed).joints())
    checked, batch = clock(lambda: sampler.batch(asked, seed, checked=True))
    checked += clock(batch.joints)[0]
    points, annotation = labelled(batch)
    found = [plain, checked - plain, points, annotation, checked + points + annotation]
    row = {name: 1e3 * value / count for name, value in zip(WARM, found, strict=True)}
    for name, entry in FORMATS.items() if exports else ():
        if entry.per_object and (entry.needs is None or import_or_none(entry.needs[0])):
            some = sampler.batch(numbers(0, FEW), seed)
            some.joints()
            spent = clock(lambda entry=entry, some=some: written(Robots(some), entry))[0]
            row[name] = 1e3 * spent / FEW
    if exports:
        view = import_module("artipg_dsl.view.sheet")
        draw = getattr(view, "draw_sheet", None) or view.sheet  # as older checkouts call it
        sized = {"sheet": view.Sheet(tile=TILE)} if hasattr(view, "Sheet") else {"tile": TILE}
        some = sampler.batch(numbers(0, DRAWN), seed)
        row["render"] = 1e3 * clock(lambda: draw(some, **sized))[0] / DRAWN
    return row


def written(robots: Any, entry: Any) -> None:
    for number in range(FEW):
        entry.files(robots, number)


def import_or_none(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError:
        return None


@contextmanager
def counting() -> Iterator[dict[str, int]]:
    """How often what costs is called, wherever it is known by its name."""
    found, undo = dict.fromkeys(COUNTED, 0), []
    for name, (place, path) in COUNTED.items():
        holder: Any = import_or_none(f"artipg_dsl.{place}")
        *owners, last = path.split(".")
        for owner in owners:
            holder = getattr(holder, owner, None)
        plain = getattr(holder, last, None)
        if plain is None:  # another checkout calls it something else
            del found[name]
            continue

        def called(*arguments: Any, plain: Any = plain, name: str = name, **named: Any) -> Any:
            found[name] += len(arguments[0]) if name == "pairs" else 1
            return plain(*arguments, **named)

        for module in [m for key, m in sys.modules.items() if key.startswith("artipg_dsl")] + [holder]:
            if getattr(module, last, None) is plain:
                undo.append((module, last, plain))
                setattr(module, last, called)
    try:
        yield found
    finally:
        for module, last, plain in undo:
            setattr(module, last, plain)


def serve(category: str, count: int, exports: bool) -> None:
    """Answers a seed a line with a row of figures; an empty line with counts and memory."""
    from artipg_dsl.session import Session

    if (pages := import_or_none("artipg_dsl.pages")) is not None:  # as the command does
        pages.hold_pages()
    sampler = Session.of(category).sampler
    warm(sampler, min(count, 8), 1, exports)  # what is made once
    print("ready", flush=True)
    for line in sys.stdin:
        if line.strip():
            print(json.dumps(warm(sampler, count, int(line), exports)), flush=True)
            continue
        with counting() as counts:
            labelled(sampler.batch(numbers(0, count), 3, checked=True))
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(json.dumps({"counts": counts, "memory": memory}), flush=True)


# ---------------------------------------------------------------- all of them


class Side:
    """A checkout, and the process that measures one category of it."""

    def __init__(self, name: str, root: Path):
        self.name, self.root = name, root
        self.environment = {**os.environ, "PYTHONPATH": str(root), "PYTHONHASHSEED": "0"}

    def command(self, *arguments: str) -> list[str]:
        return [sys.executable, str(Path(__file__).resolve()), *arguments]

    def cold(self, category: str) -> dict[str, float]:
        """With nothing kept, and with what that has kept."""
        with tempfile.TemporaryDirectory() as folder:
            first, kept = (self._cold(category, folder) for _ in range(2))
        return first | {f"kept {name}": value for name, value in kept.items()}

    def _cold(self, category: str, folder: str) -> dict[str, float]:
        made = subprocess.run(
            self.command("--cold", category),
            env=self.environment | {"APGC_CACHE": folder},
            cwd=self.root,
            check=True,
            capture_output=True,
            text=True,
        )
        return json.loads(made.stdout)

    def sample(self, category: str, count: int) -> dict[str, float]:
        """Seconds of the command itself."""
        with tempfile.TemporaryDirectory() as folder:
            words = ("-m", "artipg_dsl", "sample", category, "-n", str(count), "-o", f"{folder}/out")
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            subprocess.run([sys.executable, *words], env=self.environment, cwd=folder, check=True, capture_output=True)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return {"sample": after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime}

    @contextmanager
    def open(self, category: str, count: int, exports: bool) -> Iterator[Callable[[str], dict[str, Any]]]:
        more = [] if exports else ["--no-exports"]
        process = subprocess.Popen(
            self.command("--serve", category, "-n", str(count), *more),
            env=self.environment,
            cwd=self.root,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdin is not None and process.stdout is not None
        source, sink = process.stdin, process.stdout

        def ask(line: str) -> dict[str, Any]:
            source.write(line + "\n")
            source.flush()
            return json.loads(sink.readline())

        assert sink.readline() == "ready\n", f"{self.name}: {category} cannot be measured"
        try:
            yield ask
        finally:
            source.close()
            process.wait()


def measured(sides: list[Side], category: str, given: argparse.Namespace) -> dict[str, Any]:
    """Figures of a category by the name of the checkout; the sides take turns, each first in every other round."""
    from contextlib import ExitStack

    found: dict[str, Any] = {side.name: {"cold": [], "warm": [], "command": []} for side in sides}
    for _ in range(1 if given.no_cold else given.rounds):
        for side in () if given.no_cold else sides:
            found[side.name]["cold"].append(side.cold(category))
    for number in range(given.rounds + 1 if given.command else 0):
        for side in sides if number % 2 == 0 else sides[::-1]:
            row = side.sample(category, given.n)
            found[side.name]["command"] += [row] if number else []  # the first one fills the cache
    with ExitStack() as stack:
        asks = [(s.name, stack.enter_context(s.open(category, given.n, not given.no_exports))) for s in sides]
        for number in range(given.rounds):
            for name, ask in asks if number % 2 == 0 else asks[::-1]:
                found[name]["warm"].append(ask(str(11 + number)))
        for name, ask in asks:
            found[name] |= ask("")
    return found


def middle(rows: list[dict[str, float]]) -> dict[str, float]:
    return {name: median(row[name] for row in rows) for name in (rows[0] if rows else ())}


def ratios(ours: list[dict[str, float]], theirs: list[dict[str, float]]) -> dict[str, float]:
    """Their time by ours, round by round, the median."""
    rows = [{k: b[k] / a[k] for k in a if k in b and a[k] > 0} for a, b in zip(ours, theirs, strict=True)]
    names = [name for name in (rows[0] if rows else ()) if all(name in row for row in rows)]
    return {name: median(row[name] for row in rows) for name in names}


def show(title: str, rows: dict[str, dict[str, float]], form: str) -> None:
    names = list(dict.fromkeys(name for row in rows.values() for name in row))
    if names:
        print(f"\n{title}\n\n| category | {' | '.join(names)} |\n|---|{'---:|' * len(names)}")
    for category, row in rows.items():
        print(f"| {category} | {' | '.join(format(row[n], form) if n in row else '' for n in names)} |")
    if names and len(rows) > 1:
        print(f"| median | {' | '.join(format(median(r[n] for r in rows.values() if n in r), form) for n in names)} |")


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("categories", nargs="*")
    options.add_argument("-n", type=int, default=128, help="objects of each category, a batch")
    options.add_argument("--rounds", type=int, default=3)
    options.add_argument("--against", type=Path, help="the root of another checkout")
    options.add_argument("-o", type=Path, help="a file for all figures, JSON")
    options.add_argument("--no-exports", action="store_true")
    options.add_argument("--no-cold", action="store_true")
    options.add_argument("--command", action="store_true", help="whole processes of apgc sample, too")
    options.add_argument("--cold", help=argparse.SUPPRESS)
    options.add_argument("--serve", help=argparse.SUPPRESS)
    given = options.parse_args()
    if given.cold:
        print(json.dumps(cold(given.cold)))
        return
    if given.serve:
        serve(given.serve, given.n, not given.no_exports)
        return
    sides = [Side("this", HERE)] + ([Side("other", given.against.resolve())] if given.against else [])
    found: dict[str, Any] = {}
    for category in given.categories or sorted(path.stem for path in (HERE / "categories").glob("*.apg")):
        with tempfile.TemporaryDirectory() as folder:  # nothing is read that an earlier run has kept
            os.environ["APGC_CACHE"] = folder
            for side in sides:
                side.environment["APGC_CACHE"] = str(Path(folder) / side.name)
            found[category] = measured(sides, category, given)
        print(category, "measured", file=sys.stderr, flush=True)
    for side in sides:
        own = {category: sides_[side.name] for category, sides_ in found.items()}
        if not given.no_cold:
            show(f"{side.name}: cold, seconds", {c: middle(r["cold"]) for c, r in own.items()}, ".2f")
        if given.command:
            show(
                f"{side.name}: `apgc sample -n {given.n}`, seconds",
                {c: middle(r["command"]) for c, r in own.items()},
                ".2f",
            )
        warm_rows = {c: middle(r["warm"]) | {"memory": r["memory"]} for c, r in own.items()}
        show(f"{side.name}: warm, milliseconds an object; MB", warm_rows, ".1f")
        show(f"{side.name}: counts for {given.n} objects", {c: r["counts"] for c, r in own.items()}, ".0f")
    if given.against:
        for kind in ("cold", "command", "warm"):
            rows = {c: ratios(r["this"][kind], r["other"][kind]) for c, r in found.items()}
            show(f"{kind}: how many times as long the other checkout takes", rows, ".2f")
    if given.o:
        given.o.write_text(
            json.dumps({"objects": given.n, "rounds": given.rounds, "categories": found}, indent=1) + "\n"
        )


if __name__ == "__main__":
    main()
