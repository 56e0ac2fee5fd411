"""The compiled backend: formulas run as tapes, a block of rows at a time, by a small machine written in C.

In: a formula as a tape (``graph.formula`` makes it) and arrays. Out: the arrays that NumPy would have made, bit for bit, since every
operation on numbers is an inner loop of NumPy itself. Knows neither expressions nor geometry. Begin with ``tape`` and ``backend``.

    machine.c       what runs a tape: moves blocks of numbers and calls loops, nothing more
    layout.c        registers and phases of a tape, for the shapes that are given
    tape.h          a tape as these two see it
    bodies.h        convex bodies in pairs, as the files beside it see them
    narrow.c        which of them overlap, as ``geometry.collide`` has it
    states.c        pieces in many states of joints, as ``validity.following`` has it
    turning.c       pieces that turn, as ``validity.validate`` has it
    cells.c         pieces that several joints move, as ``validity.together`` has it
    moments.c       sums over the surfaces of solids, as ``geometry.quadrature`` has it
    overlaps.c      points in which solids may overlap, as ``geometry.overlap`` has it
    gaps.c          how far hulls reach from their pieces, as ``geometry.merge`` has it
    wrap.c          the faces of convex hulls, as ``geometry.wrap`` and ``geometry.hulls`` have them
    digits.c        rows of numbers as text, with the bytes of Python's ``%`` and of its JSON
    points.c        candidates for points, as ``geometry.candidates``, ``geometry.cover`` and ``geometry.hidden`` have them
    feet.c          on what objects stand, as ``validity.hull`` and ``validity.stance`` have it
    depths.c        what of clouds can be seen, as ``fit.outer`` has it
    covers.c        which triangles are nearest in a picture, as ``geometry.rays`` has it
    loops           the inner loops of NumPy's functions, and how an array lies in memory
    compiler        the machine compiled, kept and loaded
    tape, plan      straight-line programs of operations, and what is told to ``layout.c`` and ``machine.c``
    narrow, states, turning, cells, moments, gaps, wrap, digits, points, depths, feet, covers   what is told to the files in C of these names
    backend         which backend is used
"""
