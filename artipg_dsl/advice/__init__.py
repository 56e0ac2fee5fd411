"""What a program says that is legal and perhaps not meant: told by its text, and by a few of its objects.

In: a typed category and its lowering. Out: warnings in the report. Begin with ``advise``, which says what is looked at, and in which
order.

    advise, drawn        all of it; the few objects that are looked at, or why there are none
    seen                 those objects, and where to say what they show
    excluded             counts and choices that requirements leave hardly any object
    joints, sizes        what joints follow, how far they move; grasps, places and sizes that have a wrong unit
    places, meeting      parts that float or hide; links that meet or leave one another, and axes off what holds them
    valid, labels        objects that are hardly ever valid; labels that move nothing
    checks               what makes the check of an object slow, or wrong
"""
