"""``apgc layout``: read a folder in a layout of the field as its loaders do, and compare it with the model."""

from __future__ import annotations

import argparse
from pathlib import Path

from ..errors import UserError, plural
from ..run.progress import Progress
from .messages import say

_SHOWN = 20  # faults


def run(options: argparse.Namespace) -> int:
    from ..run.laying import check_layout

    if not Path(options.folder).is_dir():
        raise UserError(f"there is no folder {options.folder}", "give one that `apgc export --format` has laid out")
    with Progress("checking") as progress:
        found = check_layout(options.folder, progress)
    for place, fault in found.faults[:_SHOWN]:
        print(f"{place}: {fault}")
    if len(found.faults) > _SHOWN:
        print(f"and {len(found.faults) - _SHOWN} more")
    say(f"{plural(found.checked, 'check')}, {plural(len(found.faults), 'fault')}")
    return 1 if found.faults else 0
