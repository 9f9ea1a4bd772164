"""The state of a simulation as columns: what its compiled steps read and write.

A lane is one robot of one run, run after run; a column holds one number of every lane. The steps of a period write
these arrays in place, so that a period makes no new ones.
"""

from functools import cache
from typing import Any, NamedTuple

from fuzzy.compiled.columns import (
    Bools1,
    Floats1,
    Floats2,
    Floats3,
    Ints1,
    compiled_type,
)
from fuzzy.compiled.jit import types
from robotics.laws.equation import Known, pointed
from robotics.simulation.safety.monitor import MonitorLanes
from robotics.world.paths.road import Road
from robotics.world.radio.channel import Air
from robotics.world.radio.faults import Trouble
from robotics.world.sensing.carried import Looks
from robotics.world.sensing.posture import Senses
from robotics.world.vehicle.floor import Floor


class PlantLanes(NamedTuple):
    """The plant of all lanes, as of :mod:`robotics.world.vehicle.plant`."""

    parameters: Floats2  # (PARAMETERS, lanes)
    truth: Floats2  # (CHANNELS, lanes)
    pending: Floats3  # (late periods + 2, 2, lanes): orders; that of period k stands at k modulo their number
    scratch: Floats1  # the plant works in it
    steps: int  # of the plant a period
    step: float  # s
    code: int  # of robotics.world.vehicle.plant: velocities, torques, or the kinematic plant
    late_periods: int  # latency: whole periods,
    late_steps: int  # and steps of the plant beyond them
    floor: Floor  # whose friction differs by place; without patches nobody looks at it


class Lanes(NamedTuple):
    """All lanes of a simulation in one period, and what does not change."""

    robots: int  # of a run
    period: float  # s
    divergence: float  # m
    watchdog: float  # s
    body: PlantLanes
    senses: Senses
    readings: Floats2  # (lanes, sensors) m: of the range sensors
    road: Road  # of the setting's references
    path: Ints1  # (lanes,): each lane's path on that road
    references: Floats3  # (6, samples, robots): those that all runs share, looked up at once; or no samples
    trouble: Trouble
    air: Air
    known: Known  # of the law; its time is that of the first period
    memory: Floats2  # (numbers, lanes): of the law
    command: Floats2  # (rows, lanes), as of robotics.laws.equation
    work: Floats1  # the law works in it
    order: Floats2  # (2, lanes): the command after faults, and after stops from the next period on
    held_for: Floats1  # (lanes,) s without a new command
    stopped: Ints1  # (lanes,): the period in which the robot was stopped, or -1
    lost: Bools1  # (lanes,): it is stopped in this period
    goes_on: Bools1  # (runs,): it goes on: its robots sense, look, decide and move
    guard: MonitorLanes  # the monitor of passive safety


LANES_TYPE, LOOKS_TYPE = compiled_type(Lanes), compiled_type(Looks)
# Of robotics.world.sensing.carried.look
LOOK_TYPE = types.void(
    LOOKS_TYPE, types.int64, types.float64[:, ::1], types.int64, types.float64[:, ::1], types.boolean[::1]
)
GUARD_TYPE = compiled_type(MonitorLanes)
# Of robotics.simulation.safety.monitor.keep_safe
KEEP_TYPE = types.void(
    GUARD_TYPE, types.int64, types.float64, types.int64, *[types.float64[:, ::1]] * 3, types.boolean[:, ::1],
    types.boolean[::1], *[types.float64[:, ::1]] * 2,
)  # fmt: skip


@cache
def machine_code(function: Any, *kinds: Any) -> Any:
    """The machine code of a compiled function whose arguments are of ``kinds``, and lanes.

    Lanes are the same type whatever they record, so that it is one for all simulations.
    """
    if not hasattr(function, "compile"):  # NUMBA_DISABLE_JIT
        return function
    function.compile((*kinds, LANES_TYPE))
    return function.get_overload((*kinds, LANES_TYPE))


@cache
def keeping(keep: Any) -> Any:
    """The machine code of the monitor, or of what stands for none."""
    code = pointed(keep, KEEP_TYPE.args)
    return code.get_overload(KEEP_TYPE.args) if hasattr(code, "get_overload") else code


@cache
def looking(look: Any) -> Any:
    """The machine code of a compiled function that reads range sensors: :func:`robotics.world.sensing.carried.look`."""
    code = pointed(look, LOOK_TYPE.args)
    return code.get_overload(LOOK_TYPE.args) if hasattr(code, "get_overload") else code
