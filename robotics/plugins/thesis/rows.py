"""What the chapters of the thesis say of a run in their tables, and how they play it."""

from collections.abc import Callable, Mapping
from functools import partial

from robotics.laws.catalogue import label
from robotics.measures.evidence import mean_of
from robotics.measures.quantities import MEASURED_QUANTITIES, measured
from robotics.show.playback.player import player_fragment
from robotics.show.report.chapter import Film
from robotics.show.report.texts import ReportTexts
from robotics.show.report.wording import shown
from robotics.simulation.run import Run
from robotics.simulation.scenario.reading import load_scenario
from robotics.tables.texts import TextFile

TEXTS = ReportTexts("robotics.plugins.thesis")
TABLES = TextFile("robotics.plugins.thesis", "tables.toml")


def mean_cell(run: Run, quantity: str) -> str:
    """The mean of a quantity over the seeds, with its 95 % interval and its unit."""
    return shown(mean_of(measured(run, quantity)), MEASURED_QUANTITIES[quantity].unit)


def run_columns(
    scenario: str, beside: Mapping[str, Callable[[Run], str]], **quantities: str
) -> dict[str, Callable[[Run], str]]:
    """Columns of a table of runs: what ran where, what stands beside that, and the means of quantities.

    Args:
        scenario: The title of the column of scenarios.
        beside: The columns before the means.
        quantities: The title of each quantity.
    """
    means = {title: partial(mean_cell, quantity=name) for name, title in quantities.items()}
    return {scenario: lambda run: run.scenario, "controller": lambda run: label(run.controller), **beside, **means}


def film_of(run: Run, scenario: str, law: str, chapter: str) -> Film:
    """A run to play, called by its scenario's title and its law, under the picture that ``chapter`` has of it."""
    caption = f"To play: {load_scenario(scenario).title}; {label(law)}."
    return Film(caption, partial(player_fragment, run), f"{chapter}-{scenario}")
