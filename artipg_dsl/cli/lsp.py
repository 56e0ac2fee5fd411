"""``apgc lsp``: the language server, for an editor to start."""

from __future__ import annotations

import argparse
import os
import sys
from contextlib import redirect_stdout

from ..extras import PYGLS
from .messages import say


def run(_: argparse.Namespace) -> int:
    PYGLS.require("the language server")
    from ..lsp.server import make_server  # start-up: for those who have it

    if sys.stdin.isatty():
        say("apgc lsp waits for an editor to speak the Language Server Protocol: press Ctrl+C to stop")
    with redirect_stdout(sys.stderr):  # a stray word on stdout would be taken for the protocol
        try:
            make_server().start_io(sys.stdin.buffer, os.fdopen(os.dup(1), "wb"))
        except KeyboardInterrupt:
            say("")
    return 0
