"""Codes of files, modules and syntax."""

from .base import Code

READING = (
    Code("missing-file", "a file is missing or cannot be read", """
        The file named on the command line does not exist, is a folder, or may not be read. Shipped categories are
        known by name alone (`Microwave`); everything else is given by its path.
        """),
    Code("not-utf8", "the file is not UTF-8 text", """
        Program texts are UTF-8. The place shown is the first byte that is not; save the file in that encoding.
        """),
    Code("syntax", "the text does not follow the grammar", """
        At this place the text is no program any more. A statement begins with a word of its own (`param`, `part`,
        `align` ...) and ends at the end of its line; it goes on over several lines only within brackets, after a comma,
        an operator or `=`, and before `|`. What follows the broken statement is checked all the same, so several such
        errors may be shown.
        """, """
        apg 1
        category Stool {
          part seat Cuboid
        }
        """),
    Code("missing-brace", "a brace is never closed", """
        A block that begins with `{` has no `}`. The place shown is the opening brace that seems to lack its partner,
        judged by the indentation of what follows.
        """, """
        apg 1
        category Stool {
          repeat leg[k] in 0 ..< 4 {
            part rod : Cuboid
        }
        """),
    Code("missing-bracket", "a round or square bracket is never closed", """
        The bracket is not closed before its statement ends or is closed by one of the other kind. Line ends do not
        count within brackets, so the mistake shows only where the next statement begins.
        """, """
        apg 1
        category Stool {
          part seat : Cuboid(size = [30cm, 30cm, 3cm]
          part back : Cuboid
        }
        """),
    Code("unterminated-string", "a text in quotes does not end on its line", """
        Text in double quotes ends on the line on which it begins. Within it `\\"` stands for a quote.
        """, """
        apg 1
        category Stool {
          require 1cm <= 2cm else "too small
        }
        """),
    Code("reserved-word", "a word of the language is used as a name", """
        Most words that begin a statement, and `in for when is else on none and or not if`, are never names. Words that
        only begin clauses (`at`, `range`, `weight` ...) are ordinary names wherever no clause can stand.
        """, """
        apg 1
        category Stool {
          param part : length in 1cm .. 2cm
        }
        """),
    Code("unknown-module", "there is no module of that name", """
        `use name { ... }` looks for `name.apg` beside the file that says so, then in the library. The module's name
        is written without ending or folder.
        """, """
        apg 1
        use handels { BarHandle }
        """),
    Code("unknown-import", "a module has no declaration of that name", """
        A module hands out what it declares itself: roles, templates, primitives, materials, vocabularies, functions
        and categories, not what it brings in by `use`.
        """, """
        apg 1
        use primitives { Cubiod }
        """),
    Code("import-cycle", "modules import one another in a circle", """
        Modules may use each other only one way. Move what both need into a third one.
        """),
    Code("no-category", "a file declares no category", """
        Only a category can be sampled. A module of templates and roles can be checked, and used by others.
        """),
    Code("two-categories", "a file declares two categories", """
        A file holds one category, so that the file and what is sampled from it have one name. Move the other one
        into a file of its own.
        """, """
        apg 1
        use primitives { Cuboid }
        category Stool { root part seat : Cuboid(size = [30cm, 30cm, 3cm]) }
        category Bench { root part seat : Cuboid(size = [30cm, 90cm, 3cm]) }
        """),
)  # fmt: skip
