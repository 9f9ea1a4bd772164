"""``python -m robotics``: the command line."""

import sys

from robotics.command import main

sys.exit(main())
