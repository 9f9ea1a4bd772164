"""The state of a simulation as columns: what its compiled steps read and write.

A lane is one robot of one run, run after run; a column holds one number of every lane. The steps of a period write
these arrays in place, so that a period makes no new ones.
"""

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from fuzzy.compiled.jit import as_dtype, types
from robotics.environment.world import Geometry, Moving
from robotics.laws.equation import KNOWN_TYPE, ROAD_TYPE, Known
from robotics.paths.road import Road
from robotics.radio.channel import Air
from robotics.radio.faults import Trouble
from robotics.sensing.carried import Looks
from robotics.sensing.posture import Senses
from robotics.sensing.raycasting import Bodies, Eyes


class Body(NamedTuple):
    """The plant of all lanes, as of :mod:`robotics.vehicle.plant`."""

    parameters: np.ndarray  # (PARAMETERS, lanes)
    truth: np.ndarray  # (CHANNELS, lanes)
    pending: np.ndarray  # (late periods + 2, 2, lanes): orders; that of period k stands at k modulo their number
    scratch: np.ndarray  # the plant works in it
    steps: int  # of the plant a period
    step: float  # s
    code: int  # of robotics.vehicle.plant: velocities, torques, or the kinematic plant
    late_periods: int  # latency: whole periods,
    late_steps: int  # and steps of the plant beyond them


class Kept(NamedTuple):
    """What is recorded, as of :mod:`robotics.simulation.channels`; no samples: it is not."""

    samples: np.ndarray  # (samples, channels, runs, robots)
    team: np.ndarray  # (samples, channels, runs, robots)
    links: np.ndarray  # (samples, runs, robots, senders) float32
    modes: np.ndarray  # (samples, runs, robots) int8
    guarded: np.ndarray  # (samples, runs, robots) bool
    inputs: np.ndarray  # (samples, inputs, runs, robots) float32
    ranges: np.ndarray  # (samples, runs, robots, sensors) float32
    torques: np.ndarray  # (samples, wheels, runs, robots) float32
    encoders: np.ndarray  # (samples, channels, runs, robots)
    messages: np.ndarray  # (samples, values, runs, robots)
    limits: np.ndarray  # (4, lanes): of the velocities, as of robotics.vehicle.plant.velocity_limits


class Lanes(NamedTuple):
    """All lanes of a simulation in one period, and what does not change."""

    robots: int  # of a run
    period: float  # s
    divergence: float  # m
    watchdog: float  # s
    body: Body
    senses: Senses
    readings: np.ndarray  # (lanes, sensors) m: of the range sensors
    road: Road  # of the setting's references
    path: np.ndarray  # (lanes,) int: each lane's path on that road
    references: np.ndarray  # (6, samples, robots): those that all runs share, looked up at once; or no samples
    trouble: Trouble
    air: Air
    known: Known  # of the law; its time is that of the first period
    memory: np.ndarray  # (numbers, lanes): of the law
    command: np.ndarray  # (rows, lanes), as of robotics.laws.equation
    work: np.ndarray  # the law works in it
    order: np.ndarray  # (2, lanes): the command after faults, and after stops from the next period on
    held_for: np.ndarray  # (lanes,) s without a new command
    stopped: np.ndarray  # (lanes,) int: the period in which the robot was stopped, or -1
    lost: np.ndarray  # (lanes,) bool: it is stopped in this period
    kept: Kept


def _c(kind: Any, axes: int) -> Any:
    """The type of arrays of ``kind`` that are contiguous."""
    return types.Array(kind, axes, "C")


def _any(kind: Any, axes: int) -> Any:
    """The type of arrays of ``kind`` that may be a part of larger ones."""
    return types.Array(kind, axes, "A")


_F, _I, _B, _I4 = types.float64, types.int64, types.boolean, types.int32
_BODY = types.NamedTuple((_c(_F, 2), _c(_F, 2), _c(_F, 3), _c(_F, 1), _I, _F, _I, _I, _I), Body)
_SENSES = types.NamedTuple((_c(_B, 1), _c(_F, 2), *(_c(_F, 1),) * 4, _c(_F, 2), _c(_F, 4), _c(_F, 4), _I), Senses)
_EYES = types.NamedTuple((*(_c(_F, 2),) * 2, _c(_I, 1), _c(_B, 1)), Eyes)
_GEOMETRY = types.NamedTuple((_c(_F, 3), _c(_I, 3), _c(_F, 3), _c(_I, 1)), Geometry)
_MOVING = types.NamedTuple((*(_c(_F, 3),) * 2, _c(_I, 2), _c(_F, 3)), Moving)
_BODIES = types.NamedTuple((_c(_F, 2), _c(_I, 2), *(_c(_F, 2),) * 2), Bodies)
LOOKS_TYPE = types.NamedTuple(
    (
        _EYES, *(_c(_I, 1),) * 2, _c(_I, 2), _c(_I, 1), _c(_F, 2), _GEOMETRY, _MOVING, _c(_F, 3), _c(_I, 1), _c(_F, 2),
        _c(_I, 1), _c(_F, 2), _BODIES, _c(_F, 1),
    ),
    Looks,
)  # fmt: skip
LOOK_TYPE = types.void(LOOKS_TYPE, _I, _c(_F, 2), _I, _c(_F, 2))  # of robotics.sensing.carried.look
_TROUBLE = types.NamedTuple((*(_c(_I, 1),) * 3, *(_c(_F, 2),) * 2, _c(_B, 1), _c(_B, 1), _c(_B, 2), _c(_I, 1)), Trouble)
_AIR = types.NamedTuple(
    (
        *(_I,) * 2, *(_F,) * 7, _c(_B, 2), _c(_F, 3), _c(_I4, 2), _c(_B, 2),
        _c(_F, 3), _c(_I4, 3), _c(_I, 1), _c(_F, 5), _I,
    ),
    Air,
)  # fmt: skip
_KEPT = types.NamedTuple(
    (
        *(_any(_F, 4),) * 2, _any(types.float32, 4), _any(types.int8, 3), _any(_B, 3), *(_any(types.float32, 4),) * 3,
        *(_any(_F, 4),) * 2, _c(_F, 2),
    ),
    Kept,
)  # fmt: skip
LANES_TYPE = types.NamedTuple(
    (
        _I, _F, _F, _F, _BODY, _SENSES, _c(_F, 2), ROAD_TYPE, _c(_I, 1), _c(_F, 3), _TROUBLE, _AIR, KNOWN_TYPE,
        *(_c(_F, 2),) * 2, _c(_F, 1), _c(_F, 2), _c(_F, 1), _c(_I, 1), _c(_B, 1), _KEPT,
    ),
    Lanes,
)  # fmt: skip


@cache
def machine_code(function: Any, *kinds: Any) -> Any:
    """The machine code of a compiled function whose arguments are of ``kinds``, and lanes.

    Lanes are the same type whatever they record, so that it is one for all simulations.
    """
    return _made(function, (*kinds, LANES_TYPE))


@cache
def looking(look: Any) -> Any:
    """The machine code of a compiled function that reads range sensors, as :func:`robotics.sensing.carried.look`."""
    return _made(look, LOOK_TYPE.args)


def _made(function: Any, kinds: tuple[Any, ...]) -> Any:
    """The machine code for arguments of ``kinds``; it is made, or found on disk, at the first call."""
    if not hasattr(function, "compile"):  # NUMBA_DISABLE_JIT
        return function
    function.compile(kinds)
    return function.get_overload(kinds)


def check(values: Any, kind: Any = LANES_TYPE) -> None:
    """Raise TypeError unless ``values`` are of ``kind``: machine code takes them as such, and looks at nothing."""
    for value, expected, name in zip(values, kind.types, kind.fields, strict=True):
        if isinstance(expected, types.NamedTuple):
            check(value, expected)
        elif isinstance(expected, types.Array):
            good = value.dtype == as_dtype(expected.dtype) and value.ndim == expected.ndim and value.flags.writeable
            if not (good and (expected.layout == "A" or value.flags.c_contiguous)):
                raise TypeError(f"{name} must be {expected}; got {value.dtype}, {value.ndim} axes, {value.flags}")
        elif type(value) is not (float if expected == _F else int):
            raise TypeError(f"{name} must be {expected}; got {value!r}")
