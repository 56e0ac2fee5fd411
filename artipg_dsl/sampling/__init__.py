"""Objects drawn, repaired and mutated: which values a batch is evaluated with, until it is valid.

In: a program and addresses (seed, object number, attempt). Out: a batch of valid objects, and a count of what failed.
Begin with ``sample``.

    sample, prior             first and further attempts; attempts resampled to the declared distributions
    repair, search, clips     the faulty values are found and changed as little as possible
    known, values             objects whose values are known, or given, evaluated again
    mutate, correspondence    new objects from old ones (APA, DPA, CPA), and what became of each primitive
    mutation                  what is asked of these
    trace                     what was done to an object, as data and in words, and replayed
    statistics                outcomes of attempts, and what failed
    module                    a sampler as a Python module of its own
"""
