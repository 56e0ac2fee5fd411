"""Is an object possible as a thing of solids? Collisions, clearance, floating parts, stance and mass of a batch.

In: a batch. Out: which objects are at fault, why and where, and the ends of joints that go on as far as nothing is in
the way. Begin with ``faults``.

    bodies, tree, meant       convex pieces placed at rest; what moves what; which pairs of parts a statement is about
    validate, parting         links that penetrate one another, at rest or while one joint moves
    contact, evidence         which parts meet, where, and at which value of a joint
    apart, together, clearance    distances that are kept, whatever other joints do; how far a joint can go
    floating, adrift          parts that nothing holds, by their solids and for certain by their boxes alone
    stance, hull              does an object stand by itself
    materials, mass           mass, centre and inertia of links
    formulas                  labels evaluated at points, and whether their values can be said
    faults, sound             all of it together; the last look at numbers before an object is handed out
"""
