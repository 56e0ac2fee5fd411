"""Convex bodies by their supports, against separating axes of boxes and the sizes of inset pieces."""

import numpy as np
import pytest

from artipg_dsl.geometry.collide import Corners, inset, overlap, separate

CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FACES = np.array(
    [
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ]
)


def boxes(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Corners (count, 8, 3) of boxes turned at random, and their axes (count, 3, 3) as rows."""
    lot = np.random.default_rng(seed)
    axes = np.linalg.qr(lot.normal(size=(count, 3, 3)))[0]
    sized = CUBE * lot.uniform(0.05, 1.0, size=(count, 1, 3))
    return np.einsum("kpi,kij->kpj", sized, axes) + lot.uniform(-0.6, 0.6, size=(count, 1, 3)), axes


def apart(first: np.ndarray, second: np.ndarray, one: np.ndarray, two: np.ndarray) -> np.ndarray:
    """The widest gap along the 15 axes that can separate two boxes; negative where they overlap."""
    across = np.cross(one[:, :, None], two[:, None]).reshape(-1, 9, 3)
    axes = np.concatenate([one, two, across / np.linalg.norm(across, axis=-1, keepdims=True)], axis=1)
    p, q = np.einsum("kpi,kai->kap", first, axes), np.einsum("kpi,kai->kap", second, axes)
    return np.maximum(p.min(axis=2) - q.max(axis=2), q.min(axis=2) - p.max(axis=2)).max(axis=1)


def test_agrees_with_separating_axes_on_turned_boxes() -> None:
    (first, one), (second, two) = boxes(5000, 1), boxes(5000, 2)
    gap = apart(first, second, one, two)
    clear = np.abs(gap) > 1e-9
    assert (overlap(Corners(first), Corners(second)) == (gap < 0))[clear].all()
    assert 500 < (gap < 0).sum() < 4500


def test_the_direction_given_separates() -> None:
    (first, _), (second, _) = boxes(2000, 3), boxes(2000, 4)
    hit, away = separate(Corners(first), Corners(second))
    beyond = np.einsum("kpi,ki->kp", first, away).min(axis=1) - np.einsum("kpi,ki->kp", second, away).max(axis=1)
    assert (beyond[~hit] > 0).all() and hit.any()


def test_a_pair_is_judged_alike_alone_and_among_others() -> None:
    (first, _), (second, _) = boxes(200, 5), boxes(200, 6)
    together = overlap(Corners(first), Corners(second))
    alone = [overlap(Corners(first[k : k + 1]), Corners(second[k : k + 1]))[0] for k in range(200)]
    assert together.tolist() == alone


@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_inset_moves_every_face_by_the_margin(mirror: float) -> None:
    size = np.array([2.0, 0.3, 0.001])
    found = inset(CUBE * size * (1, mirror, 1), np.array([0]), FACES, 1e-4)
    assert np.allclose(found.max(axis=0) - found.min(axis=0), size - 2e-4, atol=1e-9)


def test_inset_of_a_slanted_plate_keeps_to_its_own_planes() -> None:
    (turned, axes) = boxes(50, 7)
    first = 8 * np.arange(50)
    found = inset(turned.reshape(-1, 3), first, (first[:, None, None] + FACES).reshape(-1, 3), 1e-3).reshape(50, 8, 3)
    along = [np.einsum("kpi,kai->kap", points, axes) for points in (turned, found)]
    before, after = (np.ptp(values, axis=2) for values in along)
    assert np.allclose(before - after, 2e-3, atol=1e-6)


def test_inset_moves_each_piece_as_if_it_were_alone() -> None:
    corners = [CUBE, CUBE[:4] * (1, 1, 2) + 3.0, 0.5 * CUBE * (-1, 1, 1)]
    faces = [FACES, np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]]), FACES]
    first = np.array([0, 8, 12])
    together = inset(np.concatenate(corners), first, np.concatenate([a + f for a, f in zip(first, faces, strict=True)]))
    alone = [inset(own, np.array([0]), told) for own, told in zip(corners, faces, strict=True)]
    assert np.array_equal(together, np.concatenate(alone))


@pytest.mark.parametrize(("shift", "meets"), [(1.0, False), (1.0 - 1e-5, True), (1.0 - 5e-7, False)])
def test_what_touches_does_not_meet(shift: float, meets: bool) -> None:
    first = inset(CUBE, np.array([0]), FACES)[None]
    assert overlap(Corners(first), Corners(first + [shift, 0.0, 0.0]))[0] == meets
