"""Geometry of primitives: from declared patches to meshes, convex pieces and bound surface points.

Everything is batched over instances: parameters come as a dict of columns (k,), results as arrays whose first axis is
the instance. An instance gets the same bits alone and in any batch. Lengths in metres, angles in radians; shapes live
in the primitive's own frame, unmirrored, unless a table of sites places them.

    trial, topology, weld     what is found once per primitive, when it is compiled
    mesh, pieces, box         watertight meshes with moments, convex pieces, stated boxes
    density, surface          areas, places drawn by area, positions and exact normals
    sites, block, hidden, points      points on the visible surface of whole objects
    selftest                  does everything that is declared agree?
"""
