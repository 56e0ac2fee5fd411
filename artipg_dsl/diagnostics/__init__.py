"""Diagnostics as data: what is wrong, where, what was expected, what to try. Collected in a report, not printed."""

from .codes import CODES, Code, explain
from .model import CompileError, Diagnostic, Report
from .suggest import did_you_mean, suggest

__all__ = ["CODES", "Code", "CompileError", "Diagnostic", "Report", "did_you_mean", "explain", "suggest"]
