"""``python -m robotics``: the command line."""

import sys

from robotics.commands.application import main

sys.exit(main())
