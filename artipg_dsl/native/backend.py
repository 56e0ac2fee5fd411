"""Which backend evaluates formulas: NumPy, or the compiled machine once it is there. The bytes that come out are the same.

``APGC_BACKEND`` says which: ``numpy``, ``c`` (an error where it cannot be had), or nothing for the machine if it can be had without
waiting. Where none was compiled before, a compiler is started beside the run, which goes on with NumPy until it is done.
"""

from __future__ import annotations

import ctypes
import os
import threading
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from .. import random
from ..errors import UserError
from . import compiler, loops, lots
from .compiler import NoMachine
from .moments import row_sums
from .plan import Plan, make_table
from .tape import Tape

VARIABLE = "APGC_BACKEND"
_BACKENDS = ("numpy", "c")
_PLACES = np.arange(400, dtype=np.uint64)
_SILENT = """
    look closest separate inset meet_in_states examine sweep row_sums add_moments coarse keep_points in_frames depth_pictures
    depth_sides leave shade_faces shade_vertices lay_flat chain cluster place_shares local_points held_moments philox
    mix fit_faces outlines over_edges turn_points cover
""".split()
"""Functions of the machine that return nothing, and those that return a number."""
_COUNTING = """
    near_in_states way_size examine_cells reach_of_cells print_rows print_told print_records deepest wrap near_rows
    near_pieces first_of_each lay_out near_flat near_loose
""".split()
_LONG, _ADDRESS = ctypes.c_int64, ctypes.c_void_p
_STOCK = (*[_ADDRESS] * 5, _LONG, _ADDRESS)  # pieces as distances are asked of them
_ARGUMENTS: dict[str, list[Any]] = {
    "run": [*[_ADDRESS] * 5, *[_LONG] * 4],
    "look": [_LONG, _LONG, _ADDRESS],
    "print_rows": [*[_LONG] * 4, _ADDRESS, ctypes.c_char_p, _ADDRESS, _ADDRESS],
    "deepest": [*_STOCK, _ADDRESS, _LONG, _ADDRESS],
    "chain": [*_STOCK, ctypes.c_double, _ADDRESS, _LONG, *[_ADDRESS] * 4],
    "cluster": [*_STOCK, ctypes.c_double, _ADDRESS, _LONG, _ADDRESS, _ADDRESS, _LONG, *[_ADDRESS] * 3],
}
"""Of those that are called often for little: with these, nothing has to be wrapped for a call."""
_MOVES = "choose1", "choose8", "number", "same8"


class Machine:
    """The compiled machine in this process. Raises NoMachine, Unreadable where it does not fit this NumPy."""

    def __init__(self, library: ctypes.CDLL):
        self.library = library
        try:
            _declare(library)
            self._run = library.run
            self.print_rows, self.deepest = library.print_rows, library.deepest
            self.chain, self.cluster = library.chain, library.cluster
            moves = {name: getattr(library, name) for name in _MOVES}
        except AttributeError as wrong:
            raise NoMachine(f"the compiled backend is not whole: {wrong}") from None
        _require_layout(library)
        addresses = {name: ctypes.cast(move, ctypes.c_void_p).value or 0 for name, move in moves.items()}
        self.table = make_table(addresses)

    def run(self, plan: Plan, objects: Any, outer: int, inner: int) -> int:
        """Run a plan over arrays, told by their identities; 0 where that was done."""
        return self._run(*plan.places, ctypes.addressof(objects), loops.HEADER, outer, inner, plan.block)


def _declare(library: ctypes.CDLL) -> None:
    """Tell what functions return and take. Raises AttributeError where one is not there."""
    for name in _SILENT:
        getattr(library, name).restype = None
    for name in _COUNTING:
        getattr(library, name).restype = _LONG
    for name, arguments in _ARGUMENTS.items():
        getattr(library, name).argtypes = arguments


def _require_layout(library: ctypes.CDLL) -> None:
    """Look at an array as the machine sees it. Raises NoMachine where that is not what it is."""
    found = np.zeros(5, dtype=np.int64)
    shown = np.zeros((7, 3))[::2, 1]
    library.look(id(shown), loops.HEADER, found.ctypes.data)
    expected = [shown.ctypes.data, 1, 4, 48]
    if found[:4].tolist() != expected or bool(found[4] & 1) or not found[4] & 0x100:
        raise NoMachine("the arrays of this NumPy are laid out in another way")


class _State:
    """What is known of the backend since one was chosen."""

    def __init__(self) -> None:
        self.machine: Machine | None = None
        self.begun = False
        self.why = ""  # there is no machine
        self.beside: threading.Thread | None = None  # compiles one

    def begin(self) -> None:
        """Find the machine, or begin to make it. Raises UserError where one is asked for and cannot be had."""
        asked = _choose()
        self.begun = True
        random.use(None)
        if asked == "numpy":
            self.why = "as asked"
            return
        try:
            path = compiler.kept()
            if path is not None:
                self._have(fit(path))
            elif asked:
                self._have(fit(compiler.compile_machine()))
            elif compiler.folder() is None:
                self.why = "nothing is kept, so nothing is compiled"
            else:
                self.why = "the machine is being compiled"
                self.beside = threading.Thread(target=self.compile, daemon=True)
                self.beside.start()
        except NoMachine as wrong:
            self.why = str(wrong)
            if asked:
                self.begun = False
                raise UserError(f"there is no backend c: {wrong}", "--backend numpy writes the same bytes") from None

    def compile(self) -> None:
        try:
            self._have(fit(compiler.compile_machine()))
        except (NoMachine, OSError) as wrong:
            self.why = str(wrong)

    def _have(self, machine: Machine) -> None:
        self.machine = machine
        random.use((partial(lots.philox, machine), partial(lots.mix, machine)))


_state = _State()


def _choose() -> str:
    """``numpy``, ``c`` or, where nothing is asked for, an empty text. Raises UserError."""
    asked = os.environ.get(VARIABLE, "").strip().lower()
    if asked and asked not in _BACKENDS:
        raise UserError(f"{VARIABLE} names no backend: `{asked}`", f"there are {' and '.join(_BACKENDS)}")
    return asked


def machine() -> Machine | None:
    """The machine, if formulas are to be run by it now. Raises UserError where ``APGC_BACKEND`` cannot be had."""
    if not _state.begun:
        _state.begin()
    return _state.machine


def choose(name: str | None) -> None:
    """Use a backend from here on, in this process and those it starts; the usual one for None. Raises UserError where it cannot be had."""
    global _state
    if name is None:
        os.environ.pop(VARIABLE, None)
    else:
        os.environ[VARIABLE] = name
    _state = _State()
    machine()


def told() -> str:
    """The backend that is used, and why no other, in words."""
    if machine() is not None:
        return "c"
    return f"numpy ({_state.why})" if _state.why else "numpy"


def fit(path: Path) -> Machine:
    """The machine in a file, tried on this NumPy. Raises NoMachine."""
    library = compiler.load(path)
    try:
        made = Machine(library)
        different = trial(made)
    except loops.Unreadable as wrong:
        raise NoMachine(f"the functions of this NumPy are laid out in another way: {wrong}") from None
    if different:
        raise NoMachine(f"this NumPy computes {', '.join(different)} of a block in another way than of an array")
    return made


def trial(made: Machine) -> list[str]:
    """The operations of which a block has other bits than NumPy gives for the whole: none, as far as we know."""
    wide, powers, near, order = (random.uniform(random.key(0, "machine", of), _PLACES) for of in "wpno")
    a = np.concatenate([8 * wide - 4, 10.0 ** (18 * powers - 9), 2 * near - 1, order, [0.0, -0.0, np.inf, np.nan]])
    b = a[np.argsort(np.concatenate([order, near, powers, wide, [0.1, 0.9, 0.4, 0.6]]))]
    found = []
    for op, function in loops.FUNCTIONS.items():
        tape = Tape(function.nin, (), (op,), range(function.nin), (function.nin,))
        with np.errstate(all="ignore"):
            expected = function(*(a, b)[: function.nin])
        result = tape.run(made, (a, b)[: function.nin])
        if result is None or result[0].tobytes() != expected.tobytes():
            found.append(op)
    rows = np.ascontiguousarray(np.resize(a[:-4], (3, 700)))
    for many in (1, 7, 8, 100, 129, rows.shape[1]):
        some = np.ascontiguousarray(rows[:, :many])
        if row_sums(made, some).tobytes() != np.add.reduce(some, axis=1).tobytes():
            found.append("the sum of a row")
    return found
