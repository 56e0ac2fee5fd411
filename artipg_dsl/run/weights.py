"""What a prior says of one draw, read: shares and weights of options and values, ranges, distributions."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ..diagnostics.suggest import did_you_mean, given
from ..errors import SettingError
from ..graph.reweigh import Group, narrow, redistribute, share_options, weigh_options, weigh_values
from ..language import DISTRIBUTIONS
from ..shapes import show_value
from .settings import read_setting

if TYPE_CHECKING:
    from ..graph.program import Draw

_NONE = "none"
_SHARE = re.compile(r"\s*(\d+\.?\d*|\.\d+)\s*%\s*")
_LAW = re.compile(r"\s*(?P<law>\w+)\s*(?:\((?P<arguments>[^()]*)\))?\s*")
_WHOLE = 0.5e-2  # how far shares of all values may be from adding up to 1, where they are rounded to a percent


def change_draw(draw: Draw, entry: Any) -> Draw:
    """The draw as ``entry`` wants it. Raises SettingError, NothingLeft."""
    if draw.kind == "choice":
        if isinstance(entry, Mapping):
            return _weighed_choice(draw, entry)
        return _present(draw, entry)
    if isinstance(entry, Mapping):
        return _weighed_number(draw, entry)
    if isinstance(entry, str):
        return _stated(draw, entry)
    if isinstance(entry, list) and len(entry) == 2:
        return _ranged(draw, *entry)
    raise SettingError(
        f"`{draw.column.name}` is {show_value(entry)}: a range, a distribution or weights of values are needed",
        f'write "{_example(draw)}", or --set {draw.column.name}=VALUE to fix it',
    )


# ---------------------------------------------------------------- choices


def _present(draw: Draw, entry: Any) -> Draw:
    """A part that is there in a share of the objects."""
    name = draw.column.name
    if _NONE not in draw.options:
        known = ", ".join(draw.options)
        raise SettingError(
            f"`{name}` is {show_value(entry)}, but it is one of {known} in every object",
            f'give shares or weights: {{"{draw.options[0]}": "30%"}}',
        )
    none = draw.options.index(_NONE)
    present = tuple(k for k in range(len(draw.options)) if k != none)
    share = _read_share(draw, entry)
    if isinstance(entry, int | float) and not isinstance(entry, bool) and 0 <= entry <= 1:
        share = float(entry)
    if share is None:
        raise SettingError(
            f"`{name}` is {show_value(entry)}: how often it is there is needed", 'a share from 0 to 1, or "23%"'
        )
    return share_options(draw, [(present, share)], otherwise=(none,))


def _weighed_choice(draw: Draw, entry: Mapping[str, Any]) -> Draw:
    groups: list[tuple[Group, Any]] = []
    for key, value in entry.items():
        group = tuple(int(read_setting(draw, name.strip())[0]) for name in key.split("|"))
        for k in group:
            if any(k in other for other, _ in groups) or group.count(k) > 1:
                raise SettingError(f"`{draw.column.name}`: `{draw.options[k]}` is there twice", "leave one of them out")
        groups.append((group, value))
    shares = [(group, _read_share(draw, value)) for group, value in groups]
    if shares and all(share is not None for _, share in shares):
        return share_options(draw, [(group, share or 0.0) for group, share in shares])
    for key, (group, _) in zip(entry, groups, strict=True):
        if len(group) > 1:
            raise SettingError(
                f"`{draw.column.name}`: `{key}` are several options, which have a share together",
                f'write {{"{key}": "30%"}}',
            )
    return weigh_options(draw, {group[0]: _read_weight(draw, value) for group, value in groups})


def _read_share(draw: Draw, value: Any) -> float | None:
    """``"23%"`` as 0.23; None for what is no share. Raises SettingError."""
    found = _SHARE.fullmatch(value) if isinstance(value, str) else None
    if found is None:
        return None
    share = float(found[1]) / 100.0
    if share > 1.0:
        raise SettingError(f"`{draw.column.name}`: {value} is no share", "shares lie between 0% and 100%")
    return share


def _read_weight(draw: Draw, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or value != 0 and not 1e-9 <= value <= 1e9:
        raise SettingError(
            f"`{draw.column.name}`: {show_value(value)} is no weight",
            'all are weights, 0 or from 1e-9 to 1e9, or all are shares, such as "30%"',
        )
    return float(value)


# ---------------------------------------------------------------- numbers


def _weighed_number(draw: Draw, entry: Mapping[str, Any]) -> Draw:
    name = draw.column.name
    weights: dict[float, float] = {}
    shares = [_read_share(draw, value) for value in entry.values()]
    alike = bool(shares) and all(share is not None for share in shares)
    if alike and abs(sum(share or 0.0 for share in shares) - 1.0) > _WHOLE:
        total = 100.0 * sum(share or 0.0 for share in shares)
        raise SettingError(
            f"`{name}`: the shares of its values add up to {total:.6g}%", "name every value, or give weights"
        )
    for (key, value), share in zip(entry.items(), shares, strict=True):
        number = read_setting(draw, key)[0]
        if number in weights:
            raise SettingError(f"`{name}`: {key} is there twice", "leave one of them out")
        weights[number] = (share or 0.0) if alike else _read_weight(draw, value)
    return weigh_values(draw, weights)


def _stated(draw: Draw, text: str) -> Draw:
    """``45cm .. 55cm``, ``~ normal(50cm, 2cm)``, or both."""
    ends, wave, law = text.partition("~")
    low, dots, high = ends.partition("..")
    found = _LAW.fullmatch(law)
    if bool(wave) != (found is not None) or bool(ends.strip()) != bool(dots) or not text.strip():
        raise SettingError(
            f"`{draw.column.name}` cannot be `{text}`: a range or a distribution is needed", f'write "{_example(draw)}"'
        )
    if dots:
        draw = _ranged(draw, low.strip(), high.strip())
    if found is None:
        return draw
    return _distributed(draw, found["law"], [a.strip() for a in (found["arguments"] or "").split(",") if a.strip()])


def _ranged(draw: Draw, low: Any, high: Any) -> Draw:
    ends = []
    for end in (low, high):
        if isinstance(end, bool) or not isinstance(end, int | float | str):
            raise SettingError(
                f"`{draw.column.name}`: {show_value(end)} is no end of a range", f'write "{_example(draw)}"'
            )
        ends.append(read_setting(draw, end)[0])
    if not all(map(math.isfinite, ends)) or ends[0] > ends[1]:
        raise SettingError(f"`{draw.column.name}`: the range {low} .. {high} is empty", "its low end comes first")
    return narrow(draw, ends[0], ends[1])


def _distributed(draw: Draw, law: str, arguments: list[str]) -> Draw:
    name = draw.column.name
    if law not in DISTRIBUTIONS:
        raise SettingError(
            f"`{name}`: there is no distribution `{law}`",
            did_you_mean(law, DISTRIBUTIONS) or f"the distributions are {', '.join(DISTRIBUTIONS)}",
        )
    kind = DISTRIBUTIONS[law]
    if len(arguments) not in kind.arguments:
        raise SettingError(f"`{name}`: {law}: {given(len(arguments))}", f"it takes {kind.example}")
    if law == "values":
        return weigh_values(draw, Counter(read_setting(draw, a)[0] for a in arguments))
    number = replace(draw, kind="real")
    plain = replace(number, unit="")  # a relative deviation
    read = [
        read_setting(plain if law == "lognormal" and k == 1 else number, a, anywhere=True)[0]
        for k, a in enumerate(arguments)
    ]
    for k in kind.positive:
        if not read[k] > 0.0:
            raise SettingError(f"`{name}`: {arguments[k]} in {law} must be above 0")
    return redistribute(draw, law, read)


def _example(draw: Draw) -> str:
    unit = {"m": "cm", "rad": "deg"}.get(draw.unit, draw.unit)
    return f"2{unit} .. 3{unit}"
