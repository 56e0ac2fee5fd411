"""What is looked at, and in which order."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..diagnostics import Report
from ..geometry.errors import PrimitiveError
from ..lower.elaborate.idle import warn_idle_places
from ..lower.elaborate.unlabelled import warn_unlabelled
from ..semantics.mixed import warn_mixed
from ..semantics.unused import warn_unused
from ..validity.bodies import gather
from ..validity.floating import Solids
from ..validity.stuck import find_meeting
from ..validity.tree import Tree
from . import checks, joints, labels, meeting, places, sizes, valid
from .drawn import Draw, draw_some
from .excluded import warn_excluded
from .materials import warn_of_materials
from .seen import Seen

if TYPE_CHECKING:
    from ..lower.program import Lowering
    from ..semantics.check import TypedProgram

_OF_ALL = {"floating-part", "colliding-links", "never-valid"}  # what is told of each of the objects


def advise(typed: TypedProgram, lowering: Lowering | None, draw: Draw, report: Report) -> None:
    """Report what is legal and perhaps not meant: names and places that nothing reads, what objects show, and what has no label or
    no material."""
    if not report.failed:
        warn_unused(typed, report)
        warn_mixed(typed, report)
    if typed.category is None or lowering is None:
        return
    span = typed.category.decl.name_span
    places.warn_unplaced(lowering, report)
    warn_idle_places(lowering)
    batch = draw_some(draw, lowering, span, report)
    if batch is not None:
        _look(Seen(batch, lowering, span, report))
    warn_unlabelled(lowering, span)
    warn_of_materials(lowering, span, report)


def _look(seen: Seen) -> None:
    """Report what the objects show."""
    warn_excluded(seen)
    if not joints.follow(seen):
        return
    for warn in (joints.warn_rigid, joints.warn_caught, joints.warn_beyond, joints.warn_far):
        warn(seen)
    for warn in (sizes.warn_wide, sizes.warn_off, sizes.warn_odd_size, sizes.warn_asymmetric, sizes.warn_turned_twice):
        warn(seen)
    for warn in (checks.warn_of_cost, checks.warn_untested, _look_at_solids, labels.warn_lifting):
        try:
            warn(seen)
        except PrimitiveError:
            return  # told elsewhere, or when objects are drawn


def _look_at_solids(seen: Seen) -> None:
    """Report what floats, meets, hides or falls over.."""
    tree = Tree(seen.batch)
    solids = Solids(tree, gather(seen.batch, tree.first, tree.turn, tree.shift))
    places.warn_floating(seen, solids)
    places.warn_coincident(seen)
    places.warn_buried(seen)
    found = find_meeting(tree, solids.body)
    meeting.warn_stuck(seen, solids, found)
    meeting.warn_driven(seen, solids, found)
    meeting.warn_flush(seen, solids, found)
    meeting.warn_far_axes(seen, solids)
    meeting.warn_unguided(seen, solids)
    meeting.warn_loose_loops(seen, solids)
    valid.warn_never(seen, solids)
    labels.warn_unhandled(seen, tree)
    if not {each.code for each in seen.report.diagnostics} & _OF_ALL:
        valid.warn_rare(seen, solids, found)
    valid.warn_tipping(seen, solids)
