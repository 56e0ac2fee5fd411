"""Where a shipped category declares a grasp, the surface under the fingers says so: ``affordance.grasp``."""

from __future__ import annotations

import numpy as np
import pytest

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.grasps import GraspTable, sample_grasps
from artipg_dsl.annotate.gripper import STANDARD
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.session import Session, categories

OBJECTS = 6
FEW, MANY = 200, 8000  # points of a primitive; many where fingers meet so little of it that none of the few lie there
DEEP = 1e-3  # metres behind the outermost point that a pad still meets
SHARE = 0.5  # of the surface under the fingers of a family that bears the label: the rest is what lies beside the place


def met(batch: Batch, grasps: GraspTable, rows: np.ndarray, count: int) -> np.ndarray:
    """Of the surface of their link that the pads of the grasps ``rows`` (R,) come upon: (R, 2), all of it and what bears the label, in
    square metres."""
    points = sample_points(batch, Sampling(count, per="primitive"), np.zeros(len(batch.joints().owner)))
    assert points.area is not None
    label = points.labels.get("affordance.grasp", np.zeros(points.link.shape)) > 0
    low, high = STANDARD.boxes(grasps.opening, STANDARD.measures(grasps.hand))
    found = np.zeros((len(rows), 2))
    for made, k in zip(found, rows, strict=True):
        at = np.flatnonzero(points.object == grasps.owner[k])
        own = points.link[at] == grasps.link[k]
        place = (points.position[at][own] - grasps.point[k]) @ grasps.rotation[k]
        facing = (points.normal[at][own] @ grasps.rotation[k])[:, 1]
        within = ((place >= low[k, 3] - DEEP) & (place <= high[k, 3] + DEEP)).all(axis=1)
        for side in (1.0, -1.0):
            out = np.where(within & (side * facing > 0.5), side * place[:, 1], -np.inf)
            pressed = np.isfinite(out) & (out > out.max(initial=-np.inf) - DEEP)
            area = points.area[at][own][pressed]
            made += area.sum(), area[label[at][own][pressed]].sum()
    return found


@pytest.mark.parametrize("name", categories())
def test_what_fingers_close_on_bears_the_label(name: str) -> None:
    batch = Session.of(name).sampler.batch(np.arange(OBJECTS), 5)
    grasps = sample_grasps(batch)
    found = met(batch, grasps, np.arange(len(grasps.owner)), FEW)
    families = np.unique(grasps.family)
    bare = [family for family in families if not found[grasps.family == family].any()]
    if bare:
        rows = np.flatnonzero(np.isin(grasps.family, bare))
        found[rows] = met(batch, grasps, rows, MANY)
    wrong = []
    for family in families:
        whole, labelled = found[grasps.family == family].sum(axis=0)
        if not labelled >= SHARE * whole or not whole:
            grasp = batch.program.grasps[family]
            wrong.append(f"{grasp.where}: `{grasp.name}`: {1e4 * labelled:.2f} of {1e4 * whole:.2f} cm2 have the label")
    assert not wrong, "\n".join(wrong)
