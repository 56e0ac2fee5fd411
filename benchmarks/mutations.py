"""What ``fuzz.py`` does to a text: to its bytes, tokens, values and structure, and what mostly leaves it legal.

Each mutation takes the text, the lot and another file's text. Those that keep a program legal move numbers a little, change
counts, exchange names of one kind, drop statements whole, put a part there twice; in a compiled program they exchange
references of one kind, operators of one arity, and records.
"""

from __future__ import annotations

import random
import re
from collections import defaultdict
from collections.abc import Callable

Mutation = Callable[[str, random.Random, str], str]

EDGES = ("0", "1", "-1", "2", "3", "0.5", "1e-9", "1e9", "1e30", "1e308", "0.001", "1000", "-0.5", "100000", "7")
UNITS = ("mm", "cm", "m", "deg", "turn", "%", "kg", "s", "")
TOKEN = re.compile(
    r'#[^\n]*|"(?:[^"\\\n]|\\.)*"|[@$%]?\d[\d.]*(?:e[-+]?\d+)?[A-Za-z%/0-9]*|\w+|\.\.<?|->|[<>=!]=|[^\s\w]'
)
NUMBER = re.compile(r"(-?\d+(?:\.\d+)?(?:e[-+]?\d+)?)([A-Za-z%]*)$")
DECLARED = re.compile(
    r"^\s*(?:root )?(part|param|joint|let|count|slot|port|style|out|material|repeat) +(\w+)", re.MULTILINE
)
USED = re.compile(r"use +\w+ +\{([^}]*)\}")
STATEMENT = re.compile(r"^ +(?!\}|#)\S")
SIDES = (
    {"left", "right", "front", "back", "top", "bottom"},
    {"x", "y", "z"},
    {"min", "max"},
    {"revolute", "prismatic", "continuous"},
    {"on", "to"},
    {"about", "along"},
    {"sin", "cos"},
    {"<", "<=", ">", ">="},
    {"+", "-"},
    {"*", "/"},
)
REFERENCE = re.compile(r"([@$%])(\d+)")
OPERATORS = (
    {"add", "sub", "mul", "div", "min", "max", "mod", "atan2", "hypot", "pow"},
    {"neg", "abs", "sqrt", "sin", "cos", "floor", "sign"},
    {"lt", "le", "eq"},
    {"and", "or"},
    {"sum", "min", "max"},
    {"any", "all"},
)


def exchanged(text: str, found: re.Match[str], new: str) -> str:
    return text[: found.start()] + new + text[found.end() :]


# ---------------------------------------------------------------- whatever comes of it


def of_bytes(text: str, lot: random.Random, other: str) -> str:
    at = lot.randrange(len(text) + 1)
    end = min(len(text), at + lot.choice((0, 1, 1, 2, 5, 40)))
    new = lot.choice(
        ("", chr(lot.randrange(1, 127)), text[at:end] * 2, lot.choice("\0\n\t\"'{}[]()\\é\u2028#"), other[at:end])
    )
    return text[:at] + new + text[end:]


def of_tokens(text: str, lot: random.Random, other: str) -> str:
    tokens = list(TOKEN.finditer(text)) or [re.match("", text)]  # type: ignore[list-item]
    one, two = lot.choice(tokens), lot.choice(tokens)
    strange = TOKEN.findall(other) or [""]
    new = lot.choice(
        ("", two.group(), one.group() + " " + two.group(), lot.choice(strange), one.group() + " " + one.group())
    )
    return exchanged(text, one, new)


def of_values(text: str, lot: random.Random, other: str) -> str:
    """A number becomes an extreme one, another one, or gets another unit."""
    found = numbers(text)
    if not found:
        return of_tokens(text, lot, other)
    one = lot.choice(found)
    unit = NUMBER.match(one.group())[2] if lot.random() < 0.8 else lot.choice(UNITS)  # type: ignore[index]
    value = lot.choice((*EDGES, lot.choice(found).group(), str(round(lot.uniform(-2, 2), 3))))
    plain = NUMBER.match(value)
    return exchanged(text, one, value + (unit if plain and not plain[2] else ""))


def of_structure(text: str, lot: random.Random, other: str) -> str:
    """A line or a block dropped, said twice, moved, or taken from another file."""
    lines, strange = text.split("\n"), other.split("\n")
    first, last = block(lines, lot.randrange(len(lines)))
    piece = lines[first:last]
    rest = lines[:first] + lines[last:]
    at = lot.randrange(len(rest) + 1)
    match lot.randrange(4):
        case 0:
            return "\n".join(rest)
        case 1:
            return "\n".join(lines[:last] + piece + lines[last:])
        case 2:
            return "\n".join(rest[:at] + piece + rest[at:])
    begin, end = block(strange, lot.randrange(len(strange)))
    return "\n".join(rest[:at] + strange[begin:end] + rest[at:])


def block(lines: list[str], first: int) -> tuple[int, int]:
    """A line, to the end of the braces that it opens."""
    depth, last = 0, first
    while last < len(lines):
        depth += lines[last].count("{") - lines[last].count("}")
        last += 1
        if depth <= 0 or last - first > 80:
            break
    return first, last


def numbers(text: str) -> list[re.Match[str]]:
    return [m for m in TOKEN.finditer(text) if NUMBER.match(m.group())]


# ---------------------------------------------------------------- programs that mostly stay legal


def of_domains(text: str, lot: random.Random, other: str) -> str:
    """Up to three numbers become a little larger or smaller."""
    for _ in range(lot.randrange(1, 4)):
        found = [one for one in numbers(text) if one.group() not in ("0", "1")]
        if not found:
            return text
        one = lot.choice(found)
        value, unit = NUMBER.match(one.group()).groups()  # type: ignore[union-attr]
        whole = re.fullmatch(r"-?\d+", value) is not None and not unit
        new = float(value) * lot.choice((0.5, 0.8, 0.9, 0.97, 1.03, 1.1, 1.25, 2.0))
        text = exchanged(text, one, (str(round(new)) if whole else f"{new:.6g}") + unit)
    return text


def of_counts(text: str, lot: random.Random, other: str) -> str:
    """A whole number without a unit becomes another small one."""
    found = [one for one in numbers(text) if re.fullmatch(r"\d{1,2}", one.group())][1:]  # the first is the version
    return exchanged(text, lot.choice(found), str(lot.randrange(7))) if found else text


def of_names(text: str, lot: random.Random, other: str) -> str:
    """A name, a side, an axis or an operator becomes another of its kind."""
    kinds: dict[str, set[str]] = defaultdict(set)
    for kind, name in DECLARED.findall(text):
        kinds[kind].add(name)
    groups = [*kinds.values(), *({w.strip() for w in m.split(",")} for m in USED.findall(text)), *SIDES]
    head = text.find("category ")
    tokens = [(one, group) for one in TOKEN.finditer(text, max(head, 0)) for group in groups if one.group() in group]
    tokens = [(one, sorted(group - {one.group()})) for one, group in tokens if len(group) > 1]
    if not tokens:
        return text
    one, group = lot.choice(tokens)
    return exchanged(text, one, lot.choice(group))


def of_statements(text: str, lot: random.Random, other: str) -> str:
    """A whole statement dropped, moved to another place in the text, or put under a guard."""
    lines = text.split("\n")
    inside = [k for k, line in enumerate(lines) if STATEMENT.match(line)]
    if not inside:
        return text
    first, last = block(lines, lot.choice(inside))
    piece, rest = lines[first:last], lines[:first] + lines[last:]
    match lot.randrange(4):
        case 0 | 1:
            return "\n".join(rest)
        case 2:
            at = min(lot.choice(inside), len(rest))
            return "\n".join(rest[:at] + piece + rest[at:])
    named = re.findall(r"^ +param (\w+) *: *choice (\w+)", text, re.MULTILINE)
    counted = re.findall(r"^ +count (\w+) in (\d+)", text, re.MULTILINE)
    guards = [f"{name} == {value}" for name, value in (*named, *counted)]
    if not guards:
        return "\n".join(rest)
    return "\n".join([*lines[:first], f"when {lot.choice(guards)} {{", *piece, "}", *lines[last:]])


def of_parts(text: str, lot: random.Random, other: str) -> str:
    """A part there twice, with all that is said of it: the second has another name."""
    parts = re.findall(r"^ +part +(\w+)", text, re.MULTILINE)
    if not parts:
        return text
    name = lot.choice(parts)
    lines, made, at = text.split("\n"), [], 0
    while at < len(lines):
        first, last = block(lines, at)
        piece = "\n".join(lines[first:last])
        if last - first > 40 or re.match(r"\s*(use|category|template|role|apg)\b", lines[first]):
            last, piece = first + 1, lines[first]
        made.append(piece)
        if STATEMENT.match(piece) and re.search(rf"\b{name}\b", piece) and piece.count("{") == piece.count("}"):
            again = re.sub(rf"\b{name}\b", f"{name}_2", piece)
            made.append(re.sub(r"^(\s*(?:joint|grasp|keypoint|field|let|param) +\w+)", r"\1_2", again))
        at = last
    return "\n".join(made)


# ---------------------------------------------------------------- compiled programs that mostly stay legal


def of_references(text: str, lot: random.Random, other: str) -> str:
    """A reference to an expression, a column or a table becomes another, of the same kind and defined before."""
    found = list(REFERENCE.finditer(text))
    if not found:
        return text
    one = lot.choice(found)
    near = max(0, int(one[2]) + lot.choice((-20, -5, -2, -1, 1, 2, 5)))
    return exchanged(text, one, f"{one[1]}{near}")


def of_operators(text: str, lot: random.Random, other: str) -> str:
    """An operator becomes another of its arity; for want of one, a word becomes another of its kind."""
    tokens = [
        (one, sorted(group - {one.group()}))
        for one in re.finditer(r"(?<= = )\w+", text)
        for group in OPERATORS
        if one.group() in group
    ]
    if not tokens:
        return text
    one, group = lot.choice(tokens)
    return exchanged(text, one, lot.choice(group))


def of_records(text: str, lot: random.Random, other: str) -> str:
    """A record dropped, there twice, exchanged with another of its kind, or a field of it taken from another."""
    lines = text.split("\n")
    records = [k for k, line in enumerate(lines) if re.match(r"[a-z]+ \(", line)]
    if not records:
        return text
    k = lot.choice(records)
    kind = lines[k].split(" ", 1)[0]
    j = lot.choice([j for j in records if lines[j].startswith(kind + " ")])
    match lot.randrange(4):
        case 0:
            del lines[k]
        case 1:
            lines.insert(k, lines[j])
        case 2:
            lines[k], lines[j] = lines[j], lines[k]
        case 3:
            fields = list(re.finditer(r" [a-z_]+ (?:\S+|\[[^\]]*\])(?= |\))", lines[k]))
            one = lot.choice(fields) if fields else None
            same = (
                None if one is None else re.search(rf" {one.group().split()[0]} (?:\S+|\[[^\]]*\])(?= |\))", lines[j])
            )
            if one is not None:
                lines[k] = exchanged(lines[k], one, same.group() if same and lot.random() < 0.7 else "")
    return "\n".join(lines)


KINDS: tuple[Mutation, ...] = (of_bytes, of_tokens, of_values, of_values, of_structure)
LEGAL: tuple[Mutation, ...] = (of_domains, of_domains, of_counts, of_names, of_statements, of_statements, of_parts)
COMPILED: tuple[Mutation, ...] = (of_domains, of_domains, of_references, of_operators, of_records)
