"""Codes of names: what is not there, what is there twice, what cannot stand here."""

from .base import Code

RESOLVING = (
    Code(
        "unknown-name",
        "a name is not declared here",
        """
        No parameter, part, `let` or repeat of this name is visible here. Names declared in a block (`repeat`, `when`)
        are visible only inside it; from outside, use the name of the repeat: `column.cell.front`. Check the spelling,
        declare the name, or import it with `use`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [widht, 30cm, 3cm])
        }
        """,
    ),
    Code(
        "unknown-member",
        "a value has no member of that name",
        """
        The value before the dot has no such member. A part has the faces `front back left right top bottom`, `size`,
        `center` and `box`, and what its template or role declares: parameters, ports, slots, parts and joints. Check
        the spelling, or declare a port, slot or `out` in the template for what others should see.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          require seat.widht >= 3cm
        }
        """,
    ),
    Code(
        "unknown-template",
        "there is no such template, role or primitive",
        """
        A part is made from a template, primitive or style that the file declares or imports with `use`. A role cannot
        be used as a template: it only states what its alternatives have in common. Check the spelling, or add the name
        to a `use` line.
        """,
        """
        apg 1
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
        }
        """,
    ),
    Code(
        "unknown-type",
        "there is no such type",
        """
        Types are `length angle ratio count bool area volume mass density time force torque speed`, `choice a | b`,
        `frame line plane edge point box curve material` and `style Role`; `length[3]` is a vector. The type fixes the
        dimension of a parameter, and therefore its units. Check the spelling.
        """,
        """
        apg 1
        template Stool {
          param width : lenght in 30cm .. 50cm
        }
        """,
    ),
    Code(
        "unknown-port",
        "a part has no port of that name",
        """
        The part's template has no such port or slot, or the index is too large. Ports are declared in a role or
        template with `port mount : frame`; if the role declares them, every alternative has them. Check the spelling;
        faces such as `body.front` need no declaration.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use handles { Handle, BarHandle }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part handle : Handle = BarHandle
          connect handle.mont to body.front at center
        }
        """,
    ),
    Code(
        "unknown-argument",
        "a template has no parameter of that name",
        """
        Arguments are given by the names of the template's parameters and of what its role inherits. A material has its
        own list of properties, and `at` takes the coordinates `x`, `y` and `z`. A misspelt argument would otherwise
        leave the parameter to be drawn. Check the spelling, or declare the parameter in the template.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(sise = [30cm, 30cm, 3cm])
        }
        """,
    ),
    Code(
        "unknown-clause",
        "a statement does not take this clause",
        """
        Each kind of statement, and each kind of joint, has its own clauses: a prismatic joint moves `along` a direction
        and takes no `about`, a continuous one has no `range`. A clause without effect would mislead the reader. Remove
        it, or choose the kind of statement that takes it.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Door {
          part frame_ : Cuboid(size = [1cm, 1cm, 1cm])
          part leaf : Cuboid(size = [1cm, 1cm, 1cm])
          joint spin : fixed frame_ -> leaf range 0deg .. 90deg
        }
        """,
    ),
    Code(
        "unknown-function",
        "there is no such function",
        """
        Functions are the built-in ones (`sin`, `hypot`, `min`, `sum` ...), those of the module (`let f(x) = ...`), the
        surfaces and curves of a primitive, and the constructors of frames, lines and boxes. Functions cannot be written
        in another language. Check the spelling, or declare the function with `let`.
        """,
        """
        apg 1
        let half(x) = sqroot(x)
        """,
    ),
    Code(
        "unknown-joint-kind",
        "there is no such kind of joint",
        """
        Joints are `revolute` (turns between limits), `continuous` (turns without end), `prismatic` (slides),
        `screw`, `ball` and `fixed`. These are the kinds that simulators know. A hinge is `revolute`, a slide
        `prismatic`, a dial without stops `continuous`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Door {
          part post : Cuboid(size = [1cm, 1cm, 1cm])
          part leaf : Cuboid(size = [1cm, 1cm, 1cm])
          joint open : hinge post -> leaf about leaf.left.back range 0deg .. 90deg
        }
        """,
    ),
    Code(
        "unknown-distribution",
        "there is no such distribution",
        """
        A parameter is drawn `~ uniform()`, `~ normal(mean, deviation)`, `~ lognormal(median, deviation)` or from `~
        values(a, b, b)`, always within its range. Values outside the range are never drawn, so there is no need to
        truncate a distribution. Without `~` the draw is uniform.
        """,
        """
        apg 1
        template Stool {
          param width : length in 30cm .. 50cm = 40cm ~ gauss(40cm, 3cm)
        }
        """,
    ),
    Code(
        "unknown-choice",
        "a choice has no such option",
        """
        This is not one of the options that the type lists. A comparison with a misspelt option would never be true.
        Check the spelling, or add the option to the type.
        """,
        """
        apg 1
        template Stool {
          param shape : choice round | square = rond
        }
        """,
    ),
    Code(
        "unknown-vocabulary",
        "there is no such vocabulary",
        """
        A label is written `vocabulary.word`. Vocabularies are declared in the file or imported with `use`. The shipped
        ones are in the module `vocabularies`: `use vocabularies { semantic, affordance }`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          label semantics.seat on seat
        }
        """,
    ),
    Code(
        "unknown-label",
        "a label is not in its vocabulary",
        """
        The words of a vocabulary are fixed, so that their numbers are the same in every data set. Check the spelling,
        or use the word that is nearest in meaning. New words are added at the end of the declaration.
        """,
        """
        apg 1
        use primitives { Cuboid }
        vocabulary semantic { seat leg }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          label semantic.saet on seat
        }
        """,
    ),
    Code(
        "unknown-material",
        "there is no such material",
        """
        Materials are declared in the file (`material oak { ... }`) or imported with `use materials { oak }`. A part
        without a material of its own takes that of the part around it. Check the spelling.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          material oak on seat
        }
        """,
    ),
    Code(
        "duplicate-name",
        "a name is declared twice",
        """
        Parameters, parts, ports, surfaces and slots of one template share one namespace. One name may be declared in
        two branches that exclude each other (`when a { } else { }`). Otherwise it would be unclear which one is meant.
        Rename one of the two. Keypoints have names of their own; two of one name may lie on different parts, not on one.
        As a warning: the index of a repeat, or the parameter of a grasp, is called like something around it, which it
        hides: in a repeat within a repeat, `i` would mean the inner rank alone.
        """,
        """
        apg 1
        template Stool {
          param width : length in 30cm .. 50cm
          param width : length in 40cm .. 50cm
        }
        """,
    ),
    Code(
        "reserved-name",
        "a name shadows a built-in one",
        """
        Types, constructors, built-in functions, the faces of a box, `size`, `center` and `box` keep their meaning
        everywhere and cannot be declared: it would be unclear which one is meant. Choose another name: `front_edge`,
        `seat_size`. After a dot and as names of arguments, such words are allowed. A parameter of a primitive must not be
        called `u`, `v`, `i` or `p`: these are variables of its formulas.
        """,
        """
        apg 1
        template Stool {
          param front : length in 30cm .. 50cm
        }
        """,
    ),
    Code(
        "circular-definition",
        "something is defined in terms of itself",
        """
        The chain of definitions shown leads back to its beginning, so none of them has a value. This applies to `let`,
        sizes of parts, ranges, places given by `to`, attachments, joints that carry or follow one another, roles, and
        templates that contain each other. Equations may be circular (`align` solves them together), definitions may
        not. Give one of them a value of its own, or leave a size open with `_` and state an equation.
        """,
        """
        apg 1
        template Stool {
          let a = b + 1cm
          let b = a - 1cm
        }
        """,
    ),
    Code(
        "overridden",
        "a later statement takes the place of an earlier one",
        """
        Two statements of one body give the same part, slot or surface a material, a semantic word, a field or a symmetry.
        The later one counts wherever both hold, and it holds everywhere, so the earlier one has no effect. Leave one of
        them out, put the later one under the `when` in which it is meant, or write the one that holds everywhere first.
        Labels of other vocabularies unite; there only one that says the same again is told.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak, steel }
        use vocabularies { semantic }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 3cm])
          part leg : Cuboid(size = [3cm, 3cm, 40cm])
          connect leg.top on seat.bottom at center
          material steel on leg
          material oak on seat, leg
          label semantic.seat on seat
          label semantic.leg on leg
        }
        """,
    ),
    Code(
        "holds-nowhere",
        "a label or a field holds at no point",
        """
        Whatever is drawn, no point of the targets meets the condition behind `where`, or the degree of the label is never
        above 0. So the statement has no effect. A point is measured from the centre of its target: `p.z` goes from
        `-size.z / 2` to `size.z / 2`. Correct the condition, or leave the statement out. `apgc check` finds what follows
        from ranges; `apgc report` looks at the points of objects, and finds more.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic, affordance }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 3cm])
          material oak on seat
          label semantic.seat on seat
          label affordance.support on seat where p.z > 0.9 * size.z
        }
        """,
    ),
    Code(
        "stated-twice",
        "a statement is repeated",
        """
        The same requirement, `limit`, `clear`, `close`, `allow` or `free` stands twice in a body, and one of the two holds
        wherever the other does. Often a line was copied, and a name in it not changed. Correct one of them, or leave it
        out. Of two equal preferences the weights add up: write one, with a weight.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width, depth, height : length in 30cm .. 50cm
          root part seat : Cuboid(size = [depth, width, height])
          require width <= 1.2 * depth
          require width <= 1.2 * depth
          material oak on seat
          label semantic.seat on seat
        }
        """,
    ),
    Code(
        "unused",
        "a name is never used",
        """
        A name imported by `use` does not occur in the file; or a parameter, count, `let`, style or curve of the category,
        or of a template in its file, or such a template itself, is declared but never used, so objects would be the same
        without it. Often a number was
        written where the name was meant. Or a function ignores one of its parameters, or a grasp the one that it is
        `for`, so that all grasps of the family are equal. Or the elements of a repeat have places along an axis (`pitch`,
        `spread`, `fill`), and its parts are all placed along it by other equations. This is a warning: the program works.
        Vocabularies count as used, since their words are added to those of the program; so does what a role requires of its templates.
        """,
        """
        apg 1
        use primitives   { Cuboid }
        use vocabularies { semantic }
        use materials    { oak, steel }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, 40cm, 3cm])
          label semantic.seat on seat
          material oak on seat
        }
        """,
    ),
)
