"""Codes of files, modules and syntax."""

from .base import Code

READING = (
    Code(
        "missing-file",
        "a file is missing or cannot be read",
        """
        The file named on the command line does not exist, is a folder, or may not be read. Shipped categories are known
        by name alone (`Microwave`); everything else is given by its path. If the name resembles a shipped category, the
        message suggests it. Check the spelling, and the folder in which the command runs.
        """,
    ),
    Code(
        "not-utf8",
        "the file is not UTF-8 text",
        """
        Program texts are UTF-8. The place shown is the first byte that is not; save the file as UTF-8. Comments and
        texts may contain letters of any script, so there has to be a single encoding. Most editors convert with `Save
        with encoding`.
        """,
    ),
    Code(
        "reversed-text",
        "the text is shown in another order than it is read",
        """
        The file contains an invisible character that embeds, overrides or isolates the direction of text. With it, what
        an editor shows may differ from what the compiler reads: a value may look like a part of a comment. Delete the
        character. Comments in scripts that run from right to left are shown correctly without it.
        """,
    ),
    Code(
        "syntax",
        "the text does not follow the grammar",
        """
        At this place the text no longer follows the grammar. Each statement begins with a keyword (`param`, `part`,
        `align` ...) and ends at the end of its line; it continues on the next line only within brackets, after a comma,
        an operator or `=`, and before `|`. The statements after a broken one are still checked, so several such errors
        may be shown.
        """,
        """
        apg 1
        category Stool {
          part seat Cuboid
        }
        """,
    ),
    Code(
        "too-deep",
        "expressions, blocks or parts are nested too deeply",
        """
        Expressions or blocks are nested more than 200 deep; a sum of more than 200 terms counts as well. Or a value
        depends on a chain of hundreds of others, too long for the compiler to follow; the place shown is then the
        category. Name parts of a sum with `let`, use a `repeat` for parts that are alike, and put groups of parts into
        templates, which are solved one by one.
        """,
        "apg 1\ncategory Tower {\n  param high : ratio in 0 .. 1\n  let low = " + "-" * 201 + "high\n}\n",
    ),
    Code(
        "missing-brace",
        "a brace is never closed",
        """
        A block that begins with `{` has no matching `}`. The place shown is the opening brace that seems to have no
        partner, judging by the indentation after it. As it stands, the rest of the file would belong to the block.
        Close the block where it ends, and indent its lines.
        """,
        """
        apg 1
        category Stool {
          repeat leg[k] in 0 ..< 4 {
            part rod : Cuboid
        }
        """,
    ),
    Code(
        "missing-bracket",
        "a round or square bracket is never closed",
        """
        The bracket is not closed before its statement ends, or is closed by a bracket of the other kind. Line breaks do
        not count within brackets, so the mistake only shows where the next statement begins. Close the bracket after
        its last argument.
        """,
        """
        apg 1
        category Stool {
          part seat : Cuboid(size = [30cm, 30cm, 3cm]
          part back : Cuboid
        }
        """,
    ),
    Code(
        "unterminated-string",
        "a text in quotes does not end on its line",
        """
        Text in double quotes ends on the line on which it begins. Within it, `\\"` is a quote. Keep the messages of
        `require ... else` short enough for a line. Close the quote, or shorten the text.
        """,
        """
        apg 1
        category Stool {
          require 1cm <= 2cm else "too small
        }
        """,
    ),
    Code(
        "reserved-word",
        "a word of the language is used as a name",
        """
        Most words that begin a statement, and `in for when is else on none and or not if`, cannot be names. Words that
        only begin clauses (`at`, `range`, `weight` ...) are ordinary names wherever a clause is not possible. If a word
        that begins a statement were also a name, the text could be read in two ways. Choose another name, or add an
        underscore: `part_`.
        """,
        """
        apg 1
        category Stool {
          param part : length in 1cm .. 2cm
        }
        """,
    ),
    Code(
        "unknown-module",
        "there is no module of that name",
        """
        `use name { ... }` looks for `name.apg` next to the importing file, then in the library. The module's name is
        written without extension or folder. Only these two places are searched, so that a program means the same on
        every machine. Check the spelling, or put the file next to this one.
        """,
        """
        apg 1
        use handels { BarHandle }
        """,
    ),
    Code(
        "unknown-import",
        "a module has no declaration of that name",
        """
        A module exports what it declares itself: roles, templates, primitives, materials, vocabularies, functions and
        categories. It does not export what it imports with `use`, so each name has a single home, however many modules
        use it. Check the spelling and capital letters, or import the name from the module that declares it.
        """,
        """
        apg 1
        use primitives { Cubiod }
        """,
    ),
    Code(
        "import-cycle",
        "modules import each other in a cycle",
        """
        Two modules cannot use each other, directly or through others: the order in which modules are read must not
        matter. Move what both need into a third one. It takes two files to cause this error: `a.apg` with `use b { ...
        }` and `b.apg` with `use a { ... }`.
        """,
    ),
    Code(
        "nothing-declared",
        "a file declares nothing",
        """
        The file contains no declaration: it is empty, or contains only comments, the version and `use` lines. There is
        nothing to check, import or sample; it was probably saved too early, or is not the file you meant. `apgc new
        Name` writes a category to start from.
        """,
        """
        apg 1
        # a stool
        """,
    ),
    Code(
        "no-category",
        "a file declares no category",
        """
        Only a category can be sampled. A module of templates and roles can be checked and imported. This error appears
        when such a file is sampled, compiled or checked as a category. Add `category Name { root part ... }`, or name
        another file.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Foot { part post : Cuboid(size = [2cm, 2cm, 9cm]) }
        """,
    ),
    Code(
        "two-categories",
        "a file declares two categories",
        """
        A file contains at most one category, so that the file and its samples share one name. Move the other category
        into its own file. Put templates that the two share into a module that both `use`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool { root part seat : Cuboid(size = [30cm, 30cm, 3cm]) }
        category Bench { root part seat : Cuboid(size = [30cm, 90cm, 3cm]) }
        """,
    ),
)
