"""Codes of values: units, dimensions, types, ranges, conditions."""

from .base import Code

VALUES = (
    Code(
        "missing-unit",
        "a length, angle or other quantity has no unit",
        """
        Lengths, angles and all other quantities are written with their unit (`5cm`, `30deg`, `8N`), so that no number
        can be misread. Only `0` needs none. Ratios and counts have no unit; write a percentage as `8%`.
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
        "a number has a unit that does not exist",
        """
        Units are `mm cm m km`, `deg rad turn`, `kg g`, `s ms`, `N`, quotients and products of them such as `kg/m3`,
        `N*m`, `m/s`, and `%`. The unit directly follows the number. There are no inches. The list is fixed, so that a
        misspelt unit is found. Convert the number, for example to `cm`.
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
        A length and an angle cannot be added, compared or used in place of each other. Products and quotients have new
        dimensions: a length times a length is an area. The dimension of every formula is checked before anything is
        drawn. Look for a missing factor, or for a `sin` that should take an angle.
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
        "a value has the wrong type",
        """
        The value here is not of the type that is needed: a whole part instead of a number, a number instead of a box,
        and so on. A face used as a number is its coordinate. Name the member that is meant, such as `seat.size.z`,
        `seat.top` or `seat.center`.
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
        "a name is of the wrong kind",
        """
        The name exists, but is not a value, part or template of the kind needed here. A part is made from a template or
        a primitive; `material` assigns a material, `label` a label. The message says what is needed and what was found.
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
        "a range is empty",
        """
        In a range `low .. high` the low end must not lie above the high one. The ends may be formulas; where both are
        known in advance, they are compared before anything is drawn. Swap the ends. Of a parameter or a count, a range with
        a single value is a warning: for a fixed value, use `let` or a default without a range. So is a choice of one
        option.
        """,
        """
        apg 1
        template Stool {
          param width : length in 50cm .. 30cm
        }
        """,
    ),
    Code(
        "argument-outside-range",
        "an argument lies outside the range of its parameter",
        """
        An argument replaces what the template would draw, and this one lies where the template never draws: the range
        says for which values it is made. Often the unit is wrong, such as `m` for `mm`. Correct the argument. If the
        value is meant, widen the range, and look whether the template still holds together. What is computed is told
        if it lies outside whatever is drawn. If it lies outside in some objects only, it takes effect there, and
        nothing is said: a `require` in the template says what it cannot be. A value that is drawn in a range which begins
        below 0 is told where it must be above 0.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Foot {
          param height : length in 5mm .. 40mm
          part block : Cuboid(size = [3cm, 3cm, height])
        }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          part foot : Foot(height = 20cm)
          connect foot.top on seat.bottom
        }
        """,
    ),
    Code(
        "default-outside-range",
        "a default lies outside its range",
        """
        The default of a parameter must be a legal value: it lies within its range. Otherwise the object with all
        defaults would be invalid. Move the default, or widen the range.
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
        The formula divides by zero, takes the root or the logarithm of a negative number, exceeds the largest number,
        or names a place beyond its surface, `wall.side.at(0turn, z = 30cm)`, for every draw. If it has no value for
        some draws only, those objects are invalid and drawn again, which is a warning where it happens to one of the
        few that `apgc check` draws.
        Correct the formula, or say where it applies: `a / n if n > 0 else 0cm`. `z` of a place on a surface is measured
        in the frame of the part itself, for most primitives from the middle.
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
        "a value lies outside its legal range",
        """
        Every number of an object has a legal range: sizes lie above 0 and below 1 km, places within 1 km; densities are
        above 0; damping, friction and stiffness are not negative; what lies still has no less friction than what
        slides; colours lie within 0 .. 1; axes and directions are not [0, 0, 0]; a repeat has at most 5,000 elements;
        and so on. Here the value is illegal for every draw. If it is illegal for some draws only, those objects are
        invalid and drawn again, which `sample --stats` counts. Correct the formula.
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
        A guard decides the structure, which is fixed before any length is drawn. So a guard tests `a is B`, tests
        whether an optional part exists, or compares counts, ranks and choices. Conditions on lengths and angles are not
        possible; use them in `require` or in `a if c else b`.
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
        The part can only be one of its alternatives, and none of them is the template, or has the role, named after
        `is`. Nothing under this test could ever exist. Check the names of the alternatives, or remove the test.
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
        "never-there",
        "nothing under this `when` or repeat can ever exist",
        """
        Within the ranges of counts and the options of choices and parts, and within the `when` around it, the condition
        never holds, or always holds and has an `else`; or the number of elements of a repeat is never more than 0. What
        stands there would be left out of every object. Correct the condition, widen the range, or remove it.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          count legs in 3 .. 4
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          when legs > 4 { param brace : length in 1cm .. 2cm }
        }
        """,
    ),
    Code(
        "mixed-units",
        "values of a range have different units, one of which is probably wrong",
        """
        The high end is at least eight times the low one, their units differ, and with one unit for both they would be a
        usual range: one in which the default, or the first value of the distribution, lies. Where there is neither, both
        ends are 10 or more. Mostly `20cm` stands for `20mm`. Or the default, in another unit than both ends, lies in the
        outer tenth of the range, where the same number in their unit would lie in the range as well, as 37 cm would in
        `3cm .. 45cm = 37mm`. Correct the unit. If the values are meant, write them in the same unit.
        """,
        """
        apg 1
        use primitives { Cylinder }
        use materials { steel }
        use vocabularies { semantic }
        category Tube {
          param radius : length in 14mm .. 20cm = 16mm
          root part tube : Cylinder(radius = radius, height = 50cm)
          material steel on tube
          label semantic.body on tube
        }
        """,
    ),
    Code(
        "always-true",
        "a requirement or preference has no effect",
        """
        No values in the ranges can violate this requirement, so it has no effect. The same applies to a preference that
        always or never holds. Often it compares the wrong values, or was written before a range was narrowed. Correct
        the comparison, or drop it.
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
        "dead-branch",
        "a branch of `a if c else b` is never used",
        """
        The ranges of the values that the condition compares decide it for every object, so one of the two values is
        never used. Often a bound has a wrong unit, or a range was narrowed later. Correct the condition, or write the
        other value alone. A condition that is decided by constants, as by the arguments of a template, is not told.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 4cm if width > 4m else 3cm])
          material oak on seat
          label semantic.seat on seat
        }
        """,
    ),
    Code(
        "idle-near",
        "`near` has no effect",
        """
        `near` says where the search for a solution of an equation begins, and so chooses among several solutions. This
        equation is solved in closed form and has one solution, so `near` changes nothing. Drop it. To keep a value
        close to another, give it a range, a requirement or a preference.
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
        "none-drawn",
        "no attempt to draw an object succeeds",
        """
        `apgc check` draws a few objects to examine. For one of them, none of 100 attempts met all requirements, so
        `apgc sample` would stop as well. The message says what failed most often: a `require`, or a number outside its
        legal range, such as the room between the margins of a repeat. A requirement that can be proved always to fail
        is a separate error (`impossible`). Widen the ranges, or make the range of one value depend on another.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Bench {
          param lean : angle in 10deg .. 25deg
          root part seat : Cuboid(size = [30cm, 1m, 3cm])
          part post : Cuboid(size = [3cm, 3cm, 45cm]) turned lean about y
          connect post to seat
          align post.top.center = seat.bottom.center
          require 1m * sin(lean) * cos(lean) >= 40cm  else "the foot stands too steep"
          material oak on seat, post
          label semantic.seat on seat
          label semantic.leg on post
        }
        """,
    ),
    Code(
        "excluded-value",
        "a value of a count or a choice is left out",
        """
        A count or a choice that should often have the value by its range and weights has it in hardly any object,
        because a requirement fails wherever it has, or leaves it no room. So every object is valid and the variety is
        less than the text says, as where `when legs == 3 { require ... }` can hardly hold. `apgc check` sees it in 256
        attempts, judged by the requirements alone. Widen the ranges of what is required; for an equation write `align`,
        as drawn numbers are never equal by chance. If the value is not meant, leave it out. Options of a choice and ends
        of the range of a count that `values` does not list are told, too, and alternatives of parts and styles whose
        `when` never holds within the ranges of what it compares.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width, depth : length in 30cm .. 40cm
          count legs in 3 .. 4
          root part seat : Cuboid(size = [depth, width, 3cm])
          when legs == 3 { require width + depth <= 601mm }
          repeat leg[k] in 0 ..< legs spread seat along y margin 5cm {
            part post : Cuboid(size = [3cm, 3cm, 40cm])
            connect post.top on seat.bottom
            align post.center.y = leg.center.y
          }
          material oak on seat, leg.post
          label semantic.seat on seat
          label semantic.leg on leg.post
        }
        """,
    ),
    Code(
        "impossible",
        "a requirement can never hold",
        """
        No values in the ranges can satisfy this requirement, so no object could ever be drawn. For a primitive, the
        ranges after `test` are tried. If requirements contradict one another, all of them are shown, with the values
        that they compare. Within an alternative or a `when` this is a warning: that alternative is silently never
        drawn. Widen a range, or correct the requirement.
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
