"""Statements of a body that say what its parts are for and made of: labels, fields, grasps, keypoints, symmetries, materials."""

from __future__ import annotations

from typing import Any

from ...records import dataclass
from ...source import Span
from .declarations import TypeRef
from .expressions import Expr, RangeExpr
from .nodes import Clause, Stmt


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelStmt(Stmt):
    """``label affordance.pull on a, b where p.y < 0`` or ``label affordance.press on a = 1 - hypot(p.y, p.z) / r``;
    ``label affordance.lift for raise on a``: by which joint."""

    vocabulary: str
    label: str
    label_span: Span
    targets: tuple[Expr, ...]
    joint: Expr | None = None
    where: Expr | None = None
    value: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldStmt(Stmt):
    """``field heat : ratio on body where p.z > 0 = formula``."""

    name: str
    name_span: Span
    type: TypeRef
    targets: tuple[Expr, ...]
    where: Expr | None = None
    value: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspStmt(Stmt):
    """``grasp pull_handle on handle.grip for t in -0.4 .. 0.4 { at ... approach -x close y opening ... }``.

    Any word may stand in the braces: ``unknown`` are those that a grasp does not have.
    """

    name: str
    name_span: Span
    target: Expr
    parameter: str | None
    range: RangeExpr | None
    at: Clause[Expr] | None = None
    approach: Clause[Expr] | None = None
    close: Clause[Expr] | None = None
    opening: Clause[Expr] | None = None
    quality: Clause[Expr] | None = None
    stroke: Clause[Expr] | None = None
    length: Clause[Expr] | None = None
    width: Clause[Expr] | None = None
    thickness: Clause[Expr] | None = None
    pad: Clause[Expr] | None = None
    palm: Clause[Expr] | None = None
    palm_width: Clause[Expr] | None = None
    palm_depth: Clause[Expr] | None = None
    unknown: tuple[Clause[Any], ...] = ()

    @property
    def hand(self) -> tuple[Clause[Expr], ...]:
        """The measures of the gripper that the grasp is meant for, as far as they are given."""
        measures = (
            self.stroke,
            self.length,
            self.width,
            self.thickness,
            self.pad,
            self.palm,
            self.palm_width,
            self.palm_depth,
        )
        return tuple(m for m in measures if m is not None)


@dataclass(frozen=True, slots=True, kw_only=True)
class KeypointStmt(Stmt):
    """``keypoint tip on spout.end``, ``keypoint tip on grip at [size.x / 2, 0, 0]``."""

    name: str
    name_span: Span
    target: Expr
    at: Expr | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SymmetryStmt(Stmt):
    """``symmetry handle : turn 2 about z``; ``turn`` None for ``symmetry knob : any about z``."""

    target: Expr
    turn: Expr | None
    direction: Expr


@dataclass(frozen=True, slots=True, kw_only=True)
class MaterialStmt(Stmt):
    """``material oak on body, column.cell.front``."""

    material: str
    material_span: Span
    targets: tuple[Expr, ...]
