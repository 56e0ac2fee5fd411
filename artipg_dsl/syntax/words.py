"""Kinds of tokens that messages and recovery tell apart, by the names of their terminals."""

STATEMENTS = frozenset(
    "PARAM INHERIT OUT COUNT LET ROOT PART STYLE SLOT PORT JOINT CONNECT ALIGN REQUIRE PREFER CLEAR ALLOW FREE LIMIT "
    "CLOSE REPEAT WHEN WHEN_BLOCK LABEL FIELD GRASP KEYPOINT SYMMETRY MATERIAL SURFACE CURVE INSIDE BOX PIECE "
    "SOLID".split()
)
"""What begins a statement in a body."""

TOP = frozenset("USE ROLE TEMPLATE PRIMITIVE CATEGORY MATERIAL VOCABULARY LET".split())
"""What begins a declaration of a file."""

OPERATORS = frozenset(
    "PLUS MINUS STAR SLASH CARET EQUALS UNEQUAL LESS AT_MOST MORE AT_LEAST AND OR IS ARROW UNTIL UPTO COMMA EQUAL DOT "
    "TILDE COLON IN ON IF".split()
)
"""What stands between two others."""
