"""The options of `apgc sample`, by what they say."""

from __future__ import annotations

import argparse

from ..arguments import folder, positive, whole
from .shared import add_bareness, add_checking, add_details, add_dividing, add_drawing, add_meshes, add_source


def add_sample(to: argparse.ArgumentParser) -> None:
    add_source(to)
    add_drawing(to, 10)
    to.add_argument("-o", "--out", type=folder, default="out", metavar="DIR", help="output folder (default: out)")
    _add_points(to)
    _add_formats(to)
    _add_labels(to)
    _add_mutants(to)
    add_details(to, "apply the details of real objects that `apgc bind` has stored in this folder to points and meshes")
    add_meshes(to)
    add_bareness(to)
    _add_laws(to)
    add_checking(to)
    to.add_argument("--force", action="store_true", help="replace samples that were made with other options")
    add_dividing(to)


def _add_points(to: argparse.ArgumentParser) -> None:
    """How many points there are, and where."""
    to.add_argument(
        "--points",
        type=positive,
        default=2048,
        metavar="N",
        help="number of points per object, or with --per per link, part, ... (default: 2048)",
    )
    to.add_argument(
        "--surface",
        choices=("boundary", "outside"),
        default="boundary",
        help="where points lie: boundary, the surface of the union of primitives (default); "
        "outside, what is visible of it with all joints at 0",
    )
    to.add_argument(
        "--spread",
        choices=("random", "blue"),
        default="random",
        help="how points are spread: random (default), or blue, which keeps them apart",
    )
    to.add_argument(
        "--per",
        choices=("object", "semantic", "instance", "link", "primitive"),
        default="object",
        help="what each set of N points covers: an object (default), a semantic class, a part instance, a link or a primitive",
    )
    to.add_argument(
        "--balance",
        choices=("semantic", "instance", "link", "primitive"),
        help="divide the N points of an object evenly among its semantic classes, part instances, links or primitives",
    )
    to.add_argument(
        "--weights",
        metavar="LIST",
        help="with --balance: divide by these weights instead, such as handle=3,knob=2 (default: 1)",
    )


def _add_formats(to: argparse.ArgumentParser) -> None:
    from ...export.registry import FORMATS, OTHERS  # start-up: other commands write no formats

    to.add_argument(
        "--format",
        metavar="LIST",
        help=f"formats, separated by commas: {', '.join(n for n in FORMATS if '.' not in n)} (default: points,annotation); "
        f"shards of arrays can be written in another container: points.{', points.'.join(OTHERS)}",
    )
    to.add_argument(
        "--tables",
        action="store_true",
        help="write the drawn values of the objects instead of points and annotations (with --format: in addition)",
    )


def _add_labels(to: argparse.ArgumentParser) -> None:
    """What points and annotations tell besides, and how objects stand."""
    to.add_argument(
        "--states",
        default="rest",
        metavar="LIST",
        help="joint states, separated by commas: rest, open, random:K, joint=45deg (default: rest)",
    )
    to.add_argument(
        "--motion",
        action="store_true",
        help="add the velocities of each point, by its own joint and by every joint that drives it",
    )
    to.add_argument(
        "--gripper",
        default="standard",
        metavar="LIST",
        help="gripper that must be able to execute the grasps: standard (default), any, or sizes such as stroke=8cm,width=2cm",
    )
    to.add_argument(
        "--views",
        metavar="N|FILE",
        help="add images and partial point clouds: the number of cameras, or a file that describes them",
    )


def _add_mutants(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--mutate",
        metavar="LIST",
        help="write mutants of the objects instead: apa (swap templates), dpa (change counts), cpa (perturb parameters)",
    )
    to.add_argument(
        "--variant", type=whole, metavar="K", help="with --mutate: number of the mutant of each object (default: 0)"
    )


def _add_laws(to: argparse.ArgumentParser) -> None:
    """Where the values of objects come from, and what becomes of those that are not valid."""
    to.add_argument(
        "--sampling",
        default="sequential",
        metavar="HOW",
        help="sequential (default), or prior: resample to the declared distributions; prior:N considers N attempts per object (default: 32)",
    )
    to.add_argument(
        "--params", metavar="FILE", help="read objects from a JSON file of values; invalid ones are repaired"
    )
    to.add_argument(
        "--repair",
        action="store_true",
        help="repair invalid objects with the least change instead of drawing them again",
    )
