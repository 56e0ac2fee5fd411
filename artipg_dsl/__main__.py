"""``python -m artipg_dsl`` is ``apgc``."""

import sys

from .cli.main import main

sys.exit(main())
