"""Codes of objects: what is wrong with the few that `apgc check` draws."""

from .base import Code

EXAMPLES = (
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
        "touching-links",
        "two links touch where one moves on the other",
        """
        In each of the few objects that `apgc check` draws, flat faces of two links touch with all joints at rest, and
        a joint moves one along the other. Nothing overlaps, so the objects are valid; but the two surfaces flicker in
        pictures, and in simulators such links rub, stick or jump. Leave a gap of 0.2 mm or more: the joint takes
        `gap 0.5mm` behind its faces, an `align` a `+ 0.5mm`. A face that its joint lifts off, as that of a lid on its
        rim, may touch.
        """,
        """
        apg 1
        use primitives { Cuboid, Cylinder }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width : length in 30cm .. 50cm
          root part base : Cuboid(size = [30cm, width, 20cm])
          part seat : Cylinder(radius = 15cm, height = 3cm)
          joint turn : continuous base.top -> seat.bottom
          material oak on base, seat
          label semantic.base on base
          label semantic.seat on seat
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
)
