"""Codes of structure: roles, attachments, equations, repeats, joints, primitives."""

from .base import Code

STRUCTURE = (
    Code("role-not-fulfilled", "a template does not bind what its role promises", """
        Every template of a role binds every slot, port, joint and output that the role declares without `?`. A part
        of a slot's name binds it by itself.
        """, """
        apg 1
        use primitives { Cuboid }
        role Lid { inherit size : length[3]  slot cover }
        template FlatLid : Lid { part plate : Cuboid(size = size) }
        """),
    Code("inherited-assigned", "a template assigns a value that its role hands in", """
        What a role inherits is given by the user of the role and kept when one template replaces another. A template
        reads it and does not declare it again.
        """, """
        apg 1
        use primitives { Cuboid }
        role Lid { inherit size : length[3]  inherit rim : length  slot cover }
        template FlatLid : Lid {
          param rim : length in 1mm .. 2mm
          part cover : Cuboid(size = size)
        }
        """),
    Code("wrong-role", "an alternative does not play the role", """
        Alternatives of a role are templates that declare it (`template BarHandle : Handle`).
        """, """
        apg 1
        use primitives { Cuboid }
        use handles { Handle, BarHandle }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part handle : Handle = BarHandle | Cuboid
          connect handle to body
        }
        """),
    Code("optional-outside-when", "an optional part is named where it may be absent", """
        A part with the alternative `none`, and what only some alternatives of a part have, may be missing. A statement
        goes with its own subject (the part left of `to`, the child of a joint, the target of a label); naming it
        anywhere else needs `when handle { ... }` or `when handle is BarHandle { ... }` around it.
        """, """
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
        """),
    Code("no-attachment", "a part hangs on nothing", """
        Equations place, they do not attach. In a category every part but the root is attached exactly once, by
        `connect` (rigid) or `joint` (movable), whatever alternatives and guards are chosen.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          align lid.bottom = body.top
        }
        """),
    Code("two-attachments", "a part is attached twice", """
        A part has one parent. Further contacts are equations (`align`); a loop of joints is closed with `close`.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid to body
          joint open : revolute body -> lid about lid.back.bottom range 0deg .. 90deg
        }
        """),
    Code("no-root", "a category has no root part", """
        The part marked `root` is what all others hang on; its frame is the object's.
        """, """
        apg 1
        category Chest {
          param width : length in 30cm .. 60cm
        }
        """),
    Code("two-roots", "a category has two root parts", """
        The part marked `root` is what all others hang on, so there is one.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          root part base : Cuboid(size = [40cm, 60cm, 3cm])
        }
        """),
    Code("circular", "something depends on itself", """
        The place, the attachment or the template of a part leads back to the part itself.
        """),
    Code("two-links", "something lies on two links at once", """
        A port, plane or edge lies on the link of the parts that its formula names. These move against each other, so
        it would lie on both.
        """, """
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
          connect knob to pair.mid
        }
        """),
    Code("under-determined", "nothing determines a value", """
        A parameter without a range has to be given by its user or follow from equations. This one is neither: give it
        a range, an argument, or one equation more.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, _, 30cm])
        }
        """),
    Code("over-determined", "there is an equation too many", """
        All that this equation names is already determined by others and by arguments, so it could only repeat or
        contradict them.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          param rise : length in 1cm .. 9cm
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid.bottom on body.top
          align lid.top = body.top + rise
        }
        """),
    Code("tie", "two parameters could yield and nothing says which", """
        An equation determines one of the parameters that it names, and by the order of who yields two are equal.
        Mark one as `derived`, or give one as an argument.
        """, """
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
        """),
    Code("too-many-cases", "the guards of equations combine in too many ways", """
        Who determines whom is found once for every combination of guards and alternatives within a block of equations,
        at most 64. Move part of what they place into a template or a repeat, whose inside is a block of its own.
        """),
    Code("recurrence", "a value that needs itself cannot be computed", """
        Through `previous` an element's value may follow from that of the element before it, and from nothing else of
        its own.
        """),
    Code("not-solvable", "equations cannot be solved in closed form", """
        The equation determines something that it holds in a way which cannot be turned round. State it the other way
        about, or name the unknown alone on one side.
        """, """
        apg 1
        use primitives { Cuboid }
        template Slab {
          param wide : length
          part plate : Cuboid(size = [10cm, wide, 1cm])
        }
        category Shelf {
          root part body : Cuboid(size = [30cm, 60cm, 90cm])
          part one : Slab
          connect one to body
          align one.wide + 10cm * sin(one.wide / 1cm * 1rad) = body.size.y
        }
        """),
    Code("redundant", "an equation follows from others", """
        The equation holds already because of others. It does no harm and can go.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid.bottom on body.top
          align lid.bottom = body.top
        }
        """),
    Code("contradictory", "equations contradict one another", """
        No values satisfy all of the equations shown.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid.bottom on body.top
          align lid.bottom = body.top + 1cm
        }
        """),
    Code("plane-across-axes", "a plane is used across another axis", """
        A face is a plane across one axis, and an equation of planes compares coordinates along one: left with right,
        top with bottom. A turned part has no coordinate planes in its neighbours' frame; equate points, or read its
        extent with `lowest(part, -z)`.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          part lid : Cuboid(size = [40cm, 60cm, 2cm])
          connect lid to body
          align lid.bottom = body.front
        }
        """),
    Code("no-own-box", "a template names faces of a box that it derives from its parts", """
        A template either takes `size`, then its own box and faces are given, or derives its box from its parts, then
        the box is read from outside only. A category's box is derived.
        """, """
        apg 1
        use primitives { Cuboid }
        category Chest {
          root part body : Cuboid(size = [40cm, 60cm, 30cm])
          align body.left = left
        }
        """),
    Code("many-elements", "a path names many elements where one is needed", """
        From outside, the name of a repeat stands for all its elements. Take one (`row[last]`, `row[0]`), reduce them
        (`sum(row.size.z)`, `max(...)`), or state it within the repeat.
        """, """
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
        """),
    Code("needs-index", "a path names many elements where one is needed", """
        The port has several elements, and this names none of them: write `base.tap[k]`.
        """),
    Code("unrelated-rows", "values of unrelated repeats or alternatives are mixed", """
        A formula can use values of its own repeat and of those around it. Elements of two repeats side by side have
        nothing to do with each other.
        """),
    Code("bad-axis", "a joint or repeat has no valid axis", """
        A joint that turns does so about an edge or a line (`about door.left.back`, `about dial.axis`); a direction
        alone does not say where. A prismatic joint slides along a direction. A ring turns about an axis, a mirror
        stands across x, y or z.
        """, """
        apg 1
        use primitives { Cuboid }
        template Hinged {
          part post : Cuboid(size = [1cm, 1cm, 1cm])
          part leaf : Cuboid(size = [1cm, 9cm, 9cm])
          joint open : revolute post -> leaf about z range 0deg .. 90deg
        }
        """),
    Code("needs-clearance", "a limit needs collision checking", """
        `clearance` as the end of a range is the largest value without a collision, which has no closed form here.
        """),
    Code("incomplete-primitive", "a primitive lacks surfaces, inside or box", """
        A primitive states its surfaces, an inside function and its box, or one `solid` that supplies all three.
        """, """
        apg 1
        primitive Sheet {
          param wide : length > 0  test 1cm .. 1m
          surface top (u in 0 .. 1, v in 0 .. 1) = [u * wide, v * wide, 0mm]
        }
        """),
    Code("broken-chain", "curves of a chain do not meet end to end", """
        Each curve of a chain begins where the one before it ends, for every test value of the primitive.
        """),
    Code("bad-curve", "a curve cannot make this solid", """
        The operator needs a curve with a value everywhere: for `lathe` [radius, height] with a radius of at least 0,
        for every test value of the primitive.
        """),
    Code("leaky-primitive", "the surfaces of a primitive do not close", """
        The surfaces of a primitive meet along whole edges and enclose its inside, all normals outwards, for every one
        of its test values. The place shown is a surface with an edge that meets no other.
        """),
)  # fmt: skip
