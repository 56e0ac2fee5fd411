"""The constraint graph: a category as tables, draws, definitions, requirements and what stands on them. Knows no syntax.

In: expressions and records, made by ``lower`` or read from a compiled program. Out: a ``Program``, for ``runtime`` to plan and
evaluate. Begin with ``program`` (the records) and ``expr`` (the expressions in them).

    scopes, expr, functions, show        tables and columns, expressions over them, their operations, how they are read
    substitution                         expressions with some of their nodes replaced
    interned                             equal expressions are one object
    derive, formula                      derivatives of expressions; formulas as NumPy functions
    program, primitive, reference        the records of a program; which row of which definition is meant
    linear, matching                     linear forms and solving for one unknown; which equation determines what
    interval, inequality, union          what always holds; what an inequality or a condition says of one value
    feasible, defined                    what can never hold; whether a value is a number whatever is drawn
    depend, unlabelled                   what a value depends on; surface without a label
    reweigh                              the same program with other weights and narrower ranges of its draws
    turn                                 the same program, its objects turned about the vertical
    text, writing, reading               the text form; to it, and back with nothing taken on trust
    nodes, verify                        what is verified of the nodes and records of a text
"""

from . import reading as reading  # it says how a program goes to another process
