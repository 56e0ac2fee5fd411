"""Codes of equations: who is determined by what, planes, repeats and their elements."""

from .base import Code

EQUATIONS = (
    Code(
        "unplaced",
        "nothing places a part",
        """
        No equation and no `connect` with faces or frames places the part along any axis, so it is centred in its
        surroundings: right for a core, surprising for most parts. `connect lid to body` with bare names only attaches.
        Place the part, or state that it is meant to be centred: `align lid.center = body.center`. `apgc check` warns
        about this, but the program works.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          part leg : Cuboid(size = [3cm, 3cm, 40cm])
          connect leg to seat
          material oak on seat, leg
          label semantic.seat on seat, leg
        }
        """,
    ),
    Code(
        "turned-again",
        "a part is turned farther than is written",
        """
        A part that lies `along` an axis has faces of the scope: of a cylinder `along y`, `bottom` is a place on its side.
        Mounted by a face, with `to` or by two faces of a joint, it is turned until that face meets the other, so that it
        comes to lie along another axis than is written. Mount the face that meets the other already, or leave `along` out:
        then `bottom` is the end of the cylinder. In a `ring`, `turned k * 1turn / n` turns each element once more as the ring
        turns it already: leave it out.
        """,
        """
        apg 1
        use primitives { Cuboid, Cylinder }
        use materials { oak }
        use vocabularies { semantic }
        category Churn {
          root part body : Cuboid(size = [30cm, 30cm, 40cm])
          part hub : Cylinder(radius = 3cm, height = 5cm) along y
          joint turn : continuous body.left -> hub.bottom gap 1mm
          material oak on body, hub
          label semantic.body on body
          label semantic.axle on hub
        }
        """,
    ),
    Code(
        "under-determined",
        "nothing determines a value",
        """
        A parameter without a range must be given as an argument or follow from equations. This one has neither: give it
        a range, an argument, or one more equation. Sizes are never guessed. A `_` in an argument leaves a size to the
        equations; opposite faces (`left` and `right`) determine the size between them.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, _, 30cm])
        }
        """,
    ),
    Code(
        "over-determined",
        "there is one equation too many",
        """
        Everything that this equation names is already determined by other equations and arguments, so it could only
        repeat or contradict them. An equation determines positions first, then sizes left open, then parameters of the
        part's template; the lines shown say what determines what it names. Parameters of the scope itself yield only if
        they are marked `derived`. Drop an equation, leave a size open, or mark the parameter.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          param rise : length in 1cm .. 9cm
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid.bottom on body.top
          align lid.top = body.top + rise
        }
        """,
    ),
    Code(
        "tie",
        "an equation could determine either of two parameters",
        """
        An equation determines one of the parameters that it names, and here two are equally suitable. Mark one as
        `derived`, or pass one as an argument. The choice must not depend on the order of the lines, so the language
        does not make it.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Slab {
          param wide : length in 1cm .. 90cm
          part plate : Cuboid(size = [10cm, wide, 1cm])
        }
        category Shelf {
          root part body : Cuboid(size = [30cm, 60cm, 90cm])
          part one : Slab
          part two : Slab
          connect one to body
          connect two to body
          align one.wide + two.wide = body.size.y
        }
        """,
    ),
    Code(
        "too-many-cases",
        "the guards of equations combine in too many ways",
        """
        Which equation determines which value is decided for each combination of guards and alternatives within a block
        of equations, at most 64. Move some of the parts that they place into a template or a repeat, which is a block
        of its own. Guards that exclude each other (`when a { } else { }`) make fewer combinations than independent
        ones.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [30cm, 60cm, 90cm])
          count a in 0 .. 1
          count b in 0 .. 1
          count c in 0 .. 1
          count d in 0 .. 1
          count e in 0 .. 1
          count f in 0 .. 1
          count g in 0 .. 1
          part lid : Cuboid(size = [30cm, 60cm, _])
          connect lid to body
          when a == 1 { align lid.top = body.top + 1cm }
          when b == 1 { align lid.top = body.top + 2cm }
          when c == 1 { align lid.top = body.top + 3cm }
          when d == 1 { align lid.top = body.top + 4cm }
          when e == 1 { align lid.top = body.top + 5cm }
          when f == 1 { align lid.top = body.top + 6cm }
          when g == 1 { align lid.top = body.top + 7cm }
        }
        """,
    ),
    Code(
        "recurrence",
        "a value depends on itself",
        """
        With `previous`, a value of an element may depend on the same value of the element before it, but only as a sum:
        `x = previous.x + d`. Sums are computed for all elements at once, while anything else would need a loop over
        elements. Write the value in terms of the element's index: `1cm * 1.1 ^ i`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Stair {
          root part body : Cuboid(size = [30cm, 60cm, 2cm])
          repeat step[i] in 0 ..< 4 {
            part board : Cuboid(size = [2cm, 2cm, _])
            connect board to body
            when i == 0 { align board.size.z = 1cm } else { align board.size.z = 1cm + 1.1 * previous.board.size.z }
          }
        }
        """,
    ),
    Code(
        "not-solvable",
        "equations cannot be solved",
        """
        Equations are solved symbolically where each unknown has a formula, and by a search (Newton's method) where
        several are coupled nonlinearly. Neither is possible when an unknown is read through another table in a way that
        is not linear: squared inside a repeat, and then summed. State such an equation inside the repeat. Equations
        that only place two parts relative to each other leave open where the two are together. Relate one of them to
        something already placed.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Shelf {
          root part body : Cuboid(size = [30cm, 60cm, 90cm])
          param edge : length in 1cm .. 9cm derived
          repeat row[i] in 0 ..< 3 split body along z {
            let area = edge * edge * (1 + i)
            part board : Cuboid
            connect board in row
          }
          align sum(row.area) = body.size.x * body.size.y
        }
        """,
    ),
    Code(
        "redundant",
        "an equation follows from others",
        """
        The equation already follows from others. It does no harm and can be dropped. This is a warning: the program
        works. But one of the two may have been meant for another face, or another part.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid.bottom on body.top
          align lid.bottom = body.top
        }
        """,
    ),
    Code(
        "contradictory",
        "equations contradict one another",
        """
        No values satisfy all of the equations shown. The message says by how much the two sides differ, which often
        shows what was forgotten: a thickness, a gap, a sign. `gap` is measured along the outward normal of the face
        after `on`, so it goes down from a bottom face. Drop or correct one of them.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid.bottom on body.top
          align lid.bottom = body.top + 1cm
        }
        """,
    ),
    Code(
        "plane-across-axes",
        "a plane is used across another axis",
        """
        A face is a plane across one axis, and an equation of planes compares coordinates along one: left with
        right, top with bottom. A turned part has no coordinate planes in its neighbours' frame; equate points,
        or read its extent with `lowest(part, -z)`. `front` and `back` are planes across x, `left` and `right`
        across y, `top` and `bottom` across z.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid to body
          align lid.bottom = body.front
        }
        """,
    ),
    Code(
        "no-own-box",
        "a template names faces of a box that it derives from its parts",
        """
        Either a template takes `size`, and its own box and faces are given, or its box is derived from its parts and
        can only be read from outside: the box would otherwise depend on parts that depend on the box. The box of a
        category is always derived. Give the template `param size : length[3]`, or name a face of one of its parts:
        `seat.left`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          align body.left = left
        }
        """,
    ),
    Code(
        "many-elements",
        "a path names many elements where one is needed",
        """
        From outside, the name of a repeat means all its elements. Take one (`row[last]`, `row[0]`), reduce them
        (`sum(row.size.z)`, `max(...)`), or move the statement into the repeat. The same applies to a port with several
        values: `base.tap[k]`. Which element is meant is never guessed.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Shelf {
          root part body : Cuboid(size = [30cm, 60cm, 90cm])
          repeat row[i] in 0 ..< 3 split body along z gap 2cm {
            part board : Cuboid(size = [_, _, 2cm])
            connect board in row
          }
          part hook : Cuboid(size = [1cm, 1cm, 1cm])
          connect hook to body
          align hook.top = row.board.bottom
        }
        """,
    ),
    Code(
        "unrelated-rows",
        "values of unrelated repeats or alternatives are mixed",
        """
        A formula can use values of its own repeat and of the repeats around it. The elements of two separate repeats
        are unrelated. The same applies to two alternatives of one part, since an object has only one of them. Move it
        into the repeat or template that contains both values, or reduce one side with `sum`, `min` or `max`. There is
        no short example: most such places are reported as `many-elements` or `optional-outside-when`.
        """,
    ),
)
