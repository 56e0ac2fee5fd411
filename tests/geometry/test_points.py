"""Surface points: exactly n, on the visible surface, uniform, the same for an object alone and in any batch."""

import math

import numpy as np
import pytest

from artipg_dsl import random
from artipg_dsl.geometry import mesh, points
from artipg_dsl.geometry.sites import SiteTable
from artipg_dsl.graph.expr import ZERO
from artipg_dsl.graph.formula import compile_formula
from artipg_dsl.graph.substitution import substitute

from . import scenes, shapes
from .selftest import check_primitive

KEY = random.key(7, "points")
PRIMITIVES = [shapes.cuboid(), shapes.rounded_cuboid(), shapes.cylinder()]
BOX, ROUND = PRIMITIVES[0], PRIMITIVES[2]


def numbers(*values):
    return np.array(values, dtype=np.uint64)


def box(number, size, at, owner=(0,)):
    return scenes.table(number, BOX, dict(zip(("size.x", "size.y", "size.z"), size, strict=True)), owner, [at])


def only(sites: list[SiteTable], chosen: list[int]) -> list[SiteTable]:
    """The tables of some objects, renumbered from 0."""
    out = []
    for site in sites:
        rows = np.concatenate([np.flatnonzero(site.owner == o) for o in chosen])
        owner = np.concatenate([np.full((site.owner == o).sum(), n) for n, o in enumerate(chosen)])
        out.append(
            SiteTable(
                site.number,
                site.path,
                site.primitive,
                mesh.take(site.params, rows),
                owner,
                site.rotation[rows],
                site.translation[rows],
                site.mirror[rows],
                site.link[rows],
                site.instance[rows],
                site.semantic[rows],
                site.rank[rows],
            )
        )
    return out


def test_an_object_has_the_same_points_alone_and_in_any_batch():
    address = np.arange(70, dtype=np.uint64)
    sites = scenes.cluttered(PRIMITIVES, address, 12)
    whole = points.sample(sites, 70, 300, KEY, address)
    again = points.sample(sites, 70, 300, KEY, address)
    for name in points.PointSet.__slots__:
        assert getattr(whole, name).tobytes() == getattr(again, name).tobytes()
    for chosen in ([37], [69], [41, 3, 40]):
        part = points.sample(only(sites, chosen), len(chosen), 300, KEY, address[chosen])
        for name in ("site", "patch", "u", "v", "position", "normal"):
            assert getattr(part, name).tobytes() == getattr(whole, name)[chosen].tobytes(), name


def test_bindings_evaluate_to_the_very_positions():
    address = np.arange(40, dtype=np.uint64)
    sites = scenes.cluttered(PRIMITIVES, address, 9)
    found = points.sample(sites, 40, 200, KEY, address)
    position, normal = points.evaluate(sites, found)
    assert position.tobytes() == found.position.tobytes()
    assert normal.tobytes() == found.normal.tobytes()
    assert np.allclose((found.normal**2).sum(axis=-1), 1.0, atol=1e-12)


def inside_any(sites, owner, position, skip_site, skip_row):
    """(m,) the least inside value over all rows but the own one, straight from the definition."""
    least = np.full(len(owner), np.inf)
    for site in sites:
        formula = compile_formula((site.primitive.inside,), (*site.primitive.parameters, "p.x", "p.y", "p.z"))
        for row in range(len(site)):
            at = np.flatnonzero((owner == site.owner[row]) & ~((skip_site == site.number) & (skip_row == row)))
            local = (position[at] - site.translation[row]) @ site.rotation[row]
            local[:, 1] *= site.mirror[row]
            value = formula(*(site.params[n][row] for n in site.primitive.parameters), *local.T)[0]
            least[at] = np.minimum(least[at], value)
    return least


def test_points_lie_on_the_visible_surface_only():
    address = np.arange(6, dtype=np.uint64)
    sites = scenes.cluttered(PRIMITIVES, address, 14)
    found = points.sample(sites, 6, 2000, KEY, address)
    owner = np.repeat(np.arange(6), 2000)
    flat = found.position.reshape(-1, 3)
    least = inside_any(sites, owner, flat, found.site.ravel(), found.row.ravel())
    assert least.min() > -1e-5
    own = np.full(len(owner), np.nan)
    for site in sites:
        at = np.flatnonzero(found.site.ravel() == site.number)
        row = found.row.ravel()[at]
        local = np.einsum("mij,mi->mj", site.rotation[row], flat[at] - site.translation[row])
        local[:, 1] *= site.mirror[row]
        formula = compile_formula((site.primitive.inside,), (*site.primitive.parameters, "p.x", "p.y", "p.z"))
        own[at] = formula(*(site.params[n][row] for n in site.primitive.parameters), *local.T)[0]
    assert np.abs(own).max() < 1e-12


def test_points_are_uniform_over_what_is_visible():
    """A plate with a block standing on it: shares per face follow the visible areas."""
    sites = [box(0, (0.4, 0.4, 0.02), (0, 0, 0)), box(1, (0.1, 0.2, 0.3), (0, 0, 0.16))]
    found = points.sample(sites, 1, 40_000, KEY, numbers(3))
    areas = {
        (0, 0): 0.008,
        (0, 1): 0.008,
        (0, 2): 0.008,
        (0, 3): 0.008,
        (0, 4): 0.16,
        (0, 5): 0.16 - 0.02,
        (1, 0): 0.06,
        (1, 1): 0.06,
        (1, 2): 0.03,
        (1, 3): 0.03,
        (1, 5): 0.02,
    }
    total = sum(areas.values())
    for key, area in areas.items():
        count = int(((found.site == key[0]) & (found.patch == key[1])).sum())
        assert abs(count - 40_000 * area / total) < 3 + 0.02 * 40_000 * area / total, key
    assert not ((found.site == 1) & (found.patch == 4)).any()
    top = found.position[0][(found.site[0] == 0) & (found.patch[0] == 5)]
    assert not ((np.abs(top[:, 0]) < 0.05) & (np.abs(top[:, 1]) < 0.1)).any()
    counts = np.histogram2d(top[:, 0], top[:, 1], 8, ((-0.2, 0.2), (-0.2, 0.2)))[0]
    outer = counts[[0, 1, 6, 7]]
    expected = 40_000 * 0.0025 / total
    assert ((outer - expected) ** 2 / expected).sum() < outer.size + 6 * math.sqrt(2 * outer.size)


def test_coincident_faces_belong_to_the_lower_site_and_pressed_faces_to_none():
    """Two cubes that share half their bottom plane, overlapping; a third pressed on the side of the first."""
    sites = [
        box(0, (0.2, 0.2, 0.2), (0, 0, 0)),
        box(1, (0.2, 0.2, 0.1), (0.1, 0, -0.05)),
        box(2, (0.2, 0.2, 0.2), (0, 0.2, 0)),
    ]
    found = points.sample(sites, 1, 30_000, KEY, numbers(0))
    site, patch, at = found.site[0], found.patch[0], found.position[0]
    bottom = (np.abs(at[:, 2] + 0.1) < 1e-9) & (np.abs(at[:, 0]) < 0.0999) & (np.abs(at[:, 1]) < 0.0999)
    assert bottom.sum() > 500 and (site[bottom] == 0).all()
    beyond = (np.abs(at[:, 2] + 0.1) < 1e-9) & (at[:, 0] > 0.1) & (np.abs(at[:, 1]) < 0.0999)
    assert beyond.sum() > 500 and (site[beyond] == 1).all()
    assert not ((site == 0) & (patch == 2)).any()  # left of the first: pressed against the third
    pressed = (site == 2) & (patch == 3)
    assert not (pressed & (np.abs(at[:, 0]) < 0.0999)).any()


def test_a_gap_of_a_fifth_of_a_millimetre_is_no_contact():
    sites = [box(0, (0.5, 0.5, 0.5), (0, 0, 0)), box(1, (0.5, 0.5, 0.5), (0, 0, 0.5002))]
    found = points.sample(sites, 1, 12_000, KEY, numbers(0))
    assert abs(((found.site == 1) & (found.patch == 4)).sum() - 1000) < 5


def test_nearly_buried_objects_get_their_points_from_further_rounds():
    """99 % of the candidates lie inside: only a plate of the cylinder looks out."""
    tube = {"radius": 0.1, "top_radius": 0.1, "height": 1.02}
    sites = [
        scenes.table(0, ROUND, tube, [0, 1], np.zeros(3)),
        scenes.table(1, BOX, {"size.x": 0.01, "size.y": 0.01, "size.z": 0.01}, [0, 1], np.zeros(3)),
    ]
    for number in range(2, 14):  # pressed together: hardly a face is free
        sites.append(box(number, (0.3, 0.3, 1.0), (0.0, 0.0, 0.001 * (number - 2)), (1,)))
    found = points.sample(sites, 2, 700, KEY, numbers(5, 6))
    assert found.u.shape == (2, 700)
    least = inside_any(
        sites, np.repeat([0, 1], 700), found.position.reshape(-1, 3), found.site.ravel(), found.row.ravel()
    )
    assert least.min() > -1e-5
    assert (np.abs(found.position).max(axis=1) > 0).all()


def test_an_object_without_surface_is_named():
    with pytest.raises(points.PointsError) as caught:
        points.sample([box(0, (0.1, 0.1, 0.1), (0, 0, 0))], 3, 10, KEY, numbers(0, 1, 2))
    assert caught.value.objects == [1, 2]


def test_partial_turns_and_sleeves_take_points_on_existing_patches_only():
    ring = shapes.hollow_frustum()
    params = {"radius": 0.1, "top_radius": 0.12, "bore": 0.03, "top_bore": 0.03, "height": 0.2}
    spans = np.array([2 * math.pi, math.pi])
    sites = [scenes.table(0, ring, {**params, "span": spans}, [0, 1], np.zeros(3))]
    found = points.sample(sites, 2, 3000, KEY, numbers(0, 1))
    assert set(found.patch[0]) == {0, 1, 2, 3} and set(found.patch[1]) == set(range(6))


def test_a_binding_to_rows_that_do_not_exist_is_refused():
    sites = [box(0, (0.1, 0.1, 0.1), (0, 0, 0))]
    found = points.sample(sites, 1, 10, KEY, numbers(0))
    found.row[0, 3] = 1
    with pytest.raises(ValueError, match="do not have"):
        points.evaluate(sites, found)


def test_a_binding_follows_a_change_of_parameters():
    """The same fractions on a box of twice the size are the points at twice the place."""
    small, large = (box(0, (s, s, s), (0, 0, 0)) for s in (0.1, 0.2))
    found = points.sample([small], 1, 500, KEY, numbers(0))
    position, normal = points.evaluate([large], found)
    assert np.allclose(position, 2 * found.position, atol=1e-15)
    assert np.array_equal(normal, found.normal)


def test_many_occluders_are_asked_in_parts(monkeypatch):
    from artipg_dsl.geometry import cover, hidden

    address = np.arange(5, dtype=np.uint64)
    sites = scenes.cluttered(PRIMITIVES, address, 12)
    whole = points.sample(sites, 5, 300, KEY, address)
    for module in (cover, hidden):
        monkeypatch.setattr(module, "PAIRS", 100)
    parts = points.sample(sites, 5, 300, KEY, address)
    assert parts.position.tobytes() == whole.position.tobytes()


def test_a_surface_with_a_constant_coordinate():
    """A block that stands on z = 0 of its own frame, with another in front of it."""
    x, y, z = shapes.size()
    lifted = tuple(
        shapes.patch(p.name, (p.position[0], p.position[1], ZERO if p.name == "bottom" else p.position[2] + z / 2))
        for p in BOX.patches
    )
    block = shapes.cuboid(
        patches=lifted,
        inside=substitute(BOX.inside, {shapes.PZ: shapes.PZ - z / 2}),
        low=(*BOX.low[:2], ZERO),
        high=(*BOX.high[:2], z),
    )
    assert check_primitive(block) == []
    sites = [
        scenes.table(n, block, {"size.x": 0.1, "size.y": 0.1, "size.z": 0.1}, [0], [at])
        for n, at in enumerate(((0, 0, 0), (0.1, 0, 0)))
    ]
    found = points.sample(sites, 1, 1000, KEY, numbers(0))
    assert abs((found.patch == 4).sum() - 200) < 4 and not ((found.site == 0) & (found.patch == 0)).any()
