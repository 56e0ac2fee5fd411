"""How a part is turned before it is placed: ``along`` and ``turned``, one after the other."""

from __future__ import annotations

from ...syntax import ast
from ..expressions.env import Env
from ..expressions.evaluate import Evaluator
from ..values.vectors import IDENTITY, Matrix, along, normalized, product, rotation_about, signed_axis


def apply_placements(env: Env, placements: tuple[ast.Placement, ...], outer: Matrix = IDENTITY) -> Matrix:
    """The placements one after the other, then the rotation ``outer``."""
    ev, made = Evaluator(env), IDENTITY
    for placement in placements:
        direction = ev.direction(placement.direction)
        if placement.angle is None:
            if signed_axis(direction) is None:
                raise env.context.error(
                    "bad-axis",
                    placement.direction.span,
                    "a part can only lie along x, y or z",
                    hint="for any other direction use `turned 20deg about y`, or `connect` with frames",
                )
            step = along(direction)
        else:
            angle = ev.scalar(placement.angle)
            step = rotation_about(normalized(direction), angle)
            around = next((e for e in env.chain() if e.element is not None and e.frame.rotation is not IDENTITY), None)
            if around is not None and angle.constant is None:
                env.context.spun.append((placement.span, env.scope, step, around.frame.rotation))
        made = product(step, made)
    return made if outer is IDENTITY else product(outer, made)
