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
        "a mount turns a part away from its `along`",
        """
        A part that lies `along` an axis has faces of the scope: of a cylinder `along y`, `bottom` is a place on its side.
        Mounted by a face, with `to` or by two faces of a joint, it is turned until that face meets the other, so that it
        comes to lie along another axis than is written. Mount the face that meets the other already, or leave `along` out:
        then `bottom` is the end of the cylinder.
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
        "colliding-links",
        "two links overlap in every object",
        """
        `apgc check` draws a few objects and compares the solids of their links with all joints at rest. In each of them
        these two links overlap, so no object would be valid and `apgc sample` would stop. Often a face is aligned with
        the wrong one, or nothing places a part, so that it is centred. Leave a gap, or allow the overlap and give the
        reason. Where nothing overlaps at rest, each joint moves through its range, with the others at rest; links that
        then collide in every object are told at the joint. Often its axis points the wrong way, or its range has the
        wrong sign. `apgc validate` reports links that collide in some objects.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Chest {
          param width : length in 30cm .. 50cm
          root part body : Cuboid(size = [30cm, width, 20cm])
          part lid : Cuboid(size = [30cm, body.size.y, 2cm])
          align lid.back = body.back
          align lid.left = body.left
          align lid.top = body.top
          joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
          material oak on body, lid
          label semantic.body on body
          label semantic.door on lid
        }
        """,
    ),
    Code(
        "never-valid",
        "every object has the same fault",
        """
        `apgc check` draws a few objects. Nothing is near enough to hold a link in any of them, or a loop of joints does
        not close, or a `clear` does not hold, or a joint rests outside its range, so no object would be valid and
        `apgc sample` would stop. Often a face is aligned with the wrong one, or a distance in `close` differs from the one
        that places the part.
        `apgc render --unchecked` shows the objects as they are, `apgc validate` all that is wrong with them.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Chest {
          param width : length in 30cm .. 50cm
          root part body : Cuboid(size = [30cm, width, 20cm])
          part drawer : Cuboid(size = [20cm, 20cm, 10cm])
          align drawer.back = body.front + 5cm
          joint slide : prismatic body -> drawer along x range 0cm .. 10cm
          material oak on body, drawer
          label semantic.body on body
          label semantic.drawer on drawer
        }
        """,
    ),
    Code(
        "rarely-valid",
        "half of the objects or more are invalid",
        """
        `apgc check` draws eight objects. At least four of them are invalid, though not all for one and the same reason, or
        they tip over at rest. Told is what fails most, with an example. Often a length that is right for large objects is
        too much for small ones, or one range is to be narrowed by another with `require`; a foot may be too narrow for what
        it carries. `apgc validate` looks at more objects and counts all that fails, and `apgc render --unchecked` draws
        them as they are.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Chest {
          param gap : length in -4cm .. 1cm
          root part body : Cuboid(size = [30cm, 40cm, 20cm])
          part drawer : Cuboid(size = [20cm, 20cm, 10cm])
          align drawer.back = body.front + gap
          joint slide : prismatic body -> drawer along x range 0cm .. 10cm
          material oak on body, drawer
          label semantic.body on body
          label semantic.drawer on drawer
        }
        """,
    ),
    Code(
        "floating-part",
        "a part touches nothing else of its link",
        """
        In each of the few objects that `apgc check` draws, the part touches nothing else of its rigid link, so none of
        them is valid and `apgc sample` has nothing to deliver. Often an equation names the wrong part, a sign is wrong,
        or nothing places the part, so that it is centred. Or it is attached to something that does not move with what
        it touches: the message names the link that it is on, and `apgc ledger` why. Place it on the part that carries
        it; if the carrier is not modelled, write `allow floating lid because "a glass rod"`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          part leg : Cuboid(size = [3cm, 3cm, 40cm])
          align leg.top = seat.bottom - 5cm
          connect leg to seat
          material oak on seat, leg
          label semantic.seat on seat, leg
        }
        """,
    ),
    Code(
        "coincident",
        "elements of a repeat stand in the same place",
        """
        In each of the few objects that `apgc check` draws, two elements of a repeat fill the same space, so that they look
        like one, but count and weigh twice. Often no equation places the part by the element: without one it is centred on
        the box of the element along each axis, and a `repeat` without a form, or one that lies along another axis, has the
        same box for all. In a `ring` or a `mirror`, what stands on the axis or in the plane is its own image. Place it by
        the box of the element, by its index or by a value that each element draws, or move it out of the repeat.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 3cm])
          repeat row[i] in 0 ..< 4 {
            part leg : Cuboid(size = [3cm, 3cm, 40cm])
            connect leg.top on seat.bottom
          }
          material oak on seat, row.leg
          label semantic.seat on seat, row.leg
        }
        """,
    ),
    Code(
        "buried",
        "a part lies inside another one",
        """
        In each of the few objects that `apgc check` draws, the part, or an element of a repeat, lies inside another part of
        its link. Nothing of it is seen, no point lies on it, its labels say nothing, and its mass changes nothing. Often
        nothing places the part along one axis, so that it is centred, or a sign is wrong. A `mirror` is across the plane
        through the origin of what it stands in: of a part that is off that plane, the second half does not stand on the
        other side of the part. Place it on the surface, or leave it out.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 30cm, 30cm])
          part knob : Cuboid(size = [3cm, 3cm, 3cm])
          connect knob to seat
          align knob.left = seat.left
          material oak on seat, knob
          label semantic.seat on seat, knob
        }
        """,
    ),
    Code(
        "bad-symmetry",
        "a part does not have the symmetry that is stated",
        """
        `symmetry body : turn 4 about z`, or `any about z`, says that the part looks the same after a quarter turn, so its
        box must be as long as it is wide; with `turn 3`, `turn 5` or `turn 6` the two may differ as those of a triangle, a
        pentagon or a hexagon do. In each of the few objects that `apgc check` draws they differ by more. The axes are those
        of the part itself, which `along` and a port turn with it. Training code takes such turns for equal poses. Write
        `turn 2` for an oblong part, or name the part of it that is round.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          root part seat : Cuboid(size = [30cm, 40cm, 3cm])
          symmetry seat : turn 4 about z
          material oak on seat
          label semantic.seat on seat
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
