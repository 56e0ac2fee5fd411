"""Codes of primitives and curves."""

from .base import Code

SOLIDS = (
    Code(
        "incomplete-primitive",
        "a primitive has no surfaces, inside function or box",
        """
        A primitive gives its surfaces, an inside function and its box, or one `solid` that supplies all three. The
        mesh, the points and the colliders all come from these three, so none can be left out. Add what the message
        names.
        """,
        """
        apg 1
        primitive Sheet {
          param wide : length > 0  test 1cm .. 1m
          surface top (u in 0 .. 1, v in 0 .. 1) = [u * wide, v * wide, 0mm]
        }
        """,
    ),
    Code(
        "broken-chain",
        "curves of a chain do not meet end to end",
        """
        Each curve of a chain must begin where the one before it ends, for every test value of the primitive. Otherwise
        the surface made from them would have a gap. An outer and an inner chain must have the same number of curves.
        Use the same formula at both ends.
        """,
        """
        apg 1
        primitive Bowl {
          param radius : length > 0  test 1cm .. 2cm
          curve foot (v in 0 .. 1) = [v * radius, 0cm]
          curve skin (v in 0 .. 1) = [2 * radius, v * 10cm]
          solid = lathe([foot, skin]) about z
        }
        category Dish { root part bowl : Bowl(radius = 1cm) }
        """,
    ),
    Code(
        "bad-curve",
        "a curve cannot make this solid",
        """
        The operator needs a curve that has a value everywhere: `lathe` needs [radius, height] with a radius of at least
        0, for every test value of the primitive. A formula that fails for some sizes would give broken meshes only now
        and then, so it is tried beforehand. Narrow the ranges after `test`, add a `require` to the primitive, or clip
        the formula with `max`.
        """,
        """
        apg 1
        primitive Bowl {
          param radius : length > 0  test 1cm .. 2cm
          curve skin (v in 0 .. 1) = [radius - v * 3cm, v * 10cm]
          solid = lathe(skin) about z
        }
        category Dish { root part bowl : Bowl(radius = 5cm) }
        """,
    ),
    Code(
        "missing-pieces",
        "convex pieces miss part of a primitive",
        """
        Contacts are computed from the convex pieces, so other parts could penetrate a solid that its `piece` statements
        cover only partly. It is an error if, at one of the test values, some place within the solid is farther than a
        tenth of its size from all pieces, and a warning if it is farther than a twentieth. The place shown is the
        farthest one. A thin gap at a curved surface is fine. A piece that reaches out of the solid by a twentieth of
        its size also gives a warning, and so does the hull of a concave primitive that has no pieces.
        """,
        """
        apg 1
        primitive Bar {
          param long : length > 0  test 5cm .. 20cm
          surface front  (u in 0 .. 1, v in 0 .. 1) = [1cm, (2 * u - 1) * 1cm, v * long]
          surface rear   (u in 0 .. 1, v in 0 .. 1) = [-1cm, (1 - 2 * u) * 1cm, v * long]
          surface right  (u in 0 .. 1, v in 0 .. 1) = [(2 * u - 1) * 1cm, -1cm, v * long]
          surface left   (u in 0 .. 1, v in 0 .. 1) = [(1 - 2 * u) * 1cm, 1cm, v * long]
          surface top    (u in 0 .. 1, v in 0 .. 1) = [(2 * u - 1) * 1cm, (2 * v - 1) * 1cm, long]
          surface bottom (u in 0 .. 1, v in 0 .. 1) = [(2 * u - 1) * 1cm, (1 - 2 * v) * 1cm, 0]
          inside (p) = max(abs(p.x) - 1cm, abs(p.y) - 1cm, -p.z, p.z - long)
          box = [-1cm, -1cm, 0] .. [1cm, 1cm, long]
          piece foot = hull([-1cm, -1cm, 0], [1cm, -1cm, 0], [1cm, 1cm, 0], [-1cm, 1cm, 0],
            [-1cm, -1cm, long / 4], [1cm, -1cm, long / 4], [1cm, 1cm, long / 4], [-1cm, 1cm, long / 4])
        }
        category Post { root part bar : Bar(long = 10cm) }
        """,
    ),
    Code(
        "leaky-primitive",
        "the surfaces of a primitive do not close",
        """
        The surfaces of a primitive must meet along whole edges and enclose its inside, with all normals pointing
        outwards, for every one of its test values. Otherwise the mesh, which is made from these formulas alone, would
        not be watertight. The place shown is a surface with an edge that meets no other. Compare the formulas of the
        two surfaces at that edge, and the signs and ranges of u and v. A stated box must be that of the surfaces,
        because parts are placed by it. A stated inside function must be a distance to them, with a slope of at most 1,
        that is negative in all of the solid.
        """,
        """
        apg 1
        primitive Open {
          param size : length[3] > 0  test [1cm, 1cm, 1cm] .. [9cm, 9cm, 9cm]
          surface front  (u in 0 .. 1, v in 0 .. 1) = [size.x / 2, (u - 1/2) * size.y, (v - 1/2) * size.z]
          surface back   (u in 0 .. 1, v in 0 .. 1) = [-size.x / 2, (1/2 - u) * size.y, (v - 1/2) * size.z]
          inside (p) = max(abs(p.x) - size.x / 2, abs(p.y) - size.y / 2, abs(p.z) - size.z / 2)
          box = [size.x, size.y, size.z]
        }
        category Cup {
          root part body : Open(size = [5cm, 5cm, 5cm])
        }
        """,
    ),
    Code(
        "untested-values",
        "a primitive is used outside its test ranges, where its box is wrong",
        """
        The formulas of a solid are made for the values after `test`: these decide, for example, which point of a curve
        is the highest. Outside the test ranges it may be another point. Then the primitive's box does not contain its
        surface, so parts placed by its faces end up in the wrong place; or it does not contain its convex pieces, which
        then collide with distant parts. `apgc check` compares them for a few objects. Widen the test range.
        """,
        """
        apg 1
        use vocabularies { semantic }
        use materials { steel }
        primitive Bow {
          param radius : length > 0  test 5cm .. 10cm
          param begin  : angle  test 0deg .. 20deg
          curve way (t in 0 .. 1) = [radius * cos(begin + 60deg * t), radius * sin(begin + 60deg * t), 0mm]
          curve section (u in 0turn .. 1turn) = [4mm * cos(u), 2mm * sin(u)]
          solid = sweep(section) along way up z
        }
        category Handle {
          root part bow : Bow(radius = 7cm, begin = -30deg)
          label semantic.handle on bow
          material steel on bow
        }
        """,
    ),
)
