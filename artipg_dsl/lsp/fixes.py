"""The edits that findings propose: what an editor offers to do about them."""

from __future__ import annotations

import re

from ..diagnostics import Diagnostic
from ..records import dataclass
from ..source import Span

_MEANT = re.compile(r"^did you mean `([^`]+)`\?")


@dataclass(frozen=True, slots=True)
class Fix:
    """``text`` instead of what stands at ``span``."""

    title: str
    span: Span
    text: str


def fixes(found: Diagnostic) -> list[Fix]:
    """What may be done about a finding: a word that is misspelt is replaced by the one that is meant."""
    meant = _MEANT.match(found.hint or "")
    if meant is None or found.span is None or not re.fullmatch(r"\w+", found.span.text):
        return []
    return [Fix(f"write `{meant[1]}`", found.span, meant[1])]
