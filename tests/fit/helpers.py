"""What several tests of fits are about."""

from pathlib import Path

from tests.cli.helpers import CHEST

TEXT = Path(CHEST).read_text()  # its knobs are 2 cm wide, some sixty points of 20,000
N = 3
BOARD = """
apg 1
use primitives { Cuboid }
category Board {
  param width  : length in 40cm .. 80cm = 60cm
  param height : length in 60cm .. 90cm = 75cm
  param thick  : length in 3cm .. 6cm = 4cm
  root part board : Cuboid(size = [thick, width, height])
  part foot : Cuboid(size = [12cm, width, 5cm]) | none
  connect foot.top on board.bottom
  part cap : Cuboid(size = [12cm, width, 2cm]) | none
  connect cap.bottom on board.top
}
"""
# most of the tray cannot be seen
HOUSING = """
apg 1
use primitives { Cuboid, RectSleeve }
template Tray {
  param size : length[3]
  part plate : Cuboid(size = [1cm, size.y, size.z])
  part floor : Cuboid(size = [size.x - 1cm, size.y, 3mm])
  align plate.front = front
  align floor.front = plate.back
}
category Housing {
  param width : length in 40cm .. 80cm = 60cm
  root part shell : RectSleeve(size = [60cm, width, 80cm], border = 1cm)
  part rear  : Cuboid(size = [1cm, width, 80cm])
  part front : Cuboid(size = [1cm, width, 80cm])
  connect rear.front on shell.back
  connect front.back on shell.front
  part tray : Tray(size = [31cm, 30cm, 16cm]) | none
  connect tray.back on front.front sink 30cm
}
"""
# where its knob would be, only a door with a knob shows
SIDED = """
apg 1
use primitives { Cuboid }
category Sided {
  param width : length in 40cm .. 60cm = 50cm
  param side  : choice to_left | to_right = to_left
  root part door : Cuboid(size = [3cm, width, 80cm])
  part knob : Cuboid(size = [4cm, 4cm, 8cm]) | none
  connect knob.back on door.front
  when knob {
    align knob.center.z = door.center.z
    align knob.center.y = door.center.y + (width / 2 - 5cm if side == to_left else 5cm - width / 2)
  }
}
"""
# nothing shows what is inside
CLOSED = """
apg 1
use primitives { Cuboid, RectSleeve }
category Closed {
  param width : length in 40cm .. 60cm = 50cm
  root part shell : RectSleeve(size = [40cm, width, 40cm], border = 1cm)
  part rear  : Cuboid(size = [1cm, width, 40cm])
  part front : Cuboid(size = [1cm, width, 40cm])
  connect rear.front on shell.back
  connect front.back on shell.front
  count cores in 0 .. 2 = 1 ~ values(0, 1, 1, 1)
  repeat row[i] in 0 ..< cores spread shell along z margin 15cm {
    part core : Cuboid(size = [2cm, 2cm, 2cm])
    connect core to shell
    align core.center.x = shell.center.x
    align core.center.y = shell.center.y
    align core.center.z = row.center.z
  }
}
"""
# how long its feet are no point of them says
FOOTED = """
apg 1
use primitives { Cuboid }
category Footed {
  param width  : length in 60cm .. 90cm = 75cm
  param height : length in 50cm .. 120cm = 80cm
  param lift   : length in 4cm .. 30cm = 15cm
  root part body : Cuboid(size = [40cm, width, height - lift])
  repeat foot[i] in 0 ..< 2 {
    part stem : Cuboid(size = [4cm, 4cm, lift])
    align stem.top = body.bottom
    align stem.center.x = body.center.x
    align stem.center.y = body.center.y + (width / 2 - 5cm if i == 0 else 5cm - width / 2)
    connect stem to body
  }
}
"""
SIZELESS = """
apg 1
use primitives { Cuboid }
category Sizeless {
  root part body : Cuboid(size = [40cm, 50cm, 30cm])
  part foot : Cuboid(size = [12cm, 20cm, 5cm]) | none
  connect foot.top on body.bottom
}
"""
# which of its plates is the first shows in nothing
SWAPPED = """
apg 1
use primitives { Cuboid }
category Swapped {
  param height : length in 10cm .. 20cm = 15cm
  param side : choice to_left | to_right = to_left
  let away = 15cm if side == to_left else -15cm
  root part board : Cuboid(size = [40cm, 50cm, 2cm])
  part first : Cuboid(size = [2cm, 4cm, height])
  part second : Cuboid(size = [2cm, 4cm, height])
  connect first.bottom on board.top
  connect second.bottom on board.top
  align first.center.y = board.center.y + away
  align second.center.y = board.center.y - away
}
"""
