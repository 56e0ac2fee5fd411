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
