"""Objects for PyTorch: an ``IterableDataset`` of fresh ones, a ``Dataset`` of stored ones (extra ``torch``).

    data = Stream(["Microwave", "Door"], "segmentation", batch=32, transforms=[Normalise(), Jitter()])
    for batch in DataLoader(data, batch_size=None, num_workers=4): ...

Batches are dictionaries of tensors by the names of ``loaders.tasks.make_arrays``. They are the same on any number of workers, in the same
order; processes of ``torch.distributed`` share them out.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

try:
    import torch
    from torch.utils.data import Dataset, IterableDataset, get_worker_info
    from torch.utils.data._utils.collate import default_collate_fn_map
except ImportError as missing:
    from .extras import TORCH

    raise TORCH.missing("artipg_dsl.torch") from missing

from . import loaders
from .arguments import read_whole
from .errors import UsageError
from .loaders import Drop, Jitter, Normalise, Occlude, Scale, Turn, View
from .loaders.draws import read_epoch

Item = dict[str, torch.Tensor]


class Batch(Item):
    """What a ``Stream`` makes at once. A DataLoader that would put several into one, with one axis more, is told of it."""


def _refuse(*_: Any, **__: Any) -> NoReturn:
    raise UsageError(
        "a Stream makes whole batches, and the DataLoader puts them into others", "give it batch_size=None"
    )


default_collate_fn_map[Batch] = _refuse


class Stream(IterableDataset[Batch]):
    """Batches of objects made on the way; the arguments are those of ``loaders.Stream``, and ``rank`` of ``world``.

    It makes whole batches: give the DataLoader ``batch_size=None``; another raises UsageError. ``set_epoch(e)`` makes other objects (or,
    without ``fresh``, other random states and transforms), also in workers that persist; an epoch that is repeated has the same batches.
    ``rank`` and ``world``: which of how many processes this is, by default as ``torch.distributed`` says; each has as many batches. Raises
    as ``loaders.Stream``.
    """

    def __init__(self, *args: Any, rank: int | None = None, world: int | None = None, **options: Any):
        super().__init__()
        self.source = loaders.Stream(*args, **options)
        self.words, self.categories = self.source.words, self.source.categories
        self.rank, self.world = _own_share(rank, world)
        if not len(self):
            raise UsageError(
                f"there are fewer batches ({len(self.source)}) than processes ({self.world})",
                "give a larger `size`, or a smaller `batch`",
            )
        self._epoch = torch.zeros((), dtype=torch.int64).share_memory_()

    def set_epoch(self, epoch: int) -> None:
        """Before the loop over the DataLoader begins. Raises UsageError."""
        self._epoch.fill_(read_epoch(epoch))

    def __len__(self) -> int:
        return len(self.source) // self.world if self.world > 1 else len(self.source)

    def __iter__(self) -> Iterator[Batch]:
        info, epoch = get_worker_info(), int(self._epoch)
        first, step = (0, 1) if info is None else (info.id, info.num_workers)
        numbers = range(first * self.world + self.rank, len(self) * self.world, step * self.world)
        for made in self.source.batches(numbers, epoch):
            yield Batch(_to_tensors(made))


class Stored(Dataset[Item]):
    """Items of folders that ``apgc sample`` has written; the arguments are those of ``loaders.Stored``.

    Works with samplers, ``batch_size`` and ``shuffle`` of the DataLoader. ``set_epoch`` makes new random numbers for the transforms, also
    in workers that persist. Raises as ``loaders.Stored``.
    """

    def __init__(self, folders: str | Path | Sequence[str | Path], task: str = "segmentation", **options: Any):
        self.source = loaders.Stored(folders, task, **options)
        self.words, self.categories = self.source.words, self.source.categories
        self._epoch = torch.zeros((), dtype=torch.int64).share_memory_()

    def set_epoch(self, epoch: int) -> None:
        """Before the loop over the DataLoader begins. Raises UsageError."""
        self._epoch.fill_(read_epoch(epoch))

    def __len__(self) -> int:
        return len(self.source)

    def __getitem__(self, item: int | torch.Tensor) -> Item:
        return self.__getitems__([item])[0]

    def __getitems__(self, items: Sequence[int | torch.Tensor]) -> list[Item]:
        """What a DataLoader asks for: the items of a batch at once. Samplers over a tensor of numbers give tensors of one each."""
        numbers = [item.tolist() if isinstance(item, torch.Tensor) else item for item in items]
        made = _to_tensors(self.source.take(numbers, int(self._epoch)))
        return [{name: values[k] for name, values in made.items()} for k in range(len(items))]


def _to_tensors(arrays: loaders.tasks.Arrays) -> Item:
    """Those that a transform has turned round are copied: tensors have no negative strides, and are written to."""
    return {
        name: torch.from_numpy(np.require(array, array.dtype.newbyteorder("="), ("C", "W")))
        for name, array in arrays.items()
    }


def _own_share(rank: int | None, world: int | None) -> tuple[int, int]:
    if (rank is None) != (world is None):
        raise UsageError("of `rank` and `world` there is only one", "give both, or none")
    if rank is None or world is None:
        there = torch.distributed.is_available() and torch.distributed.is_initialized()
        return (torch.distributed.get_rank(), torch.distributed.get_world_size()) if there else (0, 1)
    rank, world = read_whole("rank", rank), read_whole("world", world, 1)
    if not 0 <= rank < world:
        raise UsageError(f"there is no rank {rank} among {world}", "ranks count from 0")
    return rank, world


__all__ = ["Drop", "Jitter", "Normalise", "Occlude", "Scale", "Stored", "Stream", "Turn", "View"]
