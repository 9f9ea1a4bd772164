"""Metrics of the user's own: functions from a run to numbers, in a Python file, another package, or as they are.

They are handed to what measures, tabulates and draws, as ``metrics``; nothing is registered, so that the same call
gives the same table whatever was called before.
"""

import inspect
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType, ModuleType
from typing import Any, TypeVar

import numpy as np

from fuzzy.entrypoints import entry_points
from fuzzy.errors import InputError
from fuzzy.files.pythonfile import load_python_file, told
from fuzzy.naming import check_known, expected
from robotics.laws.specification import Specification
from robotics.measures.tracking import SCENARIO_KINDS, Metric
from robotics.simulation.run import Run

METRIC_GROUP = "fuzzyfleet.metrics"  # the entry points by which other packages add metrics
_UNKNOWN = "–"  # the unit of a function that does not say one
_ABOUT = "metric_about"  # the attribute in which the decorator keeps what it was told

Measure = Callable[[Run], Any]  # of a run: numbers (runs, robots)
Function = TypeVar("Function", bound=Measure)
# What users hand in: specifications, functions and pairs of a name and a metric, or metrics by name
OwnMetrics = Mapping[str, Metric | Measure | str] | Sequence[str | Measure | tuple[str, Metric | Measure]]
NO_METRICS: Mapping[str, Metric] = MappingProxyType({})


class MetricError(InputError):
    """A metric that does not exist, or that fails, or that is no number for each robot of each run."""


def metric(*, unit: str, title: str = "", **fields: Any) -> Callable[[Function], Function]:
    """Say what a function measures, for tables and pictures; the function stays what it is.

    >>> @metric(unit="m/s", title="largest speed", larger=True)
    ... def top_speed(run):
    ...     return np.nanmax(run["v"], axis=-1)

    Args:
        unit: The unit of its numbers; "1" for none.
        title: What it is, by default the first line of the function's docstring.
        fields: Other fields of :class:`robotics.measures.tracking.Metric`, such as ``kinds`` or ``larger``.

    Returns:
        A decorator.

    Raises:
        MetricError: A field that there is not.
    """
    for name in fields:
        check_known(name, Metric._fields[1:], "field of a metric", MetricError)

    def about(function: Function) -> Function:
        setattr(function, _ABOUT, {"unit": unit, "title": title} | fields)
        return function

    return about


def own_metric(thing: Any, name: str) -> Metric:
    """A metric of the user's own, shown wherever there is a choice. Raises MetricError for what is none.

    Args:
        thing: A :class:`Metric`, or a function of a run; what the decorator :func:`metric`, or the attributes ``unit``
            and ``title``, do not say of it, its docstring does.
        name: The name of the metric.
    """
    if not isinstance(thing, Metric):
        if not callable(thing) or isinstance(thing, type):
            raise MetricError(f"the metric {name} must be a robotics.Metric, or a function of a run; got {thing!r}")
        named = {f: getattr(thing, f) for f in ("unit", "title") if isinstance(getattr(thing, f, None), str)}
        about = {"unit": _UNKNOWN, "title": ""} | named | getattr(thing, _ABOUT, {})
        doc = (inspect.getdoc(thing) or "").partition("\n")[0].rstrip(".") if inspect.isroutine(thing) else ""
        thing = Metric(thing, **about | {"title": about["title"] or doc or name.replace("_", " ")})
    for kind in thing.kinds:
        check_known(kind, SCENARIO_KINDS, "kind of scenarios", MetricError, where=f"the metric {name}")
    short = thing.short or name.replace("_", " ")
    return thing._replace(headline=thing.headline or thing.kinds, tried=thing.tried or thing.kinds, short=short)


def metric_at(specification: str) -> tuple[str, Metric]:
    """The name and the metric of ``file.py:name``, ``file.py`` with only one, or a name that a package brings.

    Raises MetricError, in one sentence, where there is none.
    """
    about = Specification.of(specification)
    if not about.file.endswith(".py"):
        good, bad = installed_metrics()
        if specification in bad:
            raise MetricError(bad[specification])
        if specification not in good:
            raise MetricError(f"{expected(specification, good, 'metric')}; or a file: mymetric.py:comfort")
        return specification, good[specification]
    module = load_python_file(about.file, MetricError)
    own, name = _metrics_of(module), about.name
    if not name:
        if len(own) != 1:
            have = (
                f"it has {', '.join(own)}: say which, as in {about.short}:{next(iter(own))}" if own else "it has none"
            )
            raise MetricError(f"{about.file}: one metric is needed, a function of a run; {have}")
        name = next(iter(own))
    if name not in vars(module):
        raise MetricError(f"{about.file}: {expected(name, own, 'metric')}")
    return name, own_metric(vars(module)[name], name)


def _metrics_of(module: ModuleType) -> list[str]:
    """The names of the metrics that a module defines; without any that says so, of its functions."""
    public = {n: thing for n, thing in vars(module).items() if not n.startswith("_")}
    said = [n for n, thing in public.items() if isinstance(thing, Metric) or hasattr(thing, _ABOUT)]
    return said or [
        n for n, thing in public.items() if inspect.isfunction(thing) and thing.__module__ == module.__name__
    ]


@cache
def installed_metrics() -> tuple[Mapping[str, Metric], Mapping[str, str]]:
    """The metrics of other packages by name, and those that cannot be used, each with a sentence that says why.

    An entry point of the group ``fuzzyfleet.metrics`` names a :class:`Metric`, or a function of a run.
    """
    good: dict[str, Metric] = {}
    bad: dict[str, str] = {}
    for entry in sorted(entry_points(group=METRIC_GROUP), key=lambda e: e.name):
        origin = f"the package {entry.dist.name}" if entry.dist is not None else entry.value
        try:
            good[entry.name] = own_metric(entry.load(), entry.name)
        except Exception as error:  # another package's module may raise anything when it is imported
            bad[entry.name] = f"the metric {entry.name!r} of {origin} cannot be used: {type(error).__name__}: {error}"
    return good, bad


def measured(name: str, about: Metric, run: Run) -> np.ndarray:
    """The numbers (runs, robots) of a metric of the user's own.

    Raises MetricError where it fails, or gives other shapes, or not-a-number for a robot that drove.
    """
    place = inspect.getsourcefile(inspect.unwrap(about.measure)) if inspect.isroutine(about.measure) else None
    where = f"{Path(place).name}: the metric {name}" if place else f"the metric {name}"
    try:
        found = np.asarray(about.measure(run))
    except InputError:
        raise
    except Exception as error:
        what = told(error, place or "", Path(place or name).name)
        raise MetricError(f"{what} (in the metric {name})") from error
    shape = run.stopped.shape
    if found.shape != shape:
        raise MetricError(f"{where} must give one number for each run and robot, {shape}; got the shape {found.shape}")
    if found.dtype.kind not in "fiub":
        raise MetricError(f"{where} must give numbers; got {found.dtype}")
    wrong = np.isnan(found) & (np.isfinite(run["x"]).sum(axis=-1) > 1)
    if wrong.any():
        place_of = tuple(int(i) for i in np.argwhere(wrong)[0])
        raise MetricError(
            f"{where} is not a number for seed {run.seeds[place_of[0]]}, robot {place_of[1] + 1}: after a stop or a "
            "first contact samples are not-a-number, which np.nanmean leaves out; what never happens is np.inf"
        )
    return found.astype(float)
