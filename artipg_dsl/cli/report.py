"""``apgc report``: how good a category is, in figures, with a goal beside each."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from ..errors import SettingError, UsageError, UserError
from ..records import dataclass
from ..run.progress import Progress
from .arguments import STREAM
from .messages import say
from .wanted import read_request

if TYPE_CHECKING:
    from ..graph.program import Program
    from ..quality.card import Card
    from ..quality.sizes import Real
    from ..run.job import Job

PICTURED, COLUMNS, TILE = 12, 6, 160  # objects on the picture of a page


def run(options: argparse.Namespace) -> int:
    from ..export.strict import require_manifold
    from ..quality.sizes import read_reference
    from ..quality.text import card_text, markdown_table

    names = _read_names(options)
    known = read_reference(options.reference)
    _require_output(options)
    if options.meshes:
        require_manifold()
    silent = _is_silent(options)
    cards, pictures = [], []
    for card, picture in _made([_Task(options, name, known) for name in names], silent):
        if options.reference is not None and card.category not in known:
            _say_unknown(options.reference, card.category, known)
        cards.append(card)
        pictures.append(picture)
        if not silent:
            print(("\n" if len(cards) > 1 else "") + card_text(card), flush=True)
    if options.json:
        found = [card.plain() for card in cards]
        print(json.dumps(found if options.all or len(found) > 1 else found[0], indent=1))
    elif options.markdown:
        print(markdown_table(cards), end="")
    if options.html is not None:
        _write_page(options, cards, pictures)
    return 1 if options.strict and not all(card.met for card in cards) else 0


def _require_output(options: argparse.Namespace) -> None:
    """That what is to be written goes somewhere, and to one place each. Raises UsageError."""
    from ..export.write import require_place

    alone = options.html == STREAM
    if options.force and (options.html is None or alone):
        raise UsageError("--force replaces the page, and none is written", "add --html FILE, or leave out --force")
    if alone and (options.json or options.markdown):
        raise UsageError(
            "--html - writes the page to standard output, where --json and --markdown write the figures",
            "name a file for the page",
        )
    if options.html is not None and not alone:
        require_place(Path(options.html), options.force)


def _is_silent(options: argparse.Namespace) -> bool:
    """Whether one text is printed in the end, instead of card by card."""
    return bool(options.json or options.markdown or options.html == STREAM)


def _made(tasks: list[_Task], silent: bool) -> Iterator[tuple[Card, bytes]]:
    """The cards and pictures of the tasks, in their order, by several processes where that pays."""
    from ..run.sharing import LONG, share
    from ..run.workers import map_each

    def others(rest: Sequence[_Task], many: int) -> Iterator[tuple[Card, bytes]]:
        with Progress("reports") if silent else nullcontext() as progress:  # else cards tell how far it is
            if progress:
                progress(0, len(rest))
            for done, found in enumerate(map_each(_examined, rest, many, here=_examined), start=1):
                if progress:
                    progress(done, len(rest))
                yield found

    workers = tasks[0].options.workers
    return share(tasks, workers, lambda task: _examined(replace(task, watched=True)), others, pace=LONG)


def _say_unknown(reference: str, category: str, known: dict[str, Real]) -> None:
    from ..diagnostics.suggest import did_you_mean

    close = did_you_mean(category, known)
    say(f"{reference} says nothing of {category}" + (f": {close}" if close else ""))


def _write_page(options: argparse.Namespace, cards: list[Card], pictures: list[bytes]) -> None:
    from ..export.write import write_bytes
    from ..quality.page import render_page

    made = render_page(cards, pictures)
    if options.html == STREAM:
        print(made)
    else:
        write_bytes(options.html, made.encode("utf-8"), force=options.force)
        say(f"wrote {options.html}")


def _read_names(options: argparse.Namespace) -> list[str]:
    """The categories asked for. Raises UsageError."""
    from ..session import categories

    if options.all and options.programs:
        raise UsageError("--all already names every shipped category", "leave out --all, or the names")
    if options.all and options.set:
        raise UsageError("--set applies to one category, not to all of them", "name the category")
    if options.all and options.prior is not None:
        raise UsageError("--all names categories that a prior says nothing of", "name those that it speaks of")
    if not options.all and not options.programs:
        raise UsageError("no category is named", "for example `apgc report Microwave`, or --all for all shipped ones")
    return list(categories()) if options.all else options.programs


@dataclass(frozen=True, slots=True)
class _Task:
    """A category whose card is wanted; ``watched``: somebody may look on."""

    options: argparse.Namespace
    name: str
    known: dict[str, Real]
    watched: bool = False


def _examined(task: _Task) -> tuple[Card, bytes]:
    """The card of a category, and a picture where there is to be a page."""
    from ..export.strict import check_meshes
    from ..quality.card import STEPS, Known, Valid, make_card
    from ..run.job import open_job
    from ..session import categories

    options, name = task.options, task.name
    request = read_request(options, name, checked=not options.unchecked)
    with Progress(name) if task.watched else nullcontext() as progress:
        if progress:
            progress.stage("compiling")
        job = open_job(request)
        category = job.program.name
        path = Path(name) if Path(name).is_file() else categories().get(category)

        def step(doing: str, done: int, total: int) -> None:
            if progress:
                progress.stage(f"{doing} (step {STEPS.index(doing) + 1} of {len(STEPS)})", done, total)

        # wrong ones are told at once; what a prior leaves out is no fault of theirs
        variants = _read_variants(job.program, task.known.get(category), job.request.prior is not None)
        step(STEPS[0], 0, len(request.objects))
        batch = job.batch(progress=progress)
        known = Known(
            valid=Valid(job.statistics.first_valid, job.statistics.attempts, job.failures()),
            checked=request.checked,
            prior="" if job.request.prior is None else job.request.prior.show(),
            meshes=check_meshes(job.of(request.objects[: options.meshes]).batch()) if options.meshes else None,
            real=task.known.get(category),
            variants=variants,
            lines=_own_lines(path),
        )
        found = make_card(job.sampler, batch, known, step)
    return found, _picture(job.of(job.request.objects[:PICTURED])) if options.html is not None else b""


def _read_variants(program: Program, real: Real | None, weighted: bool) -> dict[str, dict[int, float]]:
    """The settings of each variant by draws. Raises UserError for one that names what the category does not have; of a program that a
    prior has ``weighted``, such a one is left out."""
    from ..run.settings import resolve_settings

    found = {}
    for name, settings in (real.variants if real is not None else {}).items():
        try:
            found[name] = resolve_settings(program, settings)[0]
        except SettingError as error:
            if weighted:
                continue
            raise UserError(
                f"the variant `{name}` of {program.name} cannot be set: {error.message}",
                error.hint or "correct `variants` in the file of real sizes",
            ) from None
    return found


def _own_lines(path: Path | None) -> int | None:
    """Lines of the text of a category; None for a compiled one."""
    from ..quality.card import program_lines

    if path is None or path.suffix != ".apg":
        return None
    return program_lines(path.read_text(encoding="utf-8"))


def _picture(job: Job) -> bytes:
    """A small contact sheet as PNG."""
    from ..view.png import png_bytes
    from ..view.sheet import Sheet, draw_sheet

    batch = job.batch()
    sheet = Sheet(columns=min(COLUMNS, len(batch)), tile=TILE, colour="material")
    return png_bytes(draw_sheet(batch, sheet))
