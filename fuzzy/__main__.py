"""``python -m fuzzy``: the command line."""

import sys

from fuzzy.command import main

sys.exit(main())
