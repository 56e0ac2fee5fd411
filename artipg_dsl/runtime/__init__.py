"""From a program to tables of numbers: the plan, what its generated code calls, and a batch of evaluated objects.

In: a program (``graph.program``) and the draws to make or keep. Out: a ``Batch``: links, joints, parts and primitives as
columns, at rest and in motion. Knows neither text nor solids. Begin with ``plan`` and ``batch``.

    needs, plan               what has to be known, and straight-line NumPy code that computes it in order of dependence
    lines                     that code as it is run: long runs of operations as tapes
    kernels, draws            what that code calls: tables and segments; values drawn per row
    laws, newton              distributions; roots of equations
    tables, referred, rooted  instances as columns, references between them, chains that end
    columns                   how tables show themselves
    tags, words               names as files take them; what parts and links are called
    batch, motion, loops      objects; where links are for given joint values; closed loops
    fields                    formulas of labels and grasps as functions of points
    repairs                   what was moved to make an object valid, as columns
"""
