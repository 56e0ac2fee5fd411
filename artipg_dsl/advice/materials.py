"""Parts without a material, whose mass is a guess."""

from __future__ import annotations

from ..diagnostics import Report
from ..lower.program import Lowering
from ..source import Span
from .seen import place_of

_NAMED = 6  # parts that a warning names


def warn_of_materials(lowering: Lowering, span: Span, report: Report) -> None:
    """Name the parts of which no primitive has a material."""
    program = lowering.program
    bare = list(dict.fromkeys(program.parts[site.part].path for site in program.sites if not site.materials))
    if not bare:
        return
    named = ", ".join(f"`{path}`" for path in bare[:_NAMED])
    more = f" and {len(bare) - _NAMED} more" if len(bare) > _NAMED else ""
    what = f"the parts {named}{more} have" if len(bare) > 1 else f"the part {named} has"
    place = place_of(lowering, bare[0], span)
    report.warning(
        "missing-material",
        place or span,
        f"{what} no material",
        hint=f"write for example `material oak on {place.text if place else 'body'}`; the default is 700 kg/m3 and light grey",
    )
