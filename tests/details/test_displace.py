"""Closed meshes in details: refined, moved once where patches meet, not folded, sheets with their sides in order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import artipg_dsl as apg
from artipg_dsl.api import Samples
from artipg_dsl.details.binding import Real, bind
from artipg_dsl.details.calm import calm
from artipg_dsl.details.displace import _met, displace
from artipg_dsl.details.elements import Solids, elements_of
from artipg_dsl.details.record import Details
from artipg_dsl.details.skin import gather
from artipg_dsl.details.store import MeshDress
from artipg_dsl.details.suits import own_suits
from artipg_dsl.details.unfold import find_folded, find_sheets, keep_apart, normals, unfold
from artipg_dsl.details.wear import Wardrobe
from artipg_dsl.geometry.vectors import cross, dot
from artipg_dsl.robot.solids import SolidGroup, build_meshes
from artipg_dsl.runtime.batch import Batch

from .raised import RAISED, surface

EDGE = 0.02


def grids(batch: Batch) -> list[SolidGroup]:
    tables = batch.sites()
    return build_meshes(tables, edges=[np.full(len(table), EDGE) for table in tables])


def displaced(batch: Batch, details: Details, donors: np.ndarray) -> tuple[list[SolidGroup], list[np.ndarray]]:
    solids, made = Solids.of(batch.sites()), grids(batch)
    wardrobe = Wardrobe(calm(Wardrobe(details, solids)), solids)
    suits = own_suits(batch, details.elements, donors)
    return made, displace(made, wardrobe, suits, np.full(len(batch), 0.7))


def test_no_step_is_longer_than_asked(samples: Samples) -> None:
    for group in grids(samples.batch):
        corners = group.vertices[:, group.faces]
        sides = corners - np.roll(corners, 1, axis=2)
        length = np.sort(np.sqrt(dot(sides, sides)), axis=2)
        assert length[..., 1].max() <= EDGE * 1.001  # the longest side of a triangle is the diagonal of a step


def test_instances_without_a_bound_are_not_refined(samples: Samples) -> None:
    tables = samples.batch.sites()
    edges = [np.where(np.arange(len(table)) == 0, EDGE, np.inf) for table in tables]
    plain = {(g.table.number, row): len(g.faces) for g in build_meshes(tables) for row in g.rows.tolist()}
    for group in build_meshes(tables, edges=edges):
        for row in group.rows.tolist():
            few = plain[group.table.number, row]
            assert len(group.faces) > few if row == 0 else len(group.faces) == few


def test_elements_with_nothing_to_wear_are_not_dressed(samples: Samples, details: Details) -> None:
    """Of a wardrobe without the details of boards, boards wear none, and what else there is wears as before."""
    solids, batch = Solids.of(samples.batch.sites()), samples.batch
    tables = batch.sites()
    board = next(table for table in tables if table.path == "board")
    some = details.take(np.flatnonzero(details.elements.site[details.element] != board.number))
    dress = MeshDress.of(Wardrobe(some, solids), own_suits(batch, details.elements, np.arange(2)), 1.0)
    assert not dress.wears(board).any()
    assert all(dress.wears(table).all() for table in tables if table is not board)


@pytest.mark.parametrize("operations", ["cpa", "apa,dpa,cpa"])
def test_meshes_of_mutants_are_raised_and_closed(samples: Samples, details: Details, operations: str) -> None:
    batch = samples.mutate(operations, strength=2.0, share=1.0 if "dpa" in operations else 0.5).batch
    made, moved = displaced(batch, details, np.arange(2))
    risen = []
    for group, vertices in zip(made, moved, strict=True):
        faces = group.faces.astype(np.int64)
        start, end = faces.ravel(), np.roll(faces, -1, axis=1).ravel()
        assert np.array_equal(np.sort(start * 10**6 + end), np.sort(end * 10**6 + start))
        for before, after in zip(group.vertices, vertices, strict=True):
            assert not find_folded(normals(before, faces), after, faces).any()
            six = [dot(p[faces[:, 0]], cross(p[faces[:, 1]], p[faces[:, 2]])).sum() for p in (before, after)]
            assert six[1] > six[0] > 0.0
            outward = normals(before, faces)
            area = np.sqrt(dot(outward, outward))
            risen.append(np.stack([dot((after - before)[faces].mean(axis=1), outward) / area, area]))
    height, area = np.concatenate(risen, axis=1)[:, np.argsort(np.concatenate(risen, axis=1)[0])]
    middle = height[np.searchsorted(np.cumsum(area), area.sum() / 2)]
    assert abs(middle - RAISED) < 0.2 * RAISED


def test_what_is_raised_on_all_sides_keeps_its_corners(samples: Samples, details: Details) -> None:
    made, moved = displaced(samples.batch, details, np.arange(2))
    board = next(k for k, group in enumerate(made) if group.table.path.startswith("board"))
    before, after = made[board].vertices[0], moved[board][0]
    low, high = before.min(axis=0), before.max(axis=0)
    sides = (np.isclose(before, low) | np.isclose(before, high)).sum(axis=1)
    seen = (sides == 3) & np.isclose(before[:, 0], low[0])  # at the back, where no peg hides anything
    assert seen.sum() == 4
    assert np.allclose(np.abs(after - before)[seen], RAISED, rtol=0.25)


def test_an_object_is_the_same_in_any_batch(samples: Samples, details: Details) -> None:
    made, together = displaced(samples.batch, details, np.arange(2))
    alone, apart = displaced(samples.job.batch([1]), details, np.array([1]))
    found = {}
    for group, vertices in zip(made, together, strict=True):
        for row, owner in enumerate(group.table.owner[group.rows].tolist()):
            if owner == 1:
                found[group.table.number, int(group.table.rank[group.rows[row]])] = vertices[row]
    assert sum(len(vertices) for vertices in apart) == len(found) > 0
    for group, vertices in zip(alone, apart, strict=True):
        for row, rank in enumerate(group.table.rank[group.rows].tolist()):
            assert np.array_equal(found[group.table.number, rank], vertices[row])


def test_strength_nought_is_the_structure(samples: Samples, details: Details) -> None:
    solids, made = Solids.of(samples.batch.sites()), grids(samples.batch)
    suits = own_suits(samples.batch, details.elements, np.arange(2))
    wardrobe = Wardrobe(calm(Wardrobe(details, solids)), solids)
    same = displace(made, wardrobe, suits, np.full(2, 0.7), 0.0)
    assert all(np.allclose(group.vertices, vertices, atol=1e-15) for group, vertices in zip(made, same, strict=True))


def test_folds_are_undone(samples: Samples) -> None:
    skin = gather(grids(samples.batch), elements_of(samples.batch))
    before = normals(skin.place, skin.faces)
    still = np.broadcast_to(np.array([0.3, -0.1, 0.2]), skin.place.shape)
    assert unfold(skin.place, still, skin.faces, skin.element) is still  # what moves as a whole folds nothing
    chance = np.random.default_rng(2)
    wild = chance.normal(scale=0.02, size=skin.place.shape)
    assert find_folded(before, skin.place + wild, skin.faces).mean() > 0.1
    calmed = unfold(skin.place, wild, skin.faces, skin.element)
    assert not find_folded(before, skin.place + calmed, skin.faces).any()
    few = np.zeros_like(skin.place)
    few[::97] = 5.0 * EDGE
    calmed = unfold(skin.place, few, skin.faces, skin.element)
    assert not find_folded(before, skin.place + calmed, skin.faces).any() and np.abs(calmed).max() > 0.0


def test_sides_of_sheets_stay_in_their_order() -> None:
    x, y = (a.ravel() for a in np.meshgrid(np.arange(10) / 10, np.arange(10) / 10))
    place = np.concatenate([np.stack([x, y, 0.0 * x + z], axis=1) for z in (0.01, 0.0)])
    normal = np.repeat([[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]], 100, axis=0)
    mesh, scale = np.zeros(200, dtype=np.int64), np.ones(200)
    here, there, thick = find_sheets(place, normal, mesh, scale)
    assert np.array_equal(here, np.arange(200)) and np.array_equal(there, (here + 100) % 200)
    assert np.allclose(thick, 0.01)
    way = np.zeros_like(place)
    way[:100, 2] = -0.02  # through the other side
    for firm, top in ((np.ones(200, dtype=bool), -0.0085), (np.arange(200) < 100, -0.02)):
        kept = keep_apart(place, normal, way, firm, mesh, scale)
        left = (place + kept)[:100, 2] - (place + kept)[100:, 2]
        assert np.all(left > 0.001) and abs(kept[0, 2] - top) < 0.004
    assert keep_apart(place, normal, 0.0 * way, firm, mesh, scale).any() == np.False_


def test_calm_details_follow_slopes_and_no_spikes(samples: Samples, details: Details) -> None:
    solids = Solids.of(samples.batch.sites())
    slope = 0.3 * np.array([[0.01, 0.02, 0.0], [0.0, 0.01, 0.03], [0.02, 0.0, 0.01]])
    frames = solids.frames(details.elements, details.element, details.patch, details.u, details.v)
    told = 0.002 + frames.place @ slope.T
    told[::50] += 0.005
    found = calm(Wardrobe(replace(details, offset=frames.into(told)), solids))
    assert len(found) > 0.99 * len(details)
    frames = solids.frames(found.elements, found.element, found.patch, found.u, found.v)
    error = np.abs(frames.out_of(found.offset) - 0.002 - frames.place @ slope.T).max(axis=1)
    assert np.quantile(error, 0.95) < 0.001 and error.max() < 0.003
    far = np.arange(len(found)) % 7 == 0
    assert len(calm(Wardrobe(replace(found, offset=np.where(far[:, None], 1.0, found.offset)), solids))) == (~far).sum()


def of_board(details: Details, samples: Samples) -> np.ndarray:
    """The numbers of the points on the board of the first sample."""
    board = next(site.number for site in samples.batch.sites() if site.path == "board")
    elements = details.elements
    return np.flatnonzero((elements.owner == 0)[details.element] & (elements.site == board)[details.element])


def kept_of(details: Details, element: int, samples: Samples) -> int:
    found = calm(Wardrobe(details, Solids.of(samples.batch.sites())))
    return int((found.element == element).sum())


def test_meshes_do_not_ripple(samples: Samples, details: Details) -> None:
    """Offsets that are of no surface leave the primitive bare: each goes its own way, or they go together and face otherwise
    than the real surface does."""
    board, chance = of_board(details, samples), np.random.default_rng(3)
    own, others = int(details.element[board[0]]), len(details) - len(board)
    assert kept_of(details, own, samples) == len(board)
    offset = details.offset.copy()
    offset[board, 0] = chance.normal(scale=RAISED, size=len(board))
    noisy = replace(details, offset=offset)
    assert kept_of(noisy, own, samples) == 0
    assert len(calm(Wardrobe(noisy, Solids.of(samples.batch.sites())))) == others
    facing = details.facing.copy()
    facing[board] = [0.6, 0.8, 0.0]
    waves = 0.15 * np.sin(4.0 * np.pi * details.u[board]) / (4.0 * np.pi)
    offset[board, 0] = RAISED + waves
    assert kept_of(replace(details, offset=offset), own, samples) == 0
    assert kept_of(replace(details, facing=facing), own, samples) == 0, (
        "nor where the real surface lies quite otherwise"
    )


def test_meshes_do_not_fray(samples: Samples, details: Details) -> None:
    """A patch of which a part alone is bound stays bare, the others of its primitive do not."""
    board = of_board(details, samples)
    patch = np.bincount(details.patch[board]).argmax()
    half = np.setdiff1d(np.arange(len(details)), board[(details.patch[board] == patch) & (details.u[board] > 0.4)])
    found = calm(Wardrobe(details.take(half), Solids.of(samples.batch.sites())))
    mine = found.patch[of_board(found, samples)]
    assert not (mine == patch).any() and len(np.unique(mine)) == len(np.unique(details.patch[board])) - 1


def test_meshes_without_details_are_the_structure(samples: Samples, details: Details) -> None:
    made, moved = displaced(samples.batch, details.take(np.empty(0, dtype=np.int64)), np.arange(2))
    assert all(np.array_equal(group.vertices, vertices) for group, vertices in zip(made, moved, strict=True))


SHEET = """apg 1
use primitives { Cuboid }
category Panel {
  root part wall : Cuboid(size = [20cm, 2cm, 20cm])
  part screen : Cuboid(size = [16cm, 1mm, 16cm])
  connect screen.back on wall.front
}
"""


def test_sheets_are_not_drowned() -> None:
    """A screen that would sink into the wall that bears it stays in front of it."""
    batch = apg.load(SHEET, n=1, seed=1).batch
    found = surface(batch, 8000, 3)
    for sunk, left in ((0.0005, True), (0.002, False)):
        points = found.position[0] - sunk * found.normal[0]
        mixed = np.random.default_rng(1).permutation(8000)
        real = Real("panel", points[mixed], found.normal[0][mixed], np.zeros(8000, dtype=np.int64), ("all",))
        solids = Solids.of(batch.sites())
        worn = calm(Wardrobe(bind(batch, real, 8000), solids))
        screen = next(site.number for site in batch.sites() if site.path == "screen")
        assert (worn.elements.site[worn.element] == screen).any() == left


def test_nodes_of_a_vertex_meet() -> None:
    axes, way = np.eye(3), np.diag([1.0, 2.0, 3.0])
    met = _met(np.zeros(3, dtype=np.int64), axes, way, 2)
    assert np.allclose(met[0], [1.0, 2.0, 3.0], rtol=0.1) and not met[1].any()
    alone = _met(np.array([1]), axes[:1], np.array([[0.1, 0.2, 0.3]]), 2)
    assert np.allclose(alone[1], [0.1, 0.2, 0.3])


SHEATH = """apg 1
use primitives { Cylinder, HollowFrustum, Cuboid }
category Sheath {
  param tall : length in 19cm .. 21cm = 20cm
  root part plate : Cuboid(size = [10cm, 10cm, 3cm])
  part rod : Cylinder(radius = 1cm, height = tall) along z
  part sleeve : HollowFrustum(radius = 15mm, bore = 10.5mm, height = 8cm) along z
  align rod.bottom = plate.bottom + 1cm
  align rod.center.x = plate.center.x
  align rod.center.y = plate.center.y
  connect rod to plate
  align sleeve.bottom = plate.top
  align sleeve.center.x = plate.center.x
  align sleeve.center.y = plate.center.y
  connect sleeve to plate
}
"""


def test_what_lay_behind_stays_there() -> None:
    """All of the surface is raised by 4 mm. Within the sleeve nothing was seen of the rod, which would follow what was."""
    batch = apg.load(SHEATH, n=1, seed=1).batch
    found = surface(batch, 12_000, 3)
    points = found.position[0] + RAISED * found.normal[0]
    mixed = np.random.default_rng(1).permutation(12_000)
    real = Real("sheath", points[mixed], found.normal[0][mixed], np.zeros(12_000, dtype=np.int64), ("all",))
    made, moved = displaced(batch, bind(batch, real, 6_000), np.zeros(1, dtype=np.int64))
    (rod,) = (k for k, group in enumerate(made) if group.table.path == "rod")
    (place,), (risen,) = made[rod].vertices, moved[rod]
    height = place[:, 2] - place[:, 2].min() - 0.02  # above the plate
    wall = np.hypot(place[:, 0], place[:, 1]) > 0.0099
    out = np.hypot(risen[:, 0], risen[:, 1]) - np.hypot(place[:, 0], place[:, 1])
    assert np.abs(out[wall & (height > 0.11) & (height < 0.15)] - RAISED).max() < 0.2 * RAISED
    assert np.abs(out[wall & (height > 0.02) & (height < 0.05)]).max() < 0.1 * RAISED
