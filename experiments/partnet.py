"""Objects of PartNet-Mobility: ``ID/`` with ``mobility_v2.json``, ``meta.json``, ``point_sample/``; y up, z to the front, hinges in degrees."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from artipg_dsl.errors import UserError

from .real import Joint, Real, checked, make_joint, upright

_PLACES, _LEAVES = "sample-points-all-pts-nor-rgba-10000.txt", "sample-points-all-label-10000.txt"
_BARE, _BARE_LEAVES = "pts-10000.txt", "label-10000.txt"
_KINDS = {"hinge": "revolute", "slider": "prismatic", "slider+": "prismatic"}


def category_of(place: Path) -> str:
    """``model_cat`` of an object. Raises UserError."""
    try:
        return str(json.loads((place / "meta.json").read_text(encoding="utf-8"))["model_cat"])
    except (OSError, ValueError, KeyError, TypeError) as wrong:
        raise UserError(f"{place / 'meta.json'}: {wrong!r}", "`model_cat` tells the category") from None


def read_mobility(place: Path, category: str) -> Real:
    """An object with x to the front and z up. Raises UserError with what is missing or wrong."""
    path, turned = place / "mobility_v2.json", upright("y", "z")
    try:
        nodes = json.loads(path.read_text(encoding="utf-8"))
        number = {node["id"]: k for k, node in enumerate(nodes)}
        link_of = {leaf: k for k, node in enumerate(nodes) for leaf in _leaves(node["parts"])}
        joints = tuple(_joint(node, number, turned) for node in nodes if node["parent"] in number)
    except (OSError, ValueError, KeyError, TypeError) as wrong:
        raise UserError(
            f"{path}: {wrong!r} is missing or wrong", "id, parent, joint, parts and jointData are read"
        ) from None
    points, normals, leaves = _points(place / "point_sample")
    lost = sorted(set(leaves.tolist()) - link_of.keys())
    if lost:
        raise UserError(f"{place / 'point_sample'}: leaves {lost[:5]} belong to no link of mobility_v2.json")
    link = np.array([link_of[leaf] for leaf in leaves.tolist()])
    normals = None if normals is None else normals @ turned.T
    return checked(path, category, place.name, points @ turned.T, normals, link, len(nodes), joints)


def _leaves(parts: list[dict[str, Any]]) -> list[int]:
    return [leaf for part in parts for leaf in (part["id"], *_leaves(part.get("children") or []))]


def _joint(node: dict[str, Any], number: dict[int, int], turned: np.ndarray) -> Joint:
    parent, child, data = number[node["parent"]], number[node["id"]], node["jointData"]
    kind = _KINDS.get(node["joint"], "fixed")
    if kind == "fixed" or not data:
        return Joint("fixed", parent, child, np.zeros(3), np.zeros(3))
    axis, limit = data["axis"], data.get("limit") or {}
    ends = [float(limit[end]) for end in "ab" if limit.get(end) is not None and not limit.get("noLimit")]
    low, high = (min(ends), max(ends)) if len(ends) == 2 else (None, None)
    origin = np.array(axis.get("origin") or [0.0] * 3, dtype=np.float64)
    return make_joint(
        kind, parent, child, turned @ np.array(axis["direction"], dtype=np.float64), turned @ origin, low, high
    )


def _points(place: Path) -> tuple[np.ndarray, np.ndarray | None, np.ndarray]:
    """Points, normals where there are any, and leaves."""
    names = (_PLACES, _LEAVES) if (place / _PLACES).exists() else (_BARE, _BARE_LEAVES)
    try:
        table, leaves = (np.loadtxt(place / name, ndmin=2) for name in names)
    except (OSError, ValueError) as wrong:
        raise UserError(
            f"{place}: {wrong}", f"{_PLACES} and {_LEAVES} are read, or {_BARE} and {_BARE_LEAVES}"
        ) from None
    if table.shape[1] < 3 or len(leaves) != len(table):
        raise UserError(f"{place / names[0]}: {table.shape} numbers for {len(leaves)} leaves")
    return table[:, :3], table[:, 3:6] if table.shape[1] >= 6 else None, leaves[:, 0].astype(np.int64)
