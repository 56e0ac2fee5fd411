"""A run: what is drawn, what is written of it, and how both are kept in a folder.

In come the words of the command line or the arguments of Python; out goes a ``Job``, which makes objects by number, or a
folder with its ``manifest.json``. Begin with ``request`` (what is drawn) and ``output`` (what is written), then read ``job``.
"""
