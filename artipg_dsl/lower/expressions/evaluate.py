"""Expressions of the text to values, in the frame and the table of one environment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...graph import expr as E
from ...graph.expr import Expr, ScopeError
from ...graph.primitive import Triple
from ...graph.program import Pose
from ...semantics.meanings import Axis, Constant, Current, Declared, Global, Last, Local, Meaning, OwnBox, Previous
from ...semantics.symbols import Symbol
from ...source import Span
from ...syntax import ast
from ...units import UNITS
from ..values.carry import merged, moved
from ..values.faces import carried_face
from ..values.kinds import Alternatives, Box, Face, Frame, Line, Placed, Plane, Ports, Ref, Value, Vec
from ..values.vectors import AXES, HERE, compose, unit
from . import arithmetic, builtins, members
from .context import Fetched
from .env import Element, Env, Function, pose_between
from .members import At, describe

if TYPE_CHECKING:
    from ..elaborate.drives import Drive
    from ..values.kinds import Carrier


class Evaluator:
    """Evaluates in ``env``; ``local`` holds the names that only this place has (formula variables, function arguments)."""

    truth, number, plane, across = arithmetic.truth, arithmetic.number, arithmetic.plane, arithmetic.across
    box_member, own_box, ref_box, here = members.box_member, members.own_box, members.ref_box, members.here

    drive: Drive | None = None  # in formulas of labels: what a force on the surface does to a joint

    def __init__(
        self,
        env: Env,
        local: dict[str, Value] | None = None,
        pose: Pose = HERE,
        instead: dict[int, Value] | None = None,
        frame: Pose = HERE,
    ):
        self.env = env
        self.local = local or {}
        self.instead = instead or {}  # by the identity of a path in the text, what is taken for it here
        self.pose = (
            pose  # carries values of the environment into the frame of the statement, which names faces by its axes
        )
        self.frame = frame  # carries what is named there into the frame of a formula (labels, grasps)

    # ------------------------------------------------------------ entry points by expected kind

    def scalar(self, node: ast.Expr) -> Expr:
        value = self.value(node)
        return value.exists if isinstance(value, Box) else self.number(value, node.span)

    def condition(self, node: ast.Expr) -> Expr:
        return self.truth(self.value(node), node.span)

    def vector(self, node: ast.Expr) -> Triple:
        """A point or direction as three scalars."""
        match self.value(node):
            case Frame(origin=(a, b, c)) | Vec(items=(a, b, c)):
                return a, b, c
            case value:
                raise self.impossible(node.span, "a point or a vector of three", value)

    def direction(self, node: ast.Expr) -> Triple:
        match self.value(node):
            case Frame() as frame:
                return frame.out
            case Line(direction=(a, b, c)) | Vec(items=(a, b, c)):
                if a is b is c is E.ZERO:
                    hint = "name an axis, or make one component differ from 0"
                    raise self.env.context.error(
                        "illegal-value", node.span, "a direction must not be [0, 0, 0]", hint=hint
                    )
                return a, b, c
            case value:
                raise self.impossible(node.span, "a direction such as x or -z", value)

    def box(self, node: ast.Expr) -> Box:
        return self.box_of(self.value(node), node.span)

    def box_of(self, value: Value, span: Span) -> Box:
        if isinstance(value, At):
            return members.fetch(self, value, Evaluator(value.element.env).box_of(value.inner, span))
        if isinstance(value, Ref):
            value = self.ref_box(value)
        if isinstance(value, Element) and value.box is not None:
            value = self.here(value, value.box) if self.inside(value) else value.box
        if isinstance(value, Box):
            return value
        if isinstance(value, Element):
            raise self.env.context.error(
                "wrong-kind",
                span,
                f"an element of `{value.name}` has no box of its own",
                hint="those of `split`, `spread`, `fill` and `pitch` have one: name the box that is meant, or a part",
            )
        raise self.impossible(span, "a box", value)

    def impossible(self, span: Span, expected: str, value: Value) -> Exception:
        """What the checker has ruled out."""
        return self.env.context.internal(span, f"this is {describe(value)}, but {expected} is needed here")

    # ------------------------------------------------------------ dispatch

    def value(self, node: ast.Expr) -> Value:
        if id(node) in self.instead:
            return self.instead[id(node)]
        try:
            match node:
                case ast.NumberExpr():
                    return self._quantity(node)
                case ast.StringExpr():
                    return node.value
                case ast.NameExpr() | ast.MemberExpr() | ast.IndexExpr():
                    context, before = self.env.context, self.env.context.reader
                    context.reader = self.env.scope
                    try:
                        value, unframed = self._path(node)
                    finally:
                        context.reader = before
                    return self._framed(value) if unframed else value
                case ast.CallExpr():
                    return self._call(node)
                case ast.VectorExpr():
                    return self._vector(node)
                case ast.UnaryExpr():
                    return arithmetic.unary(self, node)
                case ast.BinaryExpr():
                    return arithmetic.binary(self, node)
                case ast.IfExpr():
                    return arithmetic.conditional(self, node)
                case ast.IsExpr():
                    return self._is(node)
        except ScopeError as error:
            raise self.env.context.mixed(error, node.span) from None
        raise self.env.context.internal(node.span, "this has no value")

    def _quantity(self, node: ast.NumberExpr) -> Value:
        factor = UNITS[node.unit][0] if node.unit else 1.0
        return E.const(node.value * factor)

    def _vector(self, node: ast.VectorExpr) -> Value:
        items: list[Expr] = []
        on: tuple[Carrier, ...] = ()
        for k, item in enumerate(node.items):
            value = self.value(item)
            if isinstance(value, Frame) and value.face:
                value = self.plane(value, item.span)
            if isinstance(value, Plane):
                if value.axis != k:
                    raise self.env.context.error(
                        "plane-across-axes",
                        item.span,
                        f"`{item.span.words}` is a plane across {AXES[value.axis or 0]}, but is used as the"
                        f" {AXES[k]} coordinate",
                        hint=f"name a face across {AXES[k]} there, or write the coordinate as a number",
                    )
                on += value.on
                value = value.coordinate
            if not isinstance(value, Expr):
                raise self.impossible(item.span, "a number", value)
            items.append(value)
        return Vec(tuple(items), on)

    def _is(self, node: ast.IsExpr) -> Value:
        subject, wanted = self.value(node.subject), self.env.context.symbol(node)
        if wanted is None:
            raise self.env.context.internal(node.type_span, "this is not a role or a template")
        return self._matches(subject, wanted, node)

    def _matches(self, subject: Value, wanted: Symbol, node: ast.IsExpr) -> Value:
        """The predicate that a part or a style, of an element of a repeat too, is of a template or a role."""
        if isinstance(subject, Alternatives):
            return subject.matches(wanted)
        if isinstance(subject, At):
            home = type(self)(subject.element.env)
            return members.fetch(self, subject, home._matches(subject.inner, wanted, node))
        if not isinstance(subject, Ref):
            raise self.impossible(node.subject.span, "a part", subject)
        found = [(branch.scope, branch.members[0][0].matches(wanted)) for branch in subject.branches]
        if len(found) == 1:
            return found[0][1]
        parent, each = members.parted(found)  # declared in several branches of a `when`
        return members.lift(self, merged(parent, each), parent)

    # ------------------------------------------------------------ names, members, calls

    def _path(self, node: ast.Expr) -> tuple[Value, bool]:
        """A name, a member or an element; and whether it still is to be carried into the frame of the formula: parts are once it
        is said which of their places is meant."""
        if id(node) in self.instead:
            return self.instead[id(node)], False
        match node:
            case ast.NameExpr():
                value, unframed = self._name(node)
            case ast.MemberExpr():
                value, unframed = self._path(node.obj)
                value = members.member(self.unframed if unframed else self, value, node)
            case ast.IndexExpr():
                value, unframed = self._path(node.obj)
                value = (self.unframed if unframed else self)._element(node, value)
            case _:
                return self.value(node), False
        if not unframed or isinstance(value, Ref | Placed):
            return value, unframed
        return self._framed(value), False

    @property
    def unframed(self) -> Evaluator:
        """Evaluates in the frame of the statement."""
        return self if self.frame is HERE else type(self)(self.env, self.local, self.pose, self.instead)

    def _framed(self, value: Value) -> Value:
        """A value of the statement in the frame of the formula; a face keeps its edges."""
        return carried_face(value, self.frame) if isinstance(value, Face) else moved(value, self.frame)

    def _name(self, node: ast.NameExpr) -> tuple[Value, bool]:
        """What a name stands for; and whether it is to be carried into the frame of the formula."""
        meaning = self.env.context.meaning(node)
        if isinstance(meaning, Local):
            return self.local[meaning.name], False
        value = self.meant(meaning)
        if value is None:
            self.env.refuse_circle(node.name, node.span)
            raise self.env.context.internal(node.span, f"`{node.name}` has no value here")
        return moved(value, self.pose), self.frame is not HERE

    def meant(self, meaning: Meaning | None) -> Value | None:
        """The value that a name has in the environment."""
        match meaning:
            case Declared(name, depth):
                return self.env.find(name, depth)
            case Current(depth):
                return self._around(depth)
            case Previous(depth):
                element = self._around(depth)
                return None if element is None else At(element, None, element)
            case OwnBox(name):
                own = self.own_box()
                return None if own is None else self.box_member(own, name)
            case Axis(number):
                return Vec(unit(number))
            case Constant(value):
                return E.const(value)
            case Global(symbol) if symbol.kind == "function":
                function = self.module_function(symbol)
                return function if function.parameters else self.called(function, ())
        return None

    def _around(self, depth: int) -> Element | None:
        """The element in which this stands, of the repeat whose body is ``depth`` deep."""
        element = self.env.element_at(depth)
        if element is None or element.env.outer is None:
            return None
        pose = pose_between(element.env.outer, self.env)
        return element if pose is HERE else element.carried(pose)

    def module_function(self, symbol: Symbol) -> Function:
        assert isinstance(symbol.decl, ast.FunctionDecl)
        home = Env(self.env.context, symbol.module, None, self.env.scope, "")
        return Function(symbol.name, symbol.decl.parameters, symbol.decl.value, home)

    def inside(self, element: Element) -> bool:
        return any(env is element.env for env in self.env.chain())

    def _element(self, node: ast.IndexExpr, value: Value) -> Value:
        if isinstance(value, Ports):
            return builtins.pick(value, self.scalar(node.index), self.env, node.span)
        repeat = value.inner if isinstance(value, At) else value
        if not isinstance(repeat, Element):
            raise self.impossible(node.obj.span, "a repeat", value)
        home = Evaluator(value.element.env) if isinstance(value, At) else self
        index = home.position(repeat, node.index)
        count = members.fetch(self, value, repeat.count) if isinstance(value, At) else repeat.count
        self.env.context.fetched.append(Fetched(self.env.scope, index, count, node.span, self.env.context.known))
        found = At(repeat, index, repeat)
        return At(value.element, value.index, found) if isinstance(value, At) else found

    def position(self, element: Element, index: ast.Expr) -> Expr:
        if isinstance(self.env.context.meaning(index), Last):
            return E.sub(element.count, E.ONE)
        return self.scalar(index)

    # ------------------------------------------------------------ calls

    def _call(self, node: ast.CallExpr) -> Value:
        context = self.env.context
        if (form := context.form(node)) is not None:
            return context.makers.functions[form.meaning](self, node, form)
        function = self.meant(context.meaning(node.function))
        if not isinstance(function, Function):
            raise context.internal(node.span, "no function is known here")
        return self.called(function, tuple(self.value(a.value) for a in node.arguments))

    def called(self, function: Function, values: tuple[Value, ...]) -> Value:
        """The value of a function of the text, in the frame of the call: what it names is carried there."""
        local = dict(zip(function.parameters, values, strict=True))
        around = any(env is function.env for env in self.env.chain())  # those of a module name nothing that has a place
        pose = compose(self.pose, pose_between(function.env, self.env)) if around else HERE
        return Evaluator(function.env, local, pose, frame=self.frame).value(function.value)
