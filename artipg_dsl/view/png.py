"""A PNG writer and a small font for numbers: pictures need no imaging library."""

from __future__ import annotations

import struct
import zlib

import numpy as np

# 5 x 7 dots, one row per number, most significant bit on the left
GLYPHS = {
    "0": (14, 17, 17, 17, 17, 17, 14), "1": (4, 12, 4, 4, 4, 4, 14), "2": (14, 17, 1, 6, 8, 16, 31),
    "3": (14, 17, 1, 6, 1, 17, 14), "4": (2, 6, 10, 18, 31, 2, 2), "5": (31, 16, 30, 1, 1, 17, 14),
    "6": (6, 8, 16, 30, 17, 17, 14), "7": (31, 1, 2, 4, 8, 8, 8), "8": (14, 17, 17, 14, 17, 17, 14),
    "9": (14, 17, 17, 15, 1, 2, 12), "-": (0, 0, 0, 14, 0, 0, 0),
}  # fmt: skip


def png_bytes(image: np.ndarray) -> bytes:
    """A PNG file of an image (height, width, 3) uint8."""
    height, width, _ = image.shape
    rows = image.reshape(height, -1).astype(np.uint8)
    above = np.concatenate([np.zeros_like(rows[:1]), rows[:-1]])
    filtered = np.concatenate([np.full((height, 1), 2, dtype=np.uint8), rows - above], axis=1)  # 2: difference to above
    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(*chunk) for chunk in chunks)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_number(image: np.ndarray, number: int, colour: tuple[int, int, int], size: int = 1, margin: int = 6) -> None:
    """Draw a number into the lower left corner of ``image`` (height, width, 3), each dot ``size`` pixels wide."""
    left = margin
    for character in str(number):
        rows = np.array(GLYPHS[character], dtype=np.uint8)[:, None]
        dots = ((rows >> np.arange(4, -1, -1)) & 1).astype(bool).repeat(size, axis=0).repeat(size, axis=1)
        bottom = image.shape[0] - margin
        place = image[bottom - dots.shape[0] : bottom, left : left + dots.shape[1]]
        place[dots[:, : place.shape[1]]] = colour
        left += 6 * size


def srgb(light: np.ndarray) -> np.ndarray:
    """Eight-bit sRGB of linear light."""
    light = np.clip(light, 0.0, 1.0)
    value = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)
    return (value * 255 + 0.5).astype(np.uint8)
