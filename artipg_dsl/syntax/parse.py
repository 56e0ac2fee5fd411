"""Text to syntax tree. Errors go to the report, in words; the tree is None when there were any."""

from __future__ import annotations

from threading import Lock

from ..diagnostics import Report
from ..errors import InternalError
from ..garbage import uncollected
from ..source import Source
from . import ast
from .grammar import Machine, machine
from .walk import too_deep

_ONE_AT_A_TIME = Lock()

MOST_ERRORS = 10
"""So many syntax errors are reported for one file."""

_DEEPEST = 200
"""So many nodes of a tree may stand one within another."""


def parse(source: Source, report: Report) -> ast.Module | None:
    """The tree of a source, or None after reporting why there is none."""
    with _ONE_AT_A_TIME, uncollected():
        return _parse(machine(), source, report)


def _parse(tools: Machine, source: Source, report: Report) -> ast.Module | None:
    text, broken = source.text, False
    for _ in range(MOST_ERRORS):
        tree = tools.tree(source, text)
        if tree is None:
            from .messages import describe  # start-up: for texts with mistakes alone
            from .recover import without_statement  # start-up: for texts with mistakes alone

            error = tools.mistake(text)
            if error is None:
                raise InternalError(source.name, "two parsers of one grammar do not agree")
            found = describe(error, tools, source, text)
            report.error(found.code, found.span, found.message, hint=found.hint, notes=found.notes)
            broken = True
            shorter = None if found.fatal else without_statement(text, found.place, found.line_alone)
            if shorter is None:
                return None
            text = shorter
            continue
        for problem in tools.builder.problems:
            report.error("syntax", problem.span, problem.message, hint=problem.hint)
        deep = None if broken else too_deep(tree, _DEEPEST)
        if deep is not None:
            report.error(
                "too-deep",
                deep.span,
                f"more than {_DEEPEST} expressions or blocks stand one within another here",
                hint="name a part of it with `let`, or put it into a template",
            )
        return None if broken or deep is not None or tools.builder.problems else tree
    return None
