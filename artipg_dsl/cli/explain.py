"""``apgc explain``: what an error code means."""

from __future__ import annotations

import argparse
import textwrap

from ..diagnostics.codes import CODES
from ..diagnostics.suggest import did_you_mean
from ..errors import UserError


def run(options: argparse.Namespace) -> int:
    if options.code is None:
        width = max(map(len, CODES))
        for code in sorted(CODES.values(), key=lambda c: c.name):
            print(f"{code.name:<{width}}  {code.summary}")
        return 0
    if options.code not in CODES:
        raise UserError(
            f"there is no error code `{options.code}`", did_you_mean(options.code, CODES) or "`apgc explain` lists all"
        )
    code = CODES[options.code]
    print(f"{code.name}: {code.summary}")
    if code.text:
        print(f"\n{code.text.strip()}")
    if code.example:
        print("\nFor example:\n\n" + textwrap.indent(code.example.strip("\n"), "    "))
    return 0
