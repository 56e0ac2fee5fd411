"""Labels of affordances that move nothing, and joints that no label is about."""

from __future__ import annotations

from ..quality.unhandled import find_unhandled
from ..validity.tree import Tree
from .seen import Seen


def warn_lifting(seen: Seen) -> None:
    """Report labels of what is pressed on surfaces that their joint can only move outwards from rest."""
    from ..quality.dead import find_lifting  # start-up

    program = seen.batch.program
    pressed = [each for each in program.labels if each.name == "press" and seen.line(each.where) is not None]
    for label, joint in find_lifting(seen.batch, pressed) if pressed else ():
        seen.report.warning(
            "idle-press",
            seen.line(label.where) or seen.span,
            f"no press moves what is labelled `{label.vocabulary}.press` here: from rest, "
            f"`{program.joints[joint].path}` moves it out of its surface alone",
            hint="exchange the signs of the range of the joint, turn its axis round, or label the face on the other side",
        )


def warn_unhandled(seen: Seen, tree: Tree) -> None:
    """Report joints that no label of an affordance is about, of programs that say of others how to move them."""
    for number in find_unhandled(tree):
        joint = seen.batch.program.joints[number]
        seen.report.warning(
            "missing-affordance",
            seen.line(joint.where) or seen.span,
            f"no label says how to move `{joint.path}`: nothing that it carries has an affordance",
            hint=f"write for example `label affordance.{'slide' if joint.kind == 'prismatic' else 'turn'} on ...` for what a hand takes; "
            "if another joint drives it, give it a `mimic`",
        )
