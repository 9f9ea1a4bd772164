"""Metrics of one's own, in a Python file: ``file.py:name``, a :class:`Metric` or a function of a run."""

from typing import Any

import numpy as np

from fuzzy.errors import InputError
from fuzzy.files.pythonfile import load_python_file
from fuzzy.naming import expected
from robotics.measures.tracking import Metric
from robotics.simulation.run import Run


class MetricError(InputError):
    """A metric that cannot be found, or does not measure."""


def metric_in_file(specification: str) -> tuple[str, Metric]:
    """The metric of a specification ``file.py:name``, and its name. Raises MetricError.

    A function takes a :class:`robotics.simulation.run.Run` and returns numbers (runs, robots), of which less is better;
    the first line of its docstring is its title, and its attribute ``unit``, if it has one, its unit. A :class:`Metric`
    says more.
    """
    file, _, name = specification.rpartition(":")
    if not file.endswith(".py") or not name:
        raise MetricError(f"a metric of your own is file.py:function; got {specification!r}")
    module = load_python_file(file, MetricError)
    found = vars(module).get(name)
    if isinstance(found, Metric):
        return name, found._replace(measure=_checked(found.measure, specification))
    if not callable(found):
        own = {n: v for n, v in vars(module).items() if not n.startswith("_")}
        known = [n for n, v in own.items() if isinstance(v, Metric) or getattr(v, "__module__", "") == module.__name__]
        raise MetricError(f"{file}: {expected(name, known, 'function or Metric')}")
    title = (found.__doc__ or name).strip().partition("\n")[0].rstrip(".")
    return name, Metric(
        _checked(found, specification), getattr(found, "unit", "1"), title, short=title.partition(":")[0]
    )


def _checked(measure: Any, specification: str) -> Any:
    """The measure, which must return finite or infinite numbers (runs, robots)."""

    def checked(run: Run) -> np.ndarray:
        try:
            values = np.asarray(measure(run))
        except Exception as error:
            raise MetricError(f"{specification} fails: {type(error).__name__}: {error}") from error
        if values.shape != run.stopped.shape or values.dtype.kind not in "bif":
            raise MetricError(
                f"{specification} must return numbers of the shape (runs, robots) = {run.stopped.shape}; "
                f"got {values.dtype} of the shape {values.shape}"
            )
        return values if values.dtype == bool else values.astype(float)

    return checked
