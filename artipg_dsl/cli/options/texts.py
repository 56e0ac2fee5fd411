"""The options of the commands for programs as text, and for what is kept of them."""

from __future__ import annotations

import argparse

from ..arguments import picture
from .shared import add_drawing, add_program, add_unchecked

EMITS = {
    "graph": "the constraint graph (default); `apgc sample` reads it from an .apgc file",
    "ast": "the syntax tree",
    "typed": "declarations with their types, and what each name stands for",
    "plan": "the order of evaluation",
    "python": "a Python module that samples the tables with NumPy alone",
}


def add_new(to: argparse.ArgumentParser) -> None:
    to.add_argument("name", metavar="NAME", help="name of the category, such as DeskLamp")
    to.add_argument(
        "-o", "--out", metavar="FILE", help="output file, or - for stdout (default: desk_lamp.apg for DeskLamp)"
    )
    to.add_argument(
        "--from",
        dest="source",
        metavar="CATEGORY",
        help="start from a copy of a shipped category or of a file, to change its ranges, alternatives or labels",
    )
    to.add_argument("--force", action="store_true", help="overwrite an existing file")


def add_check(to: argparse.ArgumentParser) -> None:
    to.add_argument("files", nargs="+", metavar="NAME|FILE", help="shipped categories or .apg files")
    shape = to.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="print the findings as JSON")
    shape.add_argument("--sarif", action="store_true", help="print the findings as SARIF, for editors and code hosts")
    to.add_argument("--strict", action="store_true", help="exit with code 1 for warnings, too, as a gate of CI")


def add_watch(to: argparse.ArgumentParser) -> None:
    add_program(to)
    add_drawing(to, 6)
    to.add_argument(
        "-o",
        "--out",
        type=picture,
        metavar="FILE",
        help="also draw a contact sheet to this file whenever there are no errors",
    )
    add_unchecked(to)
    to.add_argument("--force", action="store_true", help="overwrite an existing picture")


def add_fmt(to: argparse.ArgumentParser) -> None:
    to.add_argument("files", nargs="+", metavar="FILE", help="an .apg file, or - to read stdin and write stdout")
    to.add_argument(
        "--check",
        action="store_true",
        help="write nothing; list the files that would change, and exit with 1 if there are any",
    )
    to.add_argument("--diff", action="store_true", help="write nothing; show what would change")


def add_compile(to: argparse.ArgumentParser) -> None:
    add_program(to)
    to.add_argument("-o", "--out", metavar="FILE", help="output file, or - for stdout (default: stdout)")
    stages = "; ".join(f"{name}: {text}" for name, text in EMITS.items())
    to.add_argument("--emit", choices=list(EMITS), default="graph", help=stages)
    to.add_argument("--force", action="store_true", help="overwrite an existing file")


def add_ledger(to: argparse.ArgumentParser) -> None:
    add_program(to)
    to.add_argument(
        "part",
        nargs="?",
        metavar="PART",
        help="a part, or one of its ports, such as door or lid.seat (default: all parts)",
    )


def add_explain(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "code", nargs="?", metavar="CODE", help="an error code, such as missing-unit (default: list all codes)"
    )


def add_lsp(to: argparse.ArgumentParser) -> None:
    to.add_argument("--stdio", action="store_true", help="speak over standard input and output, as it always does")


def add_cache(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "action",
        nargs="?",
        choices=("show", "clear"),
        default="show",
        help="show location and size (default), or clear",
    )
