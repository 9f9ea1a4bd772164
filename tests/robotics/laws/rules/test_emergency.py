"""The emergency rule: what it lets through satisfies its formula, and it takes off no more than that demands."""

from dataclasses import asdict
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fuzzy.compiled.jit import kernel
from robotics.laws.rules.clearances import SECTOR
from robotics.laws.rules.emergency import (
    ASIDE,
    COMES_NEARER,
    FAR,
    SETTLED,
    TURNING,
    UNSURE,
    EmergencyColumns,
    EmergencySettings,
    kept_safe,
)
from robotics.laws.rules.perception import KNOWN, OtherColumns, PerceivedColumns
from robotics.laws.rules.situation import TeamColumns

GUARD = EmergencySettings()
A, T, LEAST = GUARD.braking, GUARD.delay, GUARD.least
AWAY = 9.0  # m


def situation(
    front: float = AWAY,
    behind: float = AWAY,
    gap: float = AWAY,
    bearing: float = 0.0,
    velocity: tuple[float, float] = (0.0, 0.0),
    age: float = 0.05,
    room: float = 2.0,
    nearing: float = 0.0,
    way_back: float = 0.3,
) -> Any:
    """What one robot at the origin that looks along x knows of the room around it, and of one other robot."""
    now, table = PerceivedColumns.zeros(), TeamColumns.zeros()
    now.clear[...] = np.inf
    now.clear[[SECTOR.front_left, SECTOR.front_right]], now.clear[SECTOR.behind] = front, behind
    now.echoes[...] = now.clear
    now.nearing, now.known[KNOWN.room], now.known[KNOWN.way_back] = nearing, room, way_back
    readings = np.zeros(2 + 2 * OtherColumns.size)  # the places of both, and both: itself it does not hear
    other = OtherColumns(readings, 2 + OtherColumns.size)
    other.counts, other.distance, other.gap, other.bearing, other.age = 1.0, gap + 0.3, gap, bearing, age
    other.dx, other.dy = (gap + 0.3) * np.cos(bearing), (gap + 0.3) * np.sin(bearing)
    other.v_x, other.v_y, other.speed = *velocity, np.hypot(*velocity)
    return now.array, table.array, readings


class Told(NamedTuple):
    """What the rule reads of all that a law knows."""

    dt: float
    heard: np.ndarray


@kernel
def keep(v, w, halted, guard, known, now, table, readings):
    return kept_safe(v, w, halted, EmergencyColumns(guard), 0, known, table, PerceivedColumns(now), readings)


def kept(
    now: Any, v: float, w: float = 0.0, halted: float = 0.0, guard: EmergencySettings = GUARD
) -> tuple[float, float]:
    safe, turn, _ = kept_for(now, v, w, halted, guard)
    return safe, turn


def kept_for(now: Any, v: float, w: float, halted: float = 0.0, guard: EmergencySettings = GUARD) -> tuple[float, ...]:
    """The safe speed and turn rate, and for how long it has stood still."""
    numbers = np.array([*asdict(guard).values()])
    return keep(v, w, float(halted), numbers, Told(0.05, np.zeros((1, 1, 2))), *now)


def stands_in_time(v: float, room: float, u: float = 0.0) -> bool:
    """The formula of the module: whether a robot of speed v [m/s] can stop in ``room`` [m] less what is left."""
    return v <= 1e-9 or v * T + v**2 / (2 * A) + u * (T + v / A) <= room + 1e-9


@settings(max_examples=300)
@given(
    st.floats(-0.5, 1.2), st.floats(0, 2), st.floats(0, 1), st.floats(-0.1, 2.5), st.floats(-3.14, 3.14),
    st.floats(-0.6, 0.6), st.floats(-0.6, 0.6), st.floats(0, 3),
)  # fmt: skip
def test_what_it_lets_through_can_stop_and_what_can_stop_it_lets_through(
    v: float, front: float, behind: float, gap: float, bearing: float, v_x: float, v_y: float, age: float
) -> None:
    safe, _ = kept(situation(front, behind, gap, bearing, (v_x, v_y), age), v)
    approach = max(-(np.cos(bearing) * v_x + np.sin(bearing) * v_y), 0.0)
    beside = np.cos(bearing) * (1 if v >= 0 else -1)
    near = gap - LEAST - UNSURE * min(age, 1.0) * np.hypot(v_x, v_y)

    def stops(speed: float) -> bool:
        ahead = front + TURNING if v >= 0 else behind
        from_wall = stands_in_time(speed, ahead - LEAST)
        meets = beside > ASIDE and gap < FAR
        return from_wall and (not meets or stands_in_time(speed * beside, near, approach))

    assert abs(safe) <= abs(v) + 1e-12
    assert safe * v >= 0
    assert stops(abs(safe))
    if stops(abs(v)):
        assert safe == pytest.approx(v, abs=1e-9)
    elif abs(safe) > 1e-6:  # it is the largest speed that can stop
        assert not stops(abs(safe) + 1e-4)


def test_a_robot_that_approaches_leaves_less_room_than_one_that_stands_or_goes() -> None:
    stands, comes, goes = (kept(situation(gap=0.4, velocity=(v, 0.0)), 1.0)[0] for v in (0.0, -0.3, 0.3))
    assert 0 < comes < stands
    assert goes <= stands  # that it goes is not counted on


def test_back_it_goes_only_over_ground_that_it_has_just_driven() -> None:
    assert kept(situation(), -0.1)[0] == pytest.approx(-0.1)
    assert kept(situation(way_back=0.0), -0.1)[0] == 0
    assert kept(situation(behind=0.0), -0.1)[0] == 0


def test_for_what_comes_nearer_it_stands_until_that_stands() -> None:
    comes = situation(room=GUARD.near / 2, nearing=2 * COMES_NEARER)
    v, w, halted = kept_for(comes, 0.3, 1.0)
    assert v == w == 0
    assert halted > 0
    slower = situation(room=GUARD.near / 2, nearing=(COMES_NEARER + SETTLED) / 2)
    assert kept(slower, 0.3, 1.0) == (0.3, 1.0)  # not enough to begin
    assert kept(slower, 0.3, 1.0, halted) == (0, 0)  # enough to go on
    assert kept(situation(room=GUARD.near / 2, nearing=SETTLED / 2), 0.3, 1.0, halted) == (0.3, 1.0)
    assert kept(situation(room=3 * GUARD.near, nearing=2 * COMES_NEARER), 0.3, 1.0, halted) == (0.3, 1.0)


def test_switched_off_it_does_nothing() -> None:
    off = EmergencySettings(on=0.0)
    assert kept(situation(front=0.0, gap=0.0, room=0.0, nearing=1.0), 1.0, 2.0, guard=off) == (1.0, 2.0)
    assert off.idle == {"braking", "delay", "least", "near"}
    assert GUARD.idle == frozenset()
