"""Objects as files: one model of a robot for all formats, and a file per format.

In: a batch and what its files are to hold (``content``). Out: bytes by path; the same object gives the same bytes. Begin with
``registry``, which lists the formats, then ``robot``, from which most of them are written.

    registry, content                   the formats, and the optional content of files
    robot, primitives, solids, colliders, hulls    links with their meshes, mass and convex pieces
    dressed                             meshes in the details of real surfaces
    dynamics, mechanisms, adjacent      physics of joints, what moves together, what may touch
    decimals                            rows of numbers as text
    substitute, pose, principal         joints that a format lacks, links at joint values, principal axes
    materials, shading, naming          looks, normals, names
    template                            files of text from their templates
    urdf, mjcf, sdf, usd                formats for simulators
    glb, mesh_obj, scenes               formats for viewing
    partnet                           the folder of PartNet-Mobility
    shards, mutants, meanings           arrays and JSON lines of many objects, and what they mean
    objects, write, ends                files and folders, written completely or not at all; whether one has its end
    strict                              whether exported meshes overlap in any of many states
"""
