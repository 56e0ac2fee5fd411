"""The options of the commands for real objects."""

from __future__ import annotations

import argparse

from ..arguments import folder, positive, whole
from .shared import add_drawing, add_program, add_real, add_sharing, add_unchecked


def add_fit(to: argparse.ArgumentParser) -> None:
    add_program(to)
    to.add_argument("-o", "--out", type=folder, default="fitted", metavar="DIR", help="output folder (default: fitted)")
    add_real(to)
    to.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help='what is known of all files, such as leaves=2, grip="LeverHandle | DoorKnob" or width="80cm .. 1m"',
    )
    to.add_argument(
        "--facts", metavar="FILE", help='what is known of each, by its name: a JSON file, {"door_03": {"leaves": 2}}'
    )
    to.add_argument("--seed", type=whole, metavar="N", help="random seed (default: 0)")
    add_unchecked(to)
    to.add_argument(
        "--at-rest", action="store_true", help="leave all joints at rest (default: move them if nothing fits at rest)"
    )
    to.add_argument("--plain", action="store_true", help="draw no pictures")
    to.add_argument("--json", action="store_true", help="print the summary as JSON")
    to.add_argument("--force", action="store_true", help="fit everything again, and drop fits of other files")
    add_sharing(to)


def add_bind(to: argparse.ArgumentParser) -> None:
    to.add_argument("fitted", metavar="FITTED", help="a folder that `apgc fit` has written")
    to.add_argument(
        "files", nargs="*", metavar="REAL", help="the files that were fitted, or folders of them, if they have moved"
    )
    to.add_argument("-o", "--out", type=folder, default="bound", metavar="DIR", help="output folder (default: bound)")
    to.add_argument(
        "--points",
        type=positive,
        default=8192,
        metavar="N",
        help="number of points of each surface to assign (default: 8192)",
    )
    to.add_argument(
        "--assignment",
        choices=("mutual", "both", "project", "aware", "transport", "nearest"),
        default="mutual",
        help="how points of the two surfaces are assigned; nearest is Eq. 2 of the paper (default: mutual)",
    )
    to.add_argument(
        "--visible", action="store_true", help="do not complete hidden surface by the symmetries of its primitive"
    )
    to.add_argument("--json", action="store_true", help="print the summary as JSON")
    to.add_argument("--force", action="store_true", help="bind everything again, and drop details of other files")
    add_sharing(to)


def add_compare(to: argparse.ArgumentParser) -> None:
    add_program(to)
    add_drawing(to, 200)
    add_real(to)
    to.add_argument("--json", action="store_true", help="print the figures as JSON")
    to.add_argument(
        "--prior-out", metavar="FILE", help="with --map: write a prior with the shares of parts in the real objects"
    )
    to.add_argument("--force", action="store_true", help="overwrite an existing prior")
