"""Could an object exist as solid parts? Collisions, clearance, floating parts, stance and mass of a batch.

In: a batch. Out: which objects are at fault, why and where, and the limits of joints that move until something is in
the way. Begin with ``faults``.

    bodies, rings, tree, meant           convex pieces placed at rest, their bounds about axes; what moves what; which pairs of
                              parts a statement is about
    validate, following, loops    links that penetrate one another, at rest or while one joint moves; loops that do not close
    contact, evidence         which parts meet, where, and at which value of a joint
    apart, together, cells, clearance    distances kept in every state of the other joints; how far a joint can move
    floating, adrift, neighbours    parts that nothing holds; those that nothing holds in any object; which primitives of a link are near
    stance, hull              whether an object stands without tipping over
    materials, mass           mass, centre and inertia of links
    formulas                  labels evaluated at points, and whether they have a value
    fault, faults, sound             all of it together; the last check of numbers before an object is delivered
"""
