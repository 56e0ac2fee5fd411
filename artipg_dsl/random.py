"""Addressed randomness: a random number is a function of (seed, name, address), so no draw depends on any other.

The function is Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", 2011) over NumPy arrays:
the key comes from the seed and a name, the counter from a 64 bit address (an object number, a row), a lane and an
attempt.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from hashlib import blake2b

import numpy as np
from numpy.typing import ArrayLike

Key = tuple[np.uint32, np.uint32]
Words = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]

_ROUNDS = 10
_M0, _M1 = np.uint64(0xD2511F53), np.uint64(0xCD9E8D57)
_W0, _W1 = 0x9E3779B9, 0xBB67AE85
_MASK, _HALF = np.uint64(0xFFFFFFFF), np.uint64(32)
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX = (
    (np.uint64(30), np.uint64(0xBF58476D1CE4E5B9)),
    (np.uint64(27), np.uint64(0x94D049BB133111EB)),
    (np.uint64(31), None),
)
_STREAM_LANE = 0xFFFFFFFD
_CHUNK = 8192  # counters at a time: the working set of one chunk stays in the first two cache levels


_compiled: tuple[Callable[..., Words], Callable[..., np.ndarray]] | None = None


def use(compiled: tuple[Callable[..., Words], Callable[..., np.ndarray]] | None) -> None:
    """Have words (of a key, addresses, lanes and attempts) and child addresses from two functions of compiled code from here on, which
    are the same; for None from NumPy again."""
    global _compiled
    _compiled = compiled


@lru_cache(maxsize=4096)
def key(seed: int, *names: str) -> Key:
    """The 64 bit key of a seed (any integer) and a path of names, as two words."""
    digest = blake2b(digest_size=8, person=b"artipg")
    for part in (str(int(seed)), *names):
        data = part.encode()
        digest.update(len(data).to_bytes(8, "little"))
        digest.update(data)
    words = np.frombuffer(digest.digest(), dtype="<u4")
    return np.uint32(words[0]), np.uint32(words[1])


def philox(key: Key, c0: ArrayLike, c1: ArrayLike, c2: ArrayLike, c3: ArrayLike) -> Words:
    """Philox4x32-10 of the counters (arrays of words below 2 ** 32 that broadcast): four uint32 arrays."""
    counters = np.broadcast_arrays(*(np.asarray(c, dtype=np.uint64) for c in (c0, c1, c2, c3)))
    shape, size = counters[0].shape, counters[0].size
    flat = [c.reshape(-1) for c in counters]
    out = np.empty((4, size), dtype=np.uint32)
    for start in range(0, size, _CHUNK):
        part = slice(start, min(start + _CHUNK, size))
        _rounds(key, [np.array(c[part]) for c in flat], out[:, part])
    return out[0].reshape(shape), out[1].reshape(shape), out[2].reshape(shape), out[3].reshape(shape)


def _rounds(key: Key, c: list[np.ndarray], out: np.ndarray) -> None:
    """Ten rounds over uint64 arrays that hold one word each; overwrites ``c``."""
    k0, k1 = int(key[0]), int(key[1])
    first, second = np.empty_like(c[0]), np.empty_like(c[0])
    for _ in range(_ROUNDS):
        np.multiply(c[0], _M0, out=first)
        np.multiply(c[2], _M1, out=second)
        np.right_shift(second, _HALF, out=c[0])
        np.bitwise_xor(c[0], c[1], out=c[0])
        np.bitwise_xor(c[0], np.uint64(k0), out=c[0])
        np.right_shift(first, _HALF, out=c[2])
        np.bitwise_xor(c[2], c[3], out=c[2])
        np.bitwise_xor(c[2], np.uint64(k1), out=c[2])
        np.bitwise_and(second, _MASK, out=c[1])
        np.bitwise_and(first, _MASK, out=c[3])
        k0, k1 = (k0 + _W0) & 0xFFFFFFFF, (k1 + _W1) & 0xFFFFFFFF
    for row, word in zip(out, c, strict=True):
        row[...] = word


def _unit(high: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Odd multiples of 2 ** -53: 52 random bits, never 0 and never 1."""
    bits = (high.astype(np.uint64) << np.uint64(20)) | (low.astype(np.uint64) >> np.uint64(12))
    return (bits.astype(np.float64) + 0.5) * 2.0**-52


def _split(key: Key, address: ArrayLike, lane: ArrayLike, attempt: ArrayLike) -> Words:
    if _compiled is not None:
        return _compiled[0](key, address, lane, attempt)
    where = np.asarray(address, dtype=np.uint64)
    return philox(key, where & _MASK, where >> _HALF, lane, attempt)


def uniform(key: Key, address: ArrayLike, lane: ArrayLike = 0, attempt: ArrayLike = 0) -> np.ndarray:
    """One number in (0, 1) per (address, lane, attempt), which broadcast; lane and attempt lie below 2 ** 32."""
    words = _split(key, address, lane, attempt)
    return _unit(words[0], words[1])


def pair(key: Key, address: ArrayLike, lane: ArrayLike = 0, attempt: ArrayLike = 0) -> tuple[np.ndarray, np.ndarray]:
    """Two independent numbers in (0, 1) for the price of one; the first equals ``uniform`` of the same arguments."""
    words = _split(key, address, lane, attempt)
    return _unit(words[0], words[1]), _unit(words[2], words[3])


def streams(key: Key, address: ArrayLike, attempt: ArrayLike = 0) -> np.ndarray:
    """(k,) uint64: where the stream of each address starts. Its numbers are told by ``coarse``."""
    high, low, *_ = _split(key, address, _STREAM_LANE, attempt)
    return (high.astype(np.uint64) << _HALF) | low


def coarse(stream: np.ndarray, lane: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two independent numbers in (0, 1) of 32 random bits each, for each pair of a stream and a lane (0, 1, ...).

    The generator is splitmix64 (Steele, Lea and Flood, "Fast splittable pseudorandom number generators", 2014), whose
    nth number is a function of n: a seventh of the work of Philox, for what is drawn by the million.
    """
    size = len(lane)
    u, v = np.empty(size), np.empty(size)
    for start in range(0, size, _CHUNK):
        part = slice(start, start + _CHUNK)
        word = lane[part].astype(np.uint64)
        word += np.uint64(1)
        word *= _GOLDEN
        word += stream[part]
        other = np.empty_like(word)
        for shift, factor in _MIX:
            np.right_shift(word, shift, out=other)
            word ^= other
            if factor is not None:
                word *= factor
        np.right_shift(word, _HALF, out=other)
        word &= _MASK
        for out, bits in ((u, other), (v, word)):  # odd multiples of 2 ** -33
            mine = out[part]
            mine[...] = bits
            mine += 0.5
            mine *= 2.0**-32
    return u, v


def orders(stream: np.ndarray, n: int) -> np.ndarray:
    """(k, n): for each stream the numbers 0 .. n - 1 in a random order."""
    bits = np.uint64(max(n - 1, 1).bit_length())
    out = np.empty((len(stream), n), dtype=np.int64)
    lanes = (np.arange(n, dtype=np.uint64) + np.uint64(1)) * _GOLDEN
    step = max(1, _CHUNK // max(n, 1))
    for start in range(0, len(stream), step):
        part = slice(start, start + step)
        words = _scramble(stream[part, None].astype(np.uint64) + lanes)
        words = (words >> bits << bits) | np.arange(n, dtype=np.uint64)  # all different: any sort gives one order
        words.sort(axis=1)
        out[part] = words & ((np.uint64(1) << bits) - np.uint64(1))
    return out


def _scramble(value: np.ndarray) -> np.ndarray:
    """The finaliser of splitmix64: a bijection on 64 bits."""
    for shift, factor in _MIX:
        value = value ^ (value >> shift)
        value = value if factor is None else value * factor
    return value


def mix(address: ArrayLike, rank: ArrayLike) -> np.ndarray:
    """The address of a child: row ``rank`` (0, 1, ...) of what stands at ``address``; arrays broadcast, uint64."""
    if _compiled is not None:
        return _compiled[1](address, rank)
    where = np.atleast_1d(np.asarray(address, dtype=np.uint64))
    step = np.atleast_1d(np.asarray(rank)).astype(np.uint64) + np.uint64(1)
    child = _scramble(_scramble(where + _GOLDEN) + step * _GOLDEN)
    return child.reshape(np.broadcast_shapes(np.shape(address), np.shape(rank)))
