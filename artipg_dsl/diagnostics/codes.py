"""The registry of diagnostic codes: one entry each, with what `apgc explain` says."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Code:
    """``summary`` is one line; ``text`` explains at length; ``example`` is a program that brings the code about."""

    name: str
    summary: str
    text: str = ""
    example: str = ""


CODES: dict[str, Code] = {
    "always-true": Code("always-true", "a requirement holds always"),
    "bad-axis": Code("bad-axis", "a joint or repeat has no valid axis"),
    "bad-curve": Code("bad-curve", "a curve cannot make this solid"),
    "bad-guard": Code("bad-guard", "a guard is not a condition"),
    "broken-chain": Code("broken-chain", "curves of a chain do not meet end to end"),
    "circular": Code("circular", "something depends on itself"),
    "circular-definition": Code("circular-definition", "something is defined by itself"),
    "contradictory": Code("contradictory", "equations contradict one another"),
    "default-outside-range": Code("default-outside-range", "a default lies outside its domain"),
    "duplicate-name": Code("duplicate-name", "a name is declared twice"),
    "empty-range": Code("empty-range", "a range has no value"),
    "import-cycle": Code("import-cycle", "modules import one another in a circle"),
    "impossible": Code("impossible", "a requirement can never hold"),
    "incomplete-primitive": Code("incomplete-primitive", "a primitive lacks surfaces, inside or box"),
    "inherited-assigned": Code("inherited-assigned", "a template assigns a value that its role hands in"),
    "leaky-primitive": Code("leaky-primitive", "the surfaces of a primitive do not close"),
    "many-elements": Code("many-elements", "a path names many elements where one is needed"),
    "misplaced-hole": Code("misplaced-hole", "`_` stands where nothing can be left open"),
    "misplaced-statement": Code("misplaced-statement", "a statement cannot stand here"),
    "missing-argument": Code("missing-argument", "an argument is missing"),
    "missing-bracket": Code("missing-bracket", "a round or square bracket is never closed"),
    "missing-brace": Code("missing-brace", "a brace is never closed"),
    "missing-clause": Code("missing-clause", "a statement lacks a clause"),
    "missing-file": Code("missing-file", "a file is missing or cannot be read"),
    "missing-unit": Code("missing-unit", "a length, angle or other quantity has no unit"),
    "missing-value": Code("missing-value", "a declaration lacks a value"),
    "needs-clearance": Code("needs-clearance", "a limit needs collision checking"),
    "needs-index": Code("needs-index", "a path names many elements where one is needed"),
    "no-attachment": Code("no-attachment", "a part hangs on nothing"),
    "no-category": Code("no-category", "a file declares no category"),
    "no-own-box": Code("no-own-box", "a template names faces of a box that it derives from its parts"),
    "no-root": Code("no-root", "a category has no root part"),
    "not-solvable": Code("not-solvable", "equations cannot be solved in closed form"),
    "not-utf8": Code("not-utf8", "the file is not UTF-8 text"),
    "optional-outside-when": Code("optional-outside-when", "an optional part is named where it may be absent"),
    "over-determined": Code("over-determined", "there is an equation too many"),
    "plane-across-axes": Code("plane-across-axes", "a plane is used across another axis"),
    "recurrence": Code("recurrence", "a value that needs itself cannot be computed"),
    "redundant": Code("redundant", "an equation follows from others"),
    "reserved-name": Code("reserved-name", "a name shadows a built-in one"),
    "reserved-word": Code("reserved-word", "a word of the language is used as a name"),
    "role-not-fulfilled": Code("role-not-fulfilled", "a template does not bind what its role promises"),
    "too-many-cases": Code("too-many-cases", "the guards of equations combine in too many ways"),
    "syntax": Code("syntax", "the text does not follow the grammar"),
    "tie": Code("tie", "two parameters could yield and nothing says which"),
    "two-attachments": Code("two-attachments", "a part is attached twice"),
    "two-categories": Code("two-categories", "a file declares two categories"),
    "two-links": Code("two-links", "something lies on two links at once"),
    "two-roots": Code("two-roots", "a category has two root parts"),
    "under-determined": Code("under-determined", "nothing determines a value"),
    "unknown-argument": Code("unknown-argument", "a template has no parameter of that name"),
    "unknown-choice": Code("unknown-choice", "a choice has no such option"),
    "unknown-clause": Code("unknown-clause", "a statement does not take this clause"),
    "unknown-distribution": Code("unknown-distribution", "there is no such distribution"),
    "unknown-function": Code("unknown-function", "there is no such function"),
    "unknown-import": Code("unknown-import", "a module has no declaration of that name"),
    "unknown-joint-kind": Code("unknown-joint-kind", "there is no such kind of joint"),
    "unknown-label": Code("unknown-label", "a label is not in its vocabulary"),
    "unknown-material": Code("unknown-material", "there is no such material"),
    "unknown-member": Code("unknown-member", "a value has no member of that name"),
    "unknown-module": Code("unknown-module", "there is no module of that name"),
    "unknown-name": Code("unknown-name", "a name is not declared here"),
    "unknown-port": Code("unknown-port", "a part has no port of that name"),
    "unknown-template": Code("unknown-template", "there is no such template, role or primitive"),
    "unknown-type": Code("unknown-type", "there is no such type"),
    "unknown-unit": Code("unknown-unit", "a number carries a unit that does not exist"),
    "unknown-vocabulary": Code("unknown-vocabulary", "there is no such vocabulary"),
    "unrelated-rows": Code("unrelated-rows", "values of unrelated repeats or alternatives are mixed"),
    "unrelated-type": Code("unrelated-type", "a test with `is` can never hold"),
    "unterminated-string": Code("unterminated-string", "a text in quotes does not end on its line"),
    "wrong-arguments": Code("wrong-arguments", "a function or clause is given the wrong arguments"),
    "wrong-dimension": Code("wrong-dimension", "quantities of different dimension are mixed"),
    "wrong-kind": Code("wrong-kind", "something else is needed here"),
    "wrong-role": Code("wrong-role", "an alternative does not play the role"),
    "wrong-type": Code("wrong-type", "a value is of another type than needed"),
}
