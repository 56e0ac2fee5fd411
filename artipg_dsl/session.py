"""One object per compilation: its phases as cached properties, from text to a sampler. The public API's spine."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from . import kept
from .diagnostics import CompileError, Report, did_you_mean
from .garbage import uncollected
from .resources import categories_dir, library_dir
from .shapes import Misfit, fit
from .source import Source
from .syntax.load import load

if TYPE_CHECKING:  # start-up: what is kept of a compilation needs neither the parser nor the checker
    import numpy as np

    from .lower.program import Lowering
    from .runtime.batch import Batch
    from .sampling.sample import Sampler
    from .sampling.statistics import Statistics
    from .semantics.check import TypedProgram
    from .semantics.modules import Workspace
    from .semantics.symbols import ModuleScope
    from .syntax import ast


class Kept(TypedDict):
    """What is kept with a compiled program: its hash, and the digests of its primitives, which take long to find."""

    hash: str
    primitives: dict[str, str]


_AT_HAND = 8  # programs, read and planned
_DECLARED = re.compile(r"^category\s+(\w+)", re.MULTILINE)


def categories() -> dict[str, Path]:
    """The shipped categories: name (``Microwave``) to file."""
    found = {}
    for path in sorted(categories_dir().glob("*.apg")):
        declared = _DECLARED.search(path.read_text(encoding="utf-8"))
        if declared is not None:
            found[declared[1]] = path
    return found


def _locate(name: str | Path, report: Report) -> Path | None:
    """The file of a category given by name (in any case) or by path."""
    text = str(name)
    path = Path(text)
    try:
        special = path.exists() and not path.is_file() and not path.is_dir()
    except OSError as error:
        report.error("missing-file", None, f"{text} cannot be read: {error.strerror}")
        return None
    if special:
        hint = "a program is read more than once: save it in a file"
        report.error("missing-file", None, f"{text} is a pipe or a device, not a file", hint=hint)
        return None
    if path.suffix == ".apg" or path.is_file():
        return path
    shipped = categories()
    known = {k.lower(): v for k, v in shipped.items()}
    if text.lower().replace("_", "") in known:  # even where a folder is called so
        return known[text.lower().replace("_", "")]
    if path.exists():
        return path
    if path.suffix or path.name != text:
        hint = "a program is an .apg file" if path.suffix else "check the path, and end it with .apg"
        report.error("missing-file", None, f"there is no file {text}", hint=hint)
        return None
    hint = (
        ("only `apgc fmt -` reads a program from standard input: save it in a file" if text == "-" else None)
        or (f"did you mean `{text}.apg`?" if path.with_suffix(".apg").is_file() else None)
        or did_you_mean(text, shipped)
        or f"the shipped categories are {', '.join(shipped)}; or give the path of an .apg file"
    )
    report.error("missing-file", None, f"there is no category `{text}`", hint=hint)
    return None


@lru_cache(maxsize=_AT_HAND)
def _read(text: str) -> Sampler:
    """The sampler of a program as it was kept, verified as any that is read from a file. A process that asks for a category again and
    again, a notebook for one, reads it once."""
    from .geometry import facts
    from .graph.unread import from_kept
    from .sampling.sample import Sampler

    head, _, body = text.partition("\n")
    told = json.loads(head)
    fit(told, Kept)
    with uncollected():
        program = from_kept(body, told["hash"])
        for name, known in told["primitives"].items():
            if name in program.primitives:
                facts.tell_digest(program.primitives[name], known)
        program.foreign = False
        return Sampler(program)


class Session:
    """A compilation of one file or text. Findings of all phases gather in ``report``; a phase that failed is None.

    ``sampler`` and ``examine`` take what was kept of an equal compilation (see ``kept``); the phases are always computed.
    ``texts`` count instead of what is saved in their files, as in an editor: nothing is kept of a compilation with them.
    """

    def __init__(
        self,
        source: Source | None,
        path: Path | None,
        report: Report | None = None,
        texts: Mapping[Path, Source] | None = None,
    ):
        self.report = report or Report()
        self.source, self.path, self.texts = source, path, texts

    @classmethod
    def of(cls, name: str | Path) -> Session:
        """A category by name, or a file."""
        report = Report()
        path = _locate(name, report)
        return cls(None, path, report)

    @classmethod
    def of_text(cls, text: str, name: str = "<text>") -> Session:
        return cls(Source(name, text), None)

    def __reduce__(self) -> tuple[type[Session], tuple[Source | None, Path | None]]:
        """To another process goes what is compiled, which is compiled anew there."""
        return Session, (self.source, self.path)

    @cached_property
    def workspace(self) -> Workspace:
        from .semantics.modules import Workspace
        from .syntax.trees import shipped_tree

        shipped = shipped_tree if self.texts is None else None  # an editor shows all mistakes of a text that it holds
        return Workspace(self.report, [library_dir()], reader=self.read, shipped=shipped)

    def read(self, path: Path, report: Report, _: str = "") -> Source | None:
        """The text of a file that the program uses; None after reporting why there is none."""
        return (self.texts or {}).get(path.resolve()) or load(path, report, _shown(path))

    @cached_property
    def module(self) -> ModuleScope | None:
        """The parsed file with its imports."""
        if self.source is not None:
            return self.workspace.load_source(self.source)
        return None if self.path is None else self.workspace.load_file(self.path)

    @property
    def tree(self) -> ast.Module | None:
        return None if self.module is None else self.module.tree

    @cached_property
    def typed(self) -> TypedProgram | None:
        """The checked program; None when it could not be read at all."""
        from .semantics.check import check

        return None if self.module is None else check(self.workspace, self.module, self.report)

    @cached_property
    def lowering(self) -> Lowering | None:
        """The constraint graph of the category; None after errors, and for a file without a category."""
        with uncollected(), self._told_if_too_deep():
            return self._lowered()
        return None

    @contextmanager
    def _told_if_too_deep(self) -> Iterator[None]:
        """Report where values follow one from another through more calls within calls than Python allows."""
        try:
            yield
        except RecursionError:
            assert self.typed is not None and self.typed.category is not None
            decl = self.typed.category.decl
            self.report.error(
                "too-deep",
                decl.name_span,
                f"`{decl.name}` cannot be compiled: hundreds of values or parts follow one from another",
                hint="put groups of parts into templates, or use `repeat` for parts that are alike",
            )

    def _lowered(self) -> Lowering | None:
        from . import solids
        from .lower.program import lower_category

        typed = self.typed
        if typed is None or self.report.failed:
            return None
        if typed.category is None:
            solids.check_closed(solids.lower_own(typed, self.report), self.report)
            return None
        lowering = lower_category(typed, typed.category, self.report)
        if lowering is not None:
            solids.check_closed(lowering.context.solids, self.report)
        return None if self.report.failed else lowering

    @cached_property
    def sampler(self) -> Sampler:
        """The category ready to be sampled. Raises CompileError."""
        found = None if "lowering" in self.__dict__ else self._recalled()
        with uncollected():
            return found or self._compiled()

    def _recalled(self) -> Sampler | None:
        """The program as it was kept; its findings go to the report."""
        from .graph.reading import TextError

        try:
            return _read(self._recall("program") or "")
        except (ValueError, KeyError, Misfit, TextError, RecursionError):
            return None

    def _compiled(self) -> Sampler:
        from .geometry import facts
        from .runtime.plan import PlanError
        from .sampling.sample import Sampler

        lowering = self.lowering
        if lowering is None and not self.report.failed:
            what = self.path or "the text"
            self.report.error("no-category", None, f"{what} declares no category, so there is nothing to sample")
        for span, why in () if lowering is None else lowering.context.unclear:
            self.report.error(
                "needs-clearance",
                span,
                f"this `clearance` cannot be solved for: {why}",
                hint="write a number or a formula; `clearance` is for the high end of a revolute or prismatic joint that moves independently",
            )
        if lowering is None or self.report.failed:
            raise CompileError(self.report)
        sampler = None
        try:
            with self._told_if_too_deep():
                sampler = Sampler(lowering.program)
        except PlanError as error:
            self.report.error(
                "circular-definition",
                None,
                f"these values depend on one another in a circle: {error}",
                hint="determine one of them from something else",
            )
        if sampler is None:
            raise CompileError(self.report)
        program = lowering.program
        digests = {name: facts.digest_of(primitive) for name, primitive in program.primitives.items()}
        told: Kept = {"hash": program.hash, "primitives": digests}
        self._keep("program", json.dumps(told) + "\n" + lowering.text)
        return sampler

    def examine(self) -> Report:
        """All findings: of the text, of its category as far as it can be put in order, and what is perhaps not meant."""
        from .geometry import facts

        if self._recall("check") is None:
            if self.lowering is not None:
                try:
                    _ = self.sampler
                except CompileError:
                    pass  # it has told the report
            self.advise()
            self._keep("check")
            facts.flush()
        return self.report

    def advise(self) -> None:
        """Report what is legal and perhaps not meant (see ``advice``)."""
        from .advice.advise import advise  # start-up

        if self.typed is not None:
            advise(self.typed, self.lowering, self._draw, self.report)

    def _draw(self, numbers: np.ndarray, counted: Statistics) -> Batch:
        return self.sampler.batch(numbers, 0, statistics=counted)

    @cached_property
    def _text(self) -> Source | None:
        """The text itself; None where it cannot be read."""
        if self.source is not None or self.path is None:
            return self.source
        return load(self.path, Report(), _shown(self.path))

    @property
    def _folder(self) -> Path:
        return (self.path or Path(self._text.name if self._text else "")).parent

    def _recall(self, kind: str) -> str | None:
        """What was kept of an equal compilation, whose findings go to the report."""
        if self._text is None or self.texts is not None:
            return None
        found = kept.recall(kind, self._text, self._folder)
        for diagnostic in () if found is None else found[0]:
            self.report.add(diagnostic)
        return None if found is None else found[1]

    def _keep(self, kind: str, rest: str = "") -> None:
        if self._text is not None and self.texts is None:
            from .syntax.trees import keep_parsed

            keep_parsed()
            main = self.path.resolve() if self.path else None
            files = {path: source for path, source in self.workspace.read.items() if path != main}
            kept.keep(kind, self._text, self._folder, files, self.workspace.absent, self.report.diagnostics, rest)


def _shown(path: Path) -> str:
    """A path as messages show it: shipped files by their last two parts, others as they were given."""
    for folder in (library_dir(), categories_dir()):
        if path.resolve().is_relative_to(folder.resolve()):
            return f"{folder.name}/{path.resolve().relative_to(folder.resolve())}"
    return str(path)


def check_text(source: Source) -> Report:
    """Check a text as far as it goes: names, types, and the constraint graph of its category."""
    session = Session(source, None)
    _ = session.lowering
    return session.report


__all__ = ["Session", "categories", "check_text"]
