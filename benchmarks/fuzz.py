"""Mutated programs and compiled programs: no traceback, no hang, no memory, no delivered object that is broken.

    python benchmarks/fuzz.py -n 100000 -o fuzz            # goes on where it was stopped; --only 37 does one case again

Case k is a shipped file with a few bytes, tokens, values or pieces of structure changed, chosen by the seed and k alone. What
is accepted is sampled: points, annotations, masses, links. A child process does the cases one by one; when a case ends it
(10 s of processor time, 1 GB more than it began with, a crash), another child goes on behind it. What went wrong is put into
``fuzz/<kind>/`` once per place in the code: the program, what was done to it, the traceback.
"""

from __future__ import annotations

import argparse
import faulthandler
import gc
import hashlib
import json
import os
import random
import re
import resource
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Iterator
from pathlib import Path

sys.path[:0] = [str(Path(__file__).parent)]

from mutations import COMPILED, KINDS, LEGAL  # noqa: E402

ROOT = Path(__file__).parents[1]
FOLDERS = (
    "categories",
    "library",
    "docs/gallery",
    "benchmarks",
    "tests/data",
    "tests/cli/programs",
    "tests/syntax/design",
    "tests/pipeline",
)
SECONDS, MEMORY = 10, 1 << 30
CASES = 300  # that one child does
OBJECTS, POINTS = 2, 32
WARM = "apg 1\nuse primitives { Cuboid }\ncategory Box {\n  root part body : Cuboid(size = [1m, 1m, 1m])\n}\n"


class Corpus:
    """The files that are mutated: programs, and what they compile to."""

    def __init__(self, seed: int, keep: Path, compiled: bool = True, more: Path | None = None):
        self.seed = seed
        self.programs = {
            str(p.relative_to(ROOT)): p.read_text(encoding="utf-8")
            for f in FOLDERS
            for p in sorted((ROOT / f).rglob("*.apg"))
        }
        if more is not None:
            self.programs |= {str(p): p.read_text(encoding="utf-8") for p in sorted(more.rglob("*.apg"))}
        self.compiled = dict(artefacts(self.programs, keep)) if compiled else {}

    def case(self, number: int) -> tuple[str, str, str]:
        """(name of the file, what was done, the mutated text); equal for equal seeds, numbers and files."""
        lot = random.Random(f"{self.seed}:{number}")
        from_compiled = bool(self.compiled) and lot.random() < 0.5
        files = self.compiled if from_compiled else self.programs
        names = sorted(files)
        # small ones more often: the same faults, sooner
        name = lot.choices(names, [(len(files[n]) + (20_000 if from_compiled else 1_000)) ** -1.6 for n in names])[0]
        other, text, done = files[lot.choice(names)], files[name], []
        kinds = KINDS if lot.random() < 0.5 else COMPILED if from_compiled else LEGAL
        for _ in range(lot.choice((1, 1, 1, 2, 4))):
            kind = lot.choice(kinds)
            done.append(kind.__name__.removeprefix("of_"))
            text = kind(text, lot, other)
        return name, "+".join(done), text


def artefacts(programs: dict[str, str], keep: Path) -> Iterator[tuple[str, str]]:
    """The programs that declare a category, compiled; kept in a folder, as long as they do not change."""
    from artipg_dsl.diagnostics import CompileError
    from artipg_dsl.graph.writing import to_text
    from artipg_dsl.session import Session

    keep.mkdir(parents=True, exist_ok=True)
    for name, text in programs.items():
        if not re.search(r"^category ", text, re.MULTILINE):
            continue
        place = keep / f"{hashlib.sha256(text.encode()).hexdigest()[:16]}.apgc"
        if not readable(place):
            try:
                place.write_text(to_text(Session.of(ROOT / name).sampler.program), encoding="utf-8")
            except CompileError:
                continue
        yield name + "c", place.read_text(encoding="utf-8")


def readable(place: Path) -> bool:
    """Whether an artefact is there and is of this version of the package."""
    from artipg_dsl.graph.reading import TextError, from_text

    try:
        from_text(place.read_text(encoding="utf-8"))
    except (OSError, TextError):
        return False
    return True


# ---------------------------------------------------------------- one case


def share_library() -> None:
    """The library is read and checked once, and examined primitives are remembered: only what was mutated is looked at anew."""
    from artipg_dsl import solids
    from artipg_dsl.diagnostics import Report
    from artipg_dsl.graph.program import Program
    from artipg_dsl.graph.writing import digest
    from artipg_dsl.semantics import check as checking
    from artipg_dsl.semantics import checker
    from artipg_dsl.semantics.modules import Workspace
    from artipg_dsl.syntax.load import load

    whole = Workspace(
        Report(), [ROOT / "library"], reader=lambda path, report, _: load(path, report, f"library/{path.name}")
    )
    scopes = {str(place): whole.load_file(place) for place in sorted((ROOT / "library").glob("*.apg"))}
    known = checking.check(whole, next(iter(scopes.values())), Report()).checker
    shared = {id(symbol) for scope in scopes.values() for symbol in scope.own()}
    load_file, declaration, begin = Workspace.load_file, checking._declaration, checker.Checker.__init__

    def loaded(self, path, shown=None):  # noqa: ANN001, ANN202
        scope = scopes.get(str(path.resolve()))
        if scope is None:
            return load_file(self, path, shown)
        if str(path) not in self.modules:
            self.modules[str(path)] = scope
            for use in scope.tree.uses:
                loaded(self, path.parent / f"{use.module}.apg")
        return scope

    def begun(self, *given):  # noqa: ANN001, ANN002, ANN202
        begin(self, *given)
        for name, there in vars(known).items():
            if isinstance(there, dict) and name not in ("vocabularies", "calls"):
                getattr(self, name).update(there)

    Workspace.load_file = loaded
    checker.Checker.__init__ = begun
    checking._declaration = lambda ck, symbol: None if id(symbol) in shared else declaration(ck, symbol)

    examine, examined = solids.examine_primitive, set()

    def once(primitive) -> None:  # noqa: ANN001
        program = Program("P", primitives={primitive.name: primitive})
        key = digest(program)
        if key not in examined:
            examine(primitive)
            examined.add(key)

    solids.examine_primitive = once
    run("warm.apg", WARM)


def warm_up(corpus: Corpus) -> None:
    """Load and build what every child would load and build: modules, formulas and shapes of the categories."""
    for name, text in corpus.compiled.items():
        if name.startswith("categories/"):
            run(name, text)
    gc.collect()
    gc.freeze()


def run(name: str, text: str) -> str:
    """What becomes of a case: "refused", "no object", "fine" or what is broken; what should not be raised is raised."""
    from artipg_dsl.diagnostics import CompileError
    from artipg_dsl.diagnostics.text import render
    from artipg_dsl.errors import UserError
    from artipg_dsl.graph.reading import TextError, from_text
    from artipg_dsl.run.compiled import make_sampler
    from artipg_dsl.run.job import prepare
    from artipg_dsl.run.request import Request
    from artipg_dsl.session import Session
    from artipg_dsl.source import Source

    try:
        if name.endswith(".apgc"):
            sampler = make_sampler(from_text(text), name)
        else:
            session = Session(Source(name, text), None)
            if session.lowering is None:
                render(session.report.diagnostics, colour=False)
                return "refused"
            session.advise()
            render(session.report.diagnostics, colour=False)
            sampler = session.sampler
    except (CompileError, UserError, TextError):
        return "refused"
    try:
        return delivered(prepare(sampler, Request(name, numbers=((0, OBJECTS - 1),))))
    except UserError:
        return "no object"


def delivered(job) -> str:  # noqa: ANN001 - job.Job
    """What is wrong with a few objects of a program. Raises NoObject."""
    import numpy as np

    from artipg_dsl.api import Samples
    from artipg_dsl.validity.mass import masses

    made = Samples(job)
    points = made.points(POINTS)
    joints, links, mass = made.joints(), made.links(), masses(made.batch)
    annotations = made.annotations()
    numbers = {
        "points": points.position,
        "normals": points.normal,
        "links": links.translation,
        "origins": joints.origin,
        "axes": joints.axis,
        "masses": mass.mass,
        "centres": mass.center,
        "inertia": mass.inertia,
        "parts": made.parts().low,
    }
    for what, array in numbers.items():
        if not np.isfinite(array).all():
            return f"broken: nan in {what}"
    if "NaN" in json.dumps(annotations):
        return "broken: nan in annotations"
    used = (
        np.bincount(
            np.searchsorted(links.owner, points_owner(points)) + points.link.ravel(), minlength=len(links.owner)
        )
        > 0
    )
    if (mass.mass[used] <= 0).any():
        return "broken: mass that is not positive"
    if (np.linalg.eigvalsh(mass.inertia[used]) <= 0).any():
        return "broken: inertia that is not positive"
    first = np.searchsorted(links.owner, joints.owner)
    above = np.full(len(links.owner), -1)
    above[first + joints.child] = first + joints.parent
    if len(np.unique(first + joints.child)) < len(joints.child):
        return "broken: a link with two joints above"
    at = np.arange(len(above))
    for _ in range(len(above) + 1):
        at = np.where(at >= 0, above[at], -1)
    return "broken: a cycle of links" if (at >= 0).any() else "fine"


def points_owner(points):  # noqa: ANN001, ANN201
    import numpy as np

    return np.repeat(np.arange(len(points.link)), points.link.shape[1])


# ---------------------------------------------------------------- children


def child(corpus: Corpus, numbers: list[int], out: int, log: Path) -> None:
    """Do cases, and tell of each as a line of JSON. Never returns."""
    with open(out, "w", buffering=1, encoding="utf-8") as stream, open(log, "w", encoding="utf-8") as trace:
        limit = address_space() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        faulthandler.enable(trace, all_threads=False)
        faulthandler.register(signal.SIGPROF, trace, all_threads=False, chain=True)  # tells where it hangs, then ends
        os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
        warnings.simplefilter("ignore")
        for number in numbers:
            name, done, text = corpus.case(number)
            stream.write(json.dumps({"case": number, "file": name, "done": done}) + "\n")
            signal.setitimer(signal.ITIMER_PROF, SECONDS)
            found = {"outcome": "traceback", "trace": ""}
            try:
                found["outcome"] = run(name, text)
            except BaseException as error:  # noqa: BLE001 - all of them are what we look for
                found["trace"] = "".join(traceback.format_exception(error))[-6000:]
            signal.setitimer(signal.ITIMER_PROF, 0)
            stream.write(json.dumps(found) + "\n")
            if "MemoryError" in found["trace"]:
                break  # nothing that follows would be believed
    os._exit(0)


def address_space() -> int:
    """Bytes of address space that this process has."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    except OSError:
        return 2 << 30


def cases(corpus: Corpus, numbers: list[int], log: Path) -> Iterator[dict]:
    """The outcome of each case, whatever becomes of the children."""
    left = list(numbers)
    while left:
        reading, writing = os.pipe()
        started = os.fork()
        if not started:
            os.close(reading)
            child(corpus, left[:CASES], writing, log)
        os.close(writing)
        current: dict = {}
        with open(reading, encoding="utf-8") as stream:
            for line in stream:
                found = json.loads(line)
                if "case" in found:
                    current = found
                    continue
                yield current | found
                left.remove(current["case"])
                current = {}
        _, status = os.waitpid(started, 0)
        if current:  # it did not live to tell
            ended = (
                signal.Signals(os.WTERMSIG(status)).name
                if os.WIFSIGNALED(status)
                else f"exit {os.waitstatus_to_exitcode(status)}"
            )
            what = "hang" if ended == "SIGPROF" else f"crash {ended}"
            yield current | {"outcome": what, "trace": log.read_text(encoding="utf-8")[-6000:]}
            left.remove(current["case"])


def place_of(found: dict) -> str:
    """Where it went wrong: the kind of error and the last line of our own code, for faults to be told apart."""
    frames = re.findall(r'File "[^"]*artipg_dsl/([^"]+)", line (\d+)', found.get("trace", ""))
    kind = (
        re.findall(r"^(\w+(?:\.\w+)*)(?:Error|Exception|Warning|Interrupt)?:?", found["trace"].strip().split("\n")[-1])
        if found.get("trace")
        else []
    )
    where = frames[0] if found["outcome"] == "hang" and frames else frames[-1] if frames else ("", "")
    return f"{found['outcome']} {(kind or [''])[0]} {where[0]}:{where[1]}".strip(" :") if frames else found["outcome"]


def main() -> int:
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("-n", "--number", type=int, default=1000, help="how many cases in all")
    options.add_argument("-o", "--out", type=Path, default=Path("fuzz"))
    options.add_argument("--seed", type=int, default=0)
    options.add_argument("--only", type=int, help="one case again, here and without limits")
    options.add_argument("--stop", type=float, default=float("inf"), metavar="SECONDS", help="end after so long")
    options.add_argument("--more", type=Path, metavar="DIR", help="programs beside those of the repository")
    asked = options.parse_args()
    share_library()
    corpus = Corpus(asked.seed, asked.out / "compiled", more=asked.more)
    if asked.only is not None:
        name, done, text = corpus.case(asked.only)
        (asked.out / f"case{Path(name).suffix}").write_text(text, encoding="utf-8", errors="replace")
        print(name, done, run(name, text))
        return 0
    warm_up(corpus)
    return fuzz(corpus, asked.number, asked.out, asked.stop)


def fuzz(corpus: Corpus, number: int, out: Path, stop: float = float("inf")) -> int:
    """Do the cases that are not done yet; returns how many have gone wrong so far."""
    record = out / "record.json"
    counts = {"next": 0, "outcomes": {}, "faults": {}, "commits": {}}
    counts |= json.loads(record.read_text()) if record.exists() else {}
    code = commit()
    begun = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        for found in cases(corpus, list(range(counts["next"], number)), Path(folder) / "trace"):
            outcome = found["outcome"]
            counts["next"] = found["case"] + 1
            counts["commits"][code] = counts["commits"].get(code, 0) + 1
            counts["outcomes"][outcome] = counts["outcomes"].get(outcome, 0) + 1
            if outcome not in ("fine", "refused", "no object"):
                keep(corpus, found, counts["faults"], out)
            record.write_text(json.dumps(counts, indent=1))
            if time.monotonic() - begun > stop:
                break
    print(json.dumps(counts["outcomes"], indent=1))
    for place, known in sorted(counts["faults"].items(), key=lambda item: -item[1]["count"]):
        print(f"{known['count']:6} {place}   cases {known['cases'][:3]}")
    return sum(known["count"] for known in counts["faults"].values())


def commit() -> str:
    """Which state of the code this is."""
    asked = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    return asked.stdout.strip() or "no repository"


def keep(corpus: Corpus, found: dict, faults: dict, out: Path) -> None:
    """Note a fault; the first three programs of each place are kept."""
    place = place_of(found)
    known = faults.setdefault(place, {"count": 0, "cases": []})
    known["count"] += 1
    if len(known["cases"]) >= 3:
        return
    known["cases"].append(found["case"])
    name, done, text = corpus.case(found["case"])
    folder = out / re.sub(r"[^\w.-]+", "_", place)[:80]
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{found['case']}{Path(name).suffix}").write_text(text, encoding="utf-8", errors="replace")
    (folder / f"{found['case']}.txt").write_text(f"{name}: {done}\n{found.get('trace', '')}", encoding="utf-8")


if __name__ == "__main__":
    sys.exit(1 if main() else 0)
