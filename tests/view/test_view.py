"""Pictures: right occlusion and colours from every renderer, valid PNG, labels, and the choice of a renderer."""

from __future__ import annotations

import struct
import zlib
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from export.fake_batch import FakeBatch
from scipy.ndimage import gaussian_filter

from artipg_dsl.errors import UsageError
from artipg_dsl.export.write import ExportError
from artipg_dsl.geometry.resolution import Resolution
from artipg_dsl.robot.robots import Robots
from artipg_dsl.run.painting import paint_with
from artipg_dsl.session import Session
from artipg_dsl.view import regions
from artipg_dsl.view import sheet as sheets
from artipg_dsl.view.camera import look_at, place_lights
from artipg_dsl.view.deferred import camera_rays
from artipg_dsl.view.png import png_bytes, srgb, write_number
from artipg_dsl.view.raster_cpu import barycentric, rasterise
from artipg_dsl.view.scene import Scene, hex_colour, make_scene, open_values, part_colours
from artipg_dsl.view.softness import blur, spread_over_surface

BACKDROP = hex_colour(sheets.BACKDROP)


def available(name: str):  # type: ignore[no-untyped-def]
    try:
        return sheets.make_renderer(name, 64)
    except ExportError as error:
        pytest.skip(error.message)


def decode(data: bytes) -> np.ndarray:
    """An independent reading of what ``png_bytes`` writes."""
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    chunks, at = {}, 8
    while at < len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + body)
        chunks[kind], at = body, at + 12 + size
    width, height = struct.unpack(">II", chunks[b"IHDR"][:8])
    rows = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), np.uint8).reshape(height, 1 + 3 * width)
    assert (rows[:, 0] == 2).all()
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 3)


def two_squares() -> Scene:
    """A red square, facing +x, behind a green one on its right half and a blue pane to see through on its left."""
    square = np.array([[0, -1, 0], [0, 1, 0], [0, 1, 2], [0, -1, 2]], dtype=float)
    right, left = square.copy(), square.copy()
    right[:, 1], right[:, 0] = right[:, 1] / 2 + 0.5, 0.3  # the viewer's right is the object's left, +y
    left[:, 1], left[:, 0], left[:, 2] = left[:, 1] / 2 - 0.5, 0.3, left[:, 2] / 2
    colours = [[0.8, 0.1, 0.1, 1.0], [0.1, 0.8, 0.1, 1.0], [0.1, 0.1, 0.8, 0.5]]
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    return Scene(
        np.concatenate([square, right, left]),
        np.tile([1.0, 0, 0], (12, 1)),
        np.concatenate([faces, faces + 4, faces + 8]),
        np.repeat(colours, 4, axis=0),
        np.zeros(12),
        np.zeros(12),
    )


@pytest.mark.parametrize("name", sheets.RENDERERS)
def test_what_is_in_front_covers_what_is_behind(name: str) -> None:
    draw, seen = available(name), two_squares()
    camera = look_at(seen.vertices, azimuth=0.0, elevation=0.5)
    image = draw.render(seen, camera, place_lights(camera, *draw.light_counts), 0.0)
    assert image.shape == (64, 64, 3) and np.isfinite(image).all()

    def at(point: list[float]) -> np.ndarray:
        x, y, z = camera.local(np.array([point]))[:, 0]
        column, row = (1 + x * camera.scale / -z) * 32, (1 - y * camera.scale / -z) * 32
        return image[int(row), int(column)]

    green, red, pane = at([0.3, 0.5, 1.0]), at([0.0, -0.5, 1.6]), at([0.3, -0.5, 0.5])
    assert green[1] > 3 * green[0] and red[0] > 3 * red[1]
    assert pane[2] > 2 * red[2] and pane[0] > 2 * pane[1], "red shines through the blue pane"


@pytest.mark.parametrize("name", sheets.RENDERERS)
def test_a_sheet_shows_objects_on_a_plain_backdrop(name: str) -> None:
    available(name)
    image = sheets.draw_sheet(FakeBatch(3), sheets.Sheet(tile=64, columns=2, which=name))
    assert image.shape == (128, 128, 3) and image.dtype == np.uint8
    plain = srgb(BACKDROP)
    assert (image[64:, 64:] == plain).all(), "the fourth tile is empty"
    shown = (np.abs(image[:64, :64].astype(int) - plain).sum(axis=2) > 60).mean()
    assert 0.15 < shown < 0.8
    assert np.abs(image[0].astype(int) - plain).max() <= 2, "the border is backdrop"
    changed = np.abs(image[:64, :64].astype(int) - image[:64, 64:]).sum(axis=2) > 60
    assert changed.mean() > 0.03, "the second is opened"


@pytest.mark.slow
def test_one_may_look_from_any_side() -> None:
    seen = {
        view: sheets.draw_sheet(FakeBatch(1), sheets.Sheet(tile=48, which="numpy", view=view)) for view in sheets.VIEWS
    }
    pictures = list(seen.values())
    for k, picture in enumerate(pictures):
        assert all((picture != other).any() for other in pictures[:k]), list(seen)[k]
    assert (sheets.draw_sheet(FakeBatch(1), sheets.Sheet(tile=48, which="numpy", view="180,0")) == seen["back"]).all()
    assert (
        sheets.draw_sheet(FakeBatch(1), sheets.Sheet(tile=48, which="numpy", view=(0.0, 90.0))) == seen["top"]
    ).all()
    for wrong in ("sideways", "10", "10,200", "nan,0", (1.0,)):
        with pytest.raises(UsageError) as caught:
            sheets.draw_sheet(FakeBatch(1), sheets.Sheet(view=wrong))  # type: ignore[arg-type]
        assert "back" in caught.value.args[0]


@pytest.mark.parametrize("wrong", [{"tile": 8}, {"tile": 100_000}, {"states": "opened"}])
def test_tiles_and_states_that_cannot_be_are_told(wrong: dict[str, Any]) -> None:
    with pytest.raises(UsageError, match="a tile is|unknown states"):
        sheets.draw_sheet(FakeBatch(1), sheets.Sheet(which="numpy", **wrong))
    assert sheets.draw_sheet(FakeBatch(1), sheets.Sheet(which="numpy", tile=16)).shape == (16, 16, 3)


def test_renderers_agree() -> None:
    drawn = {}
    for name in sheets.RENDERERS:
        with suppress(ExportError):
            drawn[name] = sheets.draw_sheet(FakeBatch(1), sheets.Sheet(tile=64, which=name)).astype(int)
    if len(drawn) < 2:
        pytest.skip(f"only {', '.join(drawn)} can draw here")
    first, *others = drawn.values()
    for image in others:
        assert np.abs(image - first).mean() < 6


def test_colour_by_part_and_by_material_differ() -> None:
    batch = FakeBatch(1)
    robots = Robots(batch, physics=False)
    part, material = (make_scene(robots, 0, batch.pose(), colouring) for colouring in ("part", "material"))
    assert (part.vertices == material.vertices).all() and np.abs(part.colour - material.colour).max() > 0.1
    assert sorted(set(material.colour[:, 3].tolist())) == pytest.approx([0.4, 1.0])


def test_every_shipped_word_of_parts_has_a_colour_of_its_own() -> None:
    words = Session.of("Keyboard").sampler.program.vocabularies["semantic"]
    colours = srgb(part_colours())[: len(words)]
    apart = np.abs(colours[:, None].astype(int) - colours[None]).max(axis=2) + 255 * np.eye(len(colours), dtype=int)
    assert len(colours) == len(words)
    assert apart.min() >= 6


def test_regions_lie_where_labels_say() -> None:
    batch = Session.of("Microwave").sampler.batch(np.arange(2), 0)
    robots = Robots(batch, physics=False)
    shown, said = regions.find_regions(batch, robots, 1, batch.pose(), "affordance")
    assert {"press", "turn", "contain", "support"} <= said <= set(regions.words_said(batch, "affordance"))
    whole = np.linalg.norm(np.cross(*np.diff(shown.vertices[shown.faces], axis=1).transpose(1, 0, 2)), axis=1).sum() / 2
    plain = make_scene(robots, 1, batch.pose(), "material")
    every = np.linalg.norm(np.cross(*np.diff(plain.vertices[plain.faces], axis=1).transpose(1, 0, 2)), axis=1).sum() / 2
    assert whole == pytest.approx(every, rel=0.005), "cutting and joining leaves the surface whole"
    assert np.linalg.norm(shown.normals, axis=1) == pytest.approx(1.0)
    yellow = regions.colours_of(batch, "affordance")["press"]
    at = np.flatnonzero((np.abs(shown.colour[:, :3] - yellow) < 1e-9).all(axis=1))
    front = shown.vertices[:, 0].max()
    assert shown.vertices[at, 0].min() > front - 0.06 and shown.normals[at, 0].min() > 0.0, (
        "keys are pressed from the front"
    )


def test_every_shipped_affordance_has_a_colour_of_its_own() -> None:
    said = Session.of("Microwave").sampler.program.vocabularies["affordance"]
    assert len(set(regions.COLOURS)) == len(regions.COLOURS) >= len(said)


def test_stripes_share_out_what_several_words_say() -> None:
    place = np.stack([np.linspace(0, 1, 1000)] * 3, axis=1)
    red, blue = np.array([1.0, 0, 0]), np.array([0, 0, 1.0])
    shares = {"pull": np.ones(1000), "open": np.where(place[:, 0] < 0.5, 1.0, 0.0)}
    tint, painted = regions.paint([red, blue], shares, place, np.full(1000, 0.02))
    assert painted.all() and (tint[500:] == red).all()
    assert 0.35 < (tint[:500] == blue).all(axis=1).mean() < 0.65
    assert not regions.paint([], {}, place, np.full(1000, 0.02))[1].any()


def test_a_triangle_is_cut_into_squares_of_a_number() -> None:
    for n in (1, 2, 8):
        made = regions.subdivide(n)
        area = np.linalg.det(made)
        assert made.shape == (n * n, 3, 3) and area == pytest.approx(np.full(n * n, 1 / n**2))


def test_a_legend_names_what_is_shown() -> None:
    strip = sheets.draw_legend({"pull": np.array([255, 0, 0]), "press": np.array([0, 0, 255])}, 200)
    assert (strip == (255, 0, 0)).all(axis=2).sum() == (strip == (0, 0, 255)).all(axis=2).sum() == 18 * 18
    assert (strip[:, :, 0] == 60).any()


def test_opened_goes_most_of_the_way() -> None:
    assert open_values(FakeBatch(1)) == pytest.approx([1.9 * 0.8, 0.005 * 0.8])


def test_an_opened_door_is_elsewhere() -> None:
    batch = FakeBatch(1)
    robots = Robots(batch, physics=False)
    rest, swung = (make_scene(robots, 0, batch.pose(states)).vertices for states in (None, open_values(batch)))
    assert rest.shape == swung.shape and swung[:, 0].max() > rest[:, 0].max() + 0.2


def test_the_camera_frames_all_points() -> None:
    points = np.random.default_rng(1).uniform([-3, -0.1, 0], [0.5, 2, 1], (200, 3))
    camera = look_at(points)
    x, y, z = camera.local(points)
    place, depth = camera.picture(points)
    assert (depth == -z).all()
    reach = np.abs(place).max(axis=1)
    assert reach.max() < 1.0 and reach.max() > 0.75 and (z < 0).all()
    assert (-z > camera.near).all() and (-z < camera.far).all()
    clip = np.concatenate([points, np.ones((200, 1))], axis=1) @ camera.matrix().T
    assert clip[:, 0] / clip[:, 3] == pytest.approx(x * camera.scale / -z)


def test_rays_pass_through_the_picture() -> None:
    camera = look_at(np.array([[0.0, 0, 0], [1, 1, 1]]))
    rays = camera_rays(camera, 16)
    local = camera.local(rays.direction + camera.eye)
    assert local[0, 0] < 0 < local[1, 0] and local[0, -1] > 0 > local[1, -1]


def test_blurring_is_a_gaussian_filter() -> None:
    picture = np.random.default_rng(3).uniform(size=(2, 24, 24)).astype(np.float32)
    expected = gaussian_filter(picture, 1.8, truncate=2.5, axes=(1, 2), mode="constant")
    assert blur(picture, 1.8) == pytest.approx(expected, abs=1e-6)


def test_light_is_spread_over_one_surface_alone() -> None:
    """What differs within squares of two by two is evened out; edges of surfaces, in direction or depth, are kept."""
    row, column = np.divmod(np.arange(16 * 16), 16)
    light = (0.5 + 0.2 * (row % 2) - 0.1 * (column % 2) + 0.3 * (column > 7)).astype(np.float32)[None]
    normal, level = np.zeros((3, len(row)), dtype=np.float32), np.zeros(len(row), dtype=np.float32)
    normal[0], normal[1] = column <= 7, column > 7
    turned = spread_over_surface(light, np.arange(len(row)), 16, normal, level)
    normal[0], normal[1], level[:] = 1, 0, column > 7
    behind = spread_over_surface(light, np.arange(len(row)), 16, normal, level)
    inner = (row > 0) & (row < 15) & (column % 8 > 0) & (column % 8 < 7)
    assert turned[0, inner] == pytest.approx(np.where(column > 7, 0.85, 0.55)[inner], abs=1e-6)
    assert (turned == behind).all() and turned[0, column <= 7].max() < turned[0, column > 7].min()


def test_quarters_of_a_light_surround_it() -> None:
    lights = place_lights(look_at(np.array([[0.0, 0, 0], [1, 1, 1]])), 8, 24)
    around = lights.around()
    assert np.linalg.norm(around, axis=2) == pytest.approx(1.0)
    tilt = np.arccos((around * lights.direction[:, None]).sum(axis=2))
    assert np.tan(tilt) == pytest.approx(np.tile(lights.spread[:, None] / 2, 4))
    middle = around.mean(axis=1)
    assert np.cross(middle, lights.direction) == pytest.approx(np.zeros((32, 3)), abs=1e-9)


def test_the_rasteriser_covers_a_square_once_and_keeps_the_nearest() -> None:
    corners = np.array(
        [[[2.0, 2], [10, 2], [10, 10]], [[2, 2], [10, 10], [2, 10]], [[4, 4], [8, 4], [8, 8]], [[1, 1], [5, 5], [9, 9]]]
    )
    found, near = rasterise(corners, np.array([[1.0] * 3, [1.0] * 3, [2.0] * 3, [9.0] * 3]), 12)
    assert (found >= 0).sum() == 64 and set(np.unique(found)) == {-1, 0, 1, 2}, (
        "a triangle seen from its edge covers nothing"
    )
    assert found[5, 7] == 2 and near[5, 7] == 2.0 and found[0, 0] == -1
    none, _ = rasterise(np.zeros((0, 3, 2)), np.zeros((0, 3)), 4)
    assert (none == -1).all()
    weights = barycentric(corners[:1], np.array([8.0]), np.array([4.0]))
    assert weights @ corners[0] == pytest.approx(np.array([[8.0, 4.0]]))


def test_png_holds_the_picture() -> None:
    image = np.random.default_rng(0).integers(0, 256, (13, 21, 3), dtype=np.uint8)
    assert (decode(png_bytes(image)) == image).all()


def test_numbers_are_drawn_into_the_corner() -> None:
    image = np.zeros((40, 60, 3), dtype=np.uint8)
    write_number(image, 17, (255, 0, 9), size=2, margin=4)
    ink = (image == (255, 0, 9)).all(axis=2)
    assert (
        ink.any()
        and not ink[:20].any()
        and ink[22:36, 4:14].any()
        and ink[22:36, 16:26].any()
        and not ink[:, 30:].any()
    )
    write_number(image, 123456789, (1, 1, 1), size=2)  # runs over the edge without complaint


def test_a_sheet_is_written_whole_and_not_over_another(tmp_path: Path) -> None:
    target = tmp_path / "sheet.png"
    sheets.write_sheet(FakeBatch(1), target, sheets.Sheet(tile=32, which="numpy"))
    assert decode(target.read_bytes()).std() > 5
    with pytest.raises(ExportError, match="exists"):
        sheets.write_sheet(FakeBatch(1), target, sheets.Sheet(tile=32, which="numpy"))


@pytest.mark.slow
def test_several_processes_paint_the_same_sheet() -> None:
    alone = sheets.draw_sheet(FakeBatch(3), sheets.Sheet(tile=32, which="numpy"))
    shared = sheets.draw_sheet(FakeBatch(3), sheets.Sheet(tile=32, which="numpy"), paint_all=paint_with(2))
    assert (alone == shared).all()


@pytest.mark.parametrize("tile", [32, 512])
def test_outlines_are_as_fine_as_the_pixels(tile: int) -> None:
    batch = Session.of("Bottle").sampler.batch(np.arange(2), 0)
    robots = Robots(batch, resolution=sheets.by_pixels(batch, tile), physics=False)
    fine = Robots(batch, resolution=Resolution(steps=512), physics=False)
    for i in range(2):
        rough, true = (np.concatenate([item.group.vertices[item.k] for item in r.visuals[i]]) for r in (robots, fine))
        pixel = np.ptp(true, axis=0).max() / tile
        # how far the outline lies off the true one, to all sides
        around = np.linspace(0, 2 * np.pi, 97)
        ways = np.stack([np.cos(around), np.sin(around), np.zeros(97)])
        assert ((true @ ways).max(axis=0) - (rough @ ways).max(axis=0)).max() < 0.15 * pixel
    assert sum(len(g.faces) for g in robots.meshes) < sum(len(g.faces) for g in fine.meshes) / 4


def test_wrong_options_are_answered_in_words() -> None:
    for options, words in (({"which": "opengl"}, "moderngl"), ({"colour": "mass"}, "material")):
        with pytest.raises(UsageError) as caught:
            sheets.draw_sheet(FakeBatch(1), sheets.Sheet(**options))  # type: ignore[arg-type]
        assert words in caught.value.hint
    with pytest.raises(ExportError):
        sheets.draw_sheet(FakeBatch(0))


def test_without_graphics_libraries_numpy_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    for missing in ("moderngl", "embreex", "embreex.mesh_construction", "embreex.rtcore_scene"):
        monkeypatch.setitem(sys.modules, missing, None)
    assert sheets.make_renderer("auto", 16).name == "numpy"
    with pytest.raises(ExportError) as caught:
        sheets.make_renderer("moderngl", 16)
    assert "moderngl" in caught.value.message


def test_sheets_have_few_empty_tiles() -> None:
    for count in (1, 2, 5, 12, 30, 31, 100):
        columns = sheets.default_columns(count)
        assert -count % columns < columns and columns * 0.45 <= -(-count // columns) <= columns * 2
    assert sheets.default_columns(30) == 6 and sheets.default_columns(12) == 4
