"""Tables of a program and their columns: what an expression lives in and what it reads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..records import dataclass

if TYPE_CHECKING:
    from .expr import Expr


@dataclass(eq=False, slots=True)
class Scope:
    """A table of the program. ``count`` gives the rows per row of the parent: a count, or a guard that is 0 or 1."""

    name: str
    parent: Scope | None = None
    kind: str = "root"  # "root" | "repeat" | "guard"
    count: Expr | None = None

    @property
    def depth(self) -> int:
        return 0 if self.parent is None else self.parent.depth + 1

    def ancestors(self) -> Iterable[Scope]:
        """This scope, its parent, and so on up to the root."""
        scope: Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.parent

    def within(self, other: Scope | None) -> bool:
        """Whether ``other`` is this scope, one around it, or none."""
        scope: Scope | None = self
        while scope is not other and scope is not None:
            scope = scope.parent
        return scope is other

    def __repr__(self) -> str:
        return f"<scope {self.name}>"


@dataclass(eq=False, slots=True)
class Column:
    """A named value per row of a scope. ``kind`` is "real", "count", "choice" or "bool"."""

    scope: Scope
    name: str
    kind: str = "real"

    @property
    def path(self) -> str:
        return f"{self.scope.name}.{self.name}" if self.scope.parent is not None else self.name

    def __repr__(self) -> str:
        return f"<column {self.path}>"


class ScopeError(Exception):
    """Two values of tables that are not on one chain; the lowering turns it into a diagnostic."""

    def __init__(self, first: Scope, second: Scope):
        super().__init__(f"{first.name} and {second.name} have no common rows")
        self.first, self.second = first, second
