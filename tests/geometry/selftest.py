"""The self-test of a declared primitive over its test range: does everything that is said about it agree?

Surfaces must close, the inside function must vanish on them and rise outwards, the box must be the box of the mesh,
the volumes by mesh and by inside function must agree, and the convex pieces must lie within the solid and fill it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from artipg_dsl.geometry import mesh, pieces, quadrature
from artipg_dsl.geometry.agreement import (
    ON_SURFACE,
    VOLUME,
    Inspection,
    Report,
    box_faults,
    covered_places,
    fill_faults,
    pieces_beyond,
    slope_faults,
)
from artipg_dsl.geometry.errors import PrimitiveError
from artipg_dsl.geometry.patches import surfaces
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.geometry.vectors import cross, length
from artipg_dsl.graph.primitive import Primitive

_OFF_SURFACE = 1e-6  # how far off a surface its sides are asked
_MOMENTS = 5e-3  # relative difference of volume, centre and inertia by quadrature and by a fine mesh
_AREA = 5e-3  # relative difference of areas by formula and by a fine mesh
_MISSED = 0.015  # share of deeper places that may be missed all the same: the rim of a slice thinner than its rounding


@dataclass(frozen=True, slots=True)
class Finding:
    """Something that does not agree. ``surface`` names the surface (or piece) at fault, where one is."""

    primitive: str
    check: str  # "closed", "inside", "normal", "slope", "box", "area", "volume", "pieces"
    surface: str | None
    message: str

    def __str__(self) -> str:
        place = f" {self.surface}" if self.surface else ""
        return f"{self.primitive}{place}: {self.message}"


def check_primitive(primitive: Primitive, samples: int = 12, each: int = VOLUME) -> list[Finding]:
    """All that is wrong with a primitive over ``samples`` test values and the ends of its test ranges, with ``each`` places in the
    box of one and a share of them on each of its surfaces."""
    try:
        params = draw_trial(primitive, samples)
        mesh.build(primitive, params)
    except PrimitiveError as error:
        check = "inside" if "inside function" in error.words else "closed"
        return [Finding(primitive.name, check, error.patch, error.words)]
    inspection = Inspection(primitive, params, each)
    out: list[Finding] = []
    for examine in (_surfaces, slope_faults, box_faults, _areas, fill_faults, _moments, _pieces):
        for name, where, message in examine(inspection):
            out.append(Finding(primitive.name, name, where, message))
    return out


def _surfaces(seen: Inspection) -> Report:
    """The inside function is 0 on every surface, positive beyond and negative behind."""
    for patch, made in enumerate(surfaces(seen.primitive)):
        row, position, normal = seen.places(patch)
        size = seen.diagonal[row]
        value = np.abs(seen.inside(row, position)) / size
        worst = int(np.argmax(value))
        if value[worst] > ON_SURFACE:
            share = f"{100 * value[worst]:.3g} % of its size"
            yield (
                "inside",
                made.name,
                f"the inside function deviates from the surface by {share} ({seen.at(row[worst])})",
            )
            continue
        step = _OFF_SURFACE * size
        out = seen.inside(row, position + step[:, None] * normal) > 0
        back = seen.inside(row, position - step[:, None] * normal) < 0
        wrong = ~(out & back)
        if wrong.mean() > 0.02:  # a place may lie within the step of an edge
            worst = int(np.argmax(wrong))
            yield (
                "normal",
                made.name,
                (
                    f"at {100 * wrong.mean():.3g} % of places the normal does not point from inside to outside "
                    f"({seen.at(row[worst])})"
                ),
            )


def _areas(seen: Inspection) -> Report:
    """Areas by formula agree with those of a fine mesh, surface by surface: patches of one name are one surface."""
    names = np.array([surface.name for surface in surfaces(seen.primitive)])
    for group in seen.fine:
        corners = group.vertices[:, group.faces]
        first = corners[:, :, 0]
        area = length(cross(corners[:, :, 1] - first, corners[:, :, 2] - first))[..., 0] / 2
        there = np.unique(group.face_patch)
        for name in dict.fromkeys(names[there]):
            own = there[names[there] == name]
            expected = area[:, np.isin(group.face_patch, own)].sum(axis=1)
            error = np.abs(seen.areas[np.ix_(group.rows, own)].sum(axis=1) / expected - 1)
            worst = int(np.argmax(error))
            if error[worst] > _AREA:
                row = int(group.rows[worst])
                yield "area", name, f"its area differs from the mesh by {100 * error[worst]:.3g} % ({seen.at(row)})"


def _moments(seen: Inspection) -> Report:
    """Moments by quadrature are those of the mesh."""
    expected, centre, inertia = seen.moments
    if (expected <= 0).any():
        return  # told with what is filled
    exact = quadrature.volume_inertia(seen.primitive, seen.params)
    far = np.sqrt(((exact[1] - centre) ** 2).sum(axis=1)) / seen.diagonal
    off = {
        "volume": np.abs(exact[0] / expected - 1),
        "centre of mass": np.where(exact[0] > 0, far, np.inf),
        "inertia": np.abs(exact[2] - inertia).max(axis=(1, 2)) / np.abs(inertia).max(axis=(1, 2)),
    }
    for what, error in off.items():
        worst = int(np.argmax(error))
        if error[worst] > _MOMENTS:
            yield (
                "volume",
                None,
                f"its {what} by quadrature differs from the mesh by {100 * error[worst]:.3g} % ({seen.at(worst)})",
            )
            return


def _pieces(seen: Inspection) -> Report:
    """Convex pieces lie within the solid and leave out no more than a quarter of a wall."""
    for _, name, words in pieces_beyond(seen):
        yield "pieces", name, words
    row, _, covered = covered_places(seen, pieces.build(seen.primitive, seen.params))
    share = 1 - covered.mean()
    if share > _MISSED:
        worst = int(np.argmin(covered))
        yield "pieces", None, f"no piece covers {100 * share:.3g} % of the depth of the solid ({seen.at(row[worst])})"
