"""The runs behind the verdicts: every law on every scenario with noise, and some without, each in one array pass."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial

from robotics.laws.catalogue import make_controller
from robotics.plugins.thesis.claims import Needed
from robotics.plugins.thesis.experiment import Experiment
from robotics.simulation.loop import simulate
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.simulation.scenario.reading import load_scenario, scenario_names
from robotics.world.sensing.posture import LABORATORY, Sensing


def noisy(scenario: Scenario) -> Scenario:
    """The scenario with its own noise; robots that have none, as in chapters 3 to 5, get that of the other tests."""

    def own(sensing: Sensing) -> Sensing:
        quiet = sensing.posture == "odometry" or not (sensing.position_noise or sensing.relative_noise)
        return LABORATORY if quiet else sensing

    members = tuple(replace(m, sensing=None if m.sensing is None else own(m.sensing)) for m in scenario.robots)
    return replace(scenario, sensing=own(scenario.sensing), robots=members)


def ideal(scenario: Scenario) -> Scenario:
    """The scenario without noise: robots know their postures from encoders that err by less than a count."""
    members = tuple(replace(m, sensing=None) for m in scenario.robots)
    return replace(scenario, sensing=Sensing(), robots=members)


def driven(wanted: Needed, scenario: Scenario, law: str, seeds: Sequence[int]) -> Run:
    """Drive ``scenario`` by the ``law`` with noise, or once without where an ideal is ``wanted``."""
    if wanted.ideal:
        scenario, seeds = ideal(scenario), seeds[:1]
    else:
        scenario = noisy(scenario)
    return simulate(scenario, make_controller(law), seeds, name=wanted.of, message_ages=scenario.kind == "team")


def experiments_of(wanted: Iterable[Needed], seeds: Sequence[int]) -> list[Experiment]:
    """An experiment for each of those ``wanted`` that is a law on a scenario of the package, each once."""
    names = scenario_names()
    return [Experiment(need, partial(_packaged, need, seeds)) for need in dict.fromkeys(wanted) if need.on in names]


def _packaged(need: Needed, seeds: Sequence[int]) -> Run:
    return driven(need, load_scenario(need.on), need.of, seeds)
