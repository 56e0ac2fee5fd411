"""The annotation of an object as plain data, and as a line of text: joints, parts, grasps, keypoints, what was drawn, what was repaired."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from ..graph.program import MEASURES
from ..language import JOINTS
from ..runtime.curves import tabulate
from .frames import rotate
from .grasps import GraspTable, KeypointTable, sample_grasps, sample_keypoints
from .gripper import REASONS, STANDARD, Gripper, judge
from .hierarchy import find_semantic_parents, lineages_of
from .interactions import Interactions, directions_of, find_interactions
from .poses import part_poses, symmetry_words
from .rows import Column, Known, PerObject, PerState, Rows, tidy, to_text
from .states import joint_twist, rest_values

if TYPE_CHECKING:
    from ..runtime.batch import Batch
    from ..runtime.gates import Gates

_VERSION = 1


def annotate(
    batch: Batch, states: np.ndarray | None = None, gripper: Gripper | None = STANDARD
) -> list[dict[str, Any]]:
    """One annotation per object of the batch, keys in a fixed order. Everything is as at rest.

    With joint values ``states`` (K, J) there is one key more, ``states``: what is elsewhere in each of them. Grasps that
    the gripper can make neither at rest nor in one of these are counted under ``dropped``; all are there without one.

    Lengths in metres, angles in radians, the object's frame (x front, y left, z up), quaternions w x y z.
    """
    columns = _columns(batch, states, gripper)
    plain = (column.plain(len(batch)) for column in columns.values())
    return [dict(zip(columns, values, strict=True)) for values in zip(*plain, strict=True)]


def annotation_lines(
    batch: Batch,
    states: np.ndarray | None = None,
    gripper: Gripper | None = STANDARD,
    details: list[dict[str, Any] | None] | None = None,
) -> Iterator[str]:
    """The same as text, ``to_text`` of each annotation; ``details`` of the objects, if they have any, are its last key."""
    columns = _columns(batch, states, gripper) | ({} if details is None else {"details": PerObject(details)})
    keys = [f"{to_text(name)}:" for name in columns]
    for values in zip(*(column.text(len(batch)) for column in columns.values()), strict=True):
        yield "{" + ",".join([key + value for key, value in zip(keys, values, strict=True)]) + "}"


def _columns(
    batch: Batch, states: np.ndarray | None, gripper: Gripper | None
) -> dict[str, Rows | PerObject | PerState]:
    """What the annotations of a batch are made of, keys in their order."""
    n = len(batch)
    grasps, reached, dropped = _reachable(batch, states, gripper)
    acting = find_interactions(batch)
    return {
        "object": PerObject(np.asarray(batch.numbers).tolist()),
        "category": PerObject([batch.program.name] * n),
        "seed": PerObject([int(batch.seed)] * n),
        "links": _links(batch),
        "joints": _joints(batch),
        **({"closures": _closures(batch)} if batch.program.closures else {}),
        "parts": _parts(batch),
        "grasps": _grasps(batch, grasps, reached),
        "dropped": PerObject(dropped),
        "keypoints": _keypoints(batch),
        "interactions": _interactions(batch, acting),
        **({} if states is None else {"states": _states(batch, states, grasps, reached, acting)}),
        "drawn": PerObject([_drawn(batch, i) for i in range(n)]),
        # draws before this one that broke a requirement
        "rejected": PerObject(np.asarray(batch.state.attempt).tolist()),
        "repairs": PerObject(_repairs(batch)),
        "version": PerObject([_VERSION] * n),
    }


def _drawn(batch: Batch, i: int) -> dict[str, Any]:
    drawn = batch.drawn(i)
    return {key: to_plain_data(drawn[key]) for key in sorted(drawn)}


def _repairs(batch: Batch) -> list[list[dict[str, Any]]]:
    """What was moved to make each object valid."""
    found: list[list[dict[str, Any]]] = [[] for _ in range(len(batch))]
    log = batch.repairs
    for owner, entry in zip(log.owner.tolist(), log.plain(batch.program), strict=True):
        found[owner].append({key: to_plain_data(value) for key, value in entry.items()})
    return found


def to_plain_data(value: Any) -> Any:
    """NumPy values, nested ones too, as what JSON knows."""
    if isinstance(value, dict):
        return {str(key): to_plain_data(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_plain_data(inner) for inner in value]
    if isinstance(value, np.ndarray):
        return to_plain_data(value.tolist())
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        number = round(float(value), 9) + 0.0
        return number if np.isfinite(number) else None
    return value if value is None else str(value)


def _links(batch: Batch) -> Rows:
    links = batch.links()
    return Rows(links.owner, {"name": list(links.name), "number": np.asarray(links.number)})


def _names(table: Any, n_objects: int, owner: np.ndarray, number: np.ndarray) -> list[str | None]:
    """Names of the rows ``number`` of the objects ``owner`` in a table; None where the number is negative."""
    starts = np.searchsorted(table.owner, np.arange(n_objects))
    at = (starts[owner] + number).tolist()
    return [table.name[k] if own >= 0 else None for k, own in zip(at, np.asarray(number).tolist(), strict=True)]


def _joints(batch: Batch) -> Rows:
    joints, links, n = batch.joints(), batch.links(), len(batch)
    parent = _names(links, n, joints.owner, joints.parent)
    child = _names(links, n, joints.owner, joints.child)
    leader = _names(joints, n, joints.owner, joints.mimic)
    follow = zip(leader, tidy(joints.multiplier), tidy(joints.offset), strict=True)
    mimic: list[Any] = [None if a is None else {"joint": a, "multiplier": m, "offset": o} for a, m, o in follow]
    for row, (lead, own) in tabulate(joints).items():  # of the straight line the ends alone are right
        mimic[row]["curve"] = {"lead": tidy(lead), "value": tidy(own)}
    columns: dict[str, Column] = {
        "name": list(joints.name),
        "type": list(joints.kind),
        "parent": parent,
        "child": child,
        **_axes(batch, None),
        "range": Known(np.stack([joints.low, joints.high], axis=-1)),
        "rest": joints.rest,
        "mimic": mimic,
    }
    if any(JOINTS[joint.kind].advances for joint in batch.program.joints):
        columns["pitch"] = joints.pitch  # metres by a turn
    if any(joint.positions is not None for joint in batch.program.joints):
        columns["positions"] = [None if np.isnan(count) else int(count) for count in joints.positions]
    if any(joint.stiffness is not None for joint in batch.program.joints):
        columns["stiffness"] = joints.stiffness  # N/m, N m/rad
    if batch.gates is not None:
        columns["enabled_when"] = _enabled_when(batch, batch.gates)
    if batch.program.closures:
        columns["driven_by"] = _driven_by(batch)
    return Rows(joints.owner, columns)


def _driven_by(batch: Batch) -> list[str | None]:
    """For each joint whose value a closed loop determines, the joint that drives the loop."""
    found: list[str | None] = [None] * len(batch.joints().name)
    if batch.loops is not None:
        names, drives = batch.joints().name, batch.loops.driven(np.arange(len(found)))
        for row in batch.loops.variable[batch.loops.follows].tolist():
            found[row] = None if drives[row] == row else names[drives[row]]
    return found


def _closures(batch: Batch) -> Rows:
    """Where closed loops close: the two links, and the place at rest."""
    loops, links = batch.loops, batch.links()
    if loops is None:
        return Rows(np.zeros(0, dtype=np.int64), {})
    turn, shift = batch.pose()
    place = rotate(turn[loops.link[0]], loops.point[0]) + shift[loops.link[0]]
    first = zip(*(loops.link.tolist()), strict=True)
    return Rows(loops.owner, {"links": [[links.name[a], links.name[b]] for a, b in first], "point": place})


def _enabled_when(batch: Batch, gates: Gates) -> list[list[dict[str, Any]] | None]:
    """For each joint what it waits for: the other joint and the ends between which it lets it move, None for none."""
    joints = batch.joints()
    found: list[list[dict[str, Any]]] = [[] for _ in joints.name]
    ends = (np.where(np.isfinite(end), end, np.nan) for end in (gates.low, gates.high))
    low, high = (tidy(end) for end in ends)
    for own, gate, above, below in zip(gates.joint.tolist(), gates.gate.tolist(), low, high, strict=True):
        found[own].append({"joint": joints.name[gate], "from": above, "to": below})
    return [conditions or None for conditions in found]


def _axes(batch: Batch, states: np.ndarray | None) -> dict[str, Column]:
    """Origins and axes of the joints: an axis moves with the link it is fixed to."""
    joints, links = batch.joints(), batch.links()
    turn, shift = batch.pose(states)
    holder = np.searchsorted(links.owner, joints.owner) + joints.parent
    origin = rotate(turn[holder], joints.origin) + shift[holder]
    return {"origin": origin, "axis": rotate(turn[holder], joints.axis)}


def _reachable(
    batch: Batch, states: np.ndarray | None, gripper: Gripper | None
) -> tuple[GraspTable, np.ndarray, list[list[dict[str, Any]]]]:
    """The grasps that a gripper can make, whether at rest and in each state (1 + K, G), and how many cannot be made.

    A grasp is dropped for what hinders it at rest.
    """
    grasps, n = sample_grasps(batch), len(batch)
    shown = [None] if states is None else [None, *states]
    if gripper is None:
        return grasps, np.full((len(shown), len(grasps.owner)), None), [[] for _ in range(n)]
    verdicts = np.stack([judge(batch, grasps, gripper, values) for values in shown])
    made = verdicts == 0
    kept = made.any(axis=0)
    dropped: list[list[dict[str, Any]]] = [[] for _ in range(n)]
    lost = np.flatnonzero(~kept)
    rows = np.stack([grasps.owner[lost], grasps.family[lost]], axis=1)
    families, which = np.unique(rows, axis=0, return_inverse=True)
    counts = np.zeros((len(families), len(REASONS)), dtype=np.int64)
    np.add.at(counts, (which.ravel(), verdicts[0, lost]), 1)
    for (owner, family), count in zip(families.tolist(), counts.tolist(), strict=True):
        told = dict(zip(REASONS[1:], count[1:], strict=True))
        dropped[owner].append({"name": batch.program.grasps[family].name} | told)
    at = np.flatnonzero(kept)
    return grasps.take(at), made[:, at], dropped


def _states(
    batch: Batch, states: np.ndarray, grasps: GraspTable, reached: np.ndarray, acting: Interactions
) -> PerState:
    """For each object, one entry per state: rows in the order of the lists ``joints``, ``parts``, ``grasps``,
    ``keypoints`` and ``interactions``, with what differs from rest."""
    keypoints, made = sample_keypoints(batch), []
    for values, reachable in zip(states, reached[1:], strict=True):
        poses = part_poses(batch, values)
        rows: dict[str, tuple[np.ndarray, dict[str, Column]]] = {
            "joints": (batch.joints().owner, {"value": values, **_axes(batch, values)}),
            "parts": (batch.parts().owner, {"center": poses.center, "quaternion": poses.quaternion}),
            "grasps": (grasps.owner, _grasp_frames(batch, grasps, values) | {"reachable": reachable}),
            "keypoints": (keypoints.owner, _places(batch, keypoints, values)),
            "interactions": (acting.owner, _acts(batch, acting, values)),
        }
        made.append({name: Rows(owner, columns) for name, (owner, columns) in rows.items()})
    return PerState(made)


def _parts(batch: Batch) -> Rows:
    parts, n = batch.parts(), len(batch)
    poses = part_poses(batch)
    words = batch.program.vocabularies.get("semantic", ())
    of = find_semantic_parents(parts)
    semantic = [words[i] if i else None for i in np.asarray(parts.semantic).tolist()]
    columns: dict[str, Column] = {
        "number": np.asarray(parts.number),
        "name": list(parts.name),
        "path": list(parts.path),
        "template": list(parts.template),
        "parent": [None if p < 0 else p for p in np.asarray(parts.parent).tolist()],
        "semantic": semantic,
        "of": [None if p < 0 else p for p in of.tolist()],
        "lineage": lineages_of(parts, of, words, batch.program.name),
        "link": _names(batch.links(), n, parts.owner, parts.link),
        "center": poses.center,
        "quaternion": poses.quaternion,
        "size": poses.size,
        "scale": poses.scale,
        "symmetry": symmetry_words(parts.symmetry),
    }
    return Rows(parts.owner, columns)


def _grasps(batch: Batch, grasps: GraspTable, reached: np.ndarray) -> Rows:
    links, n = batch.links(), len(batch)
    columns: dict[str, Column] = {
        "name": list(grasps.name),
        "link": _names(links, n, grasps.owner, grasps.link),
        "t": grasps.t,
        **_grasp_frames(batch, grasps, None),
        "opening": grasps.opening,
        "quality": grasps.quality,
        "gripper": [_stated(row) for row in tidy(grasps.hand)],
        "reachable": reached[0],
    }
    return Rows(grasps.owner, columns)


def _stated(hand: list[float]) -> dict[str, float] | None:
    """The measures that a grasp states of the gripper it is meant for, by name; None for none."""
    return {name: value for name, value in zip(MEASURES, hand, strict=True) if value == value} or None


def _grasp_frames(batch: Batch, grasps: GraspTable, states: np.ndarray | None) -> dict[str, Column]:
    starts = np.searchsorted(batch.links().owner, np.arange(len(batch)))
    point, _, turned = grasps.moved(starts, *batch.pose(states))
    return {"point": point, "quaternion": turned}


def _places(batch: Batch, keypoints: KeypointTable, states: np.ndarray | None) -> dict[str, Column]:
    turn, shift = batch.pose(states)
    link = np.searchsorted(batch.links().owner, np.arange(len(batch)))[keypoints.owner] + keypoints.link
    return {"point": rotate(turn[link], keypoints.point) + shift[link]}


def _keypoints(batch: Batch) -> Rows:
    keypoints, links, n = sample_keypoints(batch), batch.links(), len(batch)
    columns: dict[str, Column] = {
        "name": list(keypoints.name),
        "link": _names(links, n, keypoints.owner, keypoints.link),
        **_places(batch, keypoints, None),
    }
    return Rows(keypoints.owner, columns)


def _interactions(batch: Batch, acting: Interactions) -> Rows:
    links, joints = batch.links(), batch.joints()
    columns: dict[str, Column] = {
        "affordance": list(acting.name),
        "link": [links.name[k] for k in acting.link],
        "joint": [joints.name[k] for k in acting.joint],
        **_acts(batch, acting, None),
    }
    return Rows(acting.owner, columns)


def _acts(batch: Batch, acting: Interactions, states: np.ndarray | None) -> dict[str, Column]:
    """Where interactions act, which way and how fast their links move, and how far the joint can go each way."""
    turn, shift = batch.pose(states)
    joints = batch.joints()
    values = batch.settle(rest_values(batch) if states is None else states)
    point = rotate(turn[acting.link], acting.point) + shift[acting.link]
    direction, speed = directions_of(joint_twist(batch, states), acting.joint, point)
    left = np.stack([joints.low - values, joints.high - values], axis=-1)[acting.joint]
    acts: dict[str, Column] = {}
    if batch.gates is not None:
        shut = np.zeros(len(values), dtype=bool)
        shut[batch.gates.joint[batch.gates.held(values)]] = True
        left[shut[acting.joint]] = 0.0
        acts["enabled"] = ~shut[acting.joint]
    return acts | {"point": point, "direction": Known(direction), "speed": speed, "travel": Known(left)}
