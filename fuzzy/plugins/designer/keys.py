"""The keys of the designer's page, as its help lists them."""

import tomllib
from pathlib import Path

# (key, where, what it does), as ``keys.toml`` has them
SHORTCUTS = tuple(map(tuple, tomllib.loads(Path(__file__).with_suffix(".toml").read_text(encoding="utf-8"))["keys"]))
