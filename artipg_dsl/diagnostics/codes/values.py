"""Codes of values: units, dimensions, types, ranges, conditions."""

from .base import Code

VALUES = (
    Code(
        "missing-unit",
        "a length, angle or other quantity has no unit",
        """
        Lengths, angles and all other quantities carry their unit (`5cm`, `30deg`, `8N`), so that no number can
        be misread. Only `0` may go without one. Ratios and counts have no unit; write a percentage as `8%`.
        """,
        """
        apg 1
        template Stool {
          param width : length in 30cm .. 50
        }
        """,
    ),
    Code(
        "unknown-unit",
        "a number carries a unit that does not exist",
        """
        Units are `mm cm m km`, `deg rad turn`, `kg g`, `s ms`, `N`, quotients and products of them such as
        `kg/m3`, `N*m`, `m/s`, and `%`. The unit stands right behind the number. There are no inches. The list
        is closed, so that a misspelt unit is found here. Convert the number, for example to `cm`.
        """,
        """
        apg 1
        template Stool {
          param width : length in 30cm .. 50centimetres
        }
        """,
    ),
    Code(
        "wrong-dimension",
        "quantities of different dimension are mixed",
        """
        A length and an angle cannot be added, compared or put in one another's place. Products and quotients
        make new dimensions: a length times a length is an area. The dimension of every formula is checked
        before anything is drawn. Look for a missing factor, or for a `sin` that should take an angle.
        """,
        """
        apg 1
        template Stool {
          param width : length in 30cm .. 50cm
          let wrong = width + 20deg
        }
        """,
    ),
    Code(
        "wrong-type",
        "a value is of another type than needed",
        """
        What stands here is of another type than the place needs: a whole part where a number belongs, a number
        where a box belongs, and the like. A face as a number is its coordinate. Name the member that is meant,
        such as `seat.size.z`, `seat.top` or `seat.center`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          require seat >= 3cm
        }
        """,
    ),
    Code(
        "wrong-kind",
        "something else is needed here",
        """
        The thing named exists, but is no value, part or template of the kind that can stand here. A part is
        made of a template or a primitive, a material is put on by `material`, a label by `label`. The message
        says what is needed and what was found.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : none
        }
        """,
    ),
    Code(
        "empty-range",
        "a range has no value",
        """
        In a range `low .. high` the low end must not lie above the high one. The ends may be formulas; where
        both are known beforehand they are compared before anything is drawn. Exchange the ends.
        """,
        """
        apg 1
        template Stool {
          param width : length in 50cm .. 30cm
        }
        """,
    ),
    Code(
        "default-outside-range",
        "a default lies outside its domain",
        """
        The default of a parameter is one of its legal values: it lies within its range. Otherwise the object
        with all defaults, with which the manipulation of a program begins, would be an illegal one. Move the
        default, or widen the range.
        """,
        """
        apg 1
        template Stool {
          param width : length in 30cm .. 50cm = 60cm
        }
        """,
    ),
    Code(
        "undefined-value",
        "a formula has no value",
        """
        The formula divides by zero, takes the root or the logarithm of a negative number, or grows beyond what a
        number can hold, whatever is drawn. What has no value for some draws alone makes these objects invalid, which
        are drawn again. Correct the formula, or say where it holds: `a / n if n > 0 else 0cm`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          let legs = 3 - 3
          root part seat : Cuboid(size = [30cm, 90cm / legs, 3cm])
        }
        """,
    ),
    Code(
        "illegal-value",
        "a value lies outside what is legal for it",
        """
        Every number of an object has a legal range: sizes lie above 0 and below 1 km, places within 1 km, axes and directions have
        a length, densities lie above 0, damping and friction are not negative, colours lie in 0 .. 1, a repeat has at
        most 10,000 elements, and so on. Here the value lies outside whatever is drawn. Where only some draws lead out of
        the range, these objects are invalid and drawn again, which `sample --stats` counts. Correct the formula.
        """,
        """
        apg 1
        use primitives { Cuboid }
        material cork { density 0kg/m3 }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          material cork on seat
        }
        """,
    ),
    Code(
        "bad-guard",
        "a guard is not a condition",
        """
        A guard decides the structure, which is known before any measure is. So it asks `a is B`, whether an
        optional part is there, or compares counts, ranks and choices; lengths and angles belong into `require`
        or into `a if c else b`. Tables are laid out by these guards before any length is drawn.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 3cm])
          when width > 40cm { param more : length in 1cm .. 2cm }
        }
        """,
    ),
    Code(
        "unrelated-type",
        "a test with `is` can never hold",
        """
        The part can only be one of its alternatives, and none of them is or plays what stands behind `is`.
        What stands under the test could never happen. Check the names of the alternatives, or remove the test.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use handles { Handle, BarHandle, BowHandle }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part handle : Handle = BarHandle
          connect handle.mount to body.front at center
          when handle is BowHandle { require body.size.x >= 3cm }
        }
        """,
    ),
    Code(
        "always-true",
        "a requirement always holds",
        """
        The ranges of what it names leave no way to break this requirement, so it says nothing. Often it
        compares the wrong values, or was written before a range was narrowed. Correct what it compares, or drop it.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 3cm])
          require width >= 20cm
        }
        """,
    ),
    Code(
        "idle-near",
        "`near` has nothing to choose",
        """
        `near` says where the search for the values of an equation begins, which chooses among several solutions. This
        equation is solved in closed form and has one solution, so `near` changes nothing. Drop it. To keep a value
        close to another, draw it in a range, or state a requirement or a preference.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          param width : length in 30cm .. 50cm
          param depth : length derived in 10cm .. 60cm
          root part seat : Cuboid(size = [depth, width, 3cm])
          align depth = width - 5cm near depth = 40cm
        }
        """,
    ),
    Code(
        "impossible",
        "a requirement can never hold",
        """
        The ranges of what it names leave no way to keep this requirement, so nothing could ever be drawn. For
        a primitive it is the ranges after `test` that are tried. Where requirements contradict one another, all of
        them are shown, with what they name. Within an alternative or a `when` it is a warning: what holds the
        contradiction is never drawn, and nobody would miss it. Widen a range, or correct the requirement.
        """,
        """
        apg 1
        primitive Ring {
          param radius : length > 0  test 1cm .. 2cm
          param wall   : length > 0  test 3cm .. 4cm
          require wall < radius
          curve outer (v in 0 .. 1) = [radius, v * 10cm]
          curve inner (v in 0 .. 1) = [radius - wall, v * 10cm]
          solid = lathe(outer, inner) about z
        }
        category Pipe { root part body : Ring(radius = 5cm, wall = 1cm) }
        """,
    ),
)
