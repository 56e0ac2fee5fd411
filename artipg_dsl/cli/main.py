"""``apgc``: the command line. Each command lives in a module of its own, loaded only when it is called."""

from __future__ import annotations

import argparse
import atexit
import gc
import importlib
import io
import os
import re
import sys
from collections.abc import Collection, Sequence
from contextlib import suppress
from typing import Any, NoReturn

from .messages import error, findings, say
from .options import COMMANDS
from .stop import Stopped, heeding

OK, FAILED, USAGE, INTERRUPTED = 0, 1, 2, 130
_DESCRIPTION = "Compile structure programs of articulated objects (.apg), and sample annotated objects from them."
_EPILOG = (
    "apgc COMMAND --help lists the options of a command. "
    "Exit codes: 0 success, 1 errors in a program or in data, 2 wrong usage, 130 interrupted (143 by SIGTERM)."
)

atexit.register(gc.freeze)  # what is left ends with the process: to look through it took a fifth of a check


class _Version(argparse.Action):
    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from ..version import __version__

        print(f"apgc {__version__}")
        parser.exit()


class _Once(argparse.Action):
    """Stores a value, and refuses another one: of two, it would not be told which counts."""

    def __call__(
        self, parser: argparse.ArgumentParser, names: argparse.Namespace, values: Any, option: str | None = None
    ) -> None:
        assert isinstance(parser, Parser)
        if option is not None and parser.given.setdefault(self.dest, values) != values:
            error(f"{option} is given twice, with different values", "keep one of them")
            parser.exit(USAGE)
        setattr(names, self.dest, values)


class _Formatter(argparse.HelpFormatter):
    """Of lines as long as the terminal is wide. The parser makes one for each argument, and the standard library would load what
    compresses archives to know the width."""

    def __init__(self, prog: str):
        super().__init__(prog, width=_columns() - 2)


def _columns() -> int:
    with suppress(KeyError, ValueError):
        if (given := int(os.environ["COLUMNS"])) > 0:
            return given
    with suppress(ValueError, OSError):
        if sys.__stdout__ is not None:
            return os.get_terminal_size(sys.__stdout__.fileno()).columns or 80
    return 80


class Parser(argparse.ArgumentParser):
    """Errors as those of the commands: what is wrong, and what to try, without pages of usage."""

    commands: dict[str, Parser]

    def __init__(self, *arguments: Any, **more: Any):
        super().__init__(*arguments, **{"formatter_class": _Formatter, **more})
        self.given: dict[str, Any] = {}
        for action in (None, "store"):
            self.register("action", action, _Once)

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
        """The options; leaves with what is empty, or resembles an option that no command knows."""
        words = list(sys.argv[1:] if arguments is None else arguments)
        empty = _find_empty(words)
        if empty is not None:
            error(f"{empty} is empty", "give a value, or leave it out: is a variable of the shell not set?")
            self.exit(USAGE)
        options, unknown = self.parse_known_args(words)
        if unknown:
            from difflib import get_close_matches  # start-up

            command = self.commands[options.command]
            known = {option.lstrip("-"): option for option in re.findall(r"--?[a-z][a-z-]*", command.format_usage())}
            given = unknown[0].partition("=")[0]
            name = given.lstrip("-")  # dashes say nothing
            close = get_close_matches(name, known, n=1, cutoff=0.7) or [one for one in known if name in one.split("-")]
            if close:
                error(f"apgc {options.command} has no option {given}", f"did you mean {known[close[0]]}?")
                self.exit(USAGE)
            command.error(f"unexpected argument {unknown[0]}")
        return options


def _find_empty(words: Sequence[str]) -> str | None:
    """The first option or argument that is given no text."""
    for before, word in zip(["", *words], words, strict=False):
        if not word.strip():
            return before if before.startswith("-") else "an argument"
        if re.fullmatch(r"--[\w-]+=\s*", word):
            return word.partition("=")[0]
    return None


def build_parser(words: Collection[str] = COMMANDS.keys()) -> Parser:
    """The parser of the command line; of commands that are none of some ``words`` it knows the names alone."""
    top = Parser("apgc", description=_DESCRIPTION, epilog=_EPILOG, allow_abbrev=False)
    top.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
    top.commands = commands.choices
    for name, (does, add) in COMMANDS.items():
        command = commands.add_parser(name, help=does, description=does[0].upper() + does[1:] + ".", allow_abbrev=False)
        if add is not None and name in words:
            add(command)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit code."""
    from ..errors import InternalError, UsageError, UserError

    # no product of matrices gains by threads of BLAS: to start them takes as long as to load NumPy
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    _open_streams()
    try:
        words = sys.argv[1:] if arguments is None else arguments
        options = build_parser(words).parse(words)
    except SystemExit as stop:  # help was asked for, or the parser has said what is wrong
        return int(stop.code or 0)
    try:
        if getattr(options, "backend", None):
            from ..native import backend

            backend.choose(options.backend)
        if hasattr(options, "workers"):  # long work, on arrays
            from ..pages import hold_pages

            hold_pages()
        with heeding():
            code = importlib.import_module(f".{options.command}", __package__).run(options)
        sys.stdout.flush()
        return code
    except UserError as wrong:
        error(wrong.message, wrong.hint)
        return USAGE if isinstance(wrong, UsageError) else FAILED
    except InternalError as fault:
        error(
            f"{fault.place}: {fault.what}",
            "this is a fault of apgc, not of the program: please report it with its text",
        )
        return FAILED
    except KeyboardInterrupt as stop:
        with suppress(OSError):  # the terminal may be gone
            say("\ninterrupted: no file is left incomplete; run the same command again to finish")
        return stop.code if isinstance(stop, Stopped) else INTERRUPTED
    except BrokenPipeError:  # the reader of our output has seen enough
        _drop_output()
        return OK
    except ModuleNotFoundError as wrong:
        package = (wrong.name or "").partition(".")[0]
        if package in ("", "artipg_dsl"):
            raise
        if package in sys.modules:  # it is there, but another version of it
            error(f"the installed {package} has no {wrong.name}", "pip install -U artipg_dsl installs one that fits")
        else:
            error(f"the package {package} is not installed", "pip install artipg_dsl installs it")
        return FAILED
    except OSError as wrong:  # files are told of where they are written: what is left is the output itself
        _drop_output()
        if _is_adrift():
            error("the working folder is no longer there", "change to one that is: cd")
            return FAILED
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


def _open_streams() -> None:
    """What who started us has closed is empty, and takes what is said nowhere.

    Output is UTF-8 as programs are, except on a terminal, and what it cannot show is told by its number.
    """
    for name in ("stdin", "stdout", "stderr"):  # each gets the lowest number that is free, its own
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, "r" if name == "stdin" else "w"))  # until the end
    if isinstance(sys.stdout, io.TextIOWrapper):
        encoding = sys.stdout.encoding if sys.stdout.isatty() else "utf-8"
        sys.stdout.reconfigure(encoding=encoding, errors="backslashreplace")


def _is_adrift() -> bool:
    """Whether the folder that we work in has been removed."""
    try:
        os.getcwd()
    except FileNotFoundError:
        return True
    return False


def _drop_output() -> None:
    """What is still buffered for stdout goes nowhere: it cannot be written."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
