"""Another name for what a file declares, at all places that stand for it.

The texts with the new name are read before anything is given away: their names and types must be right, and the new name must
stand for the same as the old one did, at the same places. So a name that hides another, or that a role binds, is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from ..records import dataclass
from ..resources import library_dir
from ..semantics.symbols import lineage, name_spans_of, names_of
from ..source import Source, Span
from ..syntax import ast
from ..syntax.walk import walk
from .analysis import Analysis
from .lookup import Found, find
from .uses import uses


class Refused(Exception):
    """Why a name cannot be another one, in words."""


@dataclass(frozen=True, slots=True)
class Edit:
    span: Span
    text: str


def renamed(analysis: Analysis, offset: int) -> Found:
    """The name at a place, if it can be another one. Raises Refused."""
    found = find(analysis, offset)
    if found is None:
        raise Refused("there is no name of the file here")
    if not found.declared:
        raise Refused(
            f"`{found.span.text}` is not declared by a statement: words of the language keep their names, and so do "
            "options of a choice, by which objects are kept"
        )
    if any(span.start == span.end for span in found.declared):
        raise Refused("a module is called as its file: rename the file, and the names in `use`")
    for span in found.declared:
        path = analysis.path_of(span.source)
        if path is None or path.is_relative_to(library_dir()):
            raise Refused(f"`{found.span.text}` is declared in the library")
    if (role := _role_of(analysis, found)) is not None:
        raise Refused(
            f"`{found.span.text}` is a name of the role `{role}` of the library: its templates bind it by this name"
        )
    return found


def rename(analysis: Analysis, offset: int, name: str, others: Iterable[Analysis] = ()) -> list[Edit]:
    """What is to be written for ``name`` to be the name of what stands at a place, in its text and in the others. Raises Refused.

    A parameter or a count that is drawn is said to have been the old one, so that objects stay as they are.
    """
    found, others = renamed(analysis, offset), list(others)
    if name == found.span.text:
        return []
    places = uses(analysis, offset, others)
    touched = {span.source.name for span in places}
    for each in (analysis, *others):
        if each.source.name in touched and each.failed:
            raise Refused(f"{Path(each.source.name).name} has errors: put them right first")
    edits = [Edit(span, name) for span in places]
    edits += [Edit(end, f" was {found.span.text}") for end in _ends_of_drawn((analysis, *others), places)]
    _verify(analysis, offset, edits, name, others)
    return edits


def _role_of(analysis: Analysis, found: Found) -> str | None:
    """The role of the library that says by its name what is declared in a template of it."""
    name, here = found.span.text, set(found.declared)
    files = {span.source.name for span in here}
    for module in () if analysis.typed is None else analysis.typed.modules.values():
        for symbol in module.own() if module.source.name in files else ():
            stated = [stmt for stmt in walk(symbol.decl) if isinstance(stmt, ast.Stmt) and stmt is not symbol.decl]
            if not here.intersection(span for stmt in stated for span in name_spans_of(stmt)):
                continue
            for role in lineage(symbol):
                path = analysis.path_of(role.module.source)
                if role.kind == "role" and path is not None and path.is_relative_to(library_dir()):
                    if any(name in names_of(stmt) for stmt in role.body):
                        return role.name
    return None


def _ends_of_drawn(texts: Iterable[Analysis], places: Iterable[Span]) -> list[Span]:
    """Behind the parameters and counts that are declared at some places, of those that are drawn and were nothing else before."""
    names = {(span.source.name, span.start) for span in places}
    ends: dict[tuple[str, int], Span] = {}  # a file may be known twice
    files = {name for name, _ in names}
    for each in (text for text in texts if text.source.name in files):
        for node in [] if each.module is None else walk(each.module.tree):
            if not isinstance(node, ast.CountDecl | ast.ParamDecl) or node.was is not None or not _drawn(node):
                continue
            if any((span.source.name, span.start) in names for span in name_spans_of(node)):
                ends[node.span.source.name, node.span.end] = Span(node.span.source, node.span.end, node.span.end)
    return list(ends.values())


def _drawn(node: ast.CountDecl | ast.ParamDecl) -> bool:
    """Whether a declaration draws a value that may have an old name."""
    if isinstance(node, ast.CountDecl):
        return True
    return node.keyword == "param" and len(node.names) == 1 and (node.domain is not None or bool(node.type.values))


def _verify(analysis: Analysis, offset: int, edits: Sequence[Edit], name: str, others: Sequence[Analysis]) -> None:
    """Raise Refused where the texts with their edits have errors, or the name would stand for more or less than before."""
    sources = {edit.span.source.name: edit.span.source for edit in edits}
    texts = {Path(name): _edited(source, edits) for name, source in sources.items()}
    after = [each.but(texts) for each in (analysis, *others)]
    for was, now in zip((analysis, *others), after, strict=True):
        if {Path(was.source.name), *was.reads} & texts.keys() and now.failed and not was.failed:
            raise Refused(f"`{name}` cannot be its name: {now.errors[0].message}")
    at = offset + sum(
        len(e.text) - (e.span.end - e.span.start)
        for e in edits
        if e.span.source.name == analysis.source.name and e.span.end <= offset
    )
    kept = uses(after[0], at, after[1:])
    if len(kept) != sum(edit.text == name for edit in edits):
        raise Refused(f"`{name}` cannot be its name: something else is called so where it is used")


def _edited(source: Source, edits: Sequence[Edit]) -> Source:
    text = source.text
    for edit in sorted((e for e in edits if e.span.source.name == source.name), key=lambda e: -e.span.start):
        text = text[: edit.span.start] + edit.text + text[edit.span.end :]
    return Source(source.name, text)
