"""Codes of structure: roles, attachments, links, joints."""

from .base import Code

STRUCTURE = (
    Code(
        "role-not-fulfilled",
        "a template does not bind everything its role requires",
        """
        Every template of a role must bind each slot, port, joint and output that the role declares without `?`. A part
        with the name of a slot binds it automatically. The users of a role rely on all of it, whichever alternative is
        drawn. Bind it (`slot cover = plate`, `port mount = ...`), or mark it optional in the role: `slot cover ?`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        role Lid { inherit size : length[3]  slot cover }
        template FlatLid : Lid { part plate : Cuboid(size = size) }
        """,
    ),
    Code(
        "inherited-assigned",
        "a template declares a value that its role passes in",
        """
        A value with `inherit` is given by the user of the role and kept when one template replaces another. A template
        reads it and must not declare it again: the two values could differ. Remove the declaration and read the name.
        """,
        """
        apg 1
        use primitives { Cuboid }
        role Lid { inherit size : length[3]  inherit rim : length  slot cover }
        template FlatLid : Lid {
          param rim : length in 1mm .. 2mm
          part cover : Cuboid(size = size)
        }
        """,
    ),
    Code(
        "wrong-role",
        "an alternative does not play the role",
        """
        Alternatives of a role are templates that declare it (`template BarHandle : Handle`). Only then do they have the
        ports and slots that other statements use. Add `: Handle` to the template and bind what the role requires, or
        remove the template from the list.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use handles { Handle, BarHandle }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part handle : Handle = BarHandle | Cuboid
          connect handle to body
        }
        """,
    ),
    Code(
        "optional-outside-when",
        "an optional part is used where it may be absent",
        """
        A part with the alternative `none`, or a member that only some alternatives have, may be absent. A statement
        disappears together with its own subject (the part on the left of a `connect` or an `align`, the child of a joint,
        the target of a label); using the part anywhere else needs `when handle { ... }` or `when handle is BarHandle { ... }` around it. This
        is required because one program describes all objects, including those without the part.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use handles { Handle, BarHandle }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part handle : Handle = BarHandle | none
          connect handle.mount to body.front at center
          part badge : Cuboid(size = [1mm, 3cm, 1cm])
          connect badge.back on body.front at z = handle.top + 1cm, y = body.center.y
        }
        """,
    ),
    Code(
        "no-attachment",
        "a part is not attached",
        """
        Equations place parts but do not attach them. In a category, every part except the root is attached exactly
        once, by `connect` (rigid) or `joint` (movable), whatever alternatives and guards are chosen. The attachment
        says which link carries the part when joints move. Write `connect lid to body`, or give it a joint.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          align lid.bottom = body.top
        }
        """,
    ),
    Code(
        "two-attachments",
        "a part is attached twice",
        """
        A part has one parent. Further contacts are equations (`align`); a loop of joints is closed with `close`. Links
        form a tree, as simulators expect. Keep the attachment that carries the part and turn the other one into
        equations.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid to body
          joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
        }
        """,
    ),
    Code(
        "no-root",
        "a category has no root part",
        """
        The part marked `root` is the one that all others are attached to, so every category needs one. Its frame is the
        frame of the object, and its link is the base of every exported file. Write `root` before the part that does not
        move.
        """,
        """
        apg 1
        category Chest {
          param width : length in 30cm .. 60cm
        }
        """,
    ),
    Code(
        "two-roots",
        "a category has two root parts",
        """
        The part marked `root` is the one that all others are attached to, so there can be only one. Its link is the
        base of every exported file. Remove the word from all but one, and attach the others to it with `connect`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          root part base : Cuboid(size = [40cm, 60cm, 3cm])
        }
        """,
    ),
    Code(
        "two-links",
        "something is on two links at once",
        """
        A port, plane or edge belongs to the link of the parts that its formula names. These parts move relative to each
        other, so it would belong to two links, but what is connected there can only follow one. Name a face or a port
        of only one of the parts.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Pair {
          part one : Cuboid(size = [1cm, 1cm, 1cm])
          part two : Cuboid(size = [1cm, 1cm, 1cm])
          joint slide : prismatic one -> two along x range 0cm .. 1cm
          port mid : frame = frame(at = [one.front, two.center.y, two.center.z], out = x, up = z)
        }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part pair : Pair
          connect pair to body
          part knob : Cuboid(size = [1cm, 1cm, 1cm])
          connect knob.bottom to pair.mid
        }
        """,
    ),
    Code(
        "bad-axis",
        "a joint or repeat has no valid axis",
        """
        A joint that turns does so about an edge or a line (`about door.left.back`, `about dial.axis`); a direction
        alone does not say where the axis lies. A prismatic joint slides along a direction. A ring runs around an axis,
        a mirror is across x, y or z. The axis decides how the joint moves and which side opens, so it is always stated.
        Two faces of a box meet in an edge: `door.left.back`.
        """,
        """
        apg 1
        use primitives { Cuboid }
        template Hinged {
          part post : Cuboid(size = [1cm, 1cm, 1cm])
          part leaf : Cuboid(size = [1cm, 9cm, 9cm])
          joint open : revolute post -> leaf about z range 0deg .. 90deg
        }
        """,
    ),
    Code(
        "bad-gate",
        "a joint waits for something other than the value of a joint",
        """
        `when` after a joint says how far other joints must be open before it can move: each is compared with a value in
        its own unit (`when door.open > 80deg`), and several are joined by `and`. The joints must be independent:
        neither the one that waits nor the one it waits for may follow another by `mimic`, and the object must have no
        closed loop. For conditions on choices and counts, use a `when` with a block.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Oven {
          root part body : Cuboid(size = [30cm, 60cm, 40cm])
          part rack : Cuboid(size = [20cm, 40cm, 1cm])
          align rack.bottom = body.top + 1mm
          joint slide : prismatic body -> rack along x range 0 .. 10cm when body.size.x > 20cm
        }
        """,
    ),
    Code(
        "bad-mimic",
        "a joint cannot follow another in this way",
        """
        A joint follows another by a factor and an offset (`mimic -2 * turn + 10deg`) or by any formula of its value
        that rises or falls throughout its range (`mimic 2cm * sin(turn)`). Such a formula needs a leader that moves
        independently; no other joint can follow the follower, and the object must have no closed loop. Write the
        formula in terms of the joint that leads the chain, or, for a linkage, close a loop of joints with `close`.
        A follower that is taken out of its own range is a warning: checks and views go there, while simulators hold it
        within. So is one that is taken through one half of it alone: then a wrong sign would not be told.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Press {
          root part body : Cuboid(size = [9cm, 9cm, 9cm])
          part lever : Cuboid(size = [9cm, 1cm, 1cm])
          joint turn : revolute body.top -> lever.bottom at center about y range 0deg .. 60deg
          part ram : Cuboid(size = [1cm, 1cm, 9cm])
          joint sink : prismatic body.left -> ram.right at center along -z range 0cm .. 3cm mimic 3cm * sin(turn)
          part mark : Cuboid(size = [1cm, 1cm, 1cm])
          joint point : prismatic body.right -> mark.left at center along z range 0cm .. 3cm mimic sink
        }
        """,
    ),
    Code(
        "rigid-loop",
        "no joint on a closed loop can move",
        """
        A closed loop takes degrees of freedom from its joints: two, if all axes are parallel. A triangle of two joints
        and the hinge that `close` states has none left: its joints are written to files, but none of them moves. A
        linkage of four bars has one.
        """,
        """
        apg 1
        use primitives { Cuboid }
        use materials { steel }
        vocabulary semantic { frame }
        category Frame {
          root part base : Cuboid(size = [20cm, 2cm, 2cm])
          part post : Cuboid(size = [1cm, 1cm, 15cm])
          align post.bottom = base.top - 1cm
          align post.right = base.left + 1mm
          joint lean : revolute base -> post about line(at = post.bottom.center + [0mm, 0mm, 1cm], along = y) range -60deg .. 60deg
          part brace : Cuboid(size = [20cm, 1cm, 1cm])
          align brace.right = post.left + 1mm
          align brace.top = post.top
          joint tilt : revolute post -> brace about line(at = post.top.center - [0mm, 0mm, 1cm], along = y) range -60deg .. 60deg
          close line(at = brace.front.center, along = y) on line(at = base.front.center + [0cm, 0mm, 14.5cm], along = y)
          label semantic.frame on base, post, brace
          material steel on base, post, brace
        }
        """,
    ),
    Code(
        "needs-clearance",
        "`clearance` cannot be computed here",
        """
        `clearance` as the high end of a range asks for the largest value without a collision. It can be found for
        revolute and prismatic joints that move independently, but not as the low end, nor for joints that follow others
        or are followed, nor in programs with closed loops. The program is legal and can be checked, but not sampled.
        Reverse the axis, or write the end as a formula of the sizes, or as a plain angle or length.
        """,
        """
        apg 1
        use primitives { Cuboid }
        category Box {
          root part body : Cuboid(size = [30cm, 60cm, 40cm])
          part lid : Cuboid(size = [30cm, 60cm, 2cm])
          align lid.bottom = body.top + 1mm
          joint open : revolute body -> lid about lid.back.bottom range clearance .. 90deg
        }
        """,
    ),
    Code(
        "open-count",
        "an indexed surface may have any number of copies",
        """
        The surfaces of a primitive must be known when it is compiled, so that their seams can be matched. A number of
        copies that differs between objects needs a maximum, of at most 64. Use a parameter of type `count` with a
        domain, or a formula of such parameters.
        """,
        """
        apg 1
        primitive Fan {
          param blades : count
          param reach : length > 0  test 1cm .. 1m
          let at(i) = i / blades * 360deg
          surface blade[i in 0 ..< blades] (u in 0 .. 1, v in 0 .. 1) = [u * reach * cos(at(i)), u * reach * sin(at(i)), v * reach]
          inside (p) = hypot(p.x, p.y) - reach
          box = [2 * reach, 2 * reach, reach]
        }
        category Ventilator { root part fan : Fan(blades = 3, reach = 10cm) }
        """,
    ),
)
