"""Partial views: images and clouds agree with the object, with one another and between the two ray casters."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl.annotate.camera_file import cameras_from, read_cameras
from artipg_dsl.annotate.cameras import Cameras
from artipg_dsl.annotate.cloud import sample_points
from artipg_dsl.annotate.frames import rotate, unrotate
from artipg_dsl.annotate.poses import part_poses
from artipg_dsl.annotate.states import joint_values, open_values, read_states
from artipg_dsl.annotate.views import NONE, Views, make_views, see_points
from artipg_dsl.errors import UsageError, UserError
from artipg_dsl.geometry import rays
from artipg_dsl.geometry.block import to_local
from artipg_dsl.graph.formula import compile_formula
from artipg_dsl.graph.primitive import Primitive
from artipg_dsl.runtime.batch import Batch
from artipg_dsl.sampling.sample import Sampler
from artipg_dsl.session import Session

CAMERAS = Cameras(count=3, points=1500)
SMALL = Cameras(count=2, width=48, height=32, points=700)
embree = pytest.mark.skipif(rays.best_engine() != "embree", reason="embreex is not installed")


@pytest.fixture(scope="module")
def sampler() -> Sampler:
    return Session.of("Microwave").sampler


@pytest.fixture(scope="module")
def batch(sampler: Sampler) -> Batch:
    return sampler.batch(np.arange(5), seed=3)


@pytest.fixture(scope="module")
def views(batch: Batch) -> Views:
    return make_views(batch, CAMERAS)


def seen(views: Views) -> np.ndarray:
    return views.images["depth"] > 0


def back_projected(views: Views, i: int, v: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in the object's frame, made of the depth image and the matrices alone, and where they are seen."""
    depth = views.images["depth"][i, v].astype(float)
    inside, outside = views.intrinsics[i, v], views.extrinsics[i, v]
    row, column = np.nonzero(depth)
    z = depth[row, column]
    x, y = (column + 0.5 - inside[0, 2]) / inside[0, 0] * z, (row + 0.5 - inside[1, 2]) / inside[1, 1] * z
    return unrotate(outside[:3, :3], np.stack([x, y, z], axis=-1) - outside[:3, 3]), np.stack([row, column], axis=-1)


def depth_within(batch: Batch, i: int, points: np.ndarray) -> np.ndarray:
    """The smallest inside function of the primitives of object ``i`` at points (n, 3): 0 on the union's surface."""
    least = np.full(len(points), np.inf)
    for table in batch.sites():
        for row in np.flatnonzero(table.owner == i):
            poses = table.rotation[row].reshape(9, 1), table.translation[row][:, None], table.mirror[row : row + 1]
            local = to_local(poses, np.zeros(len(points), dtype=int), points.T)
            least = np.minimum(least, inside(table.primitive, {n: p[row] for n, p in table.params.items()}, local))
    return least


def inside(primitive: Primitive, params: dict[str, float], local) -> np.ndarray:  # type: ignore[no-untyped-def]
    count = len(local[0])
    values = {name: np.full(count, value) for name, value in params.items()}
    names = dict(zip(("p.x", "p.y", "p.z"), local, strict=True))
    every = values | names
    found = compile_formula((primitive.inside,), tuple(every))(*every.values())[0]
    return np.broadcast_to(found, (count,))


def test_depth_leads_back_to_the_surface(batch: Batch, views: Views) -> None:
    for i, v in ((0, 0), (1, 2), (4, 1)):
        points, _ = back_projected(views, i, v)
        assert len(points) > 3000
        assert np.abs(depth_within(batch, i, points)).max() < 5e-4  # the mesh lies within curved surfaces


def test_classes_agree_with_sampled_points(batch: Batch, views: Views) -> None:
    points = sample_points(batch, 4000)
    width, height, agreed, compared = CAMERAS.width, CAMERAS.height, 0, 0
    for i in range(len(batch)):
        for v in range(CAMERAS.count):
            outside, within = views.extrinsics[i, v], views.intrinsics[i, v]
            local = rotate(outside[:3, :3], points.position[i]) + outside[:3, 3]
            x = local[:, 0] / local[:, 2] * within[0, 0] + within[0, 2]
            y = local[:, 1] / local[:, 2] * within[1, 1] + within[1, 2]
            column, row = x.astype(int), y.astype(int)
            assert ((column >= 0) & (column < width) & (row >= 0) & (row < height)).all(), "all of it is in the picture"
            near = np.abs(views.images["depth"][i, v][row, column] - local[:, 2]) < 3e-3
            for name in ("semantic", "instance", "link"):
                agreed += (views.images[name][i, v][row, column] == getattr(points, name)[i])[near].sum()
                compared += near.sum()
    assert compared > 20_000 and agreed / compared > 0.97  # a pixel at a border shows one of two


def test_what_shows_nothing_is_marked_in_all_images(views: Views) -> None:
    there = seen(views)
    assert 0.05 < there.mean() < 0.6
    for name in ("semantic", "instance", "link"):
        assert ((views.images[name] == NONE) == ~there).all(), name
    assert (views.images["normal"][~there] == 0).all() and (views.images["npcs"][~there] == 0).all()
    normal = views.images["normal"][there].astype(float)
    assert np.sqrt((normal**2).sum(axis=-1)) == pytest.approx(1.0, abs=1e-5)


def test_normals_turn_to_the_camera(views: Views) -> None:
    for i, v in ((0, 0), (3, 1)):
        points, at = back_projected(views, i, v)
        outside = views.extrinsics[i, v]
        eye = -unrotate(outside[:3, :3], outside[:3, 3])
        towards = ((eye - points) * views.images["normal"][i, v][at[:, 0], at[:, 1]]).sum(axis=-1)
        assert (towards > -0.05).mean() > 0.999


def test_part_coordinates_lead_back_to_the_points(batch: Batch) -> None:
    state = open_values(batch)
    views = make_views(batch, CAMERAS, state)
    poses = part_poses(batch, state)
    first = np.searchsorted(batch.parts().owner, np.arange(len(batch)))
    for i in range(len(batch)):
        part = first[i] + views.cloud["instance"][i].astype(int)
        npcs = views.cloud["npcs"][i].astype(float)
        again = rotate(poses.rotation[part], npcs * poses.scale[part][..., None]) + poses.center[part]
        assert again == pytest.approx(views.cloud["points"][i], abs=1e-6)
        assert np.abs(npcs).max() <= 0.5
    there = seen(views)
    assert np.abs(views.images["npcs"][there]).max() <= 0.5


def test_clouds_lie_at_their_pixels_in_both_frames(views: Views) -> None:
    count, height, width = CAMERAS.count, CAMERAS.height, CAMERAS.width
    assert views.cloud["points"].shape == (5, count, 1500, 3)
    assert views.images["depth"].shape == (5, count, height, width)
    for i in range(5):
        for v in range(count):
            cloud = {name: values[i, v] for name, values in views.cloud.items()}
            outside, within = views.extrinsics[i, v], views.intrinsics[i, v]
            local = rotate(outside[:3, :3], cloud["points"].astype(float)) + outside[:3, 3]
            assert local == pytest.approx(cloud["camera"], abs=1e-6)
            row, column = cloud["pixel"].T.astype(int)
            assert local[:, 0] / local[:, 2] * within[0, 0] + within[0, 2] == pytest.approx(column + 0.5, abs=1e-3)
            assert local[:, 1] / local[:, 2] * within[1, 1] + within[1, 2] == pytest.approx(row + 0.5, abs=1e-3)
            assert local[:, 2] == pytest.approx(views.images["depth"][i, v][row, column], abs=1e-6)
            assert len(np.unique(row * width + column)) == 1500, "no pixel is taken twice where there are enough"
            for name in ("semantic", "instance", "link", "npcs"):
                assert (cloud[name] == views.images[name][i, v][row, column]).all()
    assert views.cloud["affordance.pull"].any() and views.cloud["affordance.pull"].dtype == bool


def test_a_small_picture_still_gives_all_points(batch: Batch) -> None:
    views = make_views(batch, SMALL)
    there = seen(views)
    assert there.sum(axis=(2, 3)).max() < SMALL.points
    for i in range(len(batch)):
        for v in range(SMALL.count):
            points, pixel = views.cloud["points"][i, v], views.cloud["pixel"][i, v].astype(int)
            assert len(np.unique(points, axis=0)) == SMALL.points, "no point is repeated"
            assert there[i, v][pixel[:, 0], pixel[:, 1]].all()
            assert len(np.unique(pixel @ [SMALL.width, 1])) == there[i, v].sum(), "every pixel has its point"
            assert np.abs(depth_within(batch, i, points.astype(float))).max() < 5e-4
            local, within = views.cloud["camera"][i, v].astype(float), views.intrinsics[i, v]
            column = local[:, 0] / local[:, 2] * within[0, 0] + within[0, 2]
            assert (np.floor(column - 1e-4) <= pixel[:, 1]).all() and (np.floor(column + 1e-4) >= pixel[:, 1]).all()


def test_an_open_door_shows_the_cavity(batch: Batch) -> None:
    cavity = batch.program.vocabularies["semantic"].index("cavity")
    front = Cameras(count=2, azimuth=(-20, 20), elevation=(10, 25), points=100)
    values = joint_values(batch, read_states("rest,open"))
    shown = make_views(batch, front, values).images["semantic"] == cavity
    assert shown.shape[:3] == (5, 2, 2)
    assert not shown[:, 0].any() and (shown[:, 1].sum(axis=(2, 3)) > 300).all()


def test_views_of_an_object_are_its_own(sampler: Sampler, batch: Batch) -> None:
    both, alone = make_views(batch, SMALL), make_views(sampler.batch(np.array([3]), seed=3), SMALL)
    for these, those in ((both.images, alone.images), (both.cloud, alone.cloud)):
        assert all(these[name][3].tobytes() == those[name][0].tobytes() for name in these)
    assert both.extrinsics[3].tobytes() == alone.extrinsics[0].tobytes()
    assert not np.array_equal(both.extrinsics[3], both.extrinsics[2])
    values = joint_values(batch, read_states("open,rest"))
    several = make_views(batch, SMALL, values)
    assert several.images["depth"][:, 1].tobytes() == both.images["depth"].tobytes()
    for states, points in ((None, both.cloud["points"]), (values, several.cloud["points"])):
        np.testing.assert_array_equal(see_points(batch, SMALL, states), points)


@pytest.mark.some
@embree
@pytest.mark.parametrize("state", ["rest", "open"])
def test_both_ray_casters_see_the_same(batch: Batch, state: str) -> None:
    values = joint_values(batch, read_states(state))[0]
    one, other = (make_views(batch, CAMERAS, values, engine) for engine in ("embree", "numpy"))
    there = seen(one) | seen(other)
    same = (np.abs(one.images["depth"] - other.images["depth"]) < 1e-6) & there
    assert same.sum() / there.sum() > 0.999
    for name in ("semantic", "instance", "link"):
        assert (one.images[name] == other.images[name])[there].mean() > 0.999


@embree
def test_casters_name_the_same_triangles_from_any_place() -> None:
    random = np.random.default_rng(5)
    corner = random.uniform(-1, 1, (400, 1, 3)) + random.normal(0, 0.15, (400, 3, 3))
    fast, slow = rays.Embree(corner), rays.Raster(corner)
    directions = random.normal(size=(8, 2, 3))
    for k, (eye, way) in enumerate(directions):
        eye = eye * (0.2 if k % 2 else 2.0)  # also amid the triangles, some of them behind the camera
        forward = way / np.sqrt((way**2).sum()) if k % 2 else -eye / np.sqrt((eye**2).sum())
        right = np.cross(forward, [0.0, 0, 1])
        right /= np.sqrt((right**2).sum())
        turn = np.stack([right, np.cross(forward, right), forward])
        grid = rays.Grid((90.0, 90.0), (80.0, 60.0), 0.5, 0.5, 1.0, 160, 120)
        a, b = fast.first(turn, eye, grid), slow.first(turn, eye, grid)
        if k % 2 == 0:  # from outside all closed solids show their outer sides; these triangles do not close
            slow_all = rays.Raster(np.concatenate([corner, corner[:, ::-1]]))
            b = slow_all.first(turn, eye, grid)
            b = np.where(b >= 0, b % 400, -1)
        assert (a >= 0).mean() > 0.05 and (a == b).mean() > 0.995
        hit = np.flatnonzero((a == b) & (a >= 0))
        local = rays.rotate_vectors(turn, corner - eye)
        weights = rays.intersect(local, a[hit], grid.directions()[hit])
        local = local[a[hit]]
        place = (weights[..., None] * local).sum(axis=1)
        assert (weights >= 0).all()
        assert place[:, :2] / place[:, 2:] == pytest.approx(grid.directions()[hit, :2], abs=1e-5)


def test_bands_of_a_picture_do_not_show(monkeypatch: pytest.MonkeyPatch, batch: Batch) -> None:
    whole = make_views(batch, SMALL, engine="numpy")
    monkeypatch.setattr(rays, "BLOCK", 200)
    cut = make_views(batch, SMALL, engine="numpy")
    assert all(whole.images[name].tobytes() == cut.images[name].tobytes() for name in whole.images)


def test_without_embree_numpy_does_it(monkeypatch: pytest.MonkeyPatch, batch: Batch) -> None:
    rays.best_engine.cache_clear()
    with monkeypatch.context() as patched:
        patched.setitem(sys.modules, "embreex.rtcore_scene", None)
        assert rays.best_engine() == "numpy"
        assert seen(make_views(batch, SMALL)).any()
    rays.best_engine.cache_clear()


def test_cameras_of_their_own(batch: Batch) -> None:
    poses = [{"eye": [2, 0, 0.5]}, {"eye": [0.1, 0, 2], "target": [0.1, 0, 0]}, {"eye": [1.5, 1, 1], "up": [0, 1, 0]}]
    cameras = cameras_from({"poses": poses, "width": 64, "height": 64, "fov": 50, "points": 200})
    assert cameras.count == 3 and cameras_from(cameras.plain()) == cameras
    views = make_views(batch, cameras)
    outside = views.extrinsics[2]
    eye = -np.einsum("vji,vj->vi", outside[:, :3, :3], outside[:, :3, 3])
    assert eye == pytest.approx(np.array([p["eye"] for p in poses]))
    assert outside[1, 2, :3] == pytest.approx([0, 0, -1]) and np.linalg.det(outside[:, :3, :3]) == pytest.approx(1)
    assert seen(views).any(axis=(2, 3)).all()


def test_default_cameras_stand_in_front_and_see_all(batch: Batch) -> None:
    views = make_views(batch, Cameras(count=20, points=10, width=60, height=90))
    outside = views.extrinsics
    eye = -np.einsum("bvji,bvj->bvi", outside[..., :3, :3], outside[..., :3, 3])
    assert (eye[..., 0] > 0).all() and (eye[..., 2] > 0).all()
    there = seen(views)
    assert there.any(axis=(2, 3)).all()
    assert not there[..., [0, -1], :].any() and not there[..., [0, -1]].any()


def test_a_camera_that_sees_nothing_is_an_error_in_words(batch: Batch) -> None:
    away = cameras_from({"poses": [{"eye": [2, 0, 0.2], "target": [3, 0, 0.2]}]})
    with pytest.raises(UserError, match="view 0 of object 0 does not see it"):
        make_views(batch, away)
    far = {"poses": [{"eye": [50, 0, 0.2]}], "width": 65, "height": 49, "points": 1_000_000, "fov": 60}
    with pytest.raises(UserError, match="next to nothing") as caught:
        make_views(batch, cameras_from(far))
    assert "fewer points" in caught.value.hint


def test_a_camera_within_a_solid_is_refused_but_not_one_in_the_cavity(batch: Batch) -> None:
    parts = batch.parts()
    rear = next(i for i, path in enumerate(parts.path) if path == "body.rear" and parts.owner[i] == 0)
    middle = parts.translation[rear] + (parts.low[rear] + parts.high[rear]) / 2
    small = {"width": 16, "height": 12, "points": 50}
    solid = [{"eye": [3, 0, 0.2]}, {"eye": middle.tolist(), "target": [1, 0, 0.2]}]
    with pytest.raises(UserError, match="view 1 of object 0 is taken from within one of its solids"):
        make_views(batch, cameras_from(small | {"poses": solid}))
    cavity = (middle + [0.06, 0.0, 0.06]).tolist()
    views = make_views(batch, cameras_from(small | {"poses": [{"eye": cavity, "target": [3, 0.0, cavity[2]]}]}))
    assert seen(views).all() and (views.images["depth"] < 0.6).all()


def test_wrong_engines_are_told_in_words(batch: Batch, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(UsageError, match="there is no engine `optix`"):
        make_views(batch, SMALL, engine="optix")
    monkeypatch.setattr("artipg_dsl.annotate.views.best_engine", lambda: "numpy")
    with pytest.raises(UserError, match="the engine `embree` needs embreex, which is not installed") as caught:
        make_views(batch, SMALL, engine="embree")
    assert "artipg_dsl[rays]" in str(caught.value.hint)


WRONG = [
    ("[]", "an object is needed"),
    ('{"view": 3}', "`view` is not known"),
    ('{"views": 0}', "`views` is 0"),
    ('{"views": 2.5}', "a whole number"),
    ('{"views": true}', "a whole number"),
    ('{"width": 100000}', "`width` is 100000"),
    ('{"fov": 200}', "`fov` is 200"),
    ('{"fov": "wide"}', "degrees is needed"),
    ('{"azimuth": [60, -60]}', "runs from 60 down to -60"),
    ('{"azimuth": [1, 2, 3]}', "lowest and highest"),
    ('{"elevation": [0, 100]}', "`elevation` is 0 .. 100"),
    ('{"distance": [0.5, 1], "fov": 90}', "within the object"),
    ('{"poses": []}', "at least one pose"),
    ('{"poses": [[1, 2, 3]]}', "pose 0: `eye` is needed"),
    ('{"poses": [{"eye": [1, 2]}]}', "pose 0: `eye` is \\[1, 2\\]"),
    ('{"poses": [{"eye": [1, 2, 3], "target": [1, 2, 3]}]}', "looks nowhere"),
    ('{"poses": [{"eye": [1, 2, 3], "up": [0, 0, 0]}]}', "no direction"),
    ('{"poses": [{"eye": [1, 2, 3]}], "views": 4}', "`views` beside `poses`"),
    ('{"fov": 30, "fov": 40}', "`fov` is given twice"),
    ("[" * 100_000, "cannot be read"),
    ('{"views": ' + "9" * 5000 + "}", "cannot be read"),
    ('{"views": 3,}', "cameras.json:1:1[23]: it is not JSON"),  # Python 3.13 points at the comma
]


@pytest.mark.parametrize("text, message", WRONG, ids=[text[:40] for text, _ in WRONG])
def test_a_broken_camera_file_is_told_in_words(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "cameras.json").write_text(text)
    with pytest.raises(UserError, match=message) as caught:
        read_cameras(str(tmp_path / "cameras.json"))
    assert "cameras.json" in caught.value.message


def test_a_number_of_views_or_a_file(tmp_path: Path) -> None:
    assert read_cameras("3") == Cameras(count=3)
    path = tmp_path / "c.json"
    path.write_text(json.dumps({"views": 2, "azimuth": 30, "distance": [1, 2]}))
    cameras = read_cameras(str(path))
    assert (cameras.count, cameras.azimuth, cameras.distance) == (2, (30.0, 30.0), (1.0, 2.0))
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes())
    assert read_cameras(str(path)) == cameras
    wrong = {
        "\u00b2": "no camera file",
        "0": "`views` is 0",
        "-2": "`views` is -2",
        "99999": "99999",
        "no.json": "no camera file",
    }
    for text, message in wrong.items():
        with pytest.raises(UsageError, match=message):
            read_cameras(text)
    (tmp_path / "b.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UserError, match="it is not text"):
        read_cameras(str(tmp_path / "b.json"))
