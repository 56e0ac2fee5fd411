"""The text form of a program: printable, read back to the same program, and what artefacts hold and hashes are of.

One item a line. ``@n`` is a scope, ``$n`` a column, ``%n`` an expression (numbered in the order of dependence); a record
is ``(Name field value ...)`` without the fields that have their default; a list is ``[...]``. ``#`` begins a comment. Here stands
which records and items there are; ``writing`` writes them, ``reading`` reads them.
"""

from __future__ import annotations

from . import program as P
from .primitive import Patch, Piece, Primitive
from .reference import Elsewhere, Onward, Under

VERSION = 1
RECORDS = {
    cls.__name__: cls
    for cls in (
        P.Where,
        P.Pose,
        P.Bound,
        P.Limit,
        P.Union,
        P.Draw,
        P.Requirement,
        P.Preference,
        P.Part,
        P.Site,
        P.Link,
        P.Gate,
        P.Joint,
        P.Target,
        P.Label,
        P.Grasp,
        P.Keypoint,
        P.Material,
        P.Allowed,
        P.Closure,
        P.Slot,
        P.Clear,
        P.Stable,
        Primitive,
        Patch,
        Piece,
        Under,
        Elsewhere,
        Onward,
    )
}
KEPT: dict[str, type] = {
    "draw": P.Draw,
    "requirements": P.Requirement,
    "preferences": P.Preference,
    "parts": P.Part,
    "links": P.Link,
    "joints": P.Joint,
    "sites": P.Site,
    "labels": P.Label,
    "grasps": P.Grasp,
    "keypoints": P.Keypoint,
    "allowed": P.Allowed,
    "closures": P.Closure,
    "slots": P.Slot,
    "clear": P.Clear,
    "stable": P.Stable,
    "materials": P.Material,
    "primitives": Primitive,
}
