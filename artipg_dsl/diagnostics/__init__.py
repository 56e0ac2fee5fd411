"""Findings as data: what is wrong, where, what was expected, what to try. They are collected in a report; the command line prints them.

In: ``report.error(code, span, message, hint=...)`` from the compiler. Out: a ``Report``, shown as text, JSON or SARIF, or raised as
a ``CompileError``. Begin with ``model``; a new code is an entry in ``codes``.

    model, suggest        a finding and the report; the closest name
    codes                 every code with its explanation and an example
    text, data, page      findings for people and for tools; the page of all codes
"""

from .model import CompileError, Diagnostic, Report
from .suggest import did_you_mean, suggest

__all__ = ["CompileError", "Diagnostic", "Report", "did_you_mean", "suggest"]
