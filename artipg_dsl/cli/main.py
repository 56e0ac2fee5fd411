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
    "graph": "the constraint graph, which `apgc sample` takes too, from an .apgc file (default)",
    "ast": "the syntax tree",
    "typed": "declarations with their types",
    "plan": "the order of evaluation",
    "python": "a module that samples the tables with NumPy alone",
}
DESCRIPTION = "Compile structure programs of articulated objects (.apg) and sample annotated objects from them."
EPILOG = "apgc COMMAND --help tells about a command. Exit codes: 0 done, 1 errors in a program or data, 2 wrong usage."


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

        hint = f"{self.prog} --help tells what it takes"
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
            command.error(f"{unknown[0]} means nothing here")
        return options


def parser() -> Parser:
    top = Parser("apgc", description=DESCRIPTION, epilog=EPILOG, allow_abbrev=False)
    top.add_argument("--version", action=Version, nargs=0, help="show the version and leave")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    top.commands = commands.choices

    def command(name: str, help: str) -> argparse.ArgumentParser:
        return commands.add_parser(name, help=help, description=help[0].upper() + help[1:] + ".", allow_abbrev=False)

    check = command("check", "find the errors in programs")
    check.add_argument("files", nargs="+", metavar="FILE", help="an .apg file, or the name of a shipped category")
    shape = check.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="findings as JSON")
    shape.add_argument("--sarif", action="store_true", help="findings as SARIF, for editors and code hosts")

    fmt = command("fmt", "lay out programs")
    fmt.add_argument("files", nargs="+", metavar="FILE", help="an .apg file, or - for stdin to stdout")
    fmt.add_argument(
        "--check", action="store_true", help="change nothing; name the files that would change, exit code 1"
    )
    fmt.add_argument("--diff", action="store_true", help="change nothing; show what would change")

    new = command("new", "write a category to start from")
    new.add_argument("name", metavar="NAME", help="what the category is called, such as DeskLamp")
    new.add_argument(
        "-o",
        "--out",
        type=place,
        metavar="FILE",
        help="the file, or - for stdout (default: desk_lamp.apg for DeskLamp)",
    )
    new.add_argument("--force", action="store_true", help="replace a file that exists")

    compile_ = command("compile", "compile a program and show it at one of its stages")
    _program(compile_)
    compile_.add_argument("-o", "--out", type=place, metavar="FILE", help="write to a file instead of stdout (-)")
    stages = "; ".join(f"{name}: {text}" for name, text in EMITS.items())
    compile_.add_argument("--emit", choices=list(EMITS), default="graph", help=stages)

    sample = command("sample", "make annotated objects")
    _program(sample)
    _drawing(sample, 10)
    sample.add_argument(
        "-o", "--out", type=folder, default="out", metavar="DIR", help="the folder for the samples (default: out)"
    )
    sample.add_argument("--points", type=positive, default=2048, metavar="N", help="points per object (default: 2048)")
    sample.add_argument(
        "--surface", choices=("boundary", "outside"), default="boundary",
        help="boundary: of the union of all primitives (default); outside: what of it can be seen with all joints at 0",
    )  # fmt: skip
    sample.add_argument(
        "--spread", choices=("random", "blue"), default="random", help="blue: points keep apart (default: random)"
    )
    sample.add_argument(
        "--per", choices=("object", "semantic", "instance", "link", "primitive"), default="object",
        help="what has N points: each object (default), class of parts, part instance, link or primitive",
    )  # fmt: skip
    sample.add_argument(
        "--balance", choices=("semantic", "instance", "link", "primitive"),
        help="share out the N points of an object evenly over its classes, part instances, links or primitives",
    )  # fmt: skip
    sample.add_argument(
        "--weights", metavar="LIST", help="with --balance: not evenly, but such as handle=3,knob=2 (others 1)"
    )
    sample.add_argument(
        "--format", metavar="LIST", help=f"{', '.join(FORMATS)}; with commas (default: points,annotation)"
    )
    sample.add_argument(
        "--states",
        default="rest",
        metavar="LIST",
        help="joint states: rest, open, random:K, joint=45deg, with commas (default: rest)",
    )
    sample.add_argument(
        "--motion",
        action="store_true",
        help="the velocities of each point by its own joint and by all that drive it, too",
    )
    sample.add_argument(
        "--gripper", default="standard", metavar="LIST",
        help="the hand that grasps are made with: any, or measures such as stroke=8cm,width=2cm (default: standard)",
    )  # fmt: skip
    sample.add_argument(
        "--views", metavar="N|FILE", help="partial views: how many, or a file that describes the cameras"
    )
    sample.add_argument(
        "--mutate", metavar="LIST", help="make mutants of the objects: apa (templates), dpa (counts), cpa (parameters)"
    )
    sample.add_argument("--variant", type=whole, metavar="K", help="another mutant of each (default: 0)")
    _meshes(sample)
    sample.add_argument(
        "--sampling", default="sequential", metavar="HOW",
        help="sequential (default), or prior: resampled to the declared distributions; prior:N among N attempts each (32)",
    )  # fmt: skip
    sample.add_argument(
        "--params", metavar="FILE", help="objects given by their values (JSON), repaired where they are not valid"
    )
    sample.add_argument(
        "--repair", action="store_true", help="put what fails right by the least change, instead of drawing it again"
    )
    sample.add_argument("--unchecked", action="store_true", help="take objects whose links collide, too")
    sample.add_argument("--stats", action="store_true", help="tell how many first attempts were valid, and what failed")
    sample.add_argument("--force", action="store_true", help="replace samples made with other options")
    _sharing(sample)
    sample.add_argument(
        "--shard", type=part, default=(1, 1), metavar="K/N", help="write the K-th of N parts, to share the work"
    )

    export = command("export", "write objects in other formats, or those of a folder of samples again")
    export.add_argument(
        "program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file"
    )
    _drawing(export, 10)
    export.add_argument(
        "-o",
        "--out",
        type=folder,
        metavar="DIR",
        help="the folder to write to (default: the folder of samples, or out)",
    )
    export.add_argument("--format", metavar="LIST", required=True, help=f"{', '.join(per_object())}; with commas")
    _meshes(export)
    export.add_argument("--force", action="store_true", help="replace what is there")
    _sharing(export)

    mutate = command("mutate", "make new objects from those of a folder")
    mutate.add_argument(
        "folder", nargs="?", metavar="DIR", help="a folder of samples; with --params a shipped category or an .apg file"
    )
    mutate.add_argument(
        "--ops", default="apa,dpa,cpa", metavar="LIST",
        help="apa (templates), dpa (counts), cpa (parameters), in this order (default: apa,dpa,cpa)",
    )  # fmt: skip
    mutate.add_argument("-n", "--number", type=positive, metavar="N", help="mutants of each object (default: 1)")
    mutate.add_argument(
        "-o", "--out", type=folder, default="mutants", metavar="DIR", help="the folder for them (default: mutants)"
    )
    mutate.add_argument(
        "--parts", default="*", metavar="LIST", help="what may be changed: parts, values, patterns: door,handle*"
    )
    mutate.add_argument(
        "--strength", type=amount, default=1.0, metavar="X", help="scales the steps of cpa (default: 1)"
    )
    mutate.add_argument(
        "--share",
        type=fraction,
        default=0.5,
        metavar="X",
        help="how many of the templates and counts change (default: 0.5)",
    )
    mutate.add_argument(
        "--one", metavar="NAME", help="pairs that differ in this value alone: each object, then its mutants"
    )
    mutate.add_argument("--variant", type=whole, default=0, metavar="K", help="other mutants (default: 0)")
    mutate.add_argument("--only", type=numbers, metavar="NUMBERS", help="originals by number: 37 or 37,40..45")
    mutate.add_argument("--params", metavar="FILE", help="originals given by their values (JSON)")
    mutate.add_argument("--replay", metavar="FILE", help="do again what a trace-*.jsonl, or a folder of them, says")
    mutate.add_argument("--diff", nargs=2, metavar=("A", "B"), help="tell what sets two folders or two traces apart")
    mutate.add_argument("--all", action="store_true", help="with --diff: every difference of an object")
    mutate.add_argument("--points", type=positive, metavar="N", help="points per object (default: as the originals)")
    mutate.add_argument("--format", metavar="LIST", help="the formats (default: those of the originals)")
    mutate.add_argument("--unchecked", action="store_true", help="take objects whose links collide, too")
    mutate.add_argument("--stats", action="store_true", help="tell how many first attempts were valid, and what failed")
    mutate.add_argument("--force", action="store_true", help="replace what was made with other options")
    _sharing(mutate)
    mutate.add_argument(
        "--shard", type=part, default=(1, 1), metavar="K/N", help="write the K-th of N parts, to share the work"
    )

    render = command("render", "draw a contact sheet of samples")
    render.add_argument(
        "program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file"
    )
    _drawing(render, 30)
    render.add_argument(
        "-o", "--out", type=picture, default="sheet.png", metavar="FILE", help="the picture (default: sheet.png)"
    )
    render.add_argument(
        "--colour",
        "--color",
        choices=("part", "material", "affordance"),
        default="part",
        help="what colours mean (default: part)",
    )
    render.add_argument("--open", action="store_true", help="open all joints; otherwise those of every other object")
    render.add_argument(
        "--view",
        metavar="VIEW",
        help="where one looks from: front, back, left, right, top, iso, or AZIMUTH,ELEVATION in degrees, as in --view=-120,30",
    )
    render.add_argument(
        "--tile", type=positive, default=256, metavar="PIXELS", help="width of one object (default: 256)"
    )
    _meshes(render, steps=64)

    explain = command("explain", "explain an error code")
    explain.add_argument("code", nargs="?", metavar="CODE", help="such as missing-unit; without it, all codes")

    command("categories", "list the shipped categories")

    validate = command("validate", "tell which links of objects collide or block one another")
    validate.add_argument(
        "program", metavar="DIR|NAME|FILE", help="a folder of samples, a shipped category or an .apg file"
    )
    _drawing(validate, 200)
    validate.add_argument(
        "--states", type=positive, default=64, metavar="N", help="random configurations per object (default: 64)"
    )
    validate.add_argument(
        "--meshes", action="store_true", help="look at the meshes that are seen, too, in as many states (manifold3d)"
    )
    validate.add_argument("--json", action="store_true", help="the evidence as JSON")

    report = command("report", "tell how good a category is: figures over many samples, and goals")
    report.add_argument("programs", nargs="*", metavar="NAME|FILE", help="shipped categories or .apg files")
    report.add_argument("--all", action="store_true", help="all shipped categories")
    _drawing(report, 1000)
    shape = report.add_mutually_exclusive_group()
    shape.add_argument("--json", action="store_true", help="the figures as JSON")
    shape.add_argument("--markdown", action="store_true", help="a table with a row per category")
    report.add_argument(
        "--html",
        type=place,
        metavar="FILE",
        help="write a page with a picture as well; - for the page alone, to stdout",
    )
    report.add_argument("--reference", metavar="FILE", help="real sizes to compare with (default: those shipped)")
    report.add_argument("--unchecked", action="store_true", help="count objects whose links collide as valid: faster")
    report.add_argument("--strict", action="store_true", help="exit with 1 if a goal is not met")
    report.add_argument("--force", action="store_true", help="replace the page")
    _sharing(report)

    ledger = command("ledger", "tell for each value of a part what determines it")
    _program(ledger)
    ledger.add_argument("part", nargs="?", metavar="PART", help="such as door; without it, all parts")
    return top


def _program(to: argparse.ArgumentParser) -> None:
    to.add_argument("program", metavar="NAME|FILE", help="a shipped category or an .apg file")


def _meshes(to: argparse.ArgumentParser, steps: int = 24) -> None:
    to.add_argument(
        "--tolerance", type=tolerance, metavar="LENGTH",
        help=f"how far meshes may lie off the true surfaces, such as 0.5mm (default: {steps} steps per full turn)",
    )  # fmt: skip
    to.add_argument(
        "--triangles", type=positive, metavar="N", help="at most so many triangles per object, spread by curvature"
    )


def _sharing(to: argparse.ArgumentParser) -> None:
    to.add_argument(
        "--workers", type=workers, default=1, metavar="N",
        help="how many processes share the work, or auto: one per processor (default: 1)",
    )  # fmt: skip


def _drawing(to: argparse.ArgumentParser, n: int) -> None:
    to.add_argument("-n", "--number", type=positive, metavar="N", help=f"how many objects (default: {n})")
    to.add_argument("--seed", type=whole, metavar="N", help="what the objects are drawn with (default: 0)")
    to.add_argument("--only", type=numbers, metavar="NUMBERS", help="objects by number: 37 or 37,40..45")
    to.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="fix a parameter: width=45cm, handle=BarHandle"
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
        say("\ninterrupted; nothing is left half written, and the same command completes what is missing")
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has seen enough
        drop_output()
        return OK
    except ModuleNotFoundError as wrong:
        package = (wrong.name or "").partition(".")[0]
        if package in ("", "artipg_dsl"):
            raise
        error(f"the package {package} is not installed", "pip install artipg_dsl brings it")
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
