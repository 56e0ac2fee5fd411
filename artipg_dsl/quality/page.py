"""Quality cards as one page of HTML that needs no other file: figures, goals, and a picture of some objects."""

from __future__ import annotations

import base64
from collections.abc import Sequence

from .card import Card
from .text import list_figures


def render_page(cards: Sequence[Card], pictures: Sequence[bytes | None]) -> str:
    """The page of some cards; ``pictures`` are PNG files, one per card, or None."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(loader=PackageLoader("artipg_dsl.quality"), undefined=StrictUndefined, autoescape=True)
    entries = []
    for card, picture in zip(cards, pictures, strict=True):
        goals = {goal.figure: goal for goal in card.goals}
        figures = [(name, value, remarks, goals.get(name)) for name, value, remarks in list_figures(card)]
        data = None if picture is None else base64.b64encode(picture).decode("ascii")
        entries.append({"card": card, "figures": figures, "picture": data, "kinds": card.variety.kinds})
    return environment.get_template("report.html.j2").render(entries=entries)
