"""Text to tree. Knows no types and resolves no names.

In: the text of a file. Out: a ``Module`` of ``ast``, whose nodes know their place in the text; or findings in the report.
``grammar/apg.lark`` is the only definition of the syntax. Begin with ``ast`` and ``parse``.

    grammar, layout, words       the parser made from the grammar; which line ends matter; kinds of tokens
    build, build_expressions, build_statements, build_module      the parser's actions, which make the nodes in one pass
    ast, walk                    the nodes
    parse, recover               files and texts to trees, with several syntax errors in a run
    data, trees                  trees as data; each text parsed once, for all processes that share a cache
    errors                       what to say about a syntax error
    format                       one layout for programs (``apgc fmt``)

A new construct is a rule of the grammar, a node in ``ast``, an action in ``build_*``, the word in ``words`` where it
begins a statement, an example in ``tests/syntax/design/forms.apg`` and the likely mistakes in ``errors.mistakes``.
"""
