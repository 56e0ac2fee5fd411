"""Geometry of primitives: from declared patches to meshes, convex pieces and bound surface points.

In: a primitive (``graph.primitive``) and its parameters, a dict of columns (k,), or a table of placed instances
(``sites``). Out: arrays whose first axis is the instance; an instance gets the same bits alone and in any batch. Lengths in
metres, angles in radians; shapes live in the primitive's own frame, unmirrored, unless a table of sites places them.
Begin with ``patches`` and ``mesh``.

    facts, split                                 what was found in an earlier run; formulas as functions, kept there
    trial, topology, weld, flat, resolution      computed once per primitive: which edges meet, how many steps
    patches, surface, density, quadrature        positions, normals, areas, places drawn by area, integrals
    mesh, pieces, box, bound                     watertight meshes, convex pieces, stated boxes
    sites, block, points, pointset               points on the visible surface of whole objects
    candidates, hidden                           where points may come to lie, and which of them are covered
    outside, rays, blue, cells                   what can be seen from outside; points that keep their distance
    stock, merge, wrap                           convex pieces in arrays, hulls in place of several, convex hulls of points
    collide, overlap, enclosure                  convex bodies that meet, what they share, what contains what
    nearest                                      the nearest of points in many sets
    vectors, runs                                products and lengths of arrays of vectors; ranges one after the other
    agreement                                    whether what is declared about a primitive agrees
"""
