"""The surface that fingers come upon, and how much of it is labelled for them: ``affordance.grasp``."""

from __future__ import annotations

import numpy as np

from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.grasps import GraspTable
from artipg_dsl.annotate.gripper import STANDARD
from artipg_dsl.annotate.sampling import Sampling
from artipg_dsl.runtime.batch import Batch

DEEP = 1e-3  # metres behind the outermost point that a pad still meets


def find_pressed(batch: Batch, grasps: GraspTable, rows: np.ndarray, count: int) -> np.ndarray:
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
