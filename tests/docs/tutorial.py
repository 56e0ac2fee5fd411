"""A page that builds a program step by step: its fences change a file, and show what commands say of it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_FENCE = re.compile(r"^```(?P<mark>apg|console)(?P<how>[^\n]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL)


@dataclass(frozen=True, slots=True)
class Step:
    """A fence. What ``how`` says of an ``apg`` fence:

    file       the whole file
    use        imports, behind those there are
    above      declarations, above the category
    add        statements, at the end of the category
    instead    a statement in the place of the one that begins with the same two words
    wrong      as `add`, for the commands that follow at once
    """

    line: int
    how: str
    text: str


def steps(page: Path) -> list[Step]:
    text = page.read_text(encoding="utf-8")
    return [
        Step(text.count("\n", 0, m.start()) + 1, (m["how"].strip() or m["mark"]), m["text"])
        for m in _FENCE.finditer(text)
    ]


def changed(program: str, step: Step) -> str:
    """The file after an ``apg`` step."""
    if step.how == "file":
        return step.text
    if step.how == "use":
        last = [m.end() for m in re.finditer(r"^use [^}]*\}\n", program, re.MULTILINE)][-1]
        return program[:last] + step.text + program[last:]
    if step.how == "above":
        place = re.search(r"(^##[^\n]*\n)*^category ", program, re.MULTILINE)
        assert place is not None
        return program[: place.start()] + step.text + "\n" + program[place.start() :]
    if step.how == "instead":
        words = re.match(r"\s*(\S+ \S+)", step.text)
        assert words is not None
        pattern = rf"^ *{re.escape(words[1])}\b[^\n]*\n"
        assert len(re.findall(pattern, program, re.MULTILINE)) == 1, (step.line, words[1])
        return re.sub(pattern, lambda _: step.text, program, count=1, flags=re.MULTILINE)
    assert step.how in ("add", "wrong"), step
    end = program.rindex("}")
    return program[:end] + step.text + program[end:]


def commands(step: Step) -> list[tuple[list[str], str]]:
    """The commands of a console fence, each with what it says: lines as they are, `...` for anything."""
    found: list[tuple[list[str], str]] = []
    for line in step.text.splitlines(keepends=True):
        if line.startswith("$ apgc "):
            found.append((line.split("#")[0].split()[2:], ""))
        else:
            command, said = found[-1]
            found[-1] = (command, said + line)
    return found


def matches(expected: str, said: str) -> bool:
    pattern = ".*".join(re.escape(piece) for piece in expected.strip().split("..."))
    return re.fullmatch(pattern, said.strip(), re.DOTALL) is not None
