"""``python -m anfis``: the command line."""

import sys

from anfis.commands.application import main

sys.exit(main())
