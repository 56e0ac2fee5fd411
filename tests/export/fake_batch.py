"""A hand-made batch of small cupboards with the runtime's table interface: body, hinged door with a handle, a button.

The body is five boards (so that it has a cavity), the door turns about the z axis at its left back edge, the button
slides along -x. Sizes vary from object to object.
"""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from artipg_dsl.annotate.frames import axis_angle, rotate
from artipg_dsl.geometry.sites import SiteTable
from artipg_dsl.graph import expr as e
from artipg_dsl.graph.primitive import Patch, Primitive
from artipg_dsl.graph.program import Grasp, Joint, Keypoint, Label, Link, Material, Part, Pose, Program, Site, Target
from artipg_dsl.runtime.motion import follow
from artipg_dsl.runtime.repairs import Repairs
from artipg_dsl.runtime.tables import JointTable

U, V, HALF, ONE, ZERO = e.var("u"), e.var("v"), e.const(0.5), e.ONE, e.ZERO
IDENTITY = Pose(((ONE, ZERO, ZERO), (ZERO, ONE, ZERO), (ZERO, ZERO, ONE)), (ZERO, ZERO, ZERO), ONE)


def cuboid() -> Primitive:
    """A box with its six faces as patches."""
    size = [e.var(f"size.{axis}") for axis in "xyz"]
    a, b = (U - HALF), (V - HALF)

    def face(name: str, axis: int, sign: float) -> Patch:
        point = [ZERO, ZERO, ZERO]
        point[axis] = size[axis] * (sign / 2)
        point[(axis + 1) % 3] = a * size[(axis + 1) % 3]
        point[(axis + 2) % 3] = b * size[(axis + 2) % 3]
        return Patch(name, (point[0], point[1], point[2]), (ZERO, ONE), (ZERO, ONE))

    faces = [("front", 0, 1), ("back", 0, -1), ("left", 1, 1), ("right", 1, -1), ("top", 2, 1), ("bottom", 2, -1)]
    inside = e.maximum(*(e.call("abs", e.var(f"p.{n}")) - s * HALF for n, s in zip("xyz", size, strict=True)))
    low = (size[0] * -0.5, size[1] * -0.5, size[2] * -0.5)
    high = (size[0] * 0.5, size[1] * 0.5, size[2] * 0.5)
    names = ("size.x", "size.y", "size.z")
    patches = tuple(face(*f) for f in faces)
    return Primitive(
        "Cuboid", names, ((0.01, 1.0),) * 3, patches, inside, low, high, surfaces=tuple(p.name for p in patches)
    )


def cylinder() -> Primitive:
    """A cylinder about z."""
    r, h = e.var("radius"), e.var("height")
    turn = e.const(2 * np.pi)
    c, s = e.call("cos", U), e.call("sin", U)
    up, down = h * HALF, h * e.const(-0.5)
    patches = (
        Patch("side", (r * c, r * s, (V - HALF) * h), (ZERO, turn), (ZERO, ONE)),
        Patch("top", (V * r * c, V * r * s, up), (ZERO, turn), (ZERO, ONE)),
        Patch("bottom", (V * r * c, V * r * s, down), (ZERO, turn), (ZERO, ONE)),
    )
    radial = e.call("hypot", e.var("p.x"), e.var("p.y")) - r
    inside = e.maximum(radial, e.call("abs", e.var("p.z")) - up)
    return Primitive(
        "Cylinder",
        ("radius", "height"),
        ((0.001, 1.0), (0.001, 2.0)),
        patches,
        inside,
        (-r, -r, down),
        (r, r, up),
        surfaces=("side", "top", "bottom"),
    )


BOARDS = ("back", "left", "right", "top", "bottom")
SEMANTIC = ("unlabelled", "body", "door", "handle", "button", "grip")


def pose(x: e.Expr, z: e.Expr = ZERO) -> Pose:
    return Pose(IDENTITY.rotation, (x, ZERO, z), ONE)


def program() -> Program:
    """Definitions that match the tables of ``FakeBatch``."""
    root = e.Scope("root")
    primitives = {"Cuboid": cuboid(), "Cylinder": cylinder()}
    zero3 = (ZERO, ZERO, ZERO)
    paths = [f"body.{b}" for b in BOARDS] + ["door", "handle", "button"]
    semantics = ["body"] * 5 + ["door", "handle", "button"]
    links = [0] * 5 + [1, 1, 2]
    kinds = ["Cuboid"] * 6 + ["Cylinder", "Cylinder"]
    looks = ["paint"] * 5 + ["glass", "steel", "steel"]
    parts = [
        Part(p, p.split(".")[-1], root, 5 if p == "handle" else -1, k, IDENTITY, zero3, zero3, (n,), ((s, e.TRUE),))
        for p, k, n, s in zip(paths, kinds, links, semantics, strict=True)
    ]
    sites = [
        Site(p, root, k, (), IDENTITY, (n,), i, ((m, e.TRUE),))
        for i, (p, k, n, m) in enumerate(zip(paths, kinds, links, looks, strict=True))
    ]
    width = e.col(e.Column(root, "width"))
    door_front = Target(5, ("front",), pose(e.col(e.Column(root, "door_x"))), (ONE, width, ONE), zero3)
    grip = Target(
        6, (), pose(e.col(e.Column(root, "handle_x")), e.col(e.Column(root, "handle_z"))), (ONE, ONE, ONE), zero3
    )
    labels = [
        Label("affordance", "pull", (grip,), e.TRUE),
        Label("affordance", "push", (door_front,), e.call("lt", e.var("p.y"), width * e.const(-0.1))),
        Label("semantic", "grip", (grip,), e.call("le", ZERO, e.var("p.z"))),
        Label("field", "reach", (door_front,), e.var("p.y") / e.var("size.y")),
    ]
    at = (ZERO, ZERO, e.var("t") * e.var("size.z"))
    size = (ONE, ONE, e.const(0.2))
    grasp = Grasp(
        "pull_handle",
        root,
        (1,),
        grip.frame,
        size,
        zero3,
        e.const(-0.4),
        e.const(0.4),
        at,
        (-ONE, ZERO, ZERO),
        (ZERO, ONE, ZERO),
        e.const(0.02),
        ONE,
    )
    joints = [
        Joint("open", "open", root, "revolute", (0,), 1, zero3, (ZERO, ZERO, ONE), ZERO, ONE, ZERO),
        Joint("press", "press", root, "prismatic", (0,), 2, zero3, (-ONE, ZERO, ZERO), ZERO, ONE, ZERO),
    ]
    return Program(
        "Cupboard",
        "A cupboard.",
        [root],
        parts=parts,
        links=[Link(n, root, p) for n, p in LINKS],
        joints=joints,
        sites=sites,
        labels=labels,
        grasps=[grasp],
        keypoints=[Keypoint("tip", root, (1,), (width, ZERO, ZERO))],
        materials={
            "paint": Material("paint", (600.0, 800.0), colour=((0.92, 0.91, 0.88), (0.35, 0.45, 0.55))),
            "glass": Material(
                "glass", (2500.0, 2500.0), colour=((0.6, 0.75, 0.8),), roughness=(0.05, 0.05), transparency=(0.6, 0.6)
            ),
            "steel": Material(
                "steel", (7850.0, 7850.0), colour=((0.75, 0.75, 0.78),), metalness=(1.0, 1.0), roughness=(0.3, 0.3)
            ),
        },
        primitives=primitives,
        vocabularies={"semantic": SEMANTIC},
        hash="f" * 64,
    )


LINK_WORDS = ["body", "door", "button"]
LINKS = (("base", 0), ("door", 5), ("button", 7))


@dataclass
class FakeBatch:
    """``n`` cupboards from number ``first`` on."""

    n: int = 4
    first: int = 0
    seed: int = 7
    mimic: bool = False
    loops: None = None
    gates: None = None

    def __post_init__(self) -> None:
        self.program = program()
        self.numbers = np.arange(self.first, self.first + self.n)
        self.repairs = Repairs.none()
        self.known: dict = {}
        self.state = SimpleNamespace(attempt=self.numbers % 3, objects=self.numbers)
        f = self.numbers % 7 / 7.0
        self.depth, self.width, self.height = 0.3 + 0.1 * f, 0.4 + 0.1 * f, 0.3 + 0.2 * f
        self.wall, self.gap, self.slab = 0.015, 0.001, 0.02

    def __len__(self) -> int:
        return self.n

    def _boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres and sizes (8, n, 3) of the primitives; a cylinder's size is (radius, radius, height)."""
        d, w, h, t, one = self.depth, self.width, self.height, self.wall, np.ones(self.n)
        x = d / 2 + self.gap + self.slab / 2
        door_width, strip = w * 0.75, w * 0.25
        rows = [
            ((-d / 2 + t / 2, 0 * w, h / 2), (t * one, w, h)),
            ((t / 2, w / 2 - t / 2, h / 2), (d - t, t * one, h)),
            ((t / 2, -w / 2 + t / 2, h / 2), (d - t, t * one, h)),
            ((t / 2, 0 * w, h - t / 2), (d - t, w - 2 * t, t * one)),
            ((t / 2, 0 * w, t / 2 * one), (d - t, w - 2 * t, t * one)),
            ((x, w / 2 - door_width / 2, h / 2), (self.slab * one, door_width - 0.002, h)),
            ((x + 0.03, w / 2 - door_width + 0.03, h / 2), (0.008 * one, 0.008 * one, 0.2 * one)),
            ((x, -w / 2 + strip / 2, h * 0.3), (0.012 * one, 0.012 * one, 0.02 * one)),
        ]
        centers = np.stack([np.stack([np.broadcast_to(c, self.n) for c in center], axis=-1) for center, _ in rows])
        return centers, np.stack([np.stack(size, axis=-1) for _, size in rows])

    def sites(self) -> list[SiteTable]:
        centers, sizes = self._boxes()
        words, made = SEMANTIC, []
        for s, site in enumerate(self.program.sites):
            turn = np.eye(3) if s != 7 else np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # the button lies along x
            size = sizes[s]
            names = {"size.x": size[:, 0], "size.y": size[:, 1], "size.z": size[:, 2]}
            params = names if site.primitive == "Cuboid" else {"radius": size[:, 0], "height": size[:, 2]}
            made.append(
                SiteTable(
                    number=s,
                    path=site.path,
                    primitive=self.program.primitives[site.primitive],
                    params=params,
                    owner=np.arange(self.n),
                    rotation=np.broadcast_to(turn, (self.n, 3, 3)),
                    translation=centers[s],
                    mirror=np.full(self.n, -1.0 if s == 2 else 1.0),
                    link=np.full(self.n, site.link[0]),
                    instance=np.full(self.n, s),
                    semantic=np.full(self.n, words.index(self.program.parts[s].word)),
                    rank=np.zeros(self.n, dtype=np.int64),
                )
            )
        return made

    def _table(self, names: list[str]) -> dict:
        k = len(names)
        return {
            "owner": np.repeat(np.arange(self.n), k),
            "number": np.tile(np.arange(k), self.n),
            "name": names * self.n,
            "definition": np.tile(np.arange(k), self.n),
        }

    def _hinge(self) -> np.ndarray:
        return np.stack([self.depth / 2 + self.gap, self.width / 2, 0 * self.width], axis=-1)

    def links(self) -> SimpleNamespace:
        table = self._table([name for name, _ in LINKS])
        translation = self._boxes()[0][[0, 5, 7]].transpose(1, 0, 2).reshape(-1, 3)
        return SimpleNamespace(
            **table,
            rotation=np.broadcast_to(np.eye(3), (3 * self.n, 3, 3)),
            translation=translation,
            semantic=np.tile([SEMANTIC.index(word) for word in LINK_WORDS], self.n),
        )

    @property
    def link_words(self) -> list[str]:
        return LINK_WORDS * self.n

    def joints(self) -> JointTable:
        n = self.n
        nan = np.full(2 * n, np.nan)
        return JointTable(
            **self._table(["open", "press"]),
            kind=["revolute", "prismatic"] * n,
            parent=np.zeros(2 * n, dtype=int),
            child=np.tile([1, 2], n),
            origin=np.stack([self._hinge(), self._boxes()[0][7]], axis=1).reshape(-1, 3),
            axis=np.tile([[0.0, 0, 1], [-1.0, 0, 0]], (n, 1)),
            low=np.zeros(2 * n),
            high=np.tile([1.9, 0.005], n),
            rest=np.zeros(2 * n),
            mimic=np.tile([-1, 0 if self.mimic else -1], n),
            multiplier=np.full(2 * n, 0.002),
            offset=np.zeros(2 * n),
            damping=nan,
            friction=nan,
            stiffness=nan,
            effort=nan,
            velocity=nan,
            pitch=nan,
            positions=nan,
        )

    def parts(self) -> SimpleNamespace:
        program, n = self.program, self.n
        centers, sizes = self._boxes()
        half = sizes.copy() / 2
        half[6:, :, :2] *= 2  # a radius is a half already
        rotation = np.stack([site.rotation for site in self.sites()], axis=1).reshape(-1, 3, 3)
        return SimpleNamespace(
            **self._table([part.path for part in program.parts]),
            parent=np.tile([p.parent for p in program.parts], n),
            path=[p.path for p in program.parts] * n,
            template=[p.template for p in program.parts] * n,
            semantic=np.tile([SEMANTIC.index(p.word) for p in program.parts], n),
            link=np.tile([p.link[0] for p in program.parts], n),
            rotation=rotation,
            translation=centers.transpose(1, 0, 2).reshape(-1, 3),
            low=-half.transpose(1, 0, 2).reshape(-1, 3),
            high=half.transpose(1, 0, 2).reshape(-1, 3),
            symmetry=np.tile([[1, 2]] * 6 + [[0, 2]] * 2, (n, 1)),
            holder=np.full(8 * n, -1),
        )

    def settle(self, states: np.ndarray) -> np.ndarray:
        return follow(self.joints(), states)

    def pose(self, states: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
        joints = self.joints()
        states = joints.rest if states is None else np.asarray(states, dtype=float)
        states = states.reshape(self.n, 2)
        rotation, translation = np.tile(np.eye(3), (self.n, 3, 1, 1)), np.zeros((self.n, 3, 3))
        hinge, axis = self._hinge(), np.array([0.0, 0.0, 1.0])
        rotation[:, 1] = axis_angle(np.broadcast_to(axis, (self.n, 3)), states[:, 0])
        translation[:, 1] = hinge - rotate(rotation[:, 1], hinge)
        translation[:, 2, 0] = -states[:, 1]
        return rotation.reshape(-1, 3, 3), translation.reshape(-1, 3)

    def drawn(self, i: int) -> dict:
        return {"width": float(self.width[i]), "handle": "BarHandle", "buttons": 1}

    def owner(self, scope: e.Scope) -> np.ndarray:
        return np.arange(self.n)

    def read(self, exprs: list[e.Expr], scope: e.Scope) -> list[np.ndarray]:
        centers = self._boxes()[0]
        columns = {
            "width": self.width,
            "door_x": centers[5, :, 0] + self.slab / 2,
            "handle_x": centers[6, :, 0],
            "handle_z": centers[6, :, 2],
        }

        def value(node: e.Expr) -> np.ndarray:
            if node.op == "const":
                return np.full(self.n, node.value)
            if node.op == "col":
                return columns[node.value.name]
            product = {"mul": np.multiply, "neg": np.negative, "sub": np.subtract, "add": np.add}[node.op]
            return product(*(value(a) for a in node.args))

        return [value(node) for node in exprs]

    def link_numbers(self, scope: e.Scope, links: tuple[int, ...]) -> np.ndarray:
        return np.full(self.n, links[0])

    def point_set(self, count: int) -> SimpleNamespace:
        """Points on the front faces of door (the first half) and along the handle, on a regular grid."""
        centers, sizes = self._boxes()
        k = count // 2
        f = (np.arange(k) + 0.5) / k
        door = centers[5][:, None] + np.stack([0 * f + 0.5, f - 0.5, 0.3 * np.sin(9 * f)], -1) * sizes[5][:, None]
        grip = centers[6][:, None] + np.stack([0 * f + 1, 0 * f, f - 0.5], axis=-1) * sizes[6][:, None]
        site = np.broadcast_to(np.repeat([5, 6], k), (self.n, 2 * k))
        row = np.broadcast_to(np.arange(self.n)[:, None], site.shape)
        normal = np.broadcast_to([1.0, 0.0, 0.0], (self.n, 2 * k, 3))
        share = np.broadcast_to(np.tile(f, 2), site.shape)
        position = np.concatenate([door, grip], axis=1)
        return SimpleNamespace(
            site=site, row=row, patch=np.zeros_like(site), u=share, v=share, position=position, normal=normal
        )
