"""The options of the commands for folders of objects."""

from __future__ import annotations

import argparse

from ..arguments import amount, folder, fraction, numbers, positive, whole
from .shared import (
    add_backend,
    add_bareness,
    add_bounding,
    add_checking,
    add_clothes,
    add_details,
    add_dividing,
    add_drawing,
    add_meshes,
    add_sharing,
    add_source,
)


def add_export(to: argparse.ArgumentParser) -> None:
    from ...export.registry import object_formats  # start-up
    from ...layouts.registry import LAYOUTS  # start-up

    add_source(to)
    add_drawing(to, 10)
    to.add_argument(
        "-o", "--out", type=folder, metavar="DIR", help="output folder (default: the folder of samples, or out)"
    )
    to.add_argument(
        "--format",
        metavar="LIST",
        required=True,
        help=f"formats, separated by commas: {', '.join(object_formats())}; or one layout: {', '.join(LAYOUTS)}",
    )
    add_clothes(to)
    to.add_argument(
        "--split", metavar="N,N,N", help="with a layout: proportions of train, val and test (default: 8,1,1)"
    )
    to.add_argument(
        "--map",
        metavar="FILE",
        help="with a layout: a JSON file that translates a category and its words into the vocabulary of the layout",
    )
    add_meshes(to)
    add_bareness(to)
    to.add_argument("--force", action="store_true", help="overwrite existing files")
    add_sharing(to)
    add_bounding(to)


def add_layout(to: argparse.ArgumentParser) -> None:
    to.add_argument("folder", metavar="DIR", help="a folder that `apgc export` has written in a layout")


def add_mutate(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "folder",
        nargs="?",
        metavar="DIR",
        help="a folder of samples; with --params, a shipped category or an .apg file",
    )
    to.add_argument(
        "--ops",
        metavar="LIST",
        help="operations, always applied in this order: apa (swap templates), dpa (change counts), cpa (perturb parameters); default: all",
    )
    to.add_argument("-n", "--number", type=positive, metavar="N", help="number of mutants per object (default: 1)")
    to.add_argument(
        "-o", "--out", type=folder, default="mutants", metavar="DIR", help="output folder (default: mutants)"
    )
    to.add_argument(
        "--parts",
        metavar="LIST",
        help="what may change, separated by commas: parts, values or patterns, such as door,handle*",
    )
    to.add_argument("--strength", type=amount, metavar="X", help="scale of the steps of cpa (default: 1)")
    to.add_argument(
        "--share", type=fraction, metavar="X", help="share of the templates and counts that change (default: 0.5)"
    )
    to.add_argument(
        "--one",
        metavar="NAME",
        help="write groups that differ only in this value: each object, followed by its mutants",
    )
    to.add_argument("--variant", type=whole, metavar="K", help="number of the first mutant of each object (default: 0)")
    to.add_argument(
        "--distinct",
        action="store_true",
        help="leave out mutants that are nearly the same as another one of their original",
    )
    add_details(
        to, "apply the details of the originals that `apgc bind` has stored in this folder to points and meshes"
    )
    to.add_argument("--only", type=numbers, metavar="NUMBERS", help="originals by number, such as 37 or 37,40..45")
    to.add_argument("--params", metavar="FILE", help="read the originals from a JSON file of values")
    to.add_argument(
        "--replay", metavar="FILE", help="repeat the mutations recorded in a trace-*.jsonl file, or in a folder of them"
    )
    to.add_argument("--diff", nargs=2, metavar=("A", "B"), help="show how two folders or two traces differ")
    to.add_argument("--all", action="store_true", help="with --diff: show every difference")
    to.add_argument(
        "--points", type=positive, metavar="N", help="number of points per object (default: as in the originals)"
    )
    to.add_argument("--format", metavar="LIST", help="formats, separated by commas (default: those of the originals)")
    add_checking(to)
    to.add_argument("--force", action="store_true", help="replace mutants that were made with other options")
    add_backend(to)
    add_dividing(to)
