"""A vice with two screws, the second of which is the mirror of the first and so left-handed, and a key that waits for both."""

VICE = """apg 1
use primitives { Cuboid, Cylinder }
vocabulary semantic { knob }
category Vice {
  root part body : Cuboid(size = [20cm, 20cm, 5cm])
  repeat side[k] mirror across y {
    part nut : Cylinder(radius = 1cm, height = 2cm) along y
    align nut.center = [0, 12cm, 0]
    joint drive : screw body -> nut about line(at = nut.center, along = y) range 0turn .. 2turn pitch 3mm
    label semantic.knob on nut
  }
  part key : Cuboid(size = [2cm, 2cm, 2cm])
  joint press : prismatic body.top -> key.bottom gap 1mm range 0mm .. 5mm when side[0].drive > 1turn and side[1].drive > 1turn
}
"""
