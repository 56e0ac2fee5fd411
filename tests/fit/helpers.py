"""What several tests of fits are about."""

from pathlib import Path

from tests.cli.helpers import CHEST

TEXT = Path(CHEST).read_text()  # its knobs are 2 cm wide, some sixty points of 20,000
N = 3
