"""The typed program to the constraint graph: instances, equations and who yields, solids as formulas.

In: a checked category (``semantics``). Out: a ``graph.program.Program``. Begin with ``program``, the
passes in their order. Rooms below know nothing of those above:

    elaborate      bodies, parts, joints, links, labels: what the statements of a category make
    solve          equations matched with unknowns; requirements to ranges of draws
    solids         primitives; curves and what is turned, pushed or drawn along them
    expressions    expressions of the text in the frame and the table where they stand
    values         what an expression means: vectors, frames, boxes, and how they are carried around
"""
