"""The page `docs/library.md`: what the modules of the library declare, from their texts and doc comments."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from artipg_dsl.diagnostics import Report
from artipg_dsl.resources import library_dir
from artipg_dsl.source import Source
from artipg_dsl.syntax import ast
from artipg_dsl.syntax.trees import tree_of

HEAD = """# The library

The contents of the modules in `library/`, by kind of part, by role and by module. Import a name with `use`, for example
`use handles { Handle, BarHandle }`. A role can be used in place of any template that plays it, with its inherited parameters as arguments.
The [primitives](primitives.md) have a page of their own with pictures, and each [category](categories.md) shows templates in use.

A parameter with a range (`in`) is drawn, whatever its default (`=`), unless it is given as an argument or an equation determines it.
One with a default alone has that value, one without either must be given or determined. Those without a type are lengths.

What a template offers is named from outside, as in `knob.mount`: its ports are for `connect`, its slots for labels and grasps, its
joints for labels, `limit` and `mimic`. Every template has what its role offers; a `?` marks what may be absent.

[Materials](#materials) are at the end; the words of the vocabularies are listed under [labels](labels.md#vocabularies).

This page is generated from the doc comments in `library/*.apg` by `pytest tests/docs/test_library.py --update-golden`.
"""

MATERIALS = """`use materials { oak }`, then `material oak on body`. Densities are those of the solid material. For `sheet`, `housing`,
`tube`, `profile`, `casting`, `moulding` and `foamed` they are averages that include the air or components inside. Friction,
restitution and roughness are in the modules. Every object draws one value from each range. `coat` is powder-coated steel, `armour` the
wall of a safe, `clad` cookware. [The language](language.md#physics-and-looks) explains how to declare others."""

SOUGHT = {
    "handle, grip, lever": "handle grip lever pull bow loop",
    "knob, dial": "knob dial",
    "button, key, row of buttons": "button buttons buttoned key keys keyboard numpad click",
    "hinge, hinged part": "hinge hinged hinges flap",
    "lid, cap, cover": "lid cap cover covers",
    "door, leaf, sash": "door leaf leaves sash",
    "drawer": "drawer",
    "shell, housing, hollow box": "housing carcass hollow walls shell sleeve box body cabinet",
    "vessel, pot, bowl": "vessel pot bowl bottle cup",
    "leg, leg set, foot, base": "leg legs feet foot base support",
    "wheel, castor": "wheel castor castors star",
    "arm, stand, column": "arm stand column post pedestal bracket",
    "tray, turntable, shelf, deck": "tray turntable shelf shelves deck plate",
    "seat, back, arm rest": "seat back arm cushion",
    "spout, tap, tube": "spout tap tube nozzle pipe",
    "screen, display, camera": "screen display camera",
    "frame, rim, ring": "frame rim ring jambs",
    "rod, bar, rail": "rod rods bar bars rail rails",
}

_QUALIFIES = re.compile(
    r"[.,;:]| (?:of|on|with|that|in|for|from|about|around|at|under|above|behind|between|to|by|along|across|over|whose) "
)


@dataclass(frozen=True, slots=True)
class Entry:
    module: str
    node: ast.RoleDecl | ast.TemplateDecl | ast.PrimitiveDecl

    @property
    def name(self) -> str:
        return self.node.name

    @property
    def doc(self) -> str:
        return " ".join(self.node.doc.split())

    @property
    def role(self) -> str | None:
        return self.node.role if isinstance(self.node, ast.TemplateDecl) else None

    @property
    def words(self) -> set[str]:
        """The words of its name, of its role's name, and of what the doc comment begins with: up to what qualifies it."""
        names = re.findall(r"[A-Z][a-z]*", f"{self.name} {self.role or ''}")
        begins = "" if self.doc.startswith(("What ", "Stands ")) else _QUALIFIES.split(self.doc, maxsplit=1)[0]
        return set(re.findall(r"[a-z]+", f"{' '.join(names)} {begins}".lower()))


@cache
def entries() -> tuple[Entry, ...]:
    """Roles, templates and primitives, by module, in the order of the text."""
    return tuple(_entries())


@cache
def _tree(path: Path) -> ast.Module:
    tree = tree_of(Source(path.name, path.read_text(encoding="utf-8")), Report())
    assert tree is not None, path.name
    return tree.whole


def _entries() -> Iterator[Entry]:
    for path in sorted(library_dir().glob("*.apg")):
        for node in _tree(path).declarations:
            if isinstance(node, ast.RoleDecl | ast.TemplateDecl | ast.PrimitiveDecl):
                yield Entry(path.stem, node)


@cache
def materials() -> tuple[tuple[str, ast.MaterialDecl], ...]:
    """Materials with their modules, those of `materials` first, in the order of the text."""
    found = [
        (path.stem, node)
        for path in sorted(library_dir().glob("*.apg"))
        for node in _tree(path).declarations
        if isinstance(node, ast.MaterialDecl)
    ]
    return tuple(sorted(found, key=lambda entry: entry[0] != "materials"))


@cache
def page() -> str:
    """The whole page."""
    known = entries()
    lines = [HEAD, "## By kind of part", "", "| part | see |", "|---|---|"]
    for title, words in SOUGHT.items():
        found = [e for e in known if e.words & set(words.split())]
        shown = ", ".join(f"[`{e.name}`](#{e.module})" for e in found if not isinstance(e.node, ast.PrimitiveDecl))
        lines.append(f"| {title} | {shown} |")
    roles = [e for e in known if isinstance(e.node, ast.RoleDecl)]
    lines += ["", "## By role", "", "| role | what it is | templates that play it |", "|---|---|---|"]
    for role in sorted(roles, key=lambda e: e.name):
        playing = ", ".join(f"`{e.name}`" for e in known if _plays(e, role.name, known))
        lines.append(f"| [`{role.name}`](#{role.module}) | {_cell(role.doc)} | {playing or '(see the module)'} |")
    for module in dict.fromkeys(e.module for e in known):
        lines += ["", f"## {module}", ""]
        here = [e for e in known if e.module == module]
        lines += ["| name | plays | parameters | offers | what it is |", "|---|---|---|---|---|"]
        for entry in here:
            offers = _offers(entry.node, _offered(entry.role, known))
            lines.append(
                f"| `{entry.name}` | {_kind(entry)} | {_parameters(entry.node)} | {offers} | {_cell(entry.doc)} |"
            )
    lines += ["", "## materials", "", MATERIALS, "", "| name | module | kg/m3 | colour | |", "|---|---|---|---|---|"]
    lines += [_material(module, node) for module, node in materials()]
    return "\n".join(lines) + "\n"


def _material(module: str, node: ast.MaterialDecl) -> str:
    density, colour = _ends(node.density), _ends(node.colour)
    shown = "#" + "".join(f"{round(255 * (low + high) / 2):02x}" for low, high in zip(*colour, strict=True))
    looks = {"metal": _ends(node.metalness), "clear": _ends(node.transparency)}
    said = [word for word, ends in looks.items() if ends[1][0] >= 0.5]
    heavy = f"{density[0][0]:g}" + ("" if density[0] == density[1] else f" .. {density[1][0]:g}")
    return f"| `{node.name}` | `{module}` | {heavy} | `{shown}` | {', '.join(said)} |"


def _ends(clause: ast.Clause[ast.RangeExpr] | None) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Both ends of a property, as numbers; of one that is not given 0."""
    if clause is None:
        return (0.0,), (0.0,)
    low, high = (e.items if isinstance(e, ast.VectorExpr) else (e,) for e in (clause.value.low, clause.value.high))
    return tuple(n.value for n in low), tuple(n.value for n in high)  # type: ignore[attr-defined]


def _plays(entry: Entry, role: str, known: list[Entry]) -> bool:
    """Whether a template has the role, itself or through a role that refines it."""
    parents = {e.name: e.node.parent for e in known if isinstance(e.node, ast.RoleDecl)}
    own = entry.role
    while own is not None and own != role:
        own = parents.get(own)
    return own == role


def _kind(entry: Entry) -> str:
    """The role of a template, or what else a name is."""
    if isinstance(entry.node, ast.PrimitiveDecl):
        return "primitive"
    if isinstance(entry.node, ast.RoleDecl):
        return f"role, a `{entry.node.parent}`" if entry.node.parent else "role"
    return f"`{entry.role}`" if entry.role else "-"


def _parameters(node: ast.RoleDecl | ast.TemplateDecl | ast.PrimitiveDecl) -> str:
    """Parameters and counts with their types, ``in low .. high`` and ``= default`` where they have one."""
    shown = []
    for statement in node.body:
        if isinstance(statement, ast.ParamDecl) and statement.keyword != "out":
            drawn = _type(statement.type) + _domain(statement.domain) + _default(statement.default)
            shown += [f"`{name}`{drawn}" for name in statement.names]
        elif isinstance(statement, ast.CountDecl):
            shown.append(f"`{statement.name}` (count){_domain(statement.domain)}{_default(statement.default)}")
    return ", ".join(shown) or "-"


def _offers(node: ast.RoleDecl | ast.TemplateDecl | ast.PrimitiveDecl, known: set[str]) -> str:
    """Ports, slots, joints and outputs by name, by kind, without those that are ``known`` of the role of a template."""
    found: dict[str, dict[str, None]] = {"port": {}, "slot": {}, "joint": {}, "output": {}}
    for kind, name, optional in _members(node.body):
        if name not in known:
            found[kind][f"`{name}`{'?' if optional else ''}"] = None
    shown = (f"{kind}{'s' if len(names) > 1 else ''} {', '.join(names)}" for kind, names in found.items() if names)
    return "; ".join(shown) or "-"


def _members(body: tuple[ast.Stmt, ...]) -> Iterator[tuple[str, str, bool]]:
    """Kind, name, and whether it may be absent, of what a body offers; what a repeat offers is named through the repeat."""
    for statement in body:
        if isinstance(statement, ast.PortDecl):
            yield "port", statement.name + ("[i]" if statement.index is not None else ""), statement.optional
        elif isinstance(statement, ast.SlotDecl):
            yield "slot", statement.name, statement.optional
        elif isinstance(statement, ast.JointDecl):
            yield "joint", statement.name, statement.optional
        elif isinstance(statement, ast.ParamDecl) and statement.keyword == "out":
            yield from (("output", name, False) for name in statement.names)
        elif isinstance(statement, ast.WhenStmt):
            yield from ((kind, name, True) for kind, name, _ in _members((*statement.body, *statement.otherwise)))


def _offered(role: str | None, known: list[Entry]) -> set[str]:
    """The names that a role and those it refines offer."""
    roles = {e.name: e.node for e in known if isinstance(e.node, ast.RoleDecl)}
    found: set[str] = set()
    while role is not None:
        found |= {name for _, name, _ in _members(roles[role].body)}
        role = roles[role].parent
    return found


def _type(ref: ast.TypeRef) -> str:
    """Nothing for a length, as on the page of the primitives."""
    if ref.values:
        return f" ({', '.join(ref.values)})"
    if ref.style:
        return f" (style of `{ref.name}`)"
    if ref.size is not None:
        count = {2: "two", 3: "three"}[ref.size]
        return f" ({count} {ref.name}s)"
    return "" if ref.name == "length" else f" ({ref.name})"


def _domain(domain: ast.RangeExpr | None) -> str:
    return "" if domain is None else f" in {_cell(domain.span.words)}"


def _default(expr: ast.Expr | None) -> str:
    return "" if expr is None else f" = {_cell(expr.span.words)}"


def _cell(text: str) -> str:
    return text.replace("|", "\\|")
