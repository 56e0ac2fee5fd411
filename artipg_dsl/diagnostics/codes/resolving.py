"""Codes of names: what is not there, what is there twice, what cannot stand here."""

from .base import Code

RESOLVING = (
    Code(
        "unknown-name",
        "a name is not declared here",
        """
        No parameter, part, `let` or repeat of this name can be seen from here. Names of a block (`repeat`,
        `when`) are seen within it only; from outside, what a repeat declares is reached through it:
        `column.cell.front`. Names are checked before anything is drawn, so that a misspelt one cannot pass
        unnoticed. Check the spelling, declare it, or bring it in with `use`.
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
        What stands before the dot has no such member. A part has the faces `front back left right top bottom`,
        `size`, `center` and `box`, and what its template or role declares: parameters, ports, slots, parts and
        joints. Types are closed, so that a misspelt member cannot pass unnoticed. Check the spelling, or
        declare a port, slot or `out` in the template for what others shall see.
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
        A part is made of a template, primitive or style that the file declares or brings in by `use`. Names of
        roles cannot stand for a template: a role is what alternatives share. Check the spelling, or add the
        name to a `use` line.
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
        Types are `length angle ratio count bool area volume mass density time force torque speed`, `choice a |
        b`, `frame line plane edge point box curve material` and `style Role`; `length[3]` is a vector. The
        type fixes the dimension of a parameter, and so the units that it takes. Check the spelling.
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
        The place needs a port or slot that the part's template does not have, or an index beyond those it has.
        Ports are declared by a role or template with `port mount : frame`. What others connect to is named
        once, in the role, so that every alternative has it. Check the spelling; faces such as `body.front` are
        there without a declaration.
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
        Arguments are given by the names of the template's parameters and of what its role inherits. A material
        takes its own list of properties, `at` the coordinates `x`, `y` and `z`. A misspelt argument would
        otherwise leave the parameter to be drawn, unnoticed. Check the spelling, or declare the parameter in
        the template.
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
        Each kind of statement, and each kind of joint, takes clauses of its own: a prismatic joint moves
        `along` a direction and takes no `about`, a continuous one has no `range`. A clause that has no effect
        would mislead who reads it. Remove it, or choose the kind of statement that takes it.
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
        Functions are the built-in ones (`sin`, `hypot`, `min`, `sum` ...), those of the module (`let f(x) =
        ...`), the surfaces and curves of a primitive, and the constructors of frames, lines and boxes. There
        are no user functions in other languages: formulas have to be differentiated and run on whole tables.
        Check the spelling, or declare the function with `let`.
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
        A parameter is drawn `~ uniform()`, `~ normal(mean, deviation)`, `~ lognormal(median, deviation)` or
        from `~ values(a, b, b)`, always within its range. Values outside the range are never drawn, so no
        distribution needs to be cut off by hand. Without `~` the draw is uniform.
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
        A choice has the options that its type lists; this is none of them. Options are compared by name, so a
        misspelt one would never hold. Check the spelling, or add the option to the type.
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
        A label is written `vocabulary.word`. Vocabularies are declared in the file or come in by `use`. The
        shipped ones are in the module `vocabularies`: `use vocabularies { semantic, affordance }`.
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
        The words of a vocabulary are fixed, so that their numbers are the same in every data set. New words
        are added at the end of its declaration. Check the spelling, or take the word that is nearest in
        meaning.
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
        "absolute-tolerance",
        "a label compares with a fixed length",
        """
        A label is a formula that has to hold for every size a part may have. A band of 5 mm is half of a small
        knob and nothing of a large one, so that the same word means two things. Write a share of `size`, or
        name a parameter of the part, which changes with it. It is a warning: the program works.
        """,
        """
        apg 1
        use primitives { Cuboid }
        vocabulary affordance { support }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          label affordance.support on seat where p.z > size.z / 2 - 1mm
        }
        """,
    ),
    Code(
        "unknown-material",
        "there is no such material",
        """
        Materials are declared in the file (`material oak { ... }`) or come in by `use materials { oak }`. A
        part without a material has none of its own and takes that of the part around it. Check the spelling.
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
        "missing-material",
        "parts have no material",
        """
        Nothing says what a part is made of, so that its mass, friction and colour are guesses: 700 kg/m3, light
        grey. Write `material oak on body`; the parts within take it, too. `apgc check` warns of it, the program
        works.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          label semantic.seat on seat
        }
        """,
    ),
    Code(
        "missing-label",
        "surface has no semantic label",
        """
        Nothing says what a piece of surface is, in all objects or in some, so that its points are of class 0,
        `unlabelled`. Write `label semantic.seat on seat`; the parts within take it, too, and labels of their own
        stand over it. `apgc check` warns of it, the program works.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          part leg : Cuboid(size = [4cm, 4cm, 40cm])
          connect leg.top on seat.bottom
          label semantic.seat on seat
          material oak on seat, leg
        }
        """,
    ),
    Code(
        "duplicate-name",
        "a name is declared twice",
        """
        Parameters, parts, ports, surfaces and slots of one template share one namespace. One name may be
        declared in two branches that exclude each other (`when a { } else { }`). Otherwise it would depend on
        the place which one is meant. Rename one of the two.
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
        Types, constructors, built-in functions, the faces of a box, `size`, `center` and `box` keep their
        meaning everywhere and cannot be declared. A program would read differently in places where both could
        be meant. Choose another name: `front_edge`, `seat_size`. After a dot and as names of arguments such
        words are free.
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
        "something is defined by itself",
        """
        The chain of definitions shown comes back to its beginning, so that none of them has a value. This
        holds for `let`, for sizes of parts, for ranges, for places given by `to`, for attachments, for joints that
        hang on one another or follow one another, for roles and for templates that contain each other.
        Equations may run in circles (`align` solves them together),
        definitions may not. Give one of them a value of its own, or leave a size open with `_` and state an
        equation.
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
        "misplaced-statement",
        "a statement cannot stand here",
        """
        Roles declare, templates and categories build, primitives have surfaces: each takes statements of its
        own. A role has no parts because its alternatives bring them; a template has no `root` because its user
        decides what it hangs on. Move the statement to where it belongs.
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
        "`_` stands where nothing can be left open",
        """
        `_` leaves one component of a vector argument to be determined by equations: `Cuboid(size = [_, 2cm,
        _])`. It is no value and cannot be computed with. Leave the argument out altogether to leave all of it
        open. In formulas, name the value that is meant.
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
        The constructor or function cannot do without the arguments named. They have no sensible default, and
        guessing would hide a mistake. The help line gives the full form.
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
        The statement says too little: a `connect` needs `to`, `on`, `in` or `between`; a grasp needs `at`,
        `approach`, `close` and `opening`. A joint that turns needs an axis, and a range unless it is
        `continuous`. The help line names the clause.
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
        A role promises, a template gives: within a template a port is bound with `=`. A parameter of a
        category without a value needs a range to be drawn from. Write the value behind `=`, or move the
        declaration to a role.
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
        The number or the names of the arguments are not those that the function takes. Arguments are never
        ignored or made up. The message says what is expected.
        """,
        """
        apg 1
        template Stool {
          let a = sin(1deg, 2deg)
        }
        """,
    ),
)
