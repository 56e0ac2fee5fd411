"""What a folder holds, by the file that tells of it: results of different kinds do not share a folder."""

from __future__ import annotations

from typing import Literal

from ..details.dressing import SUMMARY as BOUND
from ..errors import UserError
from ..export.remote import Place
from . import manifest as manifests

FITTED, LAYOUT = "fit.json", ".layout"
Kind = Literal["fitted objects", "details", "samples", "a layout"]
_MARKS: dict[str, Kind] = {  # fitted objects are samples, too
    FITTED: "fitted objects",
    BOUND: "details",
    manifests.NAME: "samples",
    LAYOUT: "a layout",
}


def refuse_others(out: Place, *own: Kind, hint: str) -> None:
    """Refuse a folder that holds results of another kind than its ``own``. Raises UserError."""
    found = next((kind for name, kind in _MARKS.items() if (out / name).exists()), None)
    if found is not None and found not in own:
        raise UserError(f"{out} holds {found}", f"{hint}: name another")
