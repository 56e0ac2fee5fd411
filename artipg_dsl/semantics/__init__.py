"""Syntax trees to a resolved, typed program. Draws no numbers and builds no constraint graph.

In: the tree of a file (``syntax``). Out: a ``TypedProgram``: what every name stands for, the type of every expression, the guards
under which a declaration is there. Findings go to the report; after one, the unknown type silences what follows from
it. Begin with ``check``, then ``checker``.

    modules, symbols, scope              what ``use`` brings in, what files declare, what bodies declare and under which guards
    check, checker, meanings, show       the check from end to end, its state and its results, printed
    types, expressions, paths, calls, functions, surfaces     types and how they are inferred
    conditions, guards, presence         what conditions say, and what is there where they hold
    declarations, alternatives           names, domains, defaults; what parts and styles may be, and its arguments
    entries, fold, ranges                types of declarations; values of constants; what lies in a range
    statements, placing, attachments, labels      rules of statements, one group a file
    roles, parts, primitives             rules of roles and templates, of their members, of primitives
    offers, foreign, remedies            what the library would offer; words of other languages; what to try where a type does not fit
"""
