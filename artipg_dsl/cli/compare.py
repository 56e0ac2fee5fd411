"""``apgc compare``: samples of a category beside real objects, sizes, shapes and labels."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import UsageError, plural
from ..run.progress import Progress
from .arguments import STREAM
from .fit import read_words, warn
from .messages import say
from .wanted import open_wanted

if TYPE_CHECKING:
    from ..fit.likeness import Likeness
    from ..run.comparing import Comparison

_FEW = 10  # lines of a list


def run(options: argparse.Namespace) -> int:
    from ..fit.finding import find_files
    from ..fit.pose import Frame
    from ..fit.sources import File, Item
    from ..run.comparing import Comparison, read_all
    from ..run.fitting import tell_unmatched

    out = _refuse_early(options)
    frame = Frame(options.up, options.front, options.unit, options.normalised)
    items = [Item(str(path), File(path)) for path in find_files(options.files, say)]
    with Progress(options.program) as progress:
        progress.stage("compiling")
        job = open_wanted(options)
        words = dict(read_words(options.map, job.program.vocabularies.get("semantic", ())))
        progress.stage("drawing")
        batch = job.batch()
        progress.stage("reading", 0, len(items))
        known = read_all(batch, items, frame, progress)
        for name, lost in known.lost.items():
            say(f"{name}: {lost}, and were left out")
        progress.stage("comparing", 0, len(known.names))
        found = Comparison.of(batch, known, words, progress)
    failed = [{"name": name, "reason": reason} for name, reason in found.failed.items()]
    told = found.likeness, found.names, failed
    print(json.dumps(_plain(*told), indent=1) if options.json else _text(*told))
    if words:
        warn(tell_unmatched(words, known.labels, options.map, "file"))
    if out is not None:
        _write_prior(found, out, options)
    say(f"{batch.program.name}: {plural(len(batch), 'sample')} beside {plural(len(found.names), 'real object')}")
    return 0


def _refuse_early(options: argparse.Namespace) -> Path | None:
    """The file that a prior goes to, if any. Raises ExportError, UsageError."""
    from ..export.write import require_place

    if options.prior_out is None:
        if options.force:
            raise UsageError("--force replaces the file of --prior-out, and there is none", "leave it out")
        return None
    if options.prior_out == STREAM:
        raise UsageError("--prior-out writes a file beside the figures", "name it (./- for a file named -)")
    if options.map is None:
        raise UsageError("--prior-out reads labels, and nothing says what they mean", "add --map FILE")
    out = Path(options.prior_out)
    require_place(out, options.force)
    return out


def _write_prior(compared: Comparison, out: Path, options: argparse.Namespace) -> None:
    """A prior of what the labels of real objects say, and in words what no draw was found for. Raises ExportError, UserError."""
    from ..export.write import write_bytes

    found, name = compared.presence(), compared.batch.program.name
    held = {
        "about": f"Counted in {plural(found.objects, 'real object')} by apgc compare {name} --prior-out. "
        "A share is (count + 1/2) / (objects + 1); to each count of a value 1/2 is added.",
        "draws": {name: found.draws},
        "evidence": {name: found.evidence},
        "unmatched": {name: found.unmatched},
    }
    write_bytes(out, (json.dumps(held, indent=1, ensure_ascii=False) + "\n").encode("utf-8"), force=options.force)
    for line in found.unmatched:
        say(f"no draw: {line}")
    say(f"{out}: {plural(len(found.draws), 'draw')} from {plural(found.objects, 'labelled object')}")


def _plain(found: Likeness, names: list[str], failed: list[dict[str, str]]) -> dict[str, Any]:
    told = asdict(found)
    nearest, which, front = told.pop("nearest"), told.pop("which"), told.pop("front")
    told["far"] = [names[k] for k in found.far]
    each = zip(names, nearest.tolist(), which.tolist(), front, strict=True)
    told["real"] = [{"name": n, "distance": d, "nearest": int(w), "front": f} for n, d, w, f in each]
    return told | {"failed": failed}


def _text(found: Likeness, names: list[str], failed: list[dict[str, str]]) -> str:
    lines = [f"{'':<16}{'ours: 5 %, median, 95 %':>28}{'real: 5 %, median, 95 %':>28}{'real within ours':>18}"]
    for one in found.ranges:
        shown = ["".join(f"{v:8.3f}" for v in values) for values in (one.ours, one.real)]
        lines.append(f"{one.name:<16}{shown[0]:>28}{shown[1]:>28}{one.within:>17.0%} ")
    lines += ["", "chamfer distances, percent of the diagonal"]
    rows = [
        ("from each real object to the nearest sample", found.matching),
        ("from each sample to the nearest real object", found.back),
    ]
    if found.between is not None:
        rows.append(("from each real object to the nearest other", found.between))
    lines += [f"  {what:<46}{value:6.2f}" for what, value in rows]
    lines.append(f"  {'real objects that are nearest to some sample':<46}{found.coverage:6.0%}")
    worst = np.argsort(-found.nearest, kind="stable")[:_FEW].tolist()
    lines += ["", "the real objects that samples come least near to"]
    lines += [
        f"  {found.nearest[k]:6.2f}  {'FAR  ' if k in found.far else '     '}{names[k]} (sample {found.which[k]})"
        for k in worst
    ]
    if found.words:
        lines += ["", f"{'label':<16}{'share of surface, ours':>24}{'real':>8}{'in so many, ours':>20}{'real':>8}"]
        lines += [
            f"{w.word:<16}{w.share[0]:>24.1%}{w.share[1]:>8.1%}{w.present[0]:>20.0%}{w.present[1]:>8.0%}"
            for w in found.words
        ]
    lines += [f"not read: {one['name']}: {one['reason']}" for one in failed]
    return "\n".join(lines)
