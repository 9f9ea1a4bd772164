"""``python -m fuzzy``: the command line."""

import sys

from fuzzy.commands.application import main

sys.exit(main())
