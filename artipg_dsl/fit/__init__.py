"""Real objects as objects of a program: from a mesh or a cloud to the values of its draws, by analysis through synthesis.

In: a sampler and clouds. Out: for each cloud the values of the object that comes nearest, how far the two are apart, and how they lie to
one another. Begin with ``fitting``.

    sources, given            real objects in files and in memory; as Python gives them
    finding, reading          which files of a folder are objects; files as clouds
    pose, outer               their axes, unit, normals; what of them can be seen from without
    model                     the draws that shape a surface, and candidates as rows of a batch with changed values
    match, compare, refine    pairs of nearest points both ways; gaps; numbers moved by damped least squares
    search                    candidates drawn, chosen, refined, and tried with other structures
    decide, develop           choices and counts by whole clouds; changes of much of an object, which the rest has to fit first
    fitting, measure          all of it for a few clouds; distances, labels and verdict
    likeness, presence        samples of a category beside real objects; what labels of these say of its draws
"""
