"""Says which file stands in the way of one of the three packages, and imports none of them.

``anfis`` and ``robotics`` run it from its text before they import anything, as ``fuzzy`` may be somebody's fuzzy.py.
"""

import sys
import warnings
from importlib.machinery import PathFinder
from os.path import dirname, exists

for name in ("fuzzy", "anfis", "robotics"):
    found = sys.modules.get(name) or PathFinder.find_spec(name)
    file = getattr(found, "__file__", None) or getattr(found, "origin", None)
    if file and not exists(f"{dirname(file)}/__init__.pyi"):  # noqa: PTH110, PTH120 - in which each of ours has names
        said = f"{file} stands in the way of the package {name} of fuzzyfleet: rename it"
        if name == "fuzzy":
            raise ImportError(said)
        warnings.warn(f"{said} if something needs that package", stacklevel=2)
