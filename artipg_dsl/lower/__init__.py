"""The typed program to the constraint graph: instances, equations and what they determine, solids as formulas.

In: a checked category (``semantics``). Out: a ``graph.program.Program``. Begin with ``program``, the
passes in their order. Rooms below know nothing of those above:

    elaborate      bodies, parts, joints, links, labels: what the statements of a category make
    solve          equations matched with unknowns; requirements to ranges of draws
    solids         primitives; curves, and what is revolved, extruded or swept along them
    expressions    expressions, evaluated in the frame and table around them
    values         what an expression means: vectors, frames, boxes, and how they are carried between frames
"""
