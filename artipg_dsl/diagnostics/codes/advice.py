"""Codes of what is legal and perhaps not meant."""

from .base import Code

ADVICE = (
    Code(
        "missing-label",
        "some surface has no semantic label",
        """
        Nothing says what some of the surface is, in all objects or in some, so its points have class 0, `unlabelled`.
        Write `label semantic.seat on seat`; the parts inside take it too, unless they have labels of their own. `apgc
        check` warns about this, but the program works.
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
        "missing-affordance",
        "no label says how to move a joint",
        """
        The program says by labels what hands do to its parts, but not for this joint: nothing that it carries, or that
        follows it, has a label other than what it is. A robot that learns from these objects would not try it. Label what a
        hand takes, pushes or turns. A joint that something else drives, as a wheel that the ground turns, may have a word of
        its own (`roll`), or follow the joint that drives it. Programs that say so of no joint get no warning.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic, affordance }
        category Chest {
          root part body : Cuboid(size = [30cm, 40cm, 20cm])
          part drawer : Cuboid(size = [20cm, 20cm, 10cm])
          align drawer.back = body.front + 1mm
          joint slide : prismatic body -> drawer along x range 0cm .. 10cm
          part lid : Cuboid(size = [30cm, 40cm, 2cm])
          align lid.bottom = body.top + 1mm
          align lid.back = body.back
          joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
          material oak on body, drawer, lid
          label semantic.body on body
          label semantic.drawer on drawer
          label semantic.lid on lid
          label affordance.pull on drawer.front
        }
        """,
    ),
    Code(
        "missing-stable",
        "objects tip over, and nothing requires that they stand",
        """
        Each of the few objects that `apgc check` draws tips over at rest. What it stands on has a label that says so:
        `foot`, `leg`, `base`, `stand`, `wheel` or `castor`. Without `require stable` such objects are delivered as
        they are, and fall in a simulator. Broaden what they stand on, and require that they stand. What is screwed
        down has a `flange` or a `bracket` instead; of tools and other things without such a label nothing is asked.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width : length in 30cm .. 50cm
          root part foot : Cuboid(size = [10cm, 10cm, 3cm])
          part seat : Cuboid(size = [30cm, width, 3cm])
          connect seat.bottom on foot.top
          align seat.back = foot.back
          material oak on foot, seat
          label semantic.foot on foot
          label semantic.seat on seat
        }
        """,
    ),
    Code(
        "missing-material",
        "parts have no material",
        """
        Nothing says what a part is made of, so its mass, friction and colour are guessed: 700 kg/m3, light grey. Write
        `material oak on body`; the parts inside take it too. `apgc check` warns about this, but the program works.
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
        "absolute-tolerance",
        "a label compares against a fixed length",
        """
        A label is a formula that must make sense for every size of a part. A band of 5 mm is half of a small knob but
        almost nothing of a large one, so the same word would mean two things. Write a fraction of `size`, or use a
        parameter of the part, which changes with it. This is a warning: the program works.
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
        "expensive-check",
        "checking an object takes long",
        """
        Collisions and stability are checked on convex pieces. If a part has thousands of pieces, or its pieces form
        hundreds of thousands of pairs with pieces of other links, checking each object takes seconds. With `require
        stable`, ten thousand pairs of primitives that may overlap take as long, because their common volume is counted
        only once. Typical causes are bars with many short bends, wire meshes and rings with many windings. `apgc
        profile NAME` lists parts by pieces and pairs. Use fewer pieces, or fewer bends; `--unchecked` skips the check.
        The program works as it is.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use vocabularies { semantic }
        use materials { oak }
        category Mat {
          root part base : Cuboid(size = [1m, 1m, 1cm])
          repeat row[i] in 0 ..< 40 spread base along x {
            repeat bristle[j] in 0 ..< 40 spread base along y {
              part hair : Cuboid(size = [2mm, 2mm, 2cm])
              connect hair.bottom on base.top
              align hair.center.x = row.center.x
              align hair.center.y = bristle.center.y
            }
          }
          label semantic.body on base, row.bristle.hair
          material oak on base, row.bristle.hair
        }
        """,
    ),
    Code(
        "odd-size",
        "objects are as large as a house, or as small as a grain",
        """
        Most of the few objects that `apgc check` draws are more than 20 m across, or less than 2 mm. Mostly a unit is
        wrong, as in `35m` for `35mm`, or a range has one end in another unit. The largest part is named. Correct the
        unit. If the size is meant, nothing is wrong: the check and the export work at any size up to 1 km.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30m, width, 3cm])
          material oak on seat
          label semantic.seat on seat
        }
        """,
    ),
    Code(
        "idle-press",
        "what is to be pressed can only move outwards",
        """
        In the few objects that `apgc check` draws, the joint rests at one end of its range, and from there it moves the
        labelled surface outwards: a key that lifts. Mostly the range has the wrong sign, or the label names the wrong
        face. Exchange the signs of the range, turn the axis round, or label the other face.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic, affordance }
        category Bell {
          param width : length in 5cm .. 9cm
          root part base : Cuboid(size = [9cm, width, 3cm])
          part button : Cuboid(size = [2cm, 2cm, 1cm])
          align button.bottom = base.top + 4mm
          joint ring : prismatic base -> button along z range 0mm .. 3mm
          material oak on base, button
          label semantic.base on base
          label semantic.button on button
          label affordance.press on button.top
        }
        """,
    ),
    Code(
        "far-axis",
        "a joint turns about an axis that nothing holds",
        """
        In each of the few objects that `apgc check` draws, the axis lies outside of the parent link, by more than 0.6 of
        how far the child reaches from the axis: a lid would turn about its free edge. An axis within a ring, or within
        the hull of several parts, is held by them, and what moves in a closed loop by others. Often the joint names the
        wrong edge, or the wrong parent. Two axes that a `close` keeps together are told if the links beside one another
        on that axis are a centimetre apart along it, or more.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Desk {
          param width : length in 30cm .. 50cm
          root part case : Cuboid(size = [30cm, width, 80cm])
          part flap : Cuboid(size = [20cm, case.size.y, 1cm])
          align flap.back = case.front + 1mm
          align flap.bottom = case.center.z
          joint open : revolute case -> flap about flap.front.top range -60deg .. 0deg
          material oak on case, flap
          label semantic.body on case
          label semantic.door on flap
        }
        """,
    ),
    Code(
        "unguided",
        "a drawer is pulled all the way out of what holds it",
        """
        In each of the few objects that `apgc check` draws, a link that is labelled `drawer` lies beside its parent link by
        more than half of its length at rest, and not at all at an end of its range: it would fall. Shorten the range.
        Caps and lids that are pulled or lifted off are not looked at.
        """,
        """
        apg 1
        use bodies { OpenBox }
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Nightstand {
          param width : length in 30cm .. 50cm
          root part body : OpenBox(size = [35cm, width, 20cm], wall = 12mm)
          part drawer : Cuboid
          joint pull : prismatic body -> drawer in body.inner gap 1mm along x range 0cm .. 40cm
          material oak on body, drawer
          label semantic.body on body
          label semantic.drawer on drawer
        }
        """,
    ),
    Code(
        "far-off",
        "a keypoint or a grasp lies far off its link",
        """
        In each of the few objects that `apgc check` draws, the place is farther from the box of the link that it is on
        than half of its size. Mostly a unit is wrong, as in `at [0, 0, 5m]`, or the place is measured from the wrong origin. `at` is
        measured from the middle of the part, port or slot that follows `on`, along its axes. Correct the place, or name
        what it is near.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Stool {
          param width : length in 30cm .. 50cm
          root part seat : Cuboid(size = [30cm, width, 3cm])
          material oak on seat
          label semantic.seat on seat
          keypoint middle on seat at [0, 0, 15m]
        }
        """,
    ),
    Code(
        "far-motion",
        "a joint moves much farther than its object is large",
        """
        In each of the few objects that `apgc check` draws, the joint slides more than three times as far as the object is
        large, or its range is more than two turns and written in degrees. Mostly a unit is wrong, as in
        `range 0 .. 30m`, or a range is made of the wrong value. What turns many times is measured in turns:
        `range 0turn .. 5turn`.
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
          align drawer.back = body.front + 1mm
          joint slide : prismatic body -> drawer along x range 0cm .. 20m
          material oak on body, drawer
          label semantic.body on body
          label semantic.drawer on drawer
        }
        """,
    ),
    Code(
        "wide-grasp",
        "no hand opens as wide as a grasp asks for",
        """
        In each of the few objects that `apgc check` draws, all grasps of this family open wider than the hand that they
        are meant for, the one of 8 cm unless the grasp states another. Only grasps that a hand can make are written, so
        the family is missing from every annotation. Grasp where the part is narrower, or state the hand.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { oak }
        use vocabularies { semantic }
        category Chest {
          param width : length in 30cm .. 50cm
          root part body : Cuboid(size = [30cm, width, 20cm])
          material oak on body
          label semantic.body on body
          grasp lift on body { at [0, 0, size.z / 2]  approach -z  close y  opening size.y }
        }
        """,
    ),
)
