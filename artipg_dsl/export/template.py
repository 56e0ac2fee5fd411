"""Templates of text files. Most of what they are filled with are numbers, which need no escaping: names are escaped where a template
says ``| e``, and attributes by ``| attributes``."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    from jinja2 import Template

_SPECIAL = re.compile("[&<>\"']")
_QUOTES = {'"': "&#34;", "'": "&#39;"}


def _escaped(value: Any) -> str:
    """A value as text of XML, also between quotation marks."""
    text = str(value)
    return text if _SPECIAL.search(text) is None else escape(text, _QUOTES)


def _attributes(values: Mapping[str, Any]) -> str:
    """What is not None of ``values`` as attributes of an element, with a blank before each."""
    return "".join([f' {key}="{_escaped(value)}"' for key, value in values.items() if value is not None])


@lru_cache(maxsize=16)
def find_template(name: str) -> Template:
    """A template of this folder. What it is not given is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # start-up

    environment = Environment(
        loader=PackageLoader("artipg_dsl.export"), undefined=StrictUndefined, autoescape=False, auto_reload=False
    )
    environment.filters |= {"e": _escaped, "attributes": _attributes}
    return environment.get_template(name)
