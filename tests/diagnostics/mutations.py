"""Programs with one thing wrong: something dropped or exchanged, another unit or number.

Half of the kinds keep the grammar (another face, an equation less), so that they reach the later phases.
"""

from __future__ import annotations

import random
import re
from collections.abc import Iterator
from pathlib import Path

from artipg_dsl.resources import categories_dir, library_dir

_TOKEN = re.compile(r'#[^\n]*|"[^"\n]*"|\d[\d.]*[A-Za-z%/0-9]*|\w+|[^\s\w]')
_NAME = re.compile(r"[A-Za-z_]\w*$")
_NUMBER = re.compile(r"(\d+(?:\.\d+)?)([A-Za-z%]*)$")
KINDS = (
    "drop a token",
    "exchange names",
    "drop a statement",
    "change a unit",
    "exchange faces",
    "drop an equation",
    "change a number",
    "drop an argument",
)
FACES = ("front", "back", "left", "right", "top", "bottom", "center")
UNITS = ("mm", "cm", "deg", "kg", "%", "", "inch")


def programs() -> list[Path]:
    """The shipped programs."""
    return sorted([*categories_dir().glob("*.apg"), *library_dir().glob("*.apg")])


def mutations(seed: int, number: int) -> Iterator[tuple[str, str]]:
    """``number`` pairs (what was done, the text), spread over all programs; equal for equal seeds."""
    rng = random.Random(seed)
    paths = programs()
    for k in range(number):
        path = paths[k % len(paths)]
        text = path.read_text(encoding="utf-8")
        kind = rng.choice(KINDS)
        done, mutated = globals()[kind.split()[0] + "_" + kind.split()[-1]](text, rng)
        yield f"{k} {path.stem}: {done}", mutated


def tokens(text: str) -> list[re.Match[str]]:
    return [m for m in _TOKEN.finditer(text) if not m.group().startswith("#")]


def line_of(text: str, position: int) -> int:
    return text.count("\n", 0, position) + 1


def drop_token(text: str, rng: random.Random) -> tuple[str, str]:
    token = rng.choice(tokens(text))
    return f"line {line_of(text, token.start())} without `{token.group()}`", text[: token.start()] + text[token.end() :]


def exchange_names(text: str, rng: random.Random) -> tuple[str, str]:
    names = [m for m in tokens(text) if _NAME.match(m.group())]
    first, second = sorted(rng.sample(names, 2), key=lambda m: m.start())
    between = text[first.end() : second.start()]
    mutated = text[: first.start()] + second.group() + between + first.group() + text[second.end() :]
    what = f"`{first.group()}` of line {line_of(text, first.start())}"
    return f"{what} and `{second.group()}` of line {line_of(text, second.start())} exchanged", mutated


def drop_statement(text: str, rng: random.Random) -> tuple[str, str]:
    lines = text.split("\n")
    full = [k for k, line in enumerate(lines) if line.strip() and not line.strip().startswith(("#", "}"))]
    k = rng.choice(full)
    return f"without line {k + 1}, `{lines[k].strip()}`", "\n".join(lines[:k] + lines[k + 1 :])


def drop_equation(text: str, rng: random.Random) -> tuple[str, str]:
    """Without one line that places, or without what follows the subject."""
    lines = text.split("\n")
    words = ("align", "connect", "joint", "let", "require", "count", "param", "slot", "port")
    k = rng.choice([k for k, line in enumerate(lines) if line.strip().startswith(words)] or [0])
    return f"without line {k + 1}, `{lines[k].strip()}`", "\n".join(lines[:k] + lines[k + 1 :])


def exchange_faces(text: str, rng: random.Random) -> tuple[str, str]:
    faces = [m for m in tokens(text) if m.group() in FACES] or tokens(text)
    token = rng.choice(faces)
    other = rng.choice([f for f in FACES if f != token.group()])
    done = f"line {line_of(text, token.start())}: `{token.group()}` as `{other}`"
    return done, text[: token.start()] + other + text[token.end() :]


def change_number(text: str, rng: random.Random) -> tuple[str, str]:
    token = rng.choice([m for m in tokens(text) if _NUMBER.match(m.group())])
    _, unit = _NUMBER.match(token.group()).groups()  # type: ignore[union-attr]
    value = rng.choice(("0", "1", "3", "0.001", "1000", "-2"))
    done = f"line {line_of(text, token.start())}: `{token.group()}` as `{value}{unit}`"
    return done, text[: token.start()] + value + unit + text[token.end() :]


def drop_argument(text: str, rng: random.Random) -> tuple[str, str]:
    found = list(re.finditer(r", *\w+ = [^,()\[\]\n]+(?=[,)])", text)) or tokens(text)
    cut = rng.choice(found)
    return f"line {line_of(text, cut.start())} without `{cut.group()}`", text[: cut.start()] + text[cut.end() :]


def change_unit(text: str, rng: random.Random) -> tuple[str, str]:
    numbers = [m for m in tokens(text) if _NUMBER.match(m.group())]
    token = rng.choice(numbers)
    value, unit = _NUMBER.match(token.group()).groups()  # type: ignore[union-attr]
    other = rng.choice([u for u in UNITS if u != unit])
    done = f"line {line_of(text, token.start())}: `{value}{unit}` as `{value}{other}`"
    return done, text[: token.start()] + value + other + text[token.end() :]
