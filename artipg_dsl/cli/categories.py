"""``apgc categories``: what is shipped."""

from __future__ import annotations

import argparse

from ..session import Session, categories


def run(options: argparse.Namespace) -> int:
    shipped = categories()
    width = max(map(len, shipped), default=0)
    for name in shipped:
        tree = Session.of(name).tree
        docs = [d.doc for d in tree.declarations if d.doc] if tree is not None else []
        print(f"{name:<{width}}  {' '.join(docs[-1].split()) if docs else ''}".rstrip())
    return 0
