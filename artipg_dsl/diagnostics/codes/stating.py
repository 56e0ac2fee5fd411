"""Codes of statements: what stands where it cannot, what is missing, what an argument cannot be."""

from .base import Code

STATING = (
    Code(
        "misplaced-statement",
        "a statement is not allowed here",
        """
        Roles declare, templates and categories build, primitives have surfaces: each has its own statements. A role has
        no parts because its alternatives have them; a template has no `root` because its user decides what it is
        attached to. Move the statement to where it belongs.
        """,
        """
        apg 1
        role Handle {
          part grip : Cuboid
        }
        """,
    ),
    Code(
        "misplaced-hole",
        "`_` is used where nothing can be left open",
        """
        `_` leaves one component of a vector argument to be determined by equations: `Cuboid(size = [_, 2cm, _])`. It is
        not a value and cannot be used in formulas. To leave a whole argument open, omit it.
        """,
        """
        apg 1
        template Stool {
          let corner = [_, 1cm, 2cm]
        }
        """,
    ),
    Code(
        "missing-argument",
        "an argument is missing",
        """
        The constructor or function needs the arguments named. They have no sensible default. The help line shows the
        full form.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Knob {
          part body : Cuboid(size = [1cm, 1cm, 1cm])
          port mount : frame = frame(at = body.back.center)
        }
        """,
    ),
    Code(
        "missing-clause",
        "a statement lacks a clause",
        """
        The statement is incomplete: a `connect` needs `to`, `on`, `in` or `between`; a grasp needs `at`, `approach`,
        `close` and `opening`. A joint that turns needs an axis, and a range unless it is `continuous`. The help line
        names the clause.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          part leg : Cuboid(size = [3cm, 3cm, 40cm])
          connect leg fit left
        }
        """,
    ),
    Code(
        "missing-value",
        "a declaration lacks a value",
        """
        A role only declares a port; a template has to bind it with `=`. A parameter of a category without a value needs
        a range to be drawn from. Write the value after `=`, or move the declaration to a role.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Knob {
          part body : Cuboid(size = [1cm, 1cm, 1cm])
          port mount : frame
        }
        """,
    ),
    Code(
        "wrong-arguments",
        "a function or clause is given the wrong arguments",
        """
        The number or the names of the arguments do not match those that the function takes. An extra argument is never
        ignored, and a missing one is never guessed. The message says what is expected.
        """,
        """
        apg 1
        template Stool {
          let a = sin(1deg, 2deg)
        }
        """,
    ),
)
