"""The options of every command, in one place, so that ``--help`` loads nothing else."""

from __future__ import annotations

import argparse

from .arguments import amount, folder, fraction, numbers, picture, positive, random_states, whole
from .real import add_bind, add_fit
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
    add_program,
    add_real,
    add_sharing,
    add_source,
    add_unchecked,
)

_MESHES = 60  # objects of a report whose meshes are looked at
EMITS = {
    "graph": "the constraint graph (default); `apgc sample` reads it from an .apgc file",
    "ast": "the syntax tree",
    "typed": "declarations with their types, and what each name stands for",
    "plan": "the order of evaluation",
    "python": "a Python module that samples the tables with NumPy alone",
}


def _add_check(to: argparse.ArgumentParser) -> None:
    to.add_argument("files", nargs="+", metavar="NAME|FILE", help="shipped categories or .apg files")
    shape = to.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="print the findings as JSON")
    shape.add_argument("--sarif", action="store_true", help="print the findings as SARIF, for editors and code hosts")
    to.add_argument("--strict", action="store_true", help="exit with code 1 for warnings, too, as a gate of CI")


def _add_watch(to: argparse.ArgumentParser) -> None:
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


def _add_fmt(to: argparse.ArgumentParser) -> None:
    to.add_argument("files", nargs="+", metavar="FILE", help="an .apg file, or - to read stdin and write stdout")
    to.add_argument(
        "--check",
        action="store_true",
        help="write nothing; list the files that would change, and exit with 1 if there are any",
    )
    to.add_argument("--diff", action="store_true", help="write nothing; show what would change")


def _add_new(to: argparse.ArgumentParser) -> None:
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


def _add_compile(to: argparse.ArgumentParser) -> None:
    add_program(to)
    to.add_argument("-o", "--out", metavar="FILE", help="output file, or - for stdout (default: stdout)")
    stages = "; ".join(f"{name}: {text}" for name, text in EMITS.items())
    to.add_argument("--emit", choices=list(EMITS), default="graph", help=stages)
    to.add_argument("--force", action="store_true", help="overwrite an existing file")


def _add_sample(to: argparse.ArgumentParser) -> None:
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
    from ..export.registry import FORMATS, OTHERS  # start-up: other commands write no formats

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


def _add_export(to: argparse.ArgumentParser) -> None:
    from ..export.registry import object_formats  # start-up
    from ..layouts.registry import LAYOUTS  # start-up

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


def _add_mutate(to: argparse.ArgumentParser) -> None:
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


def _add_render(to: argparse.ArgumentParser) -> None:
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


def _add_explain(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "code", nargs="?", metavar="CODE", help="an error code, such as missing-unit (default: list all codes)"
    )


def _add_validate(to: argparse.ArgumentParser) -> None:
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


def _add_report(to: argparse.ArgumentParser) -> None:
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


def _add_ledger(to: argparse.ArgumentParser) -> None:
    add_program(to)
    to.add_argument(
        "part",
        nargs="?",
        metavar="PART",
        help="a part, or one of its ports, such as door or lid.seat (default: all parts)",
    )


# ---------------------------------------------------------------- shared


def _add_profile(to: argparse.ArgumentParser) -> None:
    add_program(to)
    add_drawing(to, 16)
    to.add_argument("--json", action="store_true", help="print the figures as JSON")


def _add_cache(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "action",
        nargs="?",
        choices=("show", "clear"),
        default="show",
        help="show location and size (default), or clear",
    )


def _add_compare(to: argparse.ArgumentParser) -> None:
    add_program(to)
    add_drawing(to, 200)
    add_real(to)
    to.add_argument("--json", action="store_true", help="print the figures as JSON")
    to.add_argument(
        "--prior-out", metavar="FILE", help="with --map: write a prior with the shares of parts in the real objects"
    )
    to.add_argument("--force", action="store_true", help="overwrite an existing prior")


def _add_lsp(to: argparse.ArgumentParser) -> None:
    to.add_argument("--stdio", action="store_true", help="speak over standard input and output, as it always does")


def _add_layout(to: argparse.ArgumentParser) -> None:
    to.add_argument("folder", metavar="DIR", help="a folder that `apgc export` has written in a layout")


COMMANDS = {
    "new": ("create a category to start from", _add_new),
    "check": ("check programs for errors", _add_check),
    "watch": ("check a program whenever it is saved, and draw it", _add_watch),
    "lsp": ("serve an editor: findings, hover, completion", _add_lsp),
    "fmt": ("format programs", _add_fmt),
    "compile": ("compile a program, and show one of its stages", _add_compile),
    "sample": ("generate annotated objects", _add_sample),
    "export": ("write objects in other formats", _add_export),
    "layout": ("check a folder in a layout against the model", _add_layout),
    "mutate": ("make mutants of the objects in a folder", _add_mutate),
    "render": ("draw a contact sheet of samples", _add_render),
    "validate": ("report which links collide or block one another", _add_validate),
    "report": ("measure the quality of a category over many samples", _add_report),
    "ledger": ("show what determines each value of a part", _add_ledger),
    "profile": ("show where the time goes, by stage and by part", _add_profile),
    "fit": ("find the objects that are closest to real ones", add_fit),
    "bind": ("store the surfaces of real objects as details of the objects fitted to them", add_bind),
    "compare": ("compare samples of a category with real objects", _add_compare),
    "explain": ("explain an error code", _add_explain),
    "categories": ("list the shipped categories", None),
    "cache": ("show or clear the cache", _add_cache),
}
"""What each command does, and what adds its options; the module of its name runs it."""
