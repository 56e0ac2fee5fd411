"""Templates escape what they are told to, and print numbers as they are."""

from __future__ import annotations

import pytest
from jinja2 import UndefinedError

from artipg_dsl.export.template import find_template


def test_attributes_are_escaped_and_what_is_none_left_out() -> None:
    gate = {"name": 'a<b> & "c"', "data": None, "size": 0}
    rules = find_template("object.mjcf.j2").module.rules([], [gate], [], [], [])  # type: ignore[attr-defined]
    assert '<text name="a&lt;b&gt; &amp; &#34;c&#34;" size="0"/>' in rules


def test_names_are_escaped() -> None:
    text = find_template("robot.srdf.j2").render(name="it's <here>", pairs=[("a", "b&c", "Adjacent")])
    assert '<robot name="it&#39;s &lt;here&gt;">' in text
    assert 'link2="b&amp;c"' in text


def test_what_a_template_is_not_given_is_an_error() -> None:
    with pytest.raises(UndefinedError, match="name"):
        find_template("model.config.j2").render()
