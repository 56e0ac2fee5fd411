"""Geometric details: the surface of real objects, bound to the objects of a program fitted to them, and worn by mutants of these.

In: a batch with clouds of real surfaces in its frame, or a batch with details to wear. Out: bound details; points moved as these say.
Begin with ``binding`` and ``wear``.

    assign, binding           which point of a cloud belongs to which of a structure; each with its place on the surface and its offset
    refuse                    which bound points are accidents, and no details
    completion                what was hidden, by the symmetries of each primitive
    elements, record, placed  the primitives that details are bound to; details as arrays of a file, and as points in space
    suits, trim               which element of which donor each element wears; what can be borrowed of details
    wear, maps                points in the details of their donors; places on primitives of another kind
    displace, skin, cover     closed meshes in them; what other primitives cover
    calm, unfold              what a surface can follow of details; what turns inside out, and sheets whose sides cross
    measure, report           distances, coverage, torn and inverted neighbourhoods
    dressing, store           which details objects wear; a folder of them, or those at hand
"""
