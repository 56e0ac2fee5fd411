"""Codes of values: units, dimensions, types, ranges, conditions."""

from .base import Code

VALUES = (
    Code("missing-unit", "a length, angle or other quantity has no unit", """
        Lengths, angles and all other quantities carry their unit (`5cm`, `30deg`, `8N`), so that no number can be
        misread. Only `0` may go without one.
        """, """
        apg 1
        template Stool {
          param width : length in 30cm .. 50
        }
        """),
    Code("unknown-unit", "a number carries a unit that does not exist", """
        Units are `mm cm m km`, `deg rad turn`, `kg g`, `s ms`, `N`, quotients and products of them such as `kg/m3`,
        `N*m`, `m/s`, and `%`. The unit stands right behind the number. There are no inches.
        """, """
        apg 1
        template Stool {
          param width : length in 30cm .. 50centimetres
        }
        """),
    Code("wrong-dimension", "quantities of different dimension are mixed", """
        A length and an angle cannot be added, compared or put in one another's place. Products and quotients make new
        dimensions: a length times a length is an area.
        """, """
        apg 1
        template Stool {
          param width : length in 30cm .. 50cm
          let wrong = width + 20deg
        }
        """),
    Code("wrong-type", "a value is of another type than needed", """
        What stands here is of another type than the place needs: a whole part where a number belongs, a number where
        a box belongs, and the like. A face as a number is its coordinate.
        """, """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          require seat >= 3cm
        }
        """),
    Code("wrong-kind", "something else is needed here", """
        The thing named exists, but is no value, part or template of the kind that can stand here.
        """, """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : none
        }
        """),
    Code("empty-range", "a range has no value", """
        In a range `low .. high` the low end must not lie above the high one.
        """, """
        apg 1
        template Stool {
          param width : length in 50cm .. 30cm
        }
        """),
    Code("default-outside-range", "a default lies outside its domain", """
        The default of a parameter is one of its legal values: it lies within its range.
        """, """
        apg 1
        template Stool {
          param width : length in 30cm .. 50cm = 60cm
        }
        """),
    Code("bad-guard", "a guard is not a condition", """
        A guard decides the structure, which is known before any measure is. So it asks `a is B`, whether an optional
        part is there, or compares counts, ranks and choices; lengths and angles belong into `require` or into
        `a if c else b`.
        """, """
        apg 1
        use primitives { Cuboid }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 3cm])
          when width > 40cm { param more : length in 1cm .. 2cm }
        }
        """),
    Code("unrelated-type", "a test with `is` can never hold", """
        The part can only be one of its alternatives, and none of them is or plays what stands behind `is`.
        """, """
        apg 1
        use primitives { Cuboid }
        use handles { Handle, BarHandle, BowHandle }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part handle : Handle = BarHandle
          connect handle.mount to body.front at center
          when handle is BowHandle { require body.size.x >= 3cm }
        }
        """),
    Code("always-true", "a requirement holds always", """
        The ranges of what it names leave no way to break this requirement. It can go, or one of the ranges is
        narrower than was meant.
        """),
    Code("impossible", "a requirement can never hold", """
        The ranges of what it names leave no way to keep this requirement, so nothing could ever be drawn.
        """),
)  # fmt: skip
