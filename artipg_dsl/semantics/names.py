"""Checks of the names that a body declares: reserved ones, ones declared twice, ones that hide others, ones that others had."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..language import DIRECTIONS, FACES, FUNCTIONS, OWN, TYPES, WORDS
from ..source import Span
from ..syntax import ast
from .guards import consistent
from .scope import BodyScope, Entry

if TYPE_CHECKING:
    from .checker import Checker


def check_names(ck: Checker, scope: BodyScope) -> None:
    """Reserved names, and names declared twice where both can exist."""
    for name, entries in scope.table.items():
        for entry in entries:
            if entry.scope.owner is scope.owner and _is_own(scope, entry.node):
                why = _reserved(scope, entry.kind, entry.node, name)
                if why is not None:
                    hint = "choose another name"
                    ck.error("reserved-name", entry.span, f"`{name}` cannot be declared: it is {why}", hint=hint)
                    ck.set_aside(entry)
                elif (around := _repeat_of(scope, entry)) is not None:
                    ck.error(
                        "duplicate-name",
                        entry.span,
                        f"`{name}` is already the name of the repeat around it",
                        hint="rename one of them",
                        notes=((around.name_span, "the repeat"),),
                    )
                    ck.set_aside(entry)
                elif scope.parent is not None and (hidden := scope.parent.find(name)):
                    if "index" in (entry.kind, hidden[0].kind):
                        warn_hidden(ck, name, entry.span, hidden[0], "inside this repeat")
                _renamed(ck, scope, entry)
        for position, entry in enumerate(entries):
            for earlier in entries[:position]:
                if earlier.node is entry.node or _shared(earlier.node, entry.node):
                    continue
                if consistent(ck.entry_condition(earlier), ck.entry_condition(entry)):
                    ck.error(
                        "duplicate-name",
                        entry.span,
                        f"`{name}` is declared twice",
                        hint="a name may be declared twice only under guards that exclude each other",
                        notes=((earlier.span, "first declared here"),),
                    )
                    break


def warn_hidden(ck: Checker, name: str, span: Span, hidden: Entry, inside: str) -> None:
    """Warn that a name means something else inside than around it, where it is the rank of an element or the like."""
    what = (
        f"the index of `{hidden.node.name}`" if isinstance(hidden.node, ast.RepeatStmt) else f"`{hidden.kind} {name}`"
    )
    ck.warning(
        "duplicate-name",
        span,
        f"{inside}, `{name}` no longer means {what}",
        hint="rename one of them",
        notes=((hidden.span, "hidden by it"),),
    )


def _renamed(ck: Checker, scope: BodyScope, entry: Entry) -> None:
    """What a declaration `was` is gone, and nothing else was it: two of one address would be drawn alike."""
    was = getattr(entry.node, "was", None)
    if was is None:
        return
    earlier = (e for es in scope.table.values() for e in es if e.span.start < entry.span.start)
    others = [*scope.table.get(was, ()), *(e for e in earlier if getattr(e.node, "was", None) == was)]
    other = next((o for o in others if consistent(ck.entry_condition(o), ck.entry_condition(entry))), None)
    if other is not None:
        why = "is still declared" if other.name == was else f"is what `{other.name}` was"
        said = f"`{was}` {why}: `was` gives the old name of a renamed declaration"
        notes = ((other.span, "declared here"),)
        ck.error("duplicate-name", entry.span, said, hint="leave out the `was`", notes=notes)


def _is_own(scope: BodyScope, node: ast.Stmt) -> bool:
    """Not what a template takes over from its role: that is checked where it stands."""
    source = scope.owner.decl.span
    return source.source is node.span.source and source.start <= node.span.start < source.end


def _repeat_of(scope: BodyScope, entry: Entry) -> ast.RepeatStmt | None:
    """The repeat whose element an entry is called like."""
    repeat = scope.repeat
    return repeat if repeat is not None and entry.name == repeat.name and entry.scope is scope else None


def _shared(a: ast.Stmt, b: ast.Stmt) -> bool:
    """Indexed ports are bound one by one; a slot may bear the name of the part it binds."""
    if isinstance(a, ast.PortDecl) and isinstance(b, ast.PortDecl):
        return a.index is not None and b.index is not None
    return any(isinstance(x, ast.SlotDecl) and x.targets and isinstance(y, ast.PartDecl) for x, y in ((a, b), (b, a)))


# what formulas of primitives are over, beside parameters
_VARIABLES = {
    "u": "a variable of surfaces",
    "v": "a variable of surfaces",
    "i": "the number of a copy of a surface or a piece",
    "p": "the point that `inside` is asked of",
}


def _reserved(scope: BodyScope, kind: str, node: ast.Stmt, name: str) -> str | None:
    """Why a name may not be declared in this body, or None."""
    if name in FACES and kind != "surface" and not (scope.owner.kind == "category" and kind == "part"):
        return "a face of the box that every part has"
    if name in OWN and not (name == "size" and kind == "param"):
        return "a member that every part has"
    if kind in ("param", "count") and scope.owner.kind == "primitive" and name in _VARIABLES:
        return _VARIABLES[name]
    called = isinstance(node, ast.LetDecl) and node.parameters
    if called:  # `x` alone stays the axis
        if name in FUNCTIONS:
            return "a built-in function"
        return "a word of the language" if name in WORDS and name not in DIRECTIONS else None
    if kind == "surface" or kind == "curve" and name == "base":
        return None  # reached after a dot
    if kind in ("port", "slot", "curve", "joint"):
        return "a word of the language" if name in WORDS else None
    if (
        name in TYPES and not TYPES[name].free and kind != "part"
    ):  # `part frame` is no riddle: a type name alone says nothing
        return "a type name"
    if name in WORDS and not (name == "base" and scope.owner.kind == "category"):
        return "a word of the language"
    return None
