"""The primitives that the modules of the library declare, lowered from their text."""

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import library_dir
from artipg_dsl.session import Session
from artipg_dsl.solids import lower_own


def declared():
    found = {}
    for path in sorted(library_dir().glob("*.apg")):
        typed, report = Session.of(path).typed, Report()
        found |= {symbol.name: lowered.primitive for symbol, lowered in lower_own(typed, report).items()}
        assert not report.diagnostics
    return found


SHIPPED = declared()
