"""The documentation page of all codes: ``python -m artipg_dsl.diagnostics.page > docs/diagnostics.md``."""

from __future__ import annotations

from textwrap import fill

from .codes import FAMILIES, Code

COMMAND = "python -m artipg_dsl.diagnostics.page > docs/diagnostics.md"
_INTRODUCTION = f"""\
# Diagnostics

<!-- Made from the registry in artipg_dsl/diagnostics/codes/ by `{COMMAND}`. -->

Everything that the compiler reports about a program, by code. `apgc explain CODE` prints the same in a terminal.
`apgc check FILE` reports all findings; `apgc check --json` and `--sarif` give them to tools. Each finding names the file,
line and column, and shows the text with carets, related places, the parts through which a template was used, and what to
try. Every example triggers its code.
"""


def page() -> str:
    """The page as Markdown: a list of all codes by family, then a section for each."""
    parts = [_INTRODUCTION]
    for family, codes in FAMILIES.items():
        listed = "\n".join(f"- [`{c.name}`](#{c.name}): {c.summary}" for c in codes)
        parts.append(f"**{family}**\n\n{listed}\n")
    for family, codes in FAMILIES.items():
        parts.append(f"## {family}\n")
        parts.extend(_section(code) for code in codes)
    return "\n".join(parts)


def _section(code: Code) -> str:
    """One code with its text and its example."""
    text = f"### {code.name}\n\n{code.summary[0].upper()}{code.summary[1:]}. {code.text}".split("\n\n")
    lines = [text[0], "", fill(text[1], 120, break_on_hyphens=False, break_long_words=False), ""]
    if code.example:
        lines += ["```apg fails " + code.name, code.example.rstrip("\n"), "```", ""]
    return "\n".join(lines)


if __name__ == "__main__":
    print(page(), end="")
