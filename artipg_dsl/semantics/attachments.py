"""Every part of a category is attached exactly once, or is the root; joints and connects are counted per guard."""

from __future__ import annotations

from collections.abc import Hashable, Iterator
from typing import TYPE_CHECKING

from ..records import dataclass
from ..source import Span
from ..syntax import ast
from ..syntax.walk import path_root
from .fold import constant
from .guards import TRUE, VERSUS, And, Condition, Not, Or, assignments, conjunction, consistent
from .scope import BodyScope, Entry, Guards, Variant
from .types import PartType

if TYPE_CHECKING:
    from .checker import Checker


@dataclass(frozen=True, slots=True)
class Attachment:
    """A ``connect`` or ``joint`` whose subject is the part, with what holds where it stands.

    ``there``: what holds where its ``subject``, as it is written, exists; without that the statement is void.
    """

    span: Span
    word: str
    condition: Condition
    there: Condition
    subject: str


def check(ck: Checker, scope: BodyScope) -> None:
    """The parts of a category or template, and of its repeats."""
    category = scope.owner.kind == "category"
    found: dict[int, list[Attachment]] = {}
    backwards: set[str] = set()  # what the root is attached to, the wrong way round: that is told of the root
    repeated: set[int] = set()  # the declarations of a name that the elements of a repeat attach: told once
    for at, stmt, guards in _statements(scope, scope.owner.body, ()):
        subject = ast.placed(stmt)
        first = None if subject is None else path_root(subject)
        if subject is None or not isinstance(first, ast.NameExpr):
            continue
        condition = ck.condition(guards)
        there = conjunction((condition, ck.subjects.get(id(subject), TRUE)))
        if (outer := at.home(first.name)) is not None and id(outer.table[first.name]) not in repeated:
            if _is_repeated(ck, at, outer, stmt, first.name):
                repeated.add(id(outer.table[first.name]))
        for entry in at.find(first.name):
            if entry.kind == "part" and consistent(condition, ck.entry_condition(entry)):
                word = "connect" if isinstance(stmt, ast.ConnectStmt) else "joint"
                if isinstance(entry.node, ast.PartDecl) and entry.node.root:
                    backwards |= _carriers(stmt)
                found.setdefault(id(entry), []).append(
                    Attachment(stmt.span, word, condition, there, subject.span.words)
                )
    parts = [entry for inner in scope.below() for entry in inner.entries if entry.kind == "part"]
    roots = [entry for entry in parts if isinstance(entry.node, ast.PartDecl) and entry.node.root]
    foremost = next((entry for entry in scope.entries if entry.kind == "part"), None)
    parts = [entry for entry in parts if id(entry.scope.table[entry.name]) not in repeated]
    for entry in parts:
        meant = (
            entry in roots or not roots and entry is foremost
        )  # the first of a category without a root, which is told
        _count(
            ck, entry, found.get(id(entry), []), category and not meant and entry.name not in backwards, entry in roots
        )
    if category:
        _check_roots(ck, scope, roots, foremost)


def _is_repeated(ck: Checker, at: BodyScope, outer: BodyScope, stmt: ast.Stmt, name: str) -> bool:
    """Whether the elements of a repeat attach a part of the body around it, once more each; that is told."""
    repeat, part = at.repeat, outer.table[name][0]
    if outer is at or repeat is None or part.kind != "part" or _once(at, repeat):
        return False
    ck.error(
        "two-attachments",
        stmt.span,
        f"`{name}` stands outside of `{repeat.name}`, so each of its elements would attach it",
        notes=((part.span, "declared here, once"),),
        hint=f"attach it outside of the repeat, to what carries the elements, or to one of them, `{repeat.name}[0]...`"
        + (
            "; to tie a loop of joints, the other elements `close point on point`"
            if isinstance(stmt, ast.JointDecl)
            else ""
        ),
    )
    return True


def _once(at: BodyScope, repeat: ast.RepeatStmt) -> bool:
    """Whether a repeat has at most one element, as far as its text says."""
    count = repeat.count
    if isinstance(count, ast.NameExpr):
        domains = [
            entry.node.domain for entry in at.find(count.name) if isinstance(entry.node, ast.CountDecl | ast.ParamDecl)
        ]
        count = domains[0].high if len(domains) == 1 and domains[0] is not None else None
    most = None if count is None else constant(count)
    return most is not None and most <= 1


def _carriers(stmt: ast.Stmt) -> set[str]:
    """The part that a statement attaches something to."""
    if isinstance(stmt, ast.JointDecl):
        target = stmt.parent
    else:
        assert isinstance(stmt, ast.ConnectStmt)
        target = next((clause.value for clause in ast.present(stmt.to, stmt.on, stmt.in_)), None)
    first = None if target is None else path_root(target)
    return {first.name} if isinstance(first, ast.NameExpr) else set()


def _check_roots(ck: Checker, scope: BodyScope, roots: list[Entry], first: Entry | None) -> None:
    if not roots:
        hint = f"write `root part {first.name}`" if first is not None else "write `root part body : ...`"
        span = scope.owner.decl.name_span
        ck.error("no-root", span, f"the category `{scope.owner.name}` has no root part", hint=hint)
    for position, entry in enumerate(roots):
        for earlier in roots[:position]:
            if consistent(ck.entry_condition(entry), ck.entry_condition(earlier)):
                ck.error(
                    "two-roots",
                    entry.span,
                    "a category has one root part",
                    notes=((earlier.span, "the first one"),),
                    hint="keep `root` on the part that carries the others; connect the other to it",
                )
                break


def _count(ck: Checker, entry: Entry, found: list[Attachment], needed: bool, root: bool) -> None:
    for attachment in found if root else ():
        ck.error(
            "two-attachments",
            attachment.span,
            f"`{entry.name}` is the root: it cannot be attached",
            notes=((entry.span, "declared as root here"),),
            hint="turn the statement around, so that the other part is attached to the root: `joint open : revolute body -> door`",
        )
        return
    exists = _exists(ck, entry)
    for position, later in enumerate(found):
        for earlier in found[:position]:
            if consistent(exists, earlier.condition, later.condition):
                ck.error(
                    "two-attachments",
                    later.span,
                    f"`{entry.name}` is attached twice",
                    hint=f"a part has only one attachment; {_instead(exists, earlier, later)}",
                    notes=((earlier.span, "the first attachment"),),
                )
                return
    if not needed:
        return
    if not found:
        ck.error(
            "no-attachment",
            entry.span,
            f"`{entry.name}` is not attached to anything",
            hint=f"write `connect {entry.name} to ...` or give it a joint; `align` only places it",
        )
        return
    open_cases = assignments(And((exists, Not(Or(tuple(a.there for a in found))))))
    case = next(open_cases, None) if open_cases is not None else None
    if case is not None:
        ck.error(
            "no-attachment",
            entry.span,
            f"`{entry.name}` is not attached {_words(case)}",
            hint="attach it in each case, under a `when` and its `else`",
            notes=((found[0].span, _attached(entry, found[0])),),
        )


def _instead(exists: Condition, earlier: Attachment, later: Attachment) -> str:
    """What to write instead of two attachments."""
    if not consistent(exists, earlier.there, later.there):
        return "put each under a `when` of its own, or under the `else` of the other"
    if earlier.word == later.word == "joint":
        return "to tie a loop of joints, leave one out and write `close point on point`, or two lines"
    return "`align` places without attaching"


def _attached(entry: Entry, there: Attachment) -> str:
    """Where a part is attached that is not attached everywhere."""
    return (
        "attached here, under a guard"
        if there.subject == entry.name
        else f"attached here, where `{there.subject}` exists"
    )


def _words(case: dict[str, Hashable]) -> str:
    """A case in words: ``when handle is none and rows is 2``."""
    told = []
    for key, value in case.items():
        if VERSUS in key:
            first, _, second = key.rsplit(":", 1)[-1].partition(VERSUS)
            told.append(f"{first} {({-1: '<', 0: '==', 1: '>'})[value]} {second}")  # type: ignore[index]
            continue
        name = key.rsplit(":", 1)[-1].rsplit(".", 1)[-1].split("~")[0]
        if key.endswith("#rank"):
            name = "the rank"
        shown = "none" if value is None else value.name if isinstance(value, Variant) else str(value).lower()
        told.append(f"{name} is {shown}")
    return "when " + " and ".join(told) if told else "in every case"


def _exists(ck: Checker, entry: Entry) -> Condition:
    kind, condition = ck.entry_type(entry), ck.entry_condition(entry)
    return conjunction((condition, kind.there)) if isinstance(kind, PartType) else condition


def _statements(
    scope: BodyScope, body: tuple[ast.Stmt, ...], guards: Guards
) -> Iterator[tuple[BodyScope, ast.Stmt, Guards]]:
    for stmt in body:
        if isinstance(stmt, ast.WhenStmt):
            yield from _statements(scope, stmt.body, scope.branches[id(stmt), True])
            yield from _statements(scope, stmt.otherwise, scope.branches[id(stmt), False])
        elif isinstance(stmt, ast.RepeatStmt):
            inner = scope.inner[id(stmt)]
            yield from _statements(inner, stmt.body, inner.guards)
        else:
            yield scope, stmt, guards
