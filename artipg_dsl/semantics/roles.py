"""Whether a template fulfils its role, and whether a role is sound in itself."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..syntax import ast
from ..syntax.walk import in_branches
from .offers import missing
from .scope import BodyScope, Entry
from .symbols import Symbol, lineage, parent_of
from .types import PartType

if TYPE_CHECKING:
    from .checker import Checker


def check_parent(ck: Checker, symbol: Symbol) -> None:
    """The role named after the colon exists, and roles do not refine each other in a circle."""
    decl = symbol.decl
    if isinstance(decl, ast.RoleDecl):
        name, span = decl.parent, decl.parent_span
    elif isinstance(decl, ast.TemplateDecl):
        name, span = decl.role, decl.role_span
    else:
        return
    if name is None or span is None:
        return
    found = symbol.module.find(name)
    if found is None or found.kind != "role":
        roles = [s.name for s in symbol.module.names.values() if s.kind == "role" and s is not symbol]
        what = f"there is no role `{name}` here" if found is None else f"`{name}` is a {found.kind}, not a role"
        ck.unknown(symbol.module, name, "unknown-template", span, what, missing(name, roles, "role"))
    elif symbol.kind == "role" and parent_of(lineage(symbol)[-1]) is symbol:
        ring = lineage(symbol)
        if symbol is not min(ring, key=lambda s: (s.module.name, s.decl.span.start)):
            return  # reported once
        names = [s.name for s in ring]
        ck.error(
            "circular-definition",
            span,
            f"roles refine each other in a circle: {' : '.join([*names, names[0]])}",
            hint="let one of them refine no role",
        )


def check_template(ck: Checker, symbol: Symbol) -> None:
    """Every slot, port, joint and output of the role is bound; what is inherited is not assigned."""
    role = parent_of(symbol)
    if role is None:
        return
    scope = ck.scope_of(symbol)
    bound = _names_at_any_depth(scope)
    missing: list[tuple[str, str, ast.Stmt]] = []
    for name, (_, stmt) in ck.interface_of(symbol).items():
        own = [e for e in scope.table.get(name, []) if e.node is not stmt]
        match stmt:
            case ast.SlotDecl(optional=False):
                if not any(e.kind in ("slot", "part") for e in bound.get(name, ())):
                    missing.append(("slot", name, stmt))
            case ast.PortDecl(optional=False):
                if not any(e.kind == "port" for e in own):
                    missing.append(("port", name, stmt))
            case ast.JointDecl(optional=False):
                if not any(e.kind == "joint" for e in bound.get(name, ())):
                    missing.append(("joint", name, stmt))
            case ast.ParamDecl(keyword="out"):
                if not own and not _is_aligned(symbol.body, name):
                    missing.append(("out", name, stmt))
            case ast.ParamDecl(keyword="inherit"):
                _not_assigned(ck, name, own, stmt)
    if missing:
        names = ", ".join(f"{kind} `{name}`" for kind, name, _ in missing)
        ck.error(
            "role-not-fulfilled",
            symbol.decl.name_span,
            f"the template `{symbol.name}` does not fulfil its role {role.name}: it lacks {names}",
            hint=how_to_bind(*missing[0][:2]),
            notes=tuple((s.span, f"{kind} `{n}` is required here") for kind, n, s in missing),
        )


def check_nesting(ck: Checker, symbols: list[Symbol]) -> None:
    """No template contains itself, be it through the parts of its parts."""
    done: set[int] = set()

    def visit(symbol: Symbol, trail: list[tuple[Symbol, Entry]]) -> None:
        above = [s for s, _ in trail]
        if symbol in above:
            ring = trail[above.index(symbol) :]
            names = [s.name for s, _ in ring]
            entry = ring[-1][1]
            ck.error(
                "circular-definition",
                entry.span,
                f"templates contain each other: {' > '.join([*names, names[0]])}",
                hint="give the inner part another template; for a row of the same, use `repeat`",
            )
            return
        if id(symbol) in done or symbol.kind not in ("template", "category"):
            return
        done.add(id(symbol))
        for entries in _names_at_any_depth(ck.scope_of(symbol)).values():
            for entry in entries:
                kind = ck.entry_type(entry)
                for variant in kind.domain if isinstance(kind, PartType) else ():
                    if variant is not None and variant.symbol is not None:
                        visit(variant.symbol, [*trail, (symbol, entry)])

    for symbol in symbols:
        visit(symbol, [])


def how_to_bind(kind: str, name: str) -> str:
    """What a template writes to provide a slot, a port, a joint or an output."""
    return {
        "slot": f"call a part `{name}`, or bind the slot: `slot {name} = part`",
        "port": f"write `port {name} = ...`",
        "joint": f"write `joint {name} : ...`; if nothing moves, `joint {name} : fixed base -> part`",
        "out": f"write `let {name} = ...`",
    }[kind]


def _not_assigned(ck: Checker, name: str, own: list[Entry], stmt: ast.ParamDecl) -> None:
    for entry in own:
        ck.error(
            "inherited-assigned",
            entry.span,
            f"`{name}` is inherited from the role, so the template cannot declare it again",
            hint="use it as it is, or choose another name",
            notes=((stmt.span, "inherited here"),),
        )


def _names_at_any_depth(scope: BodyScope) -> dict[str, list[Entry]]:
    """Declarations of the template itself, those inside its repeats included: a slot may bind several."""
    found: dict[str, list[Entry]] = {}
    for entry in (entry for at in scope.below() for entry in at.entries):
        found.setdefault(entry.name, []).append(entry)
    return found


def _is_aligned(body: tuple[ast.Stmt, ...], name: str) -> bool:
    """Whether an equation names the output, so that it may determine it."""
    sides = (side for s in in_branches(body) if isinstance(s, ast.AlignStmt) for side in (s.left, s.right))
    return any(isinstance(side, ast.NameExpr) and side.name == name for side in sides)
