"""A run: what is drawn, what is written of it, and how both are kept in a folder.

In: the words of the command line or the arguments of Python. Out: a ``Job``, which makes objects by number, or a folder with its
``manifest.json``. Begin with ``request`` (what is drawn) and ``output`` (what is written), then read ``job``.

    request, settings, params, traces    what is drawn: seed and numbers, values that are fixed or given, mutants
    prior, weights                       other weights and ranges for the draws of a program
    frame                                how objects of another collection lie against ours
    output, chunk                        what is written: formats and what they hold, shard by shard
    job, compiled, counts                a program at hand, compiled or not; outcomes of attempts
    dataset, resume                      the folder, and resuming it
    sharing, workers, memory             one process or several, and how much they take
    progress                             a line that tells how far it is
    evidence                             what is known of the validity of its objects
    facts                                what is known of real objects
    fitting, binding, wearing            real objects fitted, their details bound, and who wears which
    fits, bindings                       folders of these
    comparing                            samples beside real objects
    laying                               folders in the layouts of the field, category by category
    manifest, schema                     what made a folder, read and written
"""
