"""Runs of designs as the page of "Try it" gets them."""

from typing import Any

from fuzzy.system import Sugeno
from robotics.plugins.designer.tryout import TryoutTrial, design_data


def on_page(fis: Sugeno, trial: TryoutTrial) -> dict[str, Any]:
    """The run of a design; what its rule base was asked stays in the server."""
    return {name: value for name, value in design_data(fis, trial).items() if name != "asked"}


def beside(fis: Sugeno, trial: TryoutTrial) -> dict[str, Any]:
    """The run of a design that another one is compared with."""
    return {name: value for name, value in on_page(fis, trial).items() if name not in ("player", "reference")}
