"""A vector that a port of type `point` holds is a place: it moves with its frame, as the origin of a frame there does."""

import numpy as np
import pytest

from artipg_dsl.annotate.grasps import sample_keypoints
from artipg_dsl.session import Session

ROD = """primitive Rod {
  param high : length > 0  test 1cm .. 1m
  surface side   (u in 0turn .. 1turn, v in 0 .. 1) = [1cm * cos(u), 1cm * sin(u), v * high]
  surface top    (u in 0 .. 1, v in 0turn .. 1turn) = [u * 1cm * cos(v), u * 1cm * sin(v), high]
  surface bottom (u in 0turn .. 1turn, v in 0 .. 1) = [v * 1cm * cos(u), v * 1cm * sin(u), 0mm]
  inside (p) = max(hypot(p.x, p.y) - 1cm, -p.z, p.z - high)
  box = [-1cm, -1cm, 0mm] .. [1cm, 1cm, high]
  port tip : point = [0, 0, high]
  port end : frame = frame(at = [0, 0, high], out = z, up = x)
}"""
STATED = """template Post {
  part stem : Cuboid(size = [2cm, 2cm, 20cm])
  align stem.bottom.center = [0cm, 0cm, 0cm]
  port tip : point = [0, 0, 20cm]
  port end : frame = frame(at = [0, 0, 20cm], out = z, up = x)
}"""
BY_ROLE = "role Standing { port tip : point  port end : frame }\n" + STATED.replace(
    "Post {", "Post : Standing {"
).replace("tip : point", "tip")
INDEXED = STATED.replace("tip : point", "tips[0] : point") + "\n"
USED = """apg 1
use primitives {{ Cuboid }}
{declared}
category T {{
  root part base : Cuboid(size = [50cm, 50cm, 2cm])
  part post : {made}
  align post.left = base.left
  align post.front = base.front
  connect post.bottom on base.top
  part one : Cuboid(size = [1cm, 1cm, 1cm])
  part two : Cuboid(size = [1cm, 1cm, 1cm])
  connect one.bottom to frame(at = {tip}, out = z, up = x)
  connect two.bottom to frame(at = post.end.origin, out = z, up = x)
  keypoint tip on post at {tip}
  keypoint end on post at post.end.origin
  keypoint one on one at [0, 0, 0]
  keypoint two on two at [0, 0, 0]
}}
"""


@pytest.mark.parametrize(
    "declared, made, tip",
    [
        (ROD, "Rod(high = 20cm)", "post.tip"),
        (STATED, "Post()", "post.tip"),
        (BY_ROLE, "Post()", "post.tip"),
        (INDEXED, "Post()", "post.tips[0]"),
    ],
)
def test_a_point_moves_with_its_frame(declared, made, tip):
    sampler = Session.of_text(USED.format(declared=declared, made=made, tip=tip)).sampler
    found = sample_keypoints(sampler.batch(np.arange(1), seed=0))
    where = dict(zip(found.name, found.point, strict=True))
    assert np.allclose(where["tip"], where["end"], atol=1e-9)
    assert np.allclose(where["one"], where["two"], atol=1e-9)
