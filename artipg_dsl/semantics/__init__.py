"""Syntax trees to a resolved, typed program; draws no numbers and builds no constraint graph.

``modules`` follows ``use`` and gives every file its names (``symbols``). ``check`` walks all declarations: ``scope``
collects what a body declares and under which guards, ``guards`` answers questions about them, ``expressions``,
``paths``, ``calls`` and ``conditions`` infer types, the other modules hold one group of rules each. Findings go to
the report; after one, the unknown type silences what follows from it. ``show`` prints the outcome.
"""
