"""A small program around every template and primitive of the library, upright and carried by a rigid motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import product
from random import Random

from geometry.shipped import SHIPPED

from artipg_dsl.geometry.trial import draw_trial
from artipg_dsl.resources import library_dir
from artipg_dsl.semantics.offers import DECLARED
from artipg_dsl.session import Session
from artipg_dsl.syntax import ast

SIZES = (
    "[4cm, 30cm, 40cm]",
    "[40cm, 50cm, 60cm]",
    "[5cm, 12mm, 20cm]",
    "[5cm, 85cm, 200cm]",
    "[3cm, 9cm, 25cm]",
    "[12cm, 12cm, 6cm]",
    "[60cm, 1.2m, 75cm]",
    "[11cm, 28cm, 4mm]",
    "[5cm, 4cm, 3mm]",
)
LENGTHS = ("12mm", "3mm", "4cm", "30cm")
UNITS = {"length": "m", "angle": "rad", "ratio": ""}

PROBE = """apg 1
use primitives {{ Cuboid }}
{uses}
vocabulary touch {{ grasp push }}
vocabulary semantic {{ probed rest }}
category Probe {{
  root part base : Cuboid(size = [1mm, 1mm, 1mm])
  {styles}part probed : {name}{arguments}{turned}
  connect probed to base
  align probed.center = base.center{shift}
  label semantic.rest on base
  label semantic.probed on probed
  label touch.push on probed where p.z > 0.00537 * size.z and n.x > -0.437
  label touch.grasp on probed = 0.5 + 0.25 * n.y
  field height : ratio on probed = p.z / size.z
  field corner : vec on probed = p / size.z - 2 * n
  grasp across on probed for t in -0.4 .. 0.4 {{ at [0, 0.1 * size.y, t * size.z]  approach -x  close y  opening 2 * size.y }}
  keypoint tip on probed at [size.x / 2, size.y / 4, size.z / 2]
}}
"""


@dataclass(frozen=True)
class Shipped:
    """A template or primitive of a module, with what its user has to give it."""

    module: str
    name: str
    arguments: tuple[tuple[str, ...], ...]  # alternatives for each argument
    uses: tuple[tuple[str, str], ...] = ()  # (module, name) of what the arguments need
    styles: str = ""

    def programs(self) -> Iterator[tuple[str, str]]:
        """Texts upright and moved, for one set of arguments after the other."""
        named: dict[str, set[str]] = {}
        for module, name in ((self.module, self.name), *self.uses):
            if (module, name) != ("primitives", "Cuboid"):
                named.setdefault(module, set()).add(name)
        uses = "\n".join(
            f"use {module} {{ {', '.join(sorted(names))} }}"
            for module, names in sorted(named.items())
            if module != "primitives"
        )
        more = ", ".join(sorted(named.get("primitives", set())))
        every = list(product(*self.arguments))
        Random(0).shuffle(every)  # of a template with many arguments, the first are not all alike
        for chosen in every:
            arguments = f"({', '.join(chosen)})" if chosen else ""
            both = [
                PROBE.format(
                    uses=uses, styles=self.styles, name=self.name, arguments=arguments, turned=turned, shift=shift
                )
                for turned, shift in (
                    ("", " + [5m, 0, 0]"),
                    (" turned 1.1rad about [0.36, 0.48, 0.8]", " + [5.7m, -0.4m, 0.2m]"),
                )
            ]
            if more:
                both = [
                    text.replace("use primitives { Cuboid }", f"use primitives {{ Cuboid, {more} }}") for text in both
                ]
            yield both[0], both[1]


@cache
def declared() -> dict[str, tuple[str, ast.Declaration]]:
    """The declarations of the library's modules by name, with the module of each."""
    trees = {path.stem: Session.of(path) for path in sorted(library_dir().glob("*.apg"))}
    return {d.name: (module, d) for module, s in trees.items() for d in s.tree.declarations}  # type: ignore[union-attr]


def shipped() -> list[str]:
    """The names of all templates and primitives of the library, read off the texts."""
    texts = [path.read_text(encoding="utf-8") for path in library_dir().glob("*.apg")]
    return sorted({*SHIPPED, *(name for text in texts for kind, name in DECLARED.findall(text) if kind == "template")})


def shape(name: str) -> Shipped:
    module, node = declared()[name]
    if isinstance(node, ast.TemplateDecl):
        return template(module, node)
    return primitive(module, name, SHIPPED[name], node)


def primitive(module: str, name: str, made, node: ast.PrimitiveDecl) -> Shipped:
    """A primitive with values of its test range that meet its requirements."""
    values = draw_trial(made, 4)
    types = {n: p.type.name for p in node.body if isinstance(p, ast.ParamDecl) for n in p.names}
    vectors = {n.split(".")[0] for n in made.parameters if "." in n}
    given = []
    for row in range(1, 4):
        texts = {n: f"{float(values[n][row])!r}" + UNITS.get(types[n.split(".")[0]], "") for n in made.parameters}
        scalars = [f"{n} = {texts[n]}" for n in made.parameters if "." not in n]
        scalars += [
            f"{v} = [{', '.join(texts[f'{v}.{a}'] for a in 'xyz' if f'{v}.{a}' in texts)}]" for v in sorted(vectors)
        ]
        given.append(", ".join(scalars))
    return Shipped(module, name, (tuple(given),))


def template(module: str, node: ast.TemplateDecl) -> Shipped:
    """A template with values for the parameters that have neither a domain nor a default."""
    body, at = list(node.body), node.role
    while at is not None:
        role = declared()[at][1]
        body += role.body
        at = role.parent
    own_names = {n for s in node.body if isinstance(s, ast.ParamDecl) for n in s.names}
    arguments: list[tuple[str, ...]] = []
    uses: list[tuple[str, str]] = []
    styles, seen = "", set()
    for statement in body:
        if not isinstance(statement, ast.ParamDecl) or statement.keyword == "out":
            continue
        for name in statement.names:
            if name in seen or (name in own_names and statement not in node.body):
                continue
            seen.add(name)
            if statement.domain or statement.default or statement.derived:
                continue
            kind = statement.type
            if kind.style:
                role = kind.name
                choice = (
                    role
                    if isinstance(declared()[role][1], ast.TemplateDecl)
                    else next(
                        n for n, (_, d) in declared().items() if isinstance(d, ast.TemplateDecl) and d.role == role
                    )
                )
                uses += [(declared()[choice][0], choice), *([(declared()[role][0], role)] if choice != role else [])]
                styles += f"style given_{name} : {role} = {choice}\n  "
                arguments.append((f"{name} = given_{name}",))
            elif kind.size == 3:
                arguments.append(tuple(f"{name} = {size}" for size in SIZES))
            elif kind.name == "length" and kind.size == 2:
                arguments.append(tuple(f"{name} = [{a}, {b}]" for a, b in product(LENGTHS, LENGTHS)))
            elif kind.name == "count":
                arguments.append((f"{name} = 1", f"{name} = 2"))
            elif kind.name == "length":
                arguments.append(tuple(f"{name} = {length}" for length in LENGTHS))
            elif kind.name == "angle":
                arguments.append((f"{name} = 30deg", f"{name} = 90deg"))
            elif kind.name == "bool":
                arguments.append((f"{name} = 1 > 0",))
            elif kind.name == "choice" or kind.values:
                arguments.append(tuple(f"{name} = {v}" for v in kind.values))
            else:
                arguments.append((f"{name} = 0.5", f"{name} = 1"))
    return Shipped(module, node.name, tuple(arguments), tuple(uses), styles)
