"""Random words and addresses by compiled code, as ``random`` has them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from .calls import call

if TYPE_CHECKING:
    from ..random import Key, Words
    from .backend import Machine


def philox(machine: Machine, key: Key, address: ArrayLike, lane: ArrayLike, attempt: ArrayLike) -> Words:
    """The four words of each address, lane and attempt, which broadcast."""
    shape = np.broadcast_shapes(np.shape(address), np.shape(lane), np.shape(attempt))
    where, others = _whole(address, shape), [_few(given, shape) for given in (lane, attempt)]
    out = np.empty((4, *shape), dtype=np.uint32)
    told = int(key[0]) | int(key[1]) << 32
    call(machine.library.philox, where.size, told, where, *(part for a in others for part in (a.size, a)), out)
    return out[0], out[1], out[2], out[3]


def mix(machine: Machine, address: ArrayLike, rank: ArrayLike) -> np.ndarray:
    """The addresses of children, of the rank of each; arrays broadcast."""
    if isinstance(address, np.ndarray) and isinstance(rank, np.ndarray) and address.shape == rank.shape:
        shape = address.shape  # nearly always: to ask how they broadcast takes as long as all else
    else:
        shape = np.broadcast_shapes(np.shape(address), np.shape(rank))
    parent, own = _few(address, shape), _whole(rank, shape)
    out = np.empty(shape, dtype=np.uint64)
    call(machine.library.mix, out.size, parent.size, parent, own, out)
    return out


def _whole(given: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    """Whole numbers, one for each place of ``shape``."""
    array = np.asarray(given)
    return np.ascontiguousarray(array if array.shape == shape else np.broadcast_to(array, shape), dtype=np.uint64)


def _few(given: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    """The same, or the one that there is for all places."""
    array = np.asarray(given)
    return np.ascontiguousarray(array, dtype=np.uint64) if array.size == 1 else _whole(array, shape)
