"""``python -m anfis``: the command line."""

import sys

from anfis.command import main

sys.exit(main())
