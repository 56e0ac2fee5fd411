"""Random numbers for transforms: functions of the seed, the object and the epoch, whatever batch the object is in."""

from __future__ import annotations

import numpy as np

from .. import random
from ..arguments import read_whole


def read_epoch(epoch: int) -> int:
    """The number of an epoch: random numbers are told apart by 32 bits of it. Raises UsageError."""
    return read_whole("epoch", epoch, 0, 2**32 - 1)


class Draws:
    """The numbers of one transform, for the objects of one batch. Each call gives new ones.

    ``address`` (B,): the place of each object among all of its source; ``epoch`` makes new numbers of the same objects.
    """

    def __init__(self, seed: int, name: str, address: np.ndarray, epoch: int):
        self._seed, self._name, self._address, self._epoch = seed, name, np.asarray(address), epoch
        self._calls = 0

    def uniform(self, *shape: int) -> np.ndarray:
        """(B, *shape) float64 in (0, 1)."""
        return self._pair(shape)[0]

    def normal(self, *shape: int) -> np.ndarray:
        """(B, *shape) float64, standard normal (Box and Muller, "A note on the generation of random normal deviates", 1958)."""
        u, v = self._pair(shape)
        return np.sqrt(-2 * np.log(u)) * np.cos(2 * np.pi * v)

    def direction(self) -> np.ndarray:
        """(B, 3) unit vectors, uniform on the sphere (Archimedes: a height and an angle)."""
        u, v = self._pair(())
        z = 2 * u - 1
        ring, turn = np.sqrt(1 - z * z), 2 * np.pi * v
        return np.stack([ring * np.cos(turn), ring * np.sin(turn), z], axis=-1)

    def order(self, n: int) -> np.ndarray:
        """(B, n): the numbers 0 .. n - 1 in a random order for each object."""
        return random.orders(self._streams(), n)

    def _streams(self) -> np.ndarray:
        self._calls += 1
        key = random.key(self._seed, "loaders", self._name, str(self._calls))
        return random.streams(key, self._address, self._epoch)

    def _pair(self, shape: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
        each = int(np.prod(shape))
        stream, full = self._streams(), (len(self._address), *shape)
        u, v = random.coarse(np.repeat(stream, each), np.tile(np.arange(each), len(stream)))
        return u.reshape(full), v.reshape(full)
