"""Parts that float, lie in one another or are hidden, and how to place them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ..diagnostics import Report
from ..lower.values.kinds import Frame, part_of
from ..syntax import ast
from ..validity.adrift import find_adrift, find_gaps
from ..validity.buried import find_buried
from ..validity.floating import Solids, alone
from ..validity.twins import find_twins
from .seen import Seen

if TYPE_CHECKING:
    from ..lower.elaborate.part import Component
    from ..lower.program import Lowering

_APART = 1e-4  # metres: what is farther apart does not touch


def warn_unplaced(lowering: Lowering, report: Report) -> None:
    """Report parts that nothing places."""
    for part in lowering.unplaced():
        report.warning(
            "unplaced",
            part.span,
            f"nothing places `{part.name}`: it is centred along x, y and z",
            hint=f"place it {_how_to_place(part)}; if the centre is meant, write `align {part.name}.center = ...`",
        )


def warn_floating(seen: Seen, solids: Solids) -> None:
    """Report the parts that float in each of the objects that have them: none of those is ever valid."""
    links = find_adrift(solids)
    paths, floating = solids.paths(), set(links)
    here = [part for part in seen.lowering.context.parts if part.span.source is seen.lowering.root.module.source]
    for whole in (True, False):  # what floats as a whole is told as one part, else the innermost part of the file
        for part in sorted(here, key=lambda part: part.path.count("."), reverse=not whole):
            within = f"{part.path}."
            own = {path for path in floating if f"{path}.".startswith(within)}
            if not own or whole and any(f"{path}.".startswith(within) and path not in own for path in paths):
                continue
            floating -= own
            first = min(own, key=list(links).index)
            seen.report.warning(
                "floating-part",
                part.span,
                alone(first, links[first]),
                hint=f'{_how_to_hold(seen, part, solids)}; if that is meant, write `allow floating {part.name} because "..."`',
            )


def warn_coincident(seen: Seen) -> None:
    """Report parts of which elements of a repeat fill the same space: they look like one."""
    twins = find_twins(seen.batch)
    for part in seen.lowering.context.parts:
        own = [path for path in twins if path == part.path or path.startswith(f"{part.path}.")]
        if own and part.span.source is seen.lowering.root.module.source:
            twins = [path for path in twins if path not in own]
            repeat = part.path.split(".")[-2] if "." in part.path else "row"
            seen.report.warning(
                "coincident",
                part.span,
                f"elements of `{own[0]}` fill the same space, in every object examined",
                hint=f"place it by what differs between elements, such as `align {part.name}.center.y = {repeat}.center.y`; "
                "in a `ring` or a `mirror`, move it off the axis or the plane",
            )


def warn_buried(seen: Seen) -> None:
    """Report parts of which all, or some elements of a repeat, lie inside another part of their link: nothing of them is seen."""
    buried, told = find_buried(seen.batch), set[str]()
    unplaced = {found.span for found in seen.report.diagnostics if found.code == "unplaced"}
    sites = {table.path: table for table in seen.batch.sites()}
    for part in sorted(seen.lowering.context.parts, key=lambda part: part.path.count(".")):
        own = [path for path in sites if f"{path}.".startswith(f"{part.path}.")]
        if part.span.source is not seen.span.source or not own or not buried.keys() >= {*own} or told & {*own}:
            continue
        told |= {*own}
        by, rows = buried[own[0]]
        mirror = sites[own[0]].mirror
        if part.span in unplaced:
            continue  # told, with its cause
        said, hint = f"nothing of `{part.path}` is seen: it lies", f"place it on a face of `{by}`, or leave it out"
        if not rows.all():
            said = f"some elements of `{part.path}` lie"
            if len(set(mirror[rows])) == len(set(mirror[~rows])) == 1 and mirror[rows][0] != mirror[~rows][0]:
                said = f"one of the two halves of `{part.path}` lies"
                hint = "a `mirror` is across the plane through the origin of what it stands in, not through the middle of another part: "
                hint += "state the half on the positive side, by its distance from that plane"
        seen.report.warning("buried", part.span, f"{said} inside `{by}`, in every object examined", hint=hint)


def _how_to_hold(seen: Seen, part: Component, solids: Solids) -> str:
    """What to write so that a part that floats touches its link. Axes along which it reaches what carries it are not to blame."""
    free = seen.lowering.context.centred.get(part, set())
    carrier = next((part_of(other).path for attachment in part.attachments for other in attachment.to), None)
    gaps = None if carrier is None else find_gaps(solids, part.path, carrier)
    apart = set() if gaps is None else set(np.flatnonzero(gaps > _APART).tolist())
    if gaps is not None and apart and not apart & free:
        away = " and ".join(f"{1000 * gaps[axis]:.3g} mm along {'xyz'[axis]}" for axis in sorted(apart))
        return f"it is {away} from `{carrier}`: bring the two together, or attach it to what it does touch"
    axes = ["xyz"[axis] for axis in sorted(free & apart if apart else free)]
    if not 0 < len(axes) < 3:
        return f"place it {_how_to_place(part)}, or attach it to what it does touch"
    return (
        f"nothing places it along {' and '.join(axes)}, where it is centred by default: "
        f"say where with `align`; behind `on` a face, `at center` puts it in the middle of that face"
    )


def _how_to_place(part: Component) -> str:
    """How a part is placed that has its attachment already: a joint places by its own faces, a second `connect` is an error."""
    mount = next(_mounts(part), None)
    if any(attachment.joint is not None for attachment in part.attachments):
        by = "faces" if mount is None else "its port and another"
        return f"with `align`, or by {by} in its joint, as in `... -> {part.name}.{mount or 'bottom'}`"
    return f"with `connect {part.name}.{'bottom on' if mount is None else f'{mount} to'} ...` or `align`"


def _mounts(part: Component) -> Iterator[str]:
    """The ports by which a part can be mounted, whatever it is."""
    bodies = [instance.symbol.body for instance in part.instances]
    for port in bodies[0] if bodies else ():
        if isinstance(port, ast.PortDecl) and port.index is None:
            shared = all(any(isinstance(s, ast.PortDecl) and s.name == port.name for s in body) for body in bodies)
            if shared and isinstance(part.own(port.name), Frame):
                yield port.name
