"""The syntax tree: frozen nodes, each with the span it was read from.

The tree knows no types and resolves no names. Expressions end in ``Expr``, statements and declarations in
``Decl`` or ``Stmt``. Tuples everywhere; absent parts are ``None`` or an empty tuple. Who reads the tree names its nodes
``ast.PartDecl``, whichever file they are in.

    nodes, expressions                   what all nodes have in common, clauses; expressions
    declarations, statements, labels     what stands in a body
    primitives                           what stands in a primitive
    modules                              what stands in a file
"""

from .declarations import *  # noqa: F403
from .expressions import *  # noqa: F403
from .labels import *  # noqa: F403
from .modules import *  # noqa: F403
from .nodes import *  # noqa: F403
from .primitives import *  # noqa: F403
from .statements import *  # noqa: F403
