"""``apgc``: the command line. Each command lives in a module of its own, loaded only when it is called."""

from __future__ import annotations

import argparse
import importlib
import os
import re
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from typing import NoReturn

from ..export.registry import FORMATS, per_object
from .arguments import amount, folder, fraction, numbers, part, picture, place, positive, tolerance, whole, workers
from .messages import error, findings, say

OK, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
EMITS = {
    "graph": "the constraint graph (default); `apgc sample` reads it from an .apgc file",
    "ast": "the syntax tree",
    "typed": "declarations with their types",
    "plan": "the order of evaluation",
    "python": "a Python module that samples the tables with NumPy alone",
}
DESCRIPTION = "Compile structure programs of articulated objects (.apg) and sample annotated objects from them."
EPILOG = "apgc COMMAND --help lists the options of a command. Exit codes: 0 success, 1 errors in a program or in data, 2 wrong usage."


class Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from ..version import __version__

        print(f"apgc {__version__}")
        parser.exit()


class Parser(argparse.ArgumentParser):
    """Errors as those of the commands: what is wrong, and what to try, without pages of usage."""

    commands: dict[str, Parser]

    def error(self, message: str) -> NoReturn:
        from ..diagnostics.suggest import did_you_mean

        hint = f"{self.prog} --help lists the options"
        choice = re.search(r"invalid choice: '(.*)' \(choose from (.*)\)", message)
        if choice is not None:
            known = [name.strip(" '") for name in choice.group(2).split(",")]
            hint = did_you_mean(choice.group(1), known) or f"there are {', '.join(known)}"
            where = message.partition(":")[0].removeprefix("argument ")
            message = f"there is no {'command' if where == 'COMMAND' else where} `{choice.group(1)}`"
        error(message, hint)
        self.exit(USAGE)

    def parse(self, arguments: Sequence[str] | None) -> argparse.Namespace:
        """The options; leaves with what resembles an option that no command knows."""
        options, unknown = self.parse_known_args(arguments)
        if unknown:
            command = self.commands[options.command]
            close = get_close_matches(unknown[0], re.findall(r"--?[a-z]+", command.format_usage()), n=1)
            if close:
                error(f"apgc {options.command} has no option {unknown[0]}", f"did you mean {close[0]}?")
                self.exit(USAGE)
            command.error(f"unexpected argument {unknown[0]}")
        return options


def parser() -> Parser:
    top = Parser("apgc", description=DESCRIPTION, epilog=EPILOG, allow_abbrev=False)
    top.add_argument("--version", action=Version, nargs=0, help="print the version and exit")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    top.commands = commands.choices

    def command(name: str, help: str) -> argparse.ArgumentParser:
        return commands.add_parser(name, help=help, description=help[0].upper() + help[1:] + ".", allow_abbrev=False)

    check = command("check", "check programs for errors")
    check.add_argument("files", nargs="+", metavar="FILE", help="an .apg file, or the name of a shipped category")
    shape = check.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="print the findings as JSON")
    shape.add_argument("--sarif", action="store_true", help="print the findings as SARIF, for editors and code hosts")

    fmt = command("fmt", "format programs")
    fmt.add_argument("files", nargs="+", metavar="FILE", help="an .apg file, or - to read stdin and write stdout")
    fmt.add_argument(
        "--check",
        action="store_true",
        help="write nothing; list the files that would change, and exit with 1 if there are any",
    )
    fmt.add_argument("--diff", action="store_true", help="write nothing; show what would change")

    new = command("new", "create a category to start from")
    new.add_argument("name", metavar="NAME", help="name of the category, such as DeskLamp")
    new.add_argument(
        "-o",
        "--out",
        type=place,
        metavar="FILE",
        help="output file, or - for stdout (default: desk_lamp.apg for DeskLamp)",
    )
    new.add_argument("--force", action="store_true", help="overwrite an existing file")

    compile_ = command("compile", "compile a program, and show one of its stages")
    _program(compile_)
    compile_.add_argument(
        "-o", "--out", type=place, metavar="FILE", help="output file, or - for stdout (default: stdout)"
    )
    stages = "; ".join(f"{name}: {text}" for name, text in EMITS.items())
    compile_.add_argument("--emit", choices=list(EMITS), default="graph", help=stages)

    sample = command("sample", "generate annotated objects")
    _program(sample)
    _drawing(sample, 10)
    sample.add_argument("-o", "--out", type=folder, default="out", metavar="DIR", help="output folder (default: out)")
    sample.add_argument(
        "--points",
        type=positive,
        default=2048,
        metavar="N",
        help="number of points per object, or of what --per names (default: 2048)",
    )
    sample.add_argument(
        "--surface", choices=("boundary", "outside"), default="boundary",
        help="where points lie: boundary, on the union of all primitives (default); outside, on what is visible of it with all joints at 0",
    )  # fmt: skip
    sample.add_argument(
        "--spread",
        choices=("random", "blue"),
        default="random",
        help="how points are spread: random (default), or blue, which keeps them apart",
    )
    sample.add_argument(
        "--per", choices=("object", "semantic", "instance", "link", "primitive"), default="object",
        help="what each set of N points covers: an object (default), a semantic class, a part instance, a link or a primitive",
    )  # fmt: skip
    sample.add_argument(
        "--balance", choices=("semantic", "instance", "link", "primitive"),
        help="divide the N points of an object evenly among its semantic classes, part instances, links or primitives",
    )  # fmt: skip
    sample.add_argument(
        "--weights",
        metavar="LIST",
        help="with --balance: divide by these weights instead, such as handle=3,knob=2 (all others 1)",
    )
    sample.add_argument(
        "--format",
        metavar="LIST",
        help=f"formats, separated by commas: {', '.join(FORMATS)} (default: points,annotation)",
    )
    sample.add_argument(
        "--states",
        default="rest",
        metavar="LIST",
        help="joint states, separated by commas: rest, open, random:K, joint=45deg (default: rest)",
    )
    sample.add_argument(
        "--motion",
        action="store_true",
        help="add the velocities of each point, by its own joint and by every joint that drives it",
    )
    sample.add_argument(
        "--gripper", default="standard", metavar="LIST",
        help="gripper that grasps are made for: standard (default), any, or sizes such as stroke=8cm,width=2cm",
    )  # fmt: skip
    sample.add_argument(
        "--views",
        metavar="N|FILE",
        help="add images and partial point clouds: the number of cameras, or a file that describes them",
    )
    sample.add_argument(
        "--mutate",
        metavar="LIST",
        help="write mutants of the objects instead: apa (swap templates), dpa (change counts), cpa (perturb parameters)",
    )
    sample.add_argument(
        "--variant", type=whole, metavar="K", help="with --mutate: make another mutant of each object (default: 0)"
    )
    _meshes(sample)
    sample.add_argument(
        "--sampling", default="sequential", metavar="HOW",
        help="sequential (default), or prior: resample to the declared distributions; prior:N considers N attempts per object (default: 32)",
    )  # fmt: skip
    sample.add_argument(
        "--params",
        metavar="FILE",
        help="read objects from a JSON file of values; those that are not valid are repaired",
    )
    sample.add_argument(
        "--repair",
        action="store_true",
        help="repair invalid objects with the least change instead of drawing them again",
    )
    sample.add_argument("--unchecked", action="store_true", help="accept objects whose links collide")
    sample.add_argument(
        "--stats", action="store_true", help="print how many objects were valid on the first attempt, and what failed"
    )
    sample.add_argument("--force", action="store_true", help="replace samples that were made with other options")
    _sharing(sample)
    sample.add_argument(
        "--shard", type=part, default=(1, 1), metavar="K/N", help="write only the K-th of N parts, to divide the work"
    )

    export = command("export", "write objects in other formats")
    export.add_argument(
        "program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file"
    )
    _drawing(export, 10)
    export.add_argument(
        "-o",
        "--out",
        type=folder,
        metavar="DIR",
        help="output folder (default: the folder of samples, or out)",
    )
    export.add_argument(
        "--format", metavar="LIST", required=True, help=f"formats, separated by commas: {', '.join(per_object())}"
    )
    _meshes(export)
    export.add_argument("--force", action="store_true", help="overwrite existing files")
    _sharing(export)

    mutate = command("mutate", "make mutants of the objects in a folder")
    mutate.add_argument(
        "folder",
        nargs="?",
        metavar="DIR",
        help="a folder of samples; with --params, a shipped category or an .apg file",
    )
    mutate.add_argument(
        "--ops", default="apa,dpa,cpa", metavar="LIST",
        help="operations, always applied in this order: apa (swap templates), dpa (change counts), cpa (perturb parameters) (default: all)",
    )  # fmt: skip
    mutate.add_argument("-n", "--number", type=positive, metavar="N", help="number of mutants per object (default: 1)")
    mutate.add_argument(
        "-o", "--out", type=folder, default="mutants", metavar="DIR", help="output folder (default: mutants)"
    )
    mutate.add_argument(
        "--parts",
        default="*",
        metavar="LIST",
        help="what may change, separated by commas: parts, values or patterns, such as door,handle*",
    )
    mutate.add_argument(
        "--strength", type=amount, default=1.0, metavar="X", help="scale of the steps of cpa (default: 1)"
    )
    mutate.add_argument(
        "--share",
        type=fraction,
        default=0.5,
        metavar="X",
        help="share of the templates and counts that change (default: 0.5)",
    )
    mutate.add_argument(
        "--one",
        metavar="NAME",
        help="write groups that differ in this value alone: each object, followed by its mutants",
    )
    mutate.add_argument("--variant", type=whole, default=0, metavar="K", help="make other mutants (default: 0)")
    mutate.add_argument("--only", type=numbers, metavar="NUMBERS", help="originals by number, such as 37 or 37,40..45")
    mutate.add_argument("--params", metavar="FILE", help="read the originals from a JSON file of values")
    mutate.add_argument(
        "--replay", metavar="FILE", help="repeat the mutations recorded in a trace-*.jsonl file, or in a folder of them"
    )
    mutate.add_argument("--diff", nargs=2, metavar=("A", "B"), help="show how two folders or two traces differ")
    mutate.add_argument("--all", action="store_true", help="with --diff: show every difference")
    mutate.add_argument(
        "--points", type=positive, metavar="N", help="number of points per object (default: as in the originals)"
    )
    mutate.add_argument(
        "--format", metavar="LIST", help="formats, separated by commas (default: those of the originals)"
    )
    mutate.add_argument("--unchecked", action="store_true", help="accept objects whose links collide")
    mutate.add_argument(
        "--stats", action="store_true", help="print how many objects were valid on the first attempt, and what failed"
    )
    mutate.add_argument("--force", action="store_true", help="replace mutants that were made with other options")
    _sharing(mutate)
    mutate.add_argument(
        "--shard", type=part, default=(1, 1), metavar="K/N", help="write only the K-th of N parts, to divide the work"
    )

    render = command("render", "draw a contact sheet of samples")
    render.add_argument(
        "program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file"
    )
    _drawing(render, 30)
    render.add_argument(
        "-o", "--out", type=picture, default="sheet.png", metavar="FILE", help="output file (default: sheet.png)"
    )
    render.add_argument(
        "--colour",
        "--color",
        choices=("part", "material", "affordance"),
        default="part",
        help="what the colours show (default: part)",
    )
    render.add_argument(
        "--open", action="store_true", help="open the joints of all objects (default: of every other one)"
    )
    render.add_argument(
        "--view",
        metavar="VIEW",
        help="viewpoint: front, back, left, right, top, iso, or AZIMUTH,ELEVATION in degrees, as in --view=-120,30",
    )
    render.add_argument(
        "--tile", type=positive, default=256, metavar="PIXELS", help="width of each object (default: 256)"
    )
    _meshes(render, steps=64)

    explain = command("explain", "explain an error code")
    explain.add_argument("code", nargs="?", metavar="CODE", help="such as missing-unit (default: list all codes)")

    command("categories", "list the shipped categories")

    validate = command("validate", "report which links collide or block one another")
    validate.add_argument(
        "program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file"
    )
    _drawing(validate, 200)
    validate.add_argument(
        "--states",
        type=positive,
        default=64,
        metavar="N",
        help="number of random joint states per object (default: 64)",
    )
    validate.add_argument(
        "--meshes", action="store_true", help="check the visible meshes as well, in as many states (needs manifold3d)"
    )
    validate.add_argument("--json", action="store_true", help="print the evidence as JSON")

    report = command("report", "measure the quality of a category over many samples")
    report.add_argument("programs", nargs="*", metavar="NAME|FILE", help="shipped categories or .apg files")
    report.add_argument("--all", action="store_true", help="all shipped categories")
    _drawing(report, 1000)
    shape = report.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="print the figures as JSON")
    shape.add_argument("--markdown", action="store_true", help="print a table with a row per category")
    report.add_argument(
        "--html",
        type=place,
        metavar="FILE",
        help="also write an HTML page with a picture; - prints the page alone",
    )
    report.add_argument(
        "--reference", metavar="FILE", help="file of real sizes to compare with (default: the shipped one)"
    )
    report.add_argument(
        "--unchecked", action="store_true", help="count objects whose links collide as valid, which is faster"
    )
    report.add_argument("--strict", action="store_true", help="exit with 1 if a goal is not met")
    report.add_argument("--force", action="store_true", help="overwrite the page")
    _sharing(report)

    ledger = command("ledger", "show what determines each value of a part")
    _program(ledger)
    ledger.add_argument("part", nargs="?", metavar="PART", help="such as door (default: all parts)")
    return top


def _program(to: argparse.ArgumentParser) -> None:
    to.add_argument("program", metavar="NAME|FILE", help="a shipped category or an .apg file")


def _meshes(to: argparse.ArgumentParser, steps: int = 24) -> None:
    to.add_argument(
        "--tolerance", type=tolerance, metavar="LENGTH",
        help=f"how far meshes may deviate from the true surfaces, such as 0.5mm (default: {steps} steps per full turn)",
    )  # fmt: skip
    to.add_argument(
        "--triangles",
        type=positive,
        metavar="N",
        help="maximum number of triangles per object, distributed by curvature",
    )


def _sharing(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--workers", type=workers, default=1, metavar="N",
        help="number of processes, or auto for one per processor (default: 1)",
    )  # fmt: skip


def _drawing(to: argparse.ArgumentParser, n: int) -> None:
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
    to.set_defaults(default_number=n)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code."""
    from ..errors import UsageError, UserError

    try:
        options = parser().parse(arguments)
    except SystemExit as stop:  # help was asked for, or the parser has said what is wrong
        return int(stop.code or 0)
    try:
        code = importlib.import_module(f".{options.command}", __package__).run(options)
        sys.stdout.flush()
        return code
    except UserError as wrong:
        error(wrong.message, wrong.hint)
        return USAGE if isinstance(wrong, UsageError) else FAILED
    except KeyboardInterrupt:
        say("\ninterrupted: no file is left incomplete; run the same command again to finish")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has seen enough
        drop_output()
        return OK
    except ModuleNotFoundError as wrong:
        package = (wrong.name or "").partition(".")[0]
        if package in ("", "artipg_dsl"):
            raise
        error(f"the package {package} is not installed", "pip install artipg_dsl installs it")
        return FAILED
    except OSError as wrong:  # files are told of where they are written: what is left is the output itself
        drop_output()
        error(f"cannot write {wrong.filename or 'the output'}: {wrong.strerror or wrong}", None)
        return FAILED
    except RecursionError:
        error("the program is nested too deeply", "split it into templates")
        return FAILED
    except Exception as wrong:
        from ..diagnostics import CompileError

        if isinstance(wrong, CompileError):
            findings(wrong.report.diagnostics, sys.stderr)
            return FAILED
        raise


def drop_output() -> None:
    """What is still buffered for stdout goes nowhere: it cannot be written."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
