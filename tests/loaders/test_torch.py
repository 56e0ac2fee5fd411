"""PyTorch's own DataLoader over streams and folders."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from artipg_dsl import loaders

torch = pytest.importorskip(
    "torch", reason="PyTorch is large and not in the extra `test`: pip install 'artipg_dsl[torch]'"
)

from torch.utils.data import DataLoader, Subset  # noqa: E402

from artipg_dsl.errors import UsageError  # noqa: E402
from artipg_dsl.torch import Jitter, Stored, Stream  # noqa: E402


@pytest.fixture
def stream(chest: Path) -> Stream:
    return Stream(chest, size=10, batch=4, points=32, seed=3, transforms=[Jitter()])


@pytest.mark.parametrize("workers", [0, 2])
def test_any_number_of_workers_gives_the_same_batches(stream: Stream, chest: Path, workers: int) -> None:
    source = loaders.Stream(chest, size=10, batch=4, points=32, seed=3, transforms=[loaders.Jitter()])
    loader = DataLoader(stream, batch_size=None, num_workers=workers, persistent_workers=workers > 0)
    for epoch in (0, 1):
        stream.set_epoch(epoch)
        made = list(loader)
        assert [batch["object"].tolist() for batch in made] == [
            source.batch(k, epoch)["object"].tolist() for k in range(3)
        ]
        np.testing.assert_array_equal(made[2]["points"].numpy(), source.batch(2, epoch)["points"])


@pytest.mark.parametrize("options", [{}, {"batch_size": 2}, {"num_workers": 1}])
def test_batches_are_not_batched_again(stream: Stream, options: dict[str, int]) -> None:
    with pytest.raises(UsageError, match=r"makes whole batches(?s:.*)batch_size=None"):
        next(iter(DataLoader(stream, **options)))


def test_arrays_that_are_turned_round_become_tensors(chest: Path) -> None:
    options = {"size": 2, "batch": 2, "points": 32}
    plain, flipped = (
        next(iter(Stream(chest, transforms=transforms, **options)))["points"]
        for transforms in ([], [lambda arrays, draws: {"points": arrays["points"][:, ::-1]}])
    )
    assert torch.equal(flipped, plain.flip(1))


def test_an_epoch_is_a_whole_number(stream: Stream, folders: list[Path]) -> None:
    for data in (stream, Stored(folders)):
        for wrong in (-1, 0.5, 2**64):
            with pytest.raises(UsageError, match="epoch is"):
                data.set_epoch(wrong)  # type: ignore[arg-type]


def test_ranks_share_the_batches_out(chest: Path) -> None:
    ranks = [Stream(chest, size=12, batch=2, points=32, rank=r, world=4) for r in range(4)]
    assert [len(list(one)) for one in ranks] == [1, 1, 1, 1]
    assert [next(iter(one))["object"].tolist() for one in ranks] == [[0, 1], [2, 3], [4, 5], [6, 7]]
    with pytest.raises(UsageError, match="give both"):
        Stream(chest, rank=0)
    with pytest.raises(UsageError, match="rank is '0'"):
        Stream(chest, rank="0", world=2)  # type: ignore[arg-type]
    with pytest.raises(UsageError, match="no rank 4"):
        Stream(chest, rank=4, world=4)
    with pytest.raises(UsageError, match=r"fewer batches \(1\) than processes \(2\)"):
        Stream(chest, size=20, points=32, rank=0, world=2)


def test_a_network_learns_from_it(stream: Stream) -> None:
    torch.manual_seed(0)
    network = torch.nn.Linear(6, len(stream.words["semantic"]))
    steps, losses = torch.optim.Adam(network.parameters(), lr=0.1), []
    for epoch in range(8):  # the vocabulary has more classes than the category
        stream.set_epoch(epoch)
        for batch in stream:
            seen = torch.cat([batch["points"], batch["normals"]], dim=-1)
            loss = torch.nn.functional.cross_entropy(network(seen).flatten(0, 1), batch["semantic"].flatten())
            steps.zero_grad()
            loss.backward()
            steps.step()
            losses.append(loss.item())
    assert losses[-1] < 0.5 * losses[0]


def test_stored_items_are_shuffled_and_collated(folders: list[Path]) -> None:
    stored = Stored(folders, "affordance")
    generator = torch.Generator().manual_seed(1)
    seen = [b for b in DataLoader(stored, batch_size=5, shuffle=True, generator=generator)]
    assert [len(b["object"]) for b in seen] == [5, 5, 3] and seen[0]["affordance"].shape == (5, 64, 3)
    every = torch.cat([b["category"] * 10 + b["object"] for b in seen]).tolist()
    assert sorted(every) == sorted([0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 10, 11, 12]) and every != sorted(every)
    np.testing.assert_array_equal(stored[1]["points"], loaders.Stored(folders, "affordance").take([1])["points"][0])


def test_a_tensor_of_numbers_names_a_part(folders: list[Path]) -> None:
    stored = Stored(folders)
    (batch,) = DataLoader(Subset(stored, torch.tensor([3, 10])), batch_size=2)
    assert batch["object"].tolist() == [1, 0] and batch["category"].tolist() == [0, 1]
    with pytest.raises(UsageError, match="an item is 1.0"):
        stored[torch.tensor(1.0)]


def test_workers_share_what_has_been_read(folders: list[Path], tmp_path: Path) -> None:
    stored = Stored(shutil.copytree(folders[1], tmp_path / "boxes"))
    shutil.rmtree(tmp_path / "boxes")
    (batch,) = DataLoader(stored, batch_size=3, num_workers=1, multiprocessing_context="fork")
    np.testing.assert_array_equal(batch["points"], loaders.Stored(folders[1]).take([0, 1, 2])["points"])
