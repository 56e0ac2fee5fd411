"""A few objects of a category, and where to say what they show."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..diagnostics import Report
from ..records import dataclass
from ..source import Source, Span

if TYPE_CHECKING:
    from ..graph.program import Where
    from ..lower.program import Lowering
    from ..runtime.batch import Batch


@dataclass(frozen=True, slots=True)
class Seen:
    """A few objects, and the report of what they show; ``span``: where the category is declared."""

    batch: Batch
    lowering: Lowering
    span: Span
    report: Report

    def of(self, path: str) -> Span | None:
        """Where the part with this path is declared, or the one that it is in, if that is in the file of the category."""
        return place_of(self.lowering, path, self.span)

    def line(self, where: Where | None) -> Span | None:
        """The whole of a line of the file of the category."""
        return line_of(self.span.source, where)

    def later(self, *paths: str) -> Span:
        """Where the last of these parts in the text is declared: it came to those before it. Of parts in templates that is the
        part of the category that they are in, whose place is told there, unless it is the same for all."""
        for within in (self._around, self.of):
            spans = [span for path in paths if (span := within(path)) is not None]
            if len(set(spans)) == len(set(paths)):
                break
        return max(spans, key=lambda span: span.start, default=self.span)

    def _around(self, path: str) -> Span | None:
        """Where the part of the category is declared that the part with this path is in."""
        parts = (part for part in self.lowering.context.parts if f"{path}.".startswith(f"{part.path}."))
        return min(parts, key=lambda part: len(part.path)).span


def line_of(source: Source, where: Where | None) -> Span | None:
    """The whole of a line, if it is in ``source``, as a rule the file of the category."""
    if where is None or where.file != source.name:
        return None
    text = source.line(where.line)
    start = source.start(where.line) + len(text) - len(text.lstrip())
    return Span(source, start, start + len(text.strip()))


def place_of(lowering: Lowering, path: str, category: Span) -> Span | None:
    """Where the part with this path is declared, or the one that it is in, if that is in the file of the category."""
    while path:
        here = (part.span for part in lowering.context.parts if part.path == path)
        if found := next((span for span in here if span.source is category.source), None):
            return found
        path = path.rpartition(".")[0]
    return None


def always(definition: np.ndarray, there: np.ndarray) -> Iterator[tuple[int, int]]:
    """The definitions (n,) of which each that there is has something, as ``there`` (n,) says, and the first place of each."""
    lacking = set(definition[~there].tolist())
    for number in sorted(set(definition.tolist()) - lacking):
        yield number, int(np.flatnonzero(definition == number)[0])
