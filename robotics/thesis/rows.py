"""What the chapters of the thesis say of a run in their tables, and how they play it."""

from functools import partial

from robotics.laws.catalogue import label
from robotics.measures.evidence import mean_of
from robotics.measures.quantities import MEASURED_QUANTITIES, measured
from robotics.playback.player import player_fragment
from robotics.report.chapter import Film
from robotics.report.wording import shown
from robotics.scenario.reading import load_scenario
from robotics.simulation.run import Run


def mean_cells(run: Run, *quantities: str) -> list[str]:
    """The means of quantities over the seeds, each with its 95 % interval and its unit."""
    return [shown(mean_of(measured(run, name)), MEASURED_QUANTITIES[name].unit) for name in quantities]


def film_of(run: Run, scenario: str, law: str) -> Film:
    """A run to play, called by its scenario's title and its law."""
    return Film(f"To play: {load_scenario(scenario).title}; {label(law)}.", partial(player_fragment, run))
