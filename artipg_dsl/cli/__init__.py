"""The command line ``apgc``: commands that check their arguments, call the rooms below and print or write what these return.

In: the words after ``apgc``. Out: text, files and an exit code. Begin with ``main``, which loads a command when it is called.

    main, options                 commands, and their options
    arguments                     kinds of arguments
    messages                      findings and errors on the terminal
    check, watch, fmt, new        programs as text
    compile, ledger               a program at one of its stages; what determines each part
    sample, export, mutate        folders of objects
    layout                        a folder in a layout of the field, checked against the model
    render, report, validate      pictures and figures
    categories, explain           what is shipped, and what errors mean
"""

import gc

# objects between collections of garbage, of which hardly any is circular; set before all else is loaded
gc.set_threshold(1_000_000, 20, 50)
