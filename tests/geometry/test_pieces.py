"""Convex pieces: convex, within the solid, filling it, the same faces for an instance in any batch."""

import numpy as np
import pytest

from artipg_dsl.geometry import hulls, mesh, pieces
from artipg_dsl.geometry.errors import PrimitiveError
from artipg_dsl.geometry.sites import join_tables, scatter
from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.graph.expr import ZERO, const, var
from artipg_dsl.graph.formula import compile_formula
from artipg_dsl.graph.primitive import Piece
from artipg_dsl.session import Session

from . import shapes


def outside(primitive, params, rows, points):
    """(k', P): the inside function at points (k', P, 3) of instances."""
    formula = compile_formula((primitive.inside,), (*primitive.parameters, "p.x", "p.y", "p.z"))
    values = [params[n][rows, None] for n in primitive.parameters]
    return formula(*values, *np.moveaxis(points, -1, 0))[0]


@pytest.mark.parametrize("make", shapes.ALL)
def test_pieces_are_convex_and_within_the_solid_and_fill_the_mesh(make):
    primitive = make()
    params = draw_trial(primitive, 30)
    total = np.zeros(len(params[""]))
    weights = np.random.default_rng(0).dirichlet(np.full(3, 0.5), 50)
    for group in pieces.build(primitive, params):
        volume, _, _ = mesh.moments(group.vertices, group.faces)
        assert (volume > 0).all()
        total[group.rows] += volume
        extent = np.ptp(group.vertices, axis=1).max(axis=1)
        corners = group.vertices[:, group.faces]
        normal = np.cross(corners[:, :, 1] - corners[:, :, 0], corners[:, :, 2] - corners[:, :, 0])
        normal /= np.maximum(np.sqrt((normal**2).sum(axis=-1, keepdims=True)), 1e-300)
        height = np.einsum("kfi,kpi->kfp", normal, group.vertices) - (normal * corners[:, :, 0]).sum(axis=-1)[..., None]
        assert (height <= 1e-6 * extent[:, None, None]).all()
        skin = np.einsum("wc,kfci->kfwi", weights, corners).reshape(len(group.rows), -1, 3)
        assert (outside(primitive, params, group.rows, skin) < 1e-7 * extent[:, None]).all()
    ratio = total / mesh.volume_inertia(primitive, params)[0]
    assert ratio.min() > 0.75 and ratio.max() < 1 + 1e-9


def test_counts_and_guards_follow_the_parameters():
    x, y, z = shapes.size()
    half = [(a * (x / 2), b * (y / 2), c * (z / 2)) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)]
    corners = tuple((const(0.5) * p[0] + var("i") * 0.01, p[1], p[2]) for p in half)
    long = shapes.call("lt", const(0.5), x)
    split = shapes.cuboid(
        pieces=(Piece("slab", corners, shapes.call("floor", x * 10.0) + 1.0), Piece("extra", tuple(half), None, long))
    )
    params = {"size.x": np.array([0.05, 0.25, 0.95]), "size.y": np.full(3, 0.1), "size.z": np.full(3, 0.2)}
    groups = pieces.build(split, params)
    rows = {g.name: g.rows.tolist() for g in groups}
    assert rows["slab[0]"] == [0, 1, 2] and rows["slab[2]"] == [1, 2] and rows["slab[9]"] == [2]
    assert rows["extra"] == [2] and "slab[10]" not in rows
    second = next(g for g in groups if g.name == "slab[1]")
    assert np.allclose(second.vertices.mean(axis=1)[:, 0], 0.01)


def test_pieces_there_as_often_are_computed_by_one_formula(monkeypatch):
    """Those of one count and guard, wherever they stand; the points are those of each alone, bit for bit."""
    x, y, z = shapes.size()
    box = [(a * (x / 2), b * (y / 2), c * (z / 2)) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)]
    many, long = shapes.call("floor", x * 10.0) + 1.0, shapes.call("lt", const(0.5), x)
    alone = [
        Piece(f"p{k}", tuple((const(0.1 * k) * p[0] + var("i") * 0.01, p[1], p[2]) for p in box), *there)
        for k, there in enumerate(
            [(many, None), (None, long), (many, None), (many, long), (None, None), (None, long)], 1
        )
    ]
    params = {"size.x": np.array([0.05, 0.25, 0.95]), "size.y": np.full(3, 0.1), "size.z": np.full(3, 0.2)}
    made = []
    keep = pieces.keep_formula
    monkeypatch.setattr(pieces, "keep_formula", lambda *given: made.append(given[2]) or keep(*given))
    clouds = pieces.clouds(shapes.cuboid(pieces=tuple(alone)), params)
    assert sorted(made) == [24, 24, 48, 48]
    for number, (piece, cloud) in enumerate(zip(alone, clouds, strict=True)):
        (own,) = pieces.clouds(shapes.cuboid(pieces=(piece,)), params)
        assert (cloud.number, cloud.name(0)[:2]) == (number, piece.name)
        for name in ("rows", "index", "points"):
            assert getattr(cloud, name).tobytes() == getattr(own, name).tobytes()
    total = sum(pieces.amounts(shapes.cuboid(pieces=(piece,)), params) for piece in alone)
    assert pieces.amounts(shapes.cuboid(pieces=tuple(alone)), params).tolist() == total.tolist()


def test_a_hull_that_many_pieces_share_is_verified_once():
    faces = (0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3)
    hulls.read_hull.cache_clear()
    assert hulls.read_hull((0, 1, 2, 3), faces, 4) is hulls.read_hull((0, 1, 2, 3), faces, 4)
    assert hulls.read_hull.cache_info().misses == 1
    for _ in range(2):
        with pytest.raises(ValueError):
            hulls.read_hull((0, 1, 2, 3), faces[3:], 4)


def test_faces_found_once_are_checked_for_every_instance():
    x, y, z = shapes.size()
    lift = var("size.y") - const(0.5)  # the ridge along u rises for some values and sinks for others
    points = ((-x, -x, ZERO), (x, -x, ZERO), (x, x, ZERO), (-x, x, ZERO), (ZERO, ZERO, -z), (ZERO, ZERO, lift * z))
    ridge = shapes.cuboid(pieces=(Piece("tent", points),))
    params = {n: np.array([0.3, 0.3, 0.3]) for n in ("size.x", "size.y", "size.z")}
    params["size.y"] = np.array([0.9, 0.2, 0.7])
    groups = pieces.build(ridge, params)
    assert sorted(r for g in groups for r in g.rows.tolist()) == [0, 1, 2]
    assert {g.vertices.shape[1] for g in groups} == {5, 6}
    for row in range(3):
        alone = pieces.build(ridge, mesh.take(params, np.array([row])))
        together = next(g for g in groups if row in g.rows)
        assert alone[0].vertices[0].tobytes() == together.vertices[list(together.rows).index(row)].tobytes()
        assert np.array_equal(alone[0].faces, together.faces)


def test_steps_beyond_the_test_values_have_the_faces_of_the_last(monkeypatch):
    x, y, z = shapes.size()
    half = [(a * (x / 2), b * (y / 2), c * (z / 2)) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)]
    corners = tuple((p[0] + var("i") * x, p[1], p[2]) for p in half)
    row = shapes.cuboid(pieces=(Piece("slab", corners, shapes.call("floor", x * 10.0) + 1.0),))
    most = int(np.floor(10 * draw_trial(row)["size.x"].max())) + 1
    pieces.build(row, draw_trial(row))
    monkeypatch.setattr(pieces, "_own", lambda *_: pytest.fail("a hull of its own"))
    params = {"size.x": np.array([0.1 * (most + 3)]), "size.y": np.full(1, 0.1), "size.z": np.full(1, 0.2)}
    groups = pieces.build(row, params)
    assert [g.name for g in groups] == [f"slab[{i}]" for i in range(len(groups))] and len(groups) > most
    assert all(np.array_equal(g.faces, groups[0].faces) for g in groups)


def test_pieces_without_numbers_are_refused():
    x, y, z = shapes.size()
    lump = shapes.cuboid(pieces=(Piece("lump", ((x, y, z), (-x, y, z), (x, -y, z), (-x, -y, -z))),))
    params = {name: np.full_like(value, np.nan) for name, value in draw_trial(lump).items()}
    with pytest.raises(PrimitiveError, match="lump has points that are not finite numbers"):
        pieces.build(lump, params)


def test_flat_pieces_are_refused():
    x, y, _ = shapes.size()
    flat = shapes.cuboid(pieces=(Piece("sheet", ((x, y, ZERO), (-x, y, ZERO), (x, -y, ZERO), (-x, -y, ZERO))),))
    with pytest.raises(PrimitiveError, match="sheet has no volume"):
        pieces.build(flat, draw_trial(flat))


def test_a_guarded_piece_may_be_in_no_row():
    x, y, z = shapes.size()
    whole = tuple(
        (a * (x / 2), b * (y / 2), c * (z / 2)) for a in (-1.0, 1.0) for b in (-1.0, 1.0) for c in (-1.0, 1.0)
    )
    split = shapes.cuboid(pieces=(Piece("box", whole), Piece("extra", whole, None, shapes.call("lt", const(0.5), x))))
    small = {"size.x": np.array([0.05, 0.25]), "size.y": np.full(2, 0.1), "size.z": np.full(2, 0.2)}
    assert [group.name for group in pieces.build(split, small)] == ["box"]
    assert [g.name for cloud in pieces.clouds(split, small) for g in cloud.groups()] == ["box"]


def test_tables_of_one_primitive_are_one_and_keep_what_they_have() -> None:
    """Clouds that tables have already are put together to those of all rows."""
    tables = Session.of("Microwave").sampler.batch(np.arange(6), 3).sites()
    joined = join_tables(tables)
    assert len(joined) == len({id(table.primitive) for table in tables if len(table)}) < len(tables)
    assert sum(map(len, joined)) == sum(map(len, tables))
    for table in joined:
        own = [(tables[site].params, row) for site, row in zip(table.site.tolist(), table.row.tolist(), strict=True)]
        for name, column in table.params.items():
            assert column.tolist() == [params[name][row] for params, row in own]
    scatter(tables)
    kept = join_tables(tables)
    for one, other in zip(joined, kept, strict=True):
        assert [cloud.number for cloud in one.clouds] == [cloud.number for cloud in other.clouds]
        for a, b in zip(one.clouds, other.clouds, strict=True):
            assert a.variant == b.variant
            for name in ("rows", "index", "points"):
                assert np.array_equal(getattr(a, name), getattr(b, name))
