"""How good a category is, in figures: what ``apgc report`` says. Each file computes one of them from a batch of samples.

In: a sampler and a batch. Out: a ``Card`` of figures with their goals, as text, JSON or HTML. Begin with ``card``; the sizes of real
objects are in ``reference.json``.

    card, text, page                     all figures together; shown on a terminal, in Markdown, as a page
    graphs, distance, fingerprint        kinematic graphs, how far apart they are, what can be observed of an object
    coverage, duplicates, dead, sizes    pairs of choices seen, near-duplicates, what has no effect, real sizes and ratios
    asking                               objects asked for on purpose, many questions at once
    variants                             what a buyer would call another model: seen, and reached by settings
"""
