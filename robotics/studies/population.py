"""Many laws on one scenario at once: candidates times seeds, each law with its own gains, rule bases and robots.

Laws of one equation are driven side by side, their gains as columns, shared out over threads: a thousand candidates are
one pass, and every run has, to the last bit, the result that it has alone.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby
from typing import Any, Literal, NamedTuple, overload

import numpy as np

from fuzzy.compiled.threads import share_out
from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.words import counted
from robotics.laws.catalogue import as_law
from robotics.laws.law import Law
from robotics.laws.setting import Setting, TrueParameters
from robotics.laws.universe import say_of_inputs
from robotics.measures.own import NO_METRICS, OwnMetrics
from robotics.measures.registry import measure_all, metrics_of, own_metrics
from robotics.simulation.loop import CHUNK, Periods, checked_seeds, drive_chunk, record_run, threads_for
from robotics.simulation.opening import Driver, PreparedRuns, has_equation
from robotics.simulation.recorder import Recorder
from robotics.simulation.run import Run
from robotics.simulation.scenario.description import Scenario
from robotics.world.vehicle.robot import Robot


class PopulationError(InputError):
    """Laws, robots or metrics of a population that do not suit each other."""


@dataclass(frozen=True, eq=False)
class Population:
    """What became of many laws on one scenario: ``population["rms_cross_track_m"]`` is (laws, seeds, robots).

    Attributes:
        scenario: Its name.
        seeds: The seeds that each law ran with.
        metrics: By name, (laws, seeds, robots) each.
        stopped: (laws, seeds, robots) bool: it diverged, or was lost.
    """

    scenario: str
    seeds: tuple[int, ...]
    metrics: Mapping[str, np.ndarray] = field(repr=False)
    stopped: np.ndarray = field(repr=False)

    def __repr__(self) -> str:
        laws, seeds = self.stopped.shape[:2]
        return f"Population({self.scenario!r}: {counted(laws, 'law')}, {counted(seeds, 'seed')})"

    def __getitem__(self, metric: str) -> np.ndarray:
        """The numbers of one metric (laws, seeds, robots). Raises PopulationError for one that was not measured."""
        check_known(metric, self.metrics, "metric", PopulationError)
        return self.metrics[metric]


@overload
def simulate_many(
    scenario: Scenario,
    laws: Sequence[Law[Any] | str],
    seeds: Sequence[int] = ...,
    *,
    robots: Sequence[Sequence[Robot]] | None = ...,
    keep: Literal["metrics"],
    metrics: Sequence[str] | None = ...,
    own: OwnMetrics = ...,
    truth: TrueParameters | None = ...,
    threads: int | None = ...,
    progress: Callable[[], None] | None = ...,
) -> Population: ...


@overload
def simulate_many(
    scenario: Scenario,
    laws: Sequence[Law[Any] | str],
    seeds: Sequence[int] = ...,
    *,
    robots: Sequence[Sequence[Robot]] | None = ...,
    keep: Literal["runs"] = ...,
    metrics: Sequence[str] | None = ...,
    own: OwnMetrics = ...,
    truth: TrueParameters | None = ...,
    threads: int | None = ...,
    progress: Callable[[], None] | None = ...,
) -> list[Run]: ...


def simulate_many(
    scenario: Scenario,
    laws: Sequence[Law[Any] | str],
    seeds: Sequence[int] = (0,),
    *,
    robots: Sequence[Sequence[Robot]] | None = None,
    keep: Literal["runs", "metrics"] = "runs",
    metrics: Sequence[str] | None = None,
    own: OwnMetrics = NO_METRICS,
    truth: TrueParameters | None = None,
    threads: int | None = None,
    progress: Callable[[], None] | None = None,
) -> list[Run] | Population:
    """Run each of ``laws`` on ``scenario`` once for every seed, all of them in one pass as far as they can be.

    Every run is, to the last bit, the one that :func:`robotics.simulate` makes of its law and its seed.

    Args:
        scenario: The scenario.
        laws: Laws, or specifications as of :func:`make_controller`. Those with the same equation, such as ``fuzzy``
            with many rule bases, are driven side by side; a law in plain numpy is driven by itself.
        seeds: Whole numbers >= 0; each law has a run of each.
        robots: The robots of each law's runs; by default those of the scenario.
        keep: "runs" keeps all samples; "metrics" measures each run and forgets its samples, so that memory does not
            grow with the number of runs.
        metrics: The names of the metrics to measure; by default all that belong to the scenario.
        own: The user's own metrics, as of :func:`robotics.measure_all`, which are always measured.
        truth: What is so, where laws and wheel loops are told what the scenario says; by default it is what they are
            told.
        threads: How many threads share out the runs; by default as many as there are cores. The result is the same.
        progress: Called after every law.

    Returns:
        A run for each law, or for ``keep="metrics"`` a :class:`Population`.

    Raises:
        SimulationError: Seeds that are none.
        ControllerError: A law cannot drive the scenario.
        PopulationError: Other robots than the scenario has, or a metric that it does not have.
        MetricError: As of :func:`measure_all`.
    """
    seeds = checked_seeds(seeds)
    check_known(keep, ("runs", "metrics"), "way to keep runs", PopulationError)
    drivers = _drivers(_true_setting(scenario, truth), laws, robots)
    names = _wanted(scenario, metrics, own) if keep == "metrics" else ()
    found: list[list[Any]] = [
        [] for _ in laws
    ]  # of each law its runs, or the metrics of one stretch of them after the other
    told = Periods(len(laws), len(seeds), progress)

    def made(run: Run) -> Any:
        return run if keep == "runs" else _measured(run, names, own)

    for places in _alike(drivers):
        jobs = _jobs(places, [drivers[place] for place in places], len(seeds), keep == "runs", robots is not None)
        if jobs is None:
            for place in places:
                setting, law = drivers[place]
                found[place].append(made(record_run(setting, law, seeds, name=_name(laws[place]), threads=threads)))
                told(len(seeds))
            continue
        opening = PreparedRuns.of([drivers[place] for place in places], seeds)

        def one(job: _Job, opening: PreparedRuns = opening, places: list[int] = places) -> list[tuple[int, Any]]:
            runs = _driven(opening, job, seeds, [_name(laws[places[n]]) for n in job.drivers])
            told(job.last - job.first)
            return [(places[n], made(run)) for n, run in runs]

        for place, part in (pair for pairs in share_out(one, jobs, threads_for(threads)) for pair in pairs):
            found[place].append(part)
    if keep == "runs":
        return [run for (run,) in found]
    measured = {n: np.stack([np.concatenate([part[n] for part, _ in own]) for own in found]) for n in names}
    stopped = np.stack([np.concatenate([gone for _, gone in own]) for own in found])
    return Population(scenario.name, seeds, measured, stopped)


class _Job(NamedTuple):
    """Runs that are driven together: those of some drivers, or a part of those of one."""

    first: int  # of the runs of all drivers
    last: int  # one past
    drivers: range


def _jobs(places: Sequence[int], drivers: Sequence[Driver], each: int, whole: bool, apart: bool) -> list[_Job] | None:
    """What is driven together; None: every law by itself.

    Args:
        places: Those of the drivers.
        drivers: Drivers that can be driven side by side.
        each: The number of runs of each.
        whole: Whether the runs of a driver must not be parted.
        apart: Whether drivers have robots of their own, which a job shares.
    """
    setting, law = drivers[0]
    lanes = each * len(setting.robots)
    if not has_equation(law) or (whole and lanes >= CHUNK):
        return None
    if lanes >= CHUNK:
        size = max(1, CHUNK // len(setting.robots))
        return [
            _Job(n * each + k, n * each + min(k + size, each), range(n, n + 1))
            for n in range(len(places))
            for k in range(0, each, size)
        ]
    number = 1 if apart else max(1, CHUNK // lanes)
    groups = [range(n, min(n + number, len(places))) for n in range(0, len(places), number)]
    return [_Job(group.start * each, group.stop * each, group) for group in groups]


def _driven(opening: PreparedRuns, job: _Job, seeds: tuple[int, ...], names: list[str]) -> list[tuple[int, Run]]:
    """Drive a job; return the runs of each of its drivers, with the driver's place."""
    each, (setting, law) = len(seeds), opening.drivers[job.drivers.start]
    recorder = Recorder(setting, law, job.last - job.first)
    watching = recorder.observer(0, job.last - job.first)
    gone, _ = drive_chunk(opening, job.first, job.last, watching, setting.ticks)
    end, found = setting.ticks + 1, []
    for n, name in zip(job.drivers, names, strict=True):
        first, last = max(n * each, job.first), min((n + 1) * each, job.last)
        mine = seeds[first - n * each : last - n * each]
        which = slice(first - job.first, last - job.first)
        driver = opening.drivers[n]
        run = recorder.run(driver.setting, mine, name, gone, end, which, driver.law, opening.references)
        if run.inputs is not None:
            say_of_inputs(driver.law.fuzzy_systems, run.inputs)
        found.append((n, run))
    return found


def _measured(run: Run, names: Sequence[str], own: OwnMetrics) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """The metrics of a run, and whether its robots were stopped."""
    every = measure_all(run, own, only=names)
    return {name: every[name] for name in names}, run.stopped >= 0


def _true_setting(scenario: Scenario, truth: TrueParameters | None) -> Setting:
    """The scenario's setting with what is so."""
    if truth is not None and len(truth.robots) != len(scenario.robots):
        raise PopulationError(f"truth must have {counted(len(scenario.robots), 'robot')}; got {len(truth.robots)}")
    return scenario.setting if truth is None else replace(scenario.setting, truth=truth)


def _drivers(
    setting: Setting, laws: Sequence[Law[Any] | str], robots: Sequence[Sequence[Robot]] | None
) -> list[Driver]:
    if len(laws) == 0:
        raise PopulationError("at least one law is needed")
    if robots is None:
        return [Driver(setting, as_law(law)) for law in laws]
    if len(robots) != len(laws) or any(len(own) != len(setting.robots) for own in robots):
        raise PopulationError(
            f"robots must be {len(setting.robots)} for each of {counted(len(laws), 'law')}, as many as "
            f"{setting.name} has; got {[len(own) for own in robots]}"
        )
    return [Driver(replace(setting, robots=tuple(own)), as_law(law)) for law, own in zip(laws, robots, strict=True)]


def _wanted(scenario: Scenario, metrics: Sequence[str] | None, own: OwnMetrics) -> tuple[str, ...]:
    """The names of the metrics that are measured."""
    mine = own_metrics(own, scenario.kind)
    known = metrics_of(scenario.kind, scenario.setting.has_others, False, mine)
    for name in metrics or ():
        check_known(name, known, "metric", PopulationError)
    return tuple(known) if metrics is None else tuple(dict.fromkeys([*metrics, *mine]))


def _alike(drivers: Sequence[Driver]) -> list[list[int]]:
    """The places of drivers that can be driven side by side, in their order."""

    def kind(place: int) -> tuple[Any, ...]:
        law: Any = drivers[place].law
        if not has_equation(law):
            return (place,)
        return type(law), law.estimator, law.safe, law.level, law.watchdog, law.message, law.rule_inputs, law.has_modes

    return [list(places) for _, places in groupby(range(len(drivers)), key=kind)]


def _name(law: Law[Any] | str) -> str:
    return law if isinstance(law, str) else type(law).__name__
