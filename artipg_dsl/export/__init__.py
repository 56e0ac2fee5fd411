"""Objects as files, a file of code per format, written from the one model of ``robot`` or from the tables of a batch.

In: a batch and what its files are to hold (``content``). Out: bytes by path; the same object gives the same bytes. Begin with
``registry``, which lists the formats.

    registry, content                   the formats, and the optional content of files
    urdf, mjcf, sdf, usd                formats for simulators
    lacking                             what a format has no words for
    template, decimals                  files of text from their templates; rows of numbers as text
    glb, mesh_obj, scenes               formats for viewing
    partnet                             the folder of PartNet-Mobility
    shards, mutants, meanings           arrays and JSON lines of many objects, and what they mean
    containers                          what arrays are kept in
    objects, write, ends, remote        files and folders, written completely or not at all; whether one has its end; elsewhere
    strict                              whether exported meshes overlap in any of many states
"""
