"""Options that several commands share, under one name and with one meaning."""

from __future__ import annotations

import argparse

from ..arguments import fraction, memory, numbers, part, positive, tolerance, whole, workers


def add_program(to: argparse.ArgumentParser) -> None:
    to.add_argument("program", metavar="NAME|FILE", help="a shipped category or an .apg file")


def add_meshes(to: argparse.ArgumentParser, unless: str = "24 steps per full turn") -> None:
    to.add_argument(
        "--tolerance",
        type=tolerance,
        metavar="LENGTH",
        help=f"how far meshes may deviate from the true surfaces, such as 0.5mm (default: {unless})",
    )
    to.add_argument(
        "--triangles",
        type=positive,
        metavar="N",
        help="maximum number of triangles per object, distributed by curvature",
    )


def add_bareness(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--no-meshes",
        action="store_true",
        help="write partnet-mobility without meshes, which is faster; meta.json records it",
    )


def add_sharing(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--workers",
        type=workers,
        default="auto",
        metavar="N",
        help="number of processes, or auto: start with one, and use one per processor for long work (default: auto)",
    )


def add_details(to: argparse.ArgumentParser, words: str) -> None:
    to.add_argument("--details", metavar="DIR", help=words)
    to.add_argument("--detail-strength", type=fraction, metavar="X", help="scale of the details, 0 to 1 (default: 1)")


def add_clothes(to: argparse.ArgumentParser) -> None:
    """Whether meshes of objects wear details."""
    add_details(
        to,
        "apply the details that `apgc bind` has stored in this folder to the meshes (default: those that the points wear)",
    )
    to.add_argument(
        "--bare",
        action="store_true",
        help="show the bare structure, without the details that the points of the folder wear",
    )


def add_bounding(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--memory",
        type=memory,
        metavar="SIZE",
        help="memory limit of all processes together, such as 512MB (default: 2GB, or half a gigabyte each if that is more)",
    )
    to.add_argument(
        "--cluster",
        default="",
        metavar="ADDRESS",
        help="distribute the work to the workers of a Dask scheduler, such as tcp://host:8786, or, with local, to --workers processes here",
    )


def add_drawing(to: argparse.ArgumentParser, n: int) -> None:
    which = to.add_mutually_exclusive_group()
    which.add_argument("-n", "--number", type=positive, metavar="N", help=f"number of objects (default: {n})")
    which.add_argument("--only", type=numbers, metavar="NUMBERS", help="objects by number, such as 37 or 37,40..45")
    to.add_argument("--seed", type=whole, metavar="N", help="random seed (default: 0)")
    to.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="fix a parameter, such as width=45cm or handle=BarHandle",
    )
    to.add_argument(
        "--prior",
        metavar="NAME|FILE",
        help="sample with other weights, shares of parts and narrower ranges: a JSON file, or a shipped prior such as partnet",
    )
    to.add_argument(
        "--frame",
        metavar="NAME|FILE",
        help="orient the objects as in another collection: a JSON file, a shipped frame such as partnet, or own",
    )
    to.set_defaults(default_number=n)
    add_backend(to)


def add_backend(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--backend",
        choices=("numpy", "c"),
        help="backend that evaluates formulas; both give the same bytes (default: c if there is a C compiler, and numpy until c is compiled)",
    )


def add_source(to: argparse.ArgumentParser) -> None:
    to.add_argument("program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file")


def add_dividing(to: argparse.ArgumentParser) -> None:
    add_sharing(to)
    add_bounding(to)
    to.add_argument(
        "--shard", type=part, default=(1, 1), metavar="K/N", help="write only the K-th of N parts, to divide the work"
    )


def add_unchecked(to: argparse.ArgumentParser) -> None:
    to.add_argument("--unchecked", action="store_true", help="accept objects whose links collide")


def add_checking(to: argparse.ArgumentParser) -> None:
    add_unchecked(to)
    to.add_argument(
        "--stats", action="store_true", help="print how many objects were valid on the first attempt, and what failed"
    )


def add_real(to: argparse.ArgumentParser) -> None:
    """Files of real objects, how they stand, and what their labels mean."""
    to.add_argument(
        "files", nargs="+", metavar="FILE|DIR", help="meshes, point clouds or URDF files, or folders of them"
    )
    axes = ("x", "-x", "y", "-y", "z", "-z")
    to.add_argument(
        "--up",
        choices=("auto", "any", *axes),
        default="auto",
        help="upward axis of the files; any: try all, which takes longer (default: y for glb, otherwise z)",
    )
    to.add_argument(
        "--front",
        choices=("auto", *axes),
        default="auto",
        help="axis that the front faces, such as --front=-y (default: try all horizontal axes)",
    )
    to.add_argument(
        "--unit",
        choices=("auto", "m", "cm", "mm", "in", "ft"),
        default="auto",
        help="unit of the files (default: m, unless the category's sizes suggest cm, mm or in)",
    )
    to.add_argument("--normalised", action="store_true", help="the files have no scale; determine it")
    to.add_argument(
        "--map",
        metavar="FILE",
        help="a JSON file that maps names of labels to words of semantic; labels are compared, and guide `apgc fit`",
    )
