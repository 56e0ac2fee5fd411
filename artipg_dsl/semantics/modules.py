"""Files to module scopes: finds what ``use`` names, follows imports, and fills each scope's names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from ..diagnostics import Report
from ..diagnostics.suggest import any_of, did_you_mean
from ..language import reserved_name
from ..resources import library_dir
from ..source import Source, Span
from ..syntax import ast
from ..syntax.load import load
from ..syntax.trees import KeptTree, tree_of
from .offers import declared_in, kin, nearest
from .symbols import KINDS, ModuleScope, Symbol

_NAMED = 12  # names that a hint lists

Loader = Callable[[Source, Report], ast.Module | KeptTree | None]
Reader = Callable[[Path, Report, str], "Source | None"]


class Workspace:
    """The modules of one compilation, each read and parsed once; errors go to ``report``.

    ``search_path`` holds the folders where ``use`` looks after the importing file's own (default: the shipped
    library). ``loader`` turns a source into a tree, ``reader`` a path and the name to show for it into a source;
    both report what is wrong and return None. ``shipped`` is the loader of what a file uses of the shipped library.
    """

    def __init__(
        self,
        report: Report,
        search_path: Sequence[Path] | None = None,
        loader: Loader | None = None,
        reader: Reader | None = None,
        shipped: Loader | None = None,
    ) -> None:
        self.report = report
        self.search_path = tuple(search_path) if search_path is not None else (library_dir(),)
        self.loader = loader or tree_of
        self.shipped = shipped or self.loader
        self.reader = reader or load
        self.modules: dict[str, ModuleScope] = {}
        self.read: dict[Path, Source] = {}  # the files that were read
        self.absent: dict[Path, None] = {}  # where a module was looked for in vain
        self._trail: list[tuple[str, Span]] = []  # the uses that led to the module being loaded
        self._failed: set[str] = set()

    def load_file(self, path: Path, shown: str | None = None, used: bool = False) -> ModuleScope | None:
        """The scope of a file, named ``shown`` in messages, which another one may have ``used``; None after an error in reading or
        parsing it."""
        key = str(path.resolve())
        if key in self.modules:
            return self.modules[key]
        if key in self._failed:
            return None
        source = self.reader(path, self.report, shown or str(path))
        if source is not None:
            self.read[path.resolve()] = source
        loader = self.shipped if used and path.parent == library_dir() else self.loader
        scope = self._load(source, key, path.parent, loader) if source is not None else None
        if scope is None:
            self._failed.add(key)
        return scope

    def load_source(self, source: Source) -> ModuleScope | None:
        """The scope of a text at hand; its imports are looked for beside ``source.name``, then on the search path."""
        path = Path(source.name)
        return self._load(source, str(path.resolve()), path.parent, self.loader)

    def _load(self, source: Source, key: str, folder: Path, loader: Loader) -> ModuleScope | None:
        tree = loader(source, self.report)
        if tree is None:
            return None
        scope = ModuleScope(Path(source.name).stem, tree.span.source, tree)
        self.modules[key] = scope
        self._declare(scope)
        for use in tree.uses:
            self._use(scope, use, key, folder)
        return scope

    def _declare(self, scope: ModuleScope) -> None:
        for number, head in enumerate(scope.held.heads):
            why = reserved_name(head.name)
            if why is not None:
                self.report.error(
                    "reserved-name",
                    head.name_span,
                    f"`{head.name}` cannot be declared: it is {why}",
                    hint="choose another name",
                )
            elif head.name in scope.names:
                first = scope.names[head.name].decl.name_span
                self.report.error(
                    "duplicate-name",
                    head.name_span,
                    f"`{head.name}` is declared twice in this file",
                    notes=((first, "first declared here"),),
                    hint="choose another name for one of them",
                )
            else:
                scope.names[head.name] = Symbol(head.name, KINDS[head.kind], scope, number)

    def _use(self, scope: ModuleScope, use: ast.UseDecl, key: str, folder: Path) -> None:
        found = self.locate(use.module, folder, Path(scope.source.name).parent)
        if found is None:
            self.report.error(
                "unknown-module",
                use.module_span,
                f"there is no module `{use.module}`",
                hint=did_you_mean(use.module, self.available(folder))
                or f"`use` looks for {use.module}.apg next to this file, then in the library",
            )
            scope.lost.update(use.names)
            return
        path, shown = found
        target = str(path.resolve())
        self._trail.append((key, use.module_span))
        try:
            keys = [k for k, _ in self._trail]
            if target in keys:
                self._cycle(keys.index(target))
                scope.lost.update(use.names)
                return
            module = self.load_file(path, shown, used=True)
        finally:
            self._trail.pop()
        if module is not None:
            self._import(scope, use, module)
        else:
            scope.lost.update(use.names)

    def _import(self, scope: ModuleScope, use: ast.UseDecl, module: ModuleScope) -> None:
        offered = {s.name: s for s in module.own()}
        for name, span in zip(use.names, use.name_spans, strict=True):
            symbol = offered.get(name)
            if symbol is None:
                meant = kin(name, offered) or nearest(name, offered)
                scope.lost.update((name, *meant))
                self.report.error(
                    "unknown-import",
                    span,
                    f"module `{use.module}` declares no `{name}`",
                    hint=self._elsewhere(name, module, use.module, meant),
                )
            elif name in scope.names and scope.names[name] is not symbol:
                other = scope.names[name]
                merged = symbol.kind == other.kind == "vocabulary"
                where = "declared" if other.module is scope else f"imported from `{other.module.name}`"
                self.report.error(
                    "duplicate-name",
                    span,
                    f"`{name}` is already {where} in this file",
                    notes=((other.decl.name_span, "the other declaration"),),
                    hint=f"leave `{name}` out of `use`: vocabularies of one name are merged, so all its words are there"
                    if merged
                    else f"rename that one, or leave `{name}` out of `use`"
                    if other.module is scope
                    else f"leave `{name}` out of one `use`: a name means one thing in a file",
                )
            elif name in scope.names:
                self.report.warning("duplicate-name", span, f"`{name}` is imported twice", hint="leave one of them out")
            else:
                scope.names[name] = symbol

    def _elsewhere(self, name: str, module: ModuleScope, asked: str, meant: list[str]) -> str | None:
        """A hint: where the name is declared, if ``asked`` itself imports it or the library has it; else the names of ``asked`` that are
        perhaps ``meant``, else what it declares."""
        passed_on = module.find(name)
        if passed_on is not None:
            return f"`{asked}` uses it too: write `use {passed_on.module.name} {{ {name} }}`"
        if meant:
            return declared_in(name) or f"did you mean {any_of(meant)}?"
        own = [symbol.name for symbol in module.own()]
        more = f" and {len(own) - _NAMED} more, which the page of the library lists" if len(own) > _NAMED else ""
        return declared_in(name) or (f"it declares {', '.join(own[:_NAMED])}{more}" if own else None)

    def _cycle(self, first: int) -> None:
        ring = self._trail[first:]
        names = [self.modules[key].name for key, _ in ring]
        notes = tuple(
            (span, f"`{name}` uses `{following}`")
            for (_, span), name, following in zip(ring[:-1], names, names[1:], strict=False)
        )
        self.report.error(
            "import-cycle",
            ring[-1][1],
            "modules use each other in a circle: " + " -> ".join([*names, names[0]]),
            hint="move what both need into a module of its own",
            notes=notes,
        )

    def locate(self, name: str, folder: Path, shown: Path) -> tuple[Path, str] | None:
        """Where a module is, and what to call it: beside the importing file, or as ``library/name.apg``."""
        file = f"{name}.apg"
        if (folder / file).is_file():
            return folder / file, str(shown / file)
        self.absent[(folder / file).resolve()] = None
        for place in self.search_path:
            if (place / file).is_file():
                return place / file, f"{place.name}/{file}"
            self.absent[(place / file).resolve()] = None
        return None

    def available(self, folder: Path) -> list[str]:
        """The names of the modules that a file in a folder can use."""
        return sorted({path.stem for place in (folder, *self.search_path) for path in place.glob("*.apg")})
