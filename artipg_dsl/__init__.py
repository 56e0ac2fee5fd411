"""Structure programs of articulated objects: a language, its compiler, and annotated objects in any number.

``import artipg_dsl as apg; batch = apg.sample("Microwave", n=1000, seed=7)``
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .version import __version__

_PUBLIC = (
    "Bound",
    "Fitted",
    "FittedObject",
    "NothingFits",
    "Object",
    "Samples",
    "categories",
    "fit_objects",
    "load",
    "open_fitted",
    "open_samples",
    "sample",
)

if TYPE_CHECKING:
    from .api import (
        Bound,
        Fitted,
        FittedObject,
        NothingFits,
        Object,
        Samples,
        categories,
        fit_objects,
        load,
        open_fitted,
        open_samples,
        sample,
    )


def __getattr__(name: str) -> Any:
    """The public API, loaded on first use, so that importing the package is fast."""
    if name in _PUBLIC:
        from . import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *_PUBLIC])


__all__ = [
    "Bound",
    "Fitted",
    "FittedObject",
    "NothingFits",
    "Object",
    "Samples",
    "__version__",
    "categories",
    "fit_objects",
    "load",
    "open_fitted",
    "open_samples",
    "sample",
]
