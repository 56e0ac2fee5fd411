"""Diagnostics as data: what is wrong, where, what was expected, what to try. Collected in a report, never printed here."""

from .model import CompileError, Diagnostic, Report
from .suggest import did_you_mean

__all__ = ["CompileError", "Diagnostic", "Report", "did_you_mean"]
