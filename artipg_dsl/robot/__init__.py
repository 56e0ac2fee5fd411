"""What an articulated object is apart from any format: links with mass, what is seen of them, what collides, joints with their physics.

In: a batch. Out: ``Robots``, from which each object is had as a ``Robot`` of its own. Begin with ``model``, then ``robots``, which makes
it. Knows no file and no format: ``export`` writes it, ``layouts`` and ``view`` read it.

    model, robots                       the links and joints of one object; those of a batch
    primitives, solids, shading         what a link consists of; meshes and pieces of primitives; their normals
    colliders, hulls                    convex pieces that stand for an object, many of them in one hull
    dressed                             meshes in the details of real surfaces
    dynamics, mechanisms, ground        physics of joints; what moves together; what the floor asks of them
    adjacent                            which links may touch
    substitute                          joints that a format lacks, as chains of simpler ones
    pose, principal                     links at joint values; principal axes
    materials, naming                   looks; names, each once
"""
