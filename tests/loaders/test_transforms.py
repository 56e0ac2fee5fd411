"""Each augmentation does to the arrays what it says."""

import numpy as np
import pytest

from artipg_dsl.errors import UsageError
from artipg_dsl.loaders import Drop, Jitter, Normalise, Occlude, Scale, Turn, View
from artipg_dsl.loaders.draws import Draws
from artipg_dsl.loaders.tasks import Arrays

B, N = 3, 200


@pytest.fixture
def arrays() -> Arrays:
    """Spheres of radius 2 about (1, 2, 3); ``semantic`` numbers the points."""
    direction = Draws(1, "sphere", np.arange(B * N), 0).direction().reshape(B, N, 3).astype(np.float32)
    numbers = np.tile(np.arange(N), (B, 1))
    return {
        "points": 2 * direction + np.float32([1, 2, 3]),
        "normals": direction,
        "motion": direction,
        "semantic": numbers,
    }


@pytest.fixture
def draws() -> Draws:
    return Draws(7, "0", np.arange(B), 0)


def test_draws_follow_from_the_address_alone() -> None:
    one, many = Draws(7, "0", np.array([2]), 4), Draws(7, "0", np.arange(5), 4)
    np.testing.assert_array_equal(one.uniform(3), many.uniform(3)[2:3])
    np.testing.assert_array_equal(one.order(9), many.order(9)[2:3])
    assert not np.array_equal(one.uniform(3), one.uniform(3))
    assert not np.array_equal(one.direction(), Draws(7, "0", np.array([2]), 5).direction())
    normal = Draws(7, "0", np.arange(5), 4).normal(4000)
    assert abs(normal.mean()) < 0.02 and abs(normal.std() - 1) < 0.02


def test_normalise(arrays: Arrays, draws: Draws) -> None:
    made = Normalise()(arrays | {"partial": arrays["points"][:, :50]}, draws)
    np.testing.assert_allclose(np.linalg.norm(made["points"], axis=-1).max(axis=1), 1, atol=1e-6)
    np.testing.assert_array_equal(made["partial"], made["points"][:, :50])
    assert 0.45 < np.linalg.norm(made["motion"], axis=-1).mean() < 0.55  # half as large, so half as fast
    assert made["normals"] is arrays["normals"]
    with pytest.raises(UsageError, match="partial"):
        Normalise(by="partial")(arrays, draws)


@pytest.mark.parametrize("axis", "xyz")
def test_turn(arrays: Arrays, draws: Draws, axis: str) -> None:
    made, k = Turn(axis=axis)(arrays, draws), "xyz".index(axis)
    np.testing.assert_array_equal(made["points"][..., k], arrays["points"][..., k])
    np.testing.assert_allclose(
        np.linalg.norm(made["points"], axis=-1), np.linalg.norm(arrays["points"], axis=-1), rtol=1e-5
    )
    np.testing.assert_allclose((made["points"] - made["normals"] * 2).std(axis=1), 0, atol=1e-5)
    angle = np.arccos(np.clip((made["normals"] * arrays["normals"]).sum(-1), -1, 1)).max(axis=1)
    assert len(set(angle.round(3))) == B
    still = Turn(degrees=0, axis=axis)(arrays, draws)
    np.testing.assert_allclose(still["points"], arrays["points"])


def test_turns_are_right_handed(draws: Draws) -> None:
    made = Turn(axis="y")({"points": np.tile(np.float32([[0, 0, 1], [1, 0, 0]]), (B, 1, 1))}, draws)["points"]
    np.testing.assert_allclose(np.cross(made[:, 0], made[:, 1]), np.tile([0, 1, 0], (B, 1)), atol=1e-6)


def test_scale(arrays: Arrays, draws: Draws) -> None:
    made = Scale(0.5, 0.6)(arrays, draws)
    factor = made["points"][..., 0] / arrays["points"][..., 0]
    assert (factor > 0.49).all() and (factor < 0.61).all() and np.ptp(factor, axis=1).max() < 1e-3


def test_jitter(arrays: Arrays, draws: Draws) -> None:
    moved = Jitter(sigma=0.05, clip=0.1)(arrays, draws)["points"] - arrays["points"]
    assert 0.04 < moved.std() < 0.06 and np.abs(moved).max() <= 0.1 + 1e-6


@pytest.mark.parametrize("lose", [Drop(0.9), Occlude(0.3), View()])
def test_what_is_lost_is_filled_up_with_what_is_left(arrays: Arrays, draws: Draws, lose: View) -> None:
    made = lose(arrays, draws)
    for b in range(B):
        left = np.unique(made["semantic"][b])
        assert 1 <= len(left) < N
        np.testing.assert_array_equal(made["points"][b], arrays["points"][b][made["semantic"][b]])


def test_occlude_cuts_off_one_side(arrays: Arrays, draws: Draws) -> None:
    left = np.unique(Occlude(0.3)(arrays, draws)["semantic"][0])
    lost = np.setdiff1d(np.arange(N), left)
    assert len(lost) == 60
    middle = arrays["normals"][0][lost].mean(axis=0)
    assert (arrays["normals"][0][lost] @ middle).min() > 0.1 * np.linalg.norm(middle)


def test_view_shows_the_near_side(draws: Draws, arrays: Arrays) -> None:
    made = View(pixels=8, depth=0.2)(arrays, draws)
    look = made["normals"].mean(axis=1)
    look /= np.linalg.norm(look, axis=-1, keepdims=True)
    hidden = [np.setdiff1d(np.arange(N), made["semantic"][b]) for b in range(B)]
    assert all((arrays["normals"][b][hidden[b]] @ look[b]).max() < 0.5 for b in range(B))
    assert all(len(h) > N / 4 for h in hidden)
    fine = View(pixels=1 << 20, depth=0)(arrays, draws)  # each point in a pixel of its own
    np.testing.assert_array_equal(fine["semantic"], arrays["semantic"])


def test_of_partial_clouds_the_whole_stays(arrays: Arrays, draws: Draws) -> None:
    whole = {"points": arrays["points"], "partial": arrays["points"][:, :50]}
    made = Occlude(0.5)(whole, draws)
    assert made["points"] is whole["points"]
    assert [len(np.unique(cloud, axis=0)) for cloud in made["partial"]] == [25] * B


WRONG = (
    lambda: Jitter(-0.01),
    lambda: Jitter(clip=float("nan")),
    lambda: Turn(float("inf")),
    lambda: Scale(1, float("inf")),
    lambda: View(8, depth=-0.1),
    lambda: View(8.5),  # type: ignore[arg-type]
    lambda: Drop("0.5"),  # type: ignore[arg-type]
    lambda: Normalise("normals"),
)


def test_wrong_measures() -> None:
    for make in (
        lambda: Drop(1),
        lambda: Occlude(-0.1),
        lambda: Turn(axis="w"),
        lambda: Scale(2, 1),
        lambda: View(0),
        lambda: Turn(axis=[0, 0, 1]),  # type: ignore[arg-type]
        *WRONG,
    ):
        with pytest.raises(UsageError):
            make()
