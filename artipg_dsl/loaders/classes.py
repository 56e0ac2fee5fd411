"""Classes of one's own instead of the words of `semantic`: what a task tells apart, whatever the categories call it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..diagnostics.suggest import did_you_mean
from ..errors import UsageError

_UNLABELLED = "unlabelled"
_OTHERS = "*"


def find_classes(
    classes: Mapping[str, str] | None, words: Sequence[Sequence[str]]
) -> tuple[list[str], list[np.ndarray] | None] | None:
    """The names of the classes, and the class of each word (n,) of each of several vocabularies, None where numbers stay.

    ``classes`` names the class of a word, and under * that of all other words, which are else 0, `unlabelled`. Without any, words
    are classes; the result is None where the vocabularies number them differently. Raises UsageError.
    """
    if classes is None:
        first = list(words[0])
        return (first, None) if all(list(other) == first for other in words) else None
    if not isinstance(classes, Mapping) or not classes:  # of none at all, all points would be unlabelled
        raise UsageError(f"classes is {classes!r}", 'it maps words to classes: {"door": "door", "*": "body"}')
    known = dict.fromkeys(word for vocabulary in words for word in vocabulary if word != _UNLABELLED)
    for word, name in classes.items():
        if word != _OTHERS and word not in known:
            hint = did_you_mean(str(word), list(known)) or f"the words are {', '.join(known)}"
            raise UsageError(f"classes: there is no word `{word}` in `semantic`", hint)
        if not isinstance(name, str) or not name:
            raise UsageError(
                f"classes: the class of `{word}` is {name!r}", 'name it, such as {"door": "door", "*": "body"}'
            )
    names = list(dict.fromkeys([_UNLABELLED, *classes.values()]))
    others = classes.get(_OTHERS, _UNLABELLED)
    return names, [
        np.array([names.index(_UNLABELLED if w == _UNLABELLED else classes.get(w, others)) for w in vocabulary])
        for vocabulary in words
    ]
