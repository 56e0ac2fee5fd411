"""Text to tree. Knows no types and resolves no names.

``grammar/apg.lark`` is the only definition of the syntax. A text goes through

* ``grammar``: the parser made from it, with its cache;
* ``layout``: between lexer and parser, which line ends count, which words are reserved, doc comments;
* ``build*``: the parser's actions, which make the nodes of ``ast`` in one pass;
* ``parse``: files and texts to trees, several syntax errors in a run with the help of ``recover``;
* ``messages`` and ``mistakes``: what is said about a syntax error.

A new construct is a rule of the grammar, a node in ``ast``, an action in ``build_*``, the word in ``words`` where it
begins a statement, an example in ``tests/syntax/design/forms.apg`` and the likely mistakes in ``mistakes``.
"""
