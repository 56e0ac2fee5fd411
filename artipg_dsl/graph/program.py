"""The compiled program: tables, draws, definitions, requirements, and what stands on them.

Everything here is data about scopes and expressions; nothing knows syntax, nothing holds numbers of a sample. Poses are in the
frame of the object (x front, y left, z up, metres), at joint values 0 unless said otherwise. For links see ``reference``.
"""

from __future__ import annotations

from dataclasses import field

from ..records import dataclass
from .expr import TRUE, Column, Expr, Scope
from .primitive import Primitive
from .reference import Reference

Triple = tuple[Expr, Expr, Expr]

LEAD = "lead"  # in the formula of a follower: the value of the joint that it follows
UNLABELLED = "unlabelled"  # place 0 of every vocabulary: of a surface no word of it is said


@dataclass(frozen=True, slots=True, eq=False)
class Where:
    """A place in the source text, for messages."""

    file: str
    line: int
    column: int = 1

    def __str__(self) -> str:
        return f"{self.file}:{self.line}"


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """A rigid placement: rotation (rows of a proper 3 x 3 matrix) and translation, both expressions.

    ``mirror`` is +1 or -1: local geometry is taken at (x, mirror * y, z) before it is placed.
    """

    rotation: tuple[Triple, Triple, Triple]
    translation: Triple
    mirror: Expr


@dataclass(frozen=True, slots=True, eq=False)
class Bound:
    """A conditional bound of a draw: the value lies above (``side`` "low") or below ("high") ``value`` where ``guard`` holds.

    It comes from ``requirement`` (an index into Program.requirements), together with those of ``also``.
    """

    side: str
    value: Expr
    guard: Expr
    requirement: int
    also: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Limit:
    """A conditional limit of a choice: the option may only be taken where ``allowed`` holds."""

    option: int
    allowed: Expr
    requirement: int  # index into Program.requirements


@dataclass(frozen=True, slots=True, eq=False)
class Union:
    """A conditional range of several intervals: the value lies in one of ``intervals`` (low, high) where ``guard`` holds."""

    intervals: tuple[tuple[Expr, Expr], ...]
    guard: Expr
    requirement: int
    also: tuple[int, ...] = ()


@dataclass(slots=True, eq=False)
class Draw:
    """A variable that is drawn. ``address`` names it for the random function (the path, or the old name after ``was``).

    ``kind`` "real" and "count": uniform, normal (mean, deviation), lognormal (median, sigma), values (the values) or weighted
    between ``low`` and ``high``, narrowed by ``bounds`` and ``unions``. ``kind`` "choice": one of ``options`` with ``weights``.
    ``vary`` is the reach of a CPA step: (True, fraction of the value) or (False, metres or radians).
    """

    column: Column
    address: str
    kind: str
    low: Expr | None = None
    high: Expr | None = None
    default: Expr | None = None
    distribution: str = "uniform"
    arguments: tuple[Expr, ...] = ()
    options: tuple[str, ...] = ()
    weights: tuple[Expr, ...] = ()
    vary: tuple[bool, Expr] | None = None
    unit: str = ""
    where: Where | None = None
    bounds: list[Bound] = field(default_factory=list)
    limits: list[Limit] = field(default_factory=list)
    unions: list[Union] = field(default_factory=list)
    doc: str = ""

    @property
    def ends(self) -> tuple[Expr, Expr]:
        """The ends of its domain; of a real or a count, which have them."""
        assert self.low is not None and self.high is not None
        return self.low, self.high


@dataclass(frozen=True, slots=True, eq=False)
class Requirement:
    """``condition`` must hold in every row of ``scope`` where ``guard`` does.

    ``slack`` (low, high), when the condition is ``low <= high``, lets the evaluator allow for rounding.
    ``repair`` are the draws (indices) that should give way first where it fails.
    """

    scope: Scope
    condition: Expr
    guard: Expr
    message: str
    where: Where | None
    slack: tuple[Expr, Expr] | None = None
    repair: tuple[int, ...] = ()
    text: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Preference:
    """``prefer``: for each row of ``scope`` where ``guard`` holds and ``condition`` does not, an object is exp(``weight``)
    times rarer."""

    scope: Scope
    condition: Expr
    guard: Expr
    weight: Expr
    where: Where | None
    text: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Part:
    """A node of the part tree, one instance per row of ``scope`` (a chosen alternative has its own scope).

    ``path`` such as ``door`` or ``handle.post``; ``parent`` indexes Program.parts (-1: the object itself).
    ``template`` is the template or primitive it is an instance of. ``box`` (low, high) lies in the part's own frame.
    """

    path: str
    name: str
    scope: Scope
    parent: int
    template: str
    pose: Pose
    low: Triple
    high: Triple
    link: Reference
    semantic: tuple[tuple[str, Expr], ...] = ()  # (word for the whole part, predicate), the last that holds counts
    symmetry: tuple[Expr, Expr] | None = None  # (turns, axis 0..2), where there is one; turns 0: any angle, 1: none
    holder: Reference = ()  # the part that it is rigidly connected to, if there is one

    @property
    def word(self) -> str:
        """What a kind of part is called, whatever the object: the last of its semantic words, "" where it has none."""
        return self.semantic[-1][0] if self.semantic else ""


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """An elementary primitive, one instance per row of ``scope``. ``parameters`` in the order of the primitive's."""

    path: str
    scope: Scope
    primitive: str
    parameters: tuple[Expr, ...]
    pose: Pose
    link: Reference
    part: int  # index into Program.parts: the part that this primitive is
    materials: tuple[tuple[str, Expr], ...] = ()  # (name, predicate), the last that holds counts


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """A rigid link, one instance per row of ``scope``; link 0 is the root. ``part`` is the part whose frame it takes."""

    path: str
    scope: Scope
    part: int


@dataclass(frozen=True, slots=True, eq=False)
class Gate:
    """What a joint waits for: it moves only while the value of ``joint`` lies in ``low`` .. ``high``, radians or metres (None: no
    such end). ``text`` is the comparison as it is written."""

    joint: Reference
    low: Expr | None
    high: Expr | None
    text: str


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """``kind``: revolute, prismatic, continuous, screw, ball or fixed; origin and axis in the object's frame at value 0.

    ``low``, ``high``, ``rest`` in radians or metres (None: no limit; of a ball, how far it tilts). ``mimic`` is (reference
    to a joint, multiplier, offset); with a ``curve`` it follows by that formula of ``lead``, the other's value. One instance per row
    of ``scope``. ``clearance``: from its rest value it goes on as far as nothing is in the way, at most to ``high``; ``whatever``: with
    the other joints anywhere, else at rest. It stays at rest unless all ``gates`` are open. It catches at ``positions`` values.
    A spring of ``stiffness`` draws it back to ``rest``.
    """

    path: str
    name: str
    scope: Scope
    kind: str
    parent: Reference  # link
    child: int  # link
    origin: Triple
    axis: Triple
    low: Expr | None
    high: Expr | None
    rest: Expr
    mimic: tuple[Reference, Expr, Expr] | None = None
    curve: Expr | None = None
    damping: Expr | None = None
    friction: Expr | None = None
    stiffness: Expr | None = None
    effort: Expr | None = None
    velocity: Expr | None = None
    pitch: Expr | None = None
    positions: Expr | None = None
    where: Where | None = None
    clearance: bool = False
    whatever: bool = False
    gates: tuple[Gate, ...] = ()

    @property
    def values(self) -> tuple[Expr | None, ...]:
        """Its limits and what moves it, in one order: low, high, rest, damping, friction, stiffness, effort, velocity,
        pitch, positions."""
        limits = (self.low, self.high, self.rest)
        return (
            *limits,
            self.damping,
            self.friction,
            self.stiffness,
            self.effort,
            self.velocity,
            self.pitch,
            self.positions,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """Where a label lies: a site, with the surfaces meant (empty: all), in the frame and size a formula reads.

    ``frame`` places the formula's frame in the object; ``low``, ``high`` are the box of what the formula is on, in
    that frame (its centre is the origin of ``p``).
    """

    site: int
    surfaces: tuple[str, ...]
    frame: Pose
    size: Triple
    center: Triple


@dataclass(frozen=True, slots=True, eq=False)
class Label:
    """A formula on the surface. ``vocabulary`` "semantic", "affordance", ... or "field".

    ``value`` is a formula over p.x p.y p.z n.x n.y n.z u v size.x size.y size.z and columns of ``scope``'s chain:
    a predicate (True everywhere where a label has no ``where``) or a number in 0 .. 1 (a graded label) or any (a field).
    Nothing is said where ``guard``, a predicate over the same, does not hold. A field of vectors has three formulas in
    ``vector``, components in the frame of the target; its ``value`` says nothing.
    ``depth`` of the target in the part tree: within one vocabulary the deepest label that holds at a point wins.
    ``joints`` are those that it is for, as far as it names any, ``motion`` the kind that its word moves by: "along" for a
    slide, "about" for a turn.
    """

    vocabulary: str
    name: str
    targets: tuple[Target, ...]
    value: Expr
    where: Where | None = None
    depth: int = 0
    guard: Expr = TRUE
    vector: tuple[Expr, ...] = ()
    joints: tuple[int, ...] = ()
    motion: str = ""

    @property
    def formulas(self) -> tuple[Expr, ...]:
        """What is evaluated at points: the guard, then the value or the components."""
        return (self.guard, *(self.vector or (self.value,)))


MEASURES = ("stroke", "length", "width", "thickness", "pad", "palm", "palm_width", "palm_depth")  # of a gripper


@dataclass(frozen=True, slots=True, eq=False)
class Grasp:
    """A family of grasps over the parameter (variable ``t``) in ``low .. high``, in the frame of ``target``.

    ``at`` a point, ``approach`` and ``close`` unit directions, ``opening`` a width, formulas over t, size.x ... and columns.
    ``hand``: the measures of the gripper that it is meant for, as far as it states them: names of ``MEASURES`` and lengths.
    """

    name: str
    scope: Scope
    link: Reference
    frame: Pose
    size: Triple
    center: Triple
    low: Expr
    high: Expr
    at: Triple
    approach: Triple
    close: Triple
    opening: Expr
    quality: Expr
    where: Where | None = None
    hand: tuple[tuple[str, Expr], ...] = ()

    @property
    def formulas(self) -> tuple[Expr, ...]:
        """What is evaluated for each value of t: place, directions, opening, quality, then the measures of the hand."""
        return (*self.at, *self.approach, *self.close, self.opening, self.quality, *(value for _, value in self.hand))


@dataclass(frozen=True, slots=True, eq=False)
class Keypoint:
    name: str
    scope: Scope
    link: Reference
    point: Triple  # in the object's frame
    where: Where | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """Physical and optical properties, each a (low, high) range in SI units; colours are sRGB in 0 .. 1.

    An object draws one value from each range, the same for everything of the material in it.
    """

    name: str
    density: tuple[float, float] = (700.0, 700.0)
    friction_static: tuple[float, float] = (0.5, 0.5)
    friction_dynamic: tuple[float, float] = (0.4, 0.4)
    restitution: tuple[float, float] = (0.1, 0.1)
    colour: tuple[tuple[float, float, float], ...] = ((0.7, 0.7, 0.7),)
    metalness: tuple[float, float] = (0.0, 0.0)
    roughness: tuple[float, float] = (0.6, 0.6)
    transparency: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Allowed:
    """``allow overlap`` and ``free``: two sets of nodes of the part tree whose links may overlap; ``allow floating``: one.

    Said in each row of ``scope``, of the parts of that row: elements of a repeat that it stands in are each on their own.
    ``ranks``: of either, the elements of repeats that are meant, (name of the table, rank; -1 for the last).
    """

    kind: str  # "overlap" | "free" | "floating"
    scope: Scope
    first: tuple[int, ...]
    second: tuple[int, ...]
    reason: str
    ranks: tuple[tuple[tuple[str, int], ...], ...] = ((), ())


@dataclass(frozen=True, slots=True, eq=False)
class Clear:
    """``clear a from b by distance``: two sets of nodes of the part tree, said and numbered as in ``Allowed``. ``whatever`` the
    joints do; else at rest and while each moves alone."""

    scope: Scope
    first: tuple[int, ...]
    second: tuple[int, ...]
    distance: Expr
    text: str
    ranks: tuple[tuple[tuple[str, int], ...], ...] = ((), ())
    where: Where | None = None
    whatever: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Stable:
    """``require stable``: objects in which ``scope`` has a row stand by themselves; ``open``: with their joints open too."""

    scope: Scope
    open: bool
    message: str
    where: Where | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Closure:
    """``close a on b``: two points (in the object's frame at joint values 0) on two links that stay together."""

    scope: Scope
    links: tuple[Reference, Reference]
    points: tuple[Triple, Triple]
    where: Where | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Slot:
    """What one alternative of the part ``path`` binds to a slot of its role: nodes of the part tree.

    ``scope`` is the table in which the part is declared, which all its alternatives share.
    """

    path: str
    name: str
    scope: Scope
    parts: tuple[int, ...]


@dataclass(slots=True, eq=False)
class Program:
    """A compiled category."""

    name: str
    doc: str = ""
    scopes: list[Scope] = field(default_factory=list)
    draws: list[Draw] = field(default_factory=list)
    definitions: dict[Column, Expr] = field(default_factory=dict)
    requirements: list[Requirement] = field(default_factory=list)
    preferences: list[Preference] = field(default_factory=list)
    parts: list[Part] = field(default_factory=list)
    links: list[Link] = field(default_factory=list)
    joints: list[Joint] = field(default_factory=list)
    sites: list[Site] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    grasps: list[Grasp] = field(default_factory=list)
    keypoints: list[Keypoint] = field(default_factory=list)
    materials: dict[str, Material] = field(default_factory=dict)
    primitives: dict[str, Primitive] = field(default_factory=dict)
    vocabularies: dict[str, tuple[str, ...]] = field(default_factory=dict)
    allowed: list[Allowed] = field(default_factory=list)
    closures: list[Closure] = field(default_factory=list)
    slots: list[Slot] = field(default_factory=list)
    clear: list[Clear] = field(default_factory=list)
    stable: list[Stable] = field(default_factory=list)
    hash: str = ""
    foreign: bool = False  # read from a file, which anyone may have written
