"""``apgc lsp``: the language server, for an editor to start."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import redirect_stdout
from importlib.util import find_spec

from ..errors import UserError
from .messages import say


def run(_: argparse.Namespace) -> int:
    if find_spec("pygls") is None:
        raise UserError(
            "the language server needs pygls, which is not installed", "pip install 'artipg_dsl[editor]' installs it"
        )
    from ..lsp.server import make_server  # start-up: for those who have it

    if sys.stdin.isatty():
        say("apgc lsp waits for an editor to speak the Language Server Protocol: press Ctrl+C to stop")
    with redirect_stdout(sys.stderr):  # a stray word on stdout would be taken for the protocol
        try:
            make_server().start_io(sys.stdin.buffer, os.fdopen(os.dup(1), "wb"))
        except KeyboardInterrupt:
            say("")
    return 0
