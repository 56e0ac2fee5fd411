"""Labels of points, poses, grasps and the annotation, on hand-made cupboards whose answers are known."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from export.fake_batch import SEMANTIC, FakeBatch

from artipg_dsl.annotate.annotation import annotate, annotation_lines, to_plain_data
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.frames import axis_angle, compose, euler, quaternion, rotate, unrotate
from artipg_dsl.annotate.grasps import grasp_frame, sample_grasps
from artipg_dsl.annotate.gripper import STANDARD
from artipg_dsl.annotate.points import field_kinds, label_points
from artipg_dsl.annotate.poses import part_poses, symmetry_words
from artipg_dsl.annotate.rows import to_text
from artipg_dsl.annotate.states import joint_values, read_states
from artipg_dsl.graph import expr as e
from artipg_dsl.runtime.fields import Field
from artipg_dsl.session import Session
from tests.vice import VICE


def turns(count: int = 50) -> np.ndarray:
    random = np.random.default_rng(3)
    axis = random.normal(size=(count, 3))
    return axis_angle(axis / np.linalg.norm(axis, axis=1, keepdims=True), random.uniform(-np.pi, np.pi, count))


def test_rotations_quaternions_and_roll_pitch_yaw_agree() -> None:
    rotation = turns()
    assert np.abs(compose(rotation, np.swapaxes(rotation, 1, 2)) - np.eye(3)).max() < 1e-12
    w, x, y, z = quaternion(rotation).T
    assert (w >= 0).all()
    first_row = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], axis=1)
    assert np.abs(first_row - rotation[:, 0]).max() < 1e-12
    roll, pitch, yaw = euler(rotation).T
    axes = np.eye(3)[:, None].repeat(len(roll), axis=1)
    again = compose(axis_angle(axes[2], yaw), compose(axis_angle(axes[1], pitch), axis_angle(axes[0], roll)))
    assert np.abs(again - rotation).max() < 1e-9
    half_turn = np.array([[-1.0, 0, 0], [0, -1, 0], [0, 0, 1]])
    assert quaternion(half_turn).tolist() == [0, 0, 0, 1]
    looking_up = axis_angle(np.array([0.0, 1, 0]), np.array(-np.pi / 2))
    roll, pitch, yaw = euler(looking_up)
    assert (roll, pitch) == (0, pytest.approx(-np.pi / 2))


def test_labels_follow_their_formulas() -> None:
    batch = FakeBatch(3)
    points = batch.point_set(40)
    labels = label_points(batch, batch.sites(), points)
    on_handle = points.site == 6
    assert (labels.fields["affordance.pull"] == on_handle).all()
    front, width = points.patch == 0, batch.width[:, None]
    expected = (points.site == 5) & front & (points.position[..., 1] < -0.1 * width)
    assert expected.any() and (labels.fields["affordance.push"] == expected).all()
    upper = on_handle & (points.position[..., 2] >= batch.height[:, None] / 2)
    assert upper.any() and (on_handle & ~upper).any()
    assert (
        labels.semantic
        == np.where(
            upper, SEMANTIC.index("grip"), np.where(on_handle, SEMANTIC.index("handle"), SEMANTIC.index("door"))
        )
    ).all()
    reach = labels.fields["field.reach"]
    assert reach.dtype == np.float32 and np.isnan(reach[~((points.site == 5) & front)]).all()
    at = (points.site == 5) & front
    assert reach[at] == pytest.approx((points.position[..., 1] / width)[at], abs=1e-6)
    assert field_kinds(batch.program.labels) == {
        "affordance.pull": "mask",
        "affordance.push": "mask",
        "field.reach": "field",
    }


def test_a_label_on_one_surface_leaves_the_others() -> None:
    batch = FakeBatch(1)
    points = batch.point_set(40)
    points.patch = np.ones_like(points.patch)  # all on the back
    labels = label_points(batch, batch.sites(), points)
    assert not labels.fields["affordance.push"].any() and labels.fields["affordance.pull"].any()


def test_in_one_vocabulary_the_deepest_label_wins() -> None:
    batch = FakeBatch(1)
    pull, push = batch.program.labels[:2]
    handle = replace(push, targets=pull.targets, value=e.call("lt", e.var("p.z"), e.ZERO), depth=2)
    points = batch.point_set(40)
    batch.program.labels[:2] = [pull, handle]
    deeper = label_points(batch, batch.sites(), points).fields
    below = (points.site == 6) & (points.position[..., 2] < batch.height[:, None] / 2)
    assert (deeper["affordance.push"] == below).all() and below.any()
    assert (deeper["affordance.pull"] == ((points.site == 6) & ~below)).all()
    batch.program.labels[:2] = [pull, replace(handle, depth=0)]
    together = label_points(batch, batch.sites(), points).fields
    assert (together["affordance.push"] & together["affordance.pull"] == below).all()


def test_moving_an_object_moves_its_labels() -> None:
    """The formula is evaluated in the frame of its target: a rigid motion of both changes nothing."""

    class Moved(FakeBatch):
        def read(self, exprs, scope):  # type: ignore[no-untyped-def]
            values = super().read(exprs, scope)
            if len(exprs) != 13:
                return values
            rotation = np.stack(values[:9], axis=-1).reshape(-1, 3, 3)
            new = compose(turn, rotation).reshape(-1, 9)
            place = rotate(turn, np.stack(values[9:12], axis=-1)) + shift
            return [*new.T, *place.T, values[12]]

    turn, shift = turns(1)[0], np.array([0.3, -2.0, 1.0])
    still, moved = FakeBatch(2), Moved(2)
    points = still.point_set(60)
    here = label_points(still, still.sites(), points)
    points.position, points.normal = rotate(turn, points.position) + shift, rotate(turn, points.normal)
    there = label_points(moved, moved.sites(), points)
    assert (here.semantic == there.semantic).mean() > 0.99
    for name, field in here.fields.items():
        assert np.allclose(field.astype(float), there.fields[name].astype(float), atol=1e-6, equal_nan=True), name


def test_a_field_reads_columns_once_and_points_many_times() -> None:
    root = e.Scope("root")
    a, b = e.col(e.Column(root, "a")), e.col(e.Column(root, "b"))
    field = Field([e.var("p.x") * (a + b) + a, a + b])
    assert len(field.inputs) == 2 and all(not i.args or i is (a + b) for i in field.inputs)
    by_input = {id(a): 2.0, id(a + b): 5.0}
    values = field([np.array(by_input[id(i)]) for i in field.inputs], {"p.x": np.array([0.0, 1.0])})
    assert values[0].tolist() == [2.0, 7.0] and values[1].tolist() == [5.0, 5.0]


def test_poses_are_boxes_and_move_with_their_link() -> None:
    batch = FakeBatch(2)
    rest = part_poses(batch)
    opened = part_poses(batch, np.tile([np.pi / 2, 0.0], 2))
    assert rest.center.reshape(2, 8, 3) == pytest.approx(batch._boxes()[0].transpose(1, 0, 2))
    door = 5
    radius = rest.center[door] - batch._hinge()[0]
    expected = batch._hinge()[0] + [-radius[1], radius[0], radius[2]]
    assert opened.center[door] == pytest.approx(expected)
    assert opened.quaternion[door] == pytest.approx([np.sqrt(0.5), 0, 0, np.sqrt(0.5)])
    assert opened.center[0].tolist() == rest.center[0].tolist()
    assert rest.scale[door] == pytest.approx(np.sqrt((rest.size[door] ** 2).sum()))


def test_grasps_lie_on_the_handle_at_even_steps() -> None:
    batch = FakeBatch(2)
    grasps = sample_grasps(batch)
    assert len(grasps.owner) == 10 and grasps.t[:5].tolist() == pytest.approx([-0.4, -0.2, 0, 0.2, 0.4])
    steps = grasps.point[:5, 2] - batch.height[0] / 2
    assert steps.tolist() == pytest.approx([-0.08, -0.04, 0, 0.04, 0.08])
    assert grasps.point[0, 0] == pytest.approx(batch._boxes()[0][6, 0, 0])
    assert grasps.rotation[0].T.tolist() == [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    assert (grasps.opening == 0.02).all() and (np.diff(grasps.owner) >= 0).all()


def test_a_grasp_frame_is_square_even_if_its_words_are_not() -> None:
    frame = grasp_frame(np.array([[-2.0, 0, 0]]), np.array([[0.3, 1.0, 0]]))[0]
    assert np.abs(compose(frame, frame.T) - np.eye(3)).max() < 1e-12 and np.linalg.det(frame) == pytest.approx(1)
    assert frame[:, 2].tolist() == [-1, 0, 0] and unrotate(frame, np.array([0.0, 1, 0])).tolist() == [0, 1, 0]


def test_the_annotation_tells_the_whole_object() -> None:
    batch = FakeBatch(2)
    second = annotate(batch, gripper=None)[1]
    assert (second["object"], second["category"]) == (1, "Cupboard")
    assert (second["seed"], second["rejected"]) == (7, 1)
    hinge = second["joints"][0]
    assert hinge["name"] == "open" and (hinge["parent"], hinge["child"]) == ("base", "door")
    assert hinge["range"] == [0.0, 1.9] and hinge["origin"] == pytest.approx(batch._hinge()[1], abs=1e-9)
    handle = second["parts"][6]
    assert (handle["path"], handle["parent"], handle["link"], handle["semantic"]) == ("handle", 5, "door", "handle")
    assert handle["symmetry"] == "any about z" and len(handle["quaternion"]) == 4
    assert second["drawn"]["handle"] == "BarHandle" and list(second["drawn"]) == sorted(second["drawn"])
    assert len(second["grasps"]) == 5 and second["keypoints"][0]["name"] == "tip"


def test_a_line_is_json_short_and_the_same_from_any_batch() -> None:
    text = to_text(annotate(FakeBatch(5))[3])
    assert text == to_text(annotate(FakeBatch(1, first=3))[0]) and "\n" not in text
    again = json.loads(text)
    assert to_text(again) == text and "-0.0," not in text and "e-1" not in text


@pytest.mark.some
@pytest.mark.parametrize("category", ["Microwave", "Keyboard", "Foldingrack"])
def test_lines_are_the_text_of_annotations(category: str) -> None:
    """Also of details, in several states, and without a gripper."""
    batch = Session.of(category).sampler.batch(np.arange(5), seed=3)
    details = [None, *({"donor": f"Öfen {i}", "worn": i / 7} for i in range(4))]
    for states, gripper in ((None, STANDARD), (joint_values(batch, read_states("rest,open")), None)):
        plain = annotate(batch, states, gripper)
        assert list(annotation_lines(batch, states, gripper)) == [to_text(one) for one in plain]
        told = [to_text(one | {"details": own}) for one, own in zip(plain, details, strict=True)]
        assert list(annotation_lines(batch, states, gripper, details)) == told


def test_plain_values() -> None:
    assert to_plain_data({"b": np.float64(1.5), "a": (np.int64(2), np.bool_(True), None, np.nan)}) == {
        "b": 1.5,
        "a": [2, True, None, None],
    }


def test_symmetry_in_words() -> None:
    assert symmetry_words(np.array([[1, 2], [2, 0], [0, 2]])) == [None, "2 about x", "any about z"]


def test_screws_tell_their_pitch_as_they_move() -> None:
    """After a turn, a link has moved by the pitch along the axis: a mirrored screw has the other thread."""
    batch = Session.of_text(VICE).sampler.batch(np.arange(2), 1)
    values = np.where(np.isnan(batch.joints().pitch), 0.0, 2 * np.pi)
    turned, moved = batch.pose(values)
    assert np.abs(turned - np.eye(3)).max() < 1e-12
    for i, annotation in enumerate(annotate(batch)):
        numbers = {link["name"]: link["number"] for link in annotation["links"]}
        pitches = {joint["name"]: joint["pitch"] for joint in annotation["joints"]}
        assert pitches == {"side_0.drive": 0.003, "side_1.drive": -0.003, "press": None}
        for joint in annotation["joints"]:
            row = i * len(numbers) + numbers[joint["child"]]
            assert moved[row] == pytest.approx(np.array(joint["axis"]) * (joint["pitch"] or 0.0), abs=1e-9)
        one, other = (moved[i * len(numbers) + numbers[f"side_{k}.nut"]] for k in range(2))
        assert one == pytest.approx([0, 0.003, 0]) and other == pytest.approx([0, -0.003, 0])  # each outwards


MIRRORED = """apg 1
use primitives { Cuboid, Cylinder }
template Hook {
  part rod : Cuboid(size = [1cm, 1cm, 6cm])
  part barb : Cuboid(size = [2cm, 3cm, 1cm])
  align barb.right = rod.left
  align barb.back = rod.back
}
category Rack {
  root part body : Cuboid(size = [10cm, 20cm, 10cm])
  repeat side[k] mirror across y {
    part hook : Hook
    connect hook to body
    align hook.rod.right = 10.5cm
    part stub : Cylinder(radius = 1cm, height = 2cm) turned 30deg about x
    connect stub to body
    align stub.center = [0, 11cm, 2cm]
  }
}
"""


def test_boxes_of_mirrored_parts_are_mirrored() -> None:
    """One that lies to one side of its part's origin lies to the other side of a mirrored one's."""
    batch = Session.of_text(MIRRORED).sampler.batch(np.arange(2), 1)
    points = sample_points(batch, 4000)
    assert 0.4 < np.abs(points.npcs).max() <= 0.5
    for annotation in annotate(batch):
        parts = {part["name"]: part for part in annotation["parts"]}
        for name in ("hook", "hook.rod", "hook.barb", "stub"):
            own, other = (parts[f"side[{k}].{name}"] for k in range(2))
            assert own["size"] == other["size"]
            assert other["center"] == pytest.approx(np.array(own["center"]) * [1, -1, 1], abs=1e-9), name
