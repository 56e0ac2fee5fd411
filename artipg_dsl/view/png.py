"""A PNG writer and a small font for numbers and words: pictures need no imaging library."""

from __future__ import annotations

import struct
import zlib

import numpy as np

# 5 x 7 dots, one row per number, most significant bit on the left; letters are small capitals
_GLYPHS = {
    "0": (14, 17, 17, 17, 17, 17, 14),
    "1": (4, 12, 4, 4, 4, 4, 14),
    "2": (14, 17, 1, 6, 8, 16, 31),
    "3": (14, 17, 1, 6, 1, 17, 14),
    "4": (2, 6, 10, 18, 31, 2, 2),
    "5": (31, 16, 30, 1, 1, 17, 14),
    "6": (6, 8, 16, 30, 17, 17, 14),
    "7": (31, 1, 2, 4, 8, 8, 8),
    "8": (14, 17, 17, 14, 17, 17, 14),
    "9": (14, 17, 17, 15, 1, 2, 12),
    "-": (0, 0, 0, 14, 0, 0, 0),
    "_": (0, 0, 0, 0, 0, 0, 31),
    "a": (14, 17, 17, 31, 17, 17, 17),
    "b": (30, 17, 17, 30, 17, 17, 30),
    "c": (14, 17, 16, 16, 16, 17, 14),
    "d": (30, 17, 17, 17, 17, 17, 30),
    "e": (31, 16, 16, 30, 16, 16, 31),
    "f": (31, 16, 16, 30, 16, 16, 16),
    "g": (14, 17, 16, 23, 17, 17, 15),
    "h": (17, 17, 17, 31, 17, 17, 17),
    "i": (14, 4, 4, 4, 4, 4, 14),
    "j": (7, 2, 2, 2, 2, 18, 12),
    "k": (17, 18, 20, 24, 20, 18, 17),
    "l": (16, 16, 16, 16, 16, 16, 31),
    "m": (17, 27, 21, 21, 17, 17, 17),
    "n": (17, 25, 21, 19, 17, 17, 17),
    "o": (14, 17, 17, 17, 17, 17, 14),
    "p": (30, 17, 17, 30, 16, 16, 16),
    "q": (14, 17, 17, 17, 21, 18, 13),
    "r": (30, 17, 17, 30, 20, 18, 17),
    "s": (15, 16, 16, 14, 1, 1, 30),
    "t": (31, 4, 4, 4, 4, 4, 4),
    "u": (17, 17, 17, 17, 17, 17, 14),
    "v": (17, 17, 17, 17, 17, 10, 4),
    "w": (17, 17, 17, 21, 21, 27, 17),
    "x": (17, 17, 10, 4, 10, 17, 17),
    "y": (17, 17, 10, 4, 4, 4, 4),
    "z": (31, 1, 2, 4, 8, 16, 31),
}


_SIGNATURE = b"\x89PNG\r\n\x1a\n"


def png_bytes(image: np.ndarray) -> bytes:
    """A PNG file of an image (height, width, 3) uint8, or of a grey one (height, width)."""
    height, width = image.shape[:2]
    rows = image.reshape(height, -1).astype(np.uint8)
    above = np.concatenate([np.zeros_like(rows[:1]), rows[:-1]])
    filtered = np.concatenate([np.full((height, 1), 2, dtype=np.uint8), rows - above], axis=1)  # 2: difference to above
    header = struct.pack(">IIBBBBB", width, height, 8, 2 if image.ndim == 3 else 0, 0, 0, 0)
    chunks = [(b"IHDR", header), (b"IDAT", zlib.compress(filtered.tobytes(), 6)), (b"IEND", b"")]
    return _SIGNATURE + b"".join(_chunk(*chunk) for chunk in chunks)


def read_png(data: bytes) -> np.ndarray:
    """An image as ``png_bytes`` writes it: (height, width, 3) or (height, width) uint8. Raises ValueError for any other."""
    if data[:8] != _SIGNATURE:
        raise ValueError("not a PNG file")
    at, packed, head = 8, b"", b""
    while at + 8 <= len(data):
        size, kind = struct.unpack(">I4s", data[at : at + 8])
        body = data[at + 8 : at + 8 + size]
        head, packed = body if kind == b"IHDR" else head, packed + body if kind == b"IDAT" else packed
        at += size + 12
    width, height, depth, colours, *_ = struct.unpack(">IIBBBBB", head) if len(head) == 13 else (0,) * 7
    channels = {0: 1, 2: 3}.get(colours, 0)
    rows: np.ndarray = np.frombuffer(zlib.decompress(packed), dtype=np.uint8) if packed else np.zeros(0, dtype=np.uint8)
    if depth != 8 or not channels or len(rows) != height * (1 + width * channels):
        raise ValueError("not an image of 8 bits, grey or red, green and blue")
    rows = rows.reshape(height, -1)
    if (rows[:, 0] != 2).any():
        raise ValueError("not an image that we have written")
    image = np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8)
    return image.reshape((height, width, 3) if channels == 3 else (height, width))


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def write_number(image: np.ndarray, number: int, colour: tuple[int, int, int], size: int = 1, margin: int = 6) -> None:
    """Draw a number into the lower left corner of ``image`` (height, width, 3), each dot ``size`` pixels wide."""
    write_text(image[: image.shape[0] - margin, margin:], str(number), colour, size)


def write_text(image: np.ndarray, text: str, colour: tuple[int, int, int], size: int = 1) -> None:
    """Draw digits and letters along the lower border of ``image``, from its left; other characters are left blank."""
    for k, character in enumerate(text.lower()):
        rows = np.array(_GLYPHS.get(character, (0,) * 7), dtype=np.uint8)[:, None]
        dots = ((rows >> np.arange(4, -1, -1)) & 1).astype(bool).repeat(size, axis=0).repeat(size, axis=1)
        place = image[image.shape[0] - dots.shape[0] :, 6 * size * k : 6 * size * k + dots.shape[1]]
        place[dots[:, : place.shape[1]]] = colour


def srgb(light: np.ndarray) -> np.ndarray:
    """Eight-bit sRGB of linear light."""
    light = np.clip(light, 0.0, 1.0)
    value = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.power(light, 1 / 2.4) - 0.055)
    return (value * 255 + 0.5).astype(np.uint8)
