"""The options of the commands for pictures and figures of a category."""

from __future__ import annotations

import argparse

from ..arguments import picture, positive, random_states
from .shared import add_clothes, add_drawing, add_meshes, add_program, add_sharing, add_source, add_unchecked

_MESHES = 60  # objects of a report whose meshes are looked at


def add_render(to: argparse.ArgumentParser) -> None:
    add_source(to)
    add_drawing(to, 30)
    add_unchecked(to)
    to.add_argument(
        "-o", "--out", type=picture, default="sheet.png", metavar="FILE", help="output file (default: sheet.png)"
    )
    to.add_argument(
        "--colour",
        "--color",
        choices=("part", "material", "affordance"),
        default="part",
        help="what the colours show (default: part)",
    )
    to.add_argument(
        "--open", action="store_true", help="open the joints of all objects (default: of every other object)"
    )
    to.add_argument(
        "--view",
        metavar="VIEW",
        help="viewpoint: front, back, left, right, top, iso, or AZIMUTH,ELEVATION in degrees, as in --view=-120,30",
    )
    to.add_argument(
        "--tile", type=positive, default=256, metavar="PIXELS", help="width of each object in pixels (default: 256)"
    )
    add_clothes(to)
    add_meshes(to, "as fine as the pixels")
    add_sharing(to)
    to.add_argument("--force", action="store_true", help="overwrite an existing file")


def add_validate(to: argparse.ArgumentParser) -> None:
    add_source(to)
    add_drawing(to, 200)
    add_sharing(to)
    to.add_argument(
        "--states",
        type=random_states,
        default=64,
        metavar="random:K",
        help="number of random joint states in which to check each object, besides rest and each joint alone (default: random:64)",
    )
    to.add_argument(
        "--meshes",
        action="store_true",
        help="also check the visible meshes, in the same number of states (needs manifold3d)",
    )
    to.add_argument("--json", action="store_true", help="print the evidence as JSON")


def add_report(to: argparse.ArgumentParser) -> None:
    to.add_argument("programs", nargs="*", metavar="NAME|FILE", help="shipped categories or .apg files")
    to.add_argument("--all", action="store_true", help="report on all shipped categories")
    add_drawing(to, 1000)
    shape = to.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="print the figures as JSON")
    shape.add_argument("--markdown", action="store_true", help="print a table with a row per category")
    to.add_argument("--html", metavar="FILE", help="also write an HTML page with a picture; - prints the page alone")
    to.add_argument("--reference", metavar="FILE", help="file of real sizes to compare with (default: the shipped one)")
    to.add_argument(
        "--unchecked", action="store_true", help="count objects whose links collide as valid, which is faster"
    )
    to.add_argument(
        "--meshes",
        type=positive,
        nargs="?",
        const=_MESHES,
        metavar="N",
        help=f"check the visible meshes of the first N objects too (default: {_MESHES}), in as many states as `apgc validate --meshes`",
    )
    to.add_argument("--strict", action="store_true", help="exit with 1 if a goal is not met")
    to.add_argument("--force", action="store_true", help="overwrite an existing page")
    add_sharing(to)


def add_profile(to: argparse.ArgumentParser) -> None:
    add_program(to)
    add_drawing(to, 16)
    to.add_argument("--json", action="store_true", help="print the figures as JSON")
