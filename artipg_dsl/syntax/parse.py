"""Text to syntax tree. Errors go to the report, in words; the tree is None when there were any."""

from __future__ import annotations

from threading import Lock

from ..diagnostics import Report
from ..errors import InternalError
from ..garbage import uncollected
from ..source import Source
from . import ast
from .grammar import Machine, machine
from .token import Token
from .walk import too_deep

_ONE_AT_A_TIME = Lock()

MOST_ERRORS = 10
"""So many syntax errors are reported for one file."""

_DEEPEST = 200
"""So many nodes of a tree may stand one within another."""


def parse(source: Source, report: Report) -> ast.Module | None:
    """The tree of a source, or None after reporting why there is none."""
    with _ONE_AT_A_TIME, uncollected():
        tree, whole = _parse(machine(), source, report)
    return tree if whole else None


def parse_piece(source: Source, begin: int, end: int) -> ast.Module | None:
    """The tree of a part of a source that stands alone, as a declaration does; None where it has a mistake."""
    with _ONE_AT_A_TIME, uncollected():
        tools = machine()
        tree = tools.tree(source, " " * begin + source.text[begin:end])
        return None if tree is None or tools.builder.problems or too_deep(tree, _DEEPEST) else tree


def parse_rest(source: Source) -> ast.Module | None:
    """The tree of a source without the statements that have mistakes; None where nothing sensible is left."""
    with _ONE_AT_A_TIME, uncollected():
        return _parse(machine(), source, Report())[0]


def tokens_of(source: Source) -> list[Token]:
    """The tokens and comments of a source in their order; where a statement has a mistake, those that it would have anywhere."""
    with _ONE_AT_A_TIME, uncollected():
        tools = machine()
        _parse(tools, source, Report())
        read = sorted((*tools.layout.seen, *tools.layout.comments), key=lambda t: t.start_pos)
        found, end = list[Token](), 0
        for token in [*(t for t in read if t.value.strip()), Token("$END", "", len(source.text), len(source.text))]:
            if source.text[end : token.start_pos].strip():
                found += tools.loose(source.text, end, token.start_pos)
            found.append(token)
            end = token.end_pos
    return found[:-1]


def _parse(tools: Machine, source: Source, report: Report) -> tuple[ast.Module | None, bool]:
    """The tree of what has no mistakes, and whether that is the whole source."""
    text, broken = source.text, False
    for _ in range(MOST_ERRORS):
        tree = tools.tree(source, text)
        if tree is None:
            from .errors.messages import describe  # start-up: for texts with mistakes alone
            from .recover import without_statement  # start-up: for texts with mistakes alone

            error = tools.mistake(text)
            if error is None:
                raise InternalError(source.name, "two parsers of one grammar do not agree")
            found = describe(error, tools, source, text)
            if not found.told:
                report.error(found.code, found.span, found.message, hint=found.hint, notes=found.notes)
            broken = True
            shorter = None if found.fatal else without_statement(text, found.place, found.line_alone)
            if shorter is None:
                return None, False
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
        return tree if deep is None else None, not (broken or deep or tools.builder.problems)
    return None, False
