"""Whether a log can tell anything: clocks, units, columns that were swapped, gaps, a robot that never moved.

What cannot be is refused with a sentence that says what to do; what is odd, and can be left out, is left out and told.
"""

from dataclasses import replace
from math import pi
from typing import NamedTuple

import numpy as np

from fuzzy.shown import shown
from fuzzy.words import listed
from robotics.plugins.identify.signals import LOG_GAP, IdentifyError, MeasuredVelocities, Poses, Signals

_LONGEST_GAP = 3.0  # s: a longer one is taken for another drive, which begins so much later
SETTLING_TIME = 1.0  # s after a gap before the model is compared again: by then it has forgotten what it missed
_FASTEST, _FASTEST_TURN = 15.0, 20.0  # m/s and rad/s: no small robot moves so
_LEAST_MOTION = 5.0  # s
_SHORT = 20.0  # s
_LATEST = 1.0  # s: of the delays that are tried
_JUMP = 0.5, 2.0  # m/s and rad/s: below it nothing is an outlier
_RARE = 0.05  # of the samples: outliers at most; of more the unit is wrong
_STUCK = 1.5  # s: a number that stays so long while commands change
_TURNED = 20.0  # degrees: of a heading that belongs to other axes
_FACTORS = {1000.0: "m/s and mm/s", 100.0: "m/s and cm/s", 180 / pi: "rad/s and degrees/s", 30 / pi: "rad/s and rpm"}


class SoundSignals(NamedTuple):
    """Signals that passed, with what was found on the way."""

    signals: Signals
    usable: np.ndarray  # (velocities,) bool: samples by which the model is judged
    delay: float  # s: from command to motion, by their correlation: latency and lag together
    remarks: tuple[str, ...]


def sound(signals: Signals) -> SoundSignals:
    """Look at everything that can be wrong with a log. Raises IdentifyError."""
    _check_times(signals)
    signals, left_out = _without_outliers(signals)
    _check_sizes(signals)
    signals, remarks = _without_long_gaps(signals)
    remarks = left_out + remarks
    delay = _check_match(signals)
    if delay > _LATEST - 0.05:
        remarks.append(
            f"What was measured comes {_LATEST:g} s after its command, or later than is tried: were both written by "
            "the same clock?"
        )
    if signals.poses is not None:
        _check_heading(signals, signals.poses)
    usable, more = _usable(signals)
    moving = float(np.count_nonzero(usable) * _period(signals))
    if moving < _LEAST_MOTION:
        raise IdentifyError(
            f"{signals.log}: only {shown(moving, digits=2)} s of it can be used; {_LEAST_MOTION:g} s are the least, "
            "and a minute is good: robotics excite makes one"
        )
    if moving < _SHORT:
        more.append(f"The log has {moving:.0f} s that can be used: intervals are wide. A minute is good.")
    if _period(signals) > 0.25:
        more.append(f"Velocities come every {_period(signals):.2g} s: a lag below that is hardly seen.")
    return SoundSignals(signals, usable, delay, (*signals.remarks, *remarks, *more))


def _period(signals: Signals) -> float:
    return float(np.median(np.diff(signals.velocities.time)))


def _check_times(signals: Signals) -> None:
    given, seen = signals.commands, signals.velocities
    for name, time in (("commands", given.time), ("velocities", seen.time)):
        if len(time) < 10:
            raise IdentifyError(f"{signals.log}: there are {len(time)} {name} in it, which is too little")
    period = _period(signals)
    if period > 2.0:
        unit = "ms" if period < 5e3 else "µs" if period < 5e6 else "ns"
        raise IdentifyError(
            f"{signals.log}: its velocities come every {shown(period)} s by its clock: are the times in {unit}? "
            f"Then call the column time [{unit}]"
        )
    if period < 2e-4:
        raise IdentifyError(
            f"{signals.log}: its velocities come every {shown(period)} s by its clock: no robot tells them so often; "
            "say the unit of the times, such as time [min]"
        )
    if given.time[0] > seen.time[-1] or seen.time[0] > given.time[-1]:
        raise IdentifyError(
            f"{signals.log}: commands are from {given.time[0]:.2f} to {given.time[-1]:.2f} s, and velocities from "
            f"{seen.time[0]:.2f} to {seen.time[-1]:.2f} s: by their clocks they are of different times"
        )


def _without_outliers(signals: Signals) -> tuple[Signals, list[str]]:
    """The same without single numbers that no robot tells, and those that stay whatever the robot does."""
    given, seen = signals.commands, signals.velocities
    said: list[str] = []
    bad = np.zeros(len(seen.time), dtype=bool)
    place = np.maximum(np.searchsorted(given.time, seen.time, side="right") - 1, 0)
    for name, unit, least, told, measured in (
        ("speed", "m/s", _JUMP[0], given.v, seen.v),
        ("turn rate", "rad/s", _JUMP[1], given.w, seen.w),
    ):
        most = max(3 * float(np.abs(told).max()), least)
        beyond = np.abs(measured) > most
        if 0 < beyond.mean() <= _RARE:
            bad |= beyond
            said.append(
                f"{np.count_nonzero(beyond)} of {len(beyond)} measured {name}s are beyond {shown(most)} {unit}, three "
                "times what was commanded: left out."
            )
        for first, last in _constant(seen.time, measured[None], _STUCK):
            asked = told[place[first : np.searchsorted(seen.time, seen.time[last] - 1.0)]]
            if len(asked) and np.ptp(asked) > 0.3 * np.ptp(told):
                bad[first : last + 1] = True
                said.append(
                    f"The measured {name} stays at {shown(measured[first])} {unit} from {seen.time[first]:.2f} s to "
                    f"{seen.time[last]:.2f} s, whatever was commanded: left out."
                )
    if bad.all() or len(seen.time) - np.count_nonzero(bad) < 10:
        return signals, []
    velocities = MeasuredVelocities(*(each[~bad] for each in seen))
    poses, more = _without_lost_poses(signals.poses, velocities)
    return replace(signals, velocities=velocities, poses=poses), said + more


def _constant(time: np.ndarray, values: np.ndarray, least: float) -> list[tuple[int, int]]:
    """The first and the last place of each stretch of ``least`` [s] and more in which values (k, n) never change."""
    changes = np.flatnonzero((np.diff(values, axis=1) != 0).any(axis=0))
    edges = zip([0, *(changes + 1)], [*changes, len(time) - 1], strict=True)
    return [(int(first), int(last)) for first, last in edges if time[last] - time[first] >= least]


def _without_lost_poses(poses: Poses | None, seen: MeasuredVelocities) -> tuple[Poses | None, list[str]]:
    """Poses without those that stand still while the wheels turn, and those that no robot reaches so soon."""
    if poses is None or len(poses.time) < 3:
        return poses, []
    good = np.ones(len(poses.time), dtype=bool)
    said: list[str] = []
    since = np.minimum(np.diff(seen.time, prepend=seen.time[0]), LOG_GAP)
    driven, turned = (np.interp(poses.time, seen.time, np.cumsum(np.abs(each) * since)) for each in (seen.v, seen.w))
    for first, last in _constant(poses.time, np.stack(poses[1:]), _STUCK):
        if driven[last] - driven[first] > 0.1 or turned[last] - turned[first] > 0.3:
            good[first + 1 : last + 1] = False
            said.append(
                f"The pose stays the same from {poses.time[first]:.2f} s to {poses.time[last]:.2f} s while the wheels "
                "turn: left out."
            )
    fastest, kept = 2 * float(np.abs(seen.v).max()) + 0.5, int(np.argmax(good))
    at, lost = poses.x + 1j * poses.y, 0
    for k in np.flatnonzero(good).tolist():
        if abs(at[k] - at[kept]) > fastest * (poses.time[k] - poses.time[kept]) + 0.1:
            good[k], lost = False, lost + 1
        else:
            kept = k
    if lost > 0.5 * len(at):
        return poses, said  # in other units, or odd from the first one on
    if lost:
        said.append(f"{lost} of {len(at)} poses are farther away than the robot comes in that time: left out.")
    return Poses(*(each[good] for each in poses)), said


def _check_sizes(signals: Signals) -> None:
    """Refuse speeds that no such robot has: they are in other units."""
    for what, part in (("commanded", signals.commands), ("measured", signals.velocities)):
        speed, turn = (float(np.quantile(np.abs(each), 0.99)) for each in (part.v, part.w))
        if speed > _FASTEST:
            raise IdentifyError(
                f"{signals.log}: {what} speeds reach {shown(speed)} m/s: are they in mm/s? In a CSV file the header "
                "says the unit, such as v [mm/s]"
            )
        if turn > _FASTEST_TURN:
            raise IdentifyError(
                f"{signals.log}: {what} turn rates reach {shown(turn)} rad/s: are they in degrees per second? In a "
                "CSV file the header says the unit, such as w [deg/s]"
            )
    if not (signals.commands.v.any() or signals.commands.w.any()):
        raise IdentifyError(f"{signals.log}: it commands nothing but to stand still")
    spread = np.ptp(signals.velocities.v), np.ptp(signals.velocities.w)
    if max(spread) < 1e-3 and (np.abs(signals.commands.v).max() > 0.01 or np.abs(signals.commands.w).max() > 0.05):
        raise IdentifyError(
            f"{signals.log}: the robot was commanded up to {shown(np.abs(signals.commands.v).max(), 1)} m/s and "
            f"{shown(np.abs(signals.commands.w).max(), 1)} rad/s, and never moved: were its motors on, and is this the "
            "odometry of the same robot?"
        )
    for name, each in zip(("speed", "turn rate"), spread, strict=True):
        if each < 1e-9:
            raise IdentifyError(
                f"{signals.log}: the measured {name} is the same all the time: a drive must go straight on and turn, "
                "as the commands of robotics excite do"
            )


def _without_long_gaps(signals: Signals) -> tuple[Signals, list[str]]:
    """The same with the times in which nothing at all is told cut down to a few seconds."""
    parts = {
        "commands": signals.commands,
        "velocities": signals.velocities,
        "poses": signals.poses,
        "yaw": signals.yaw,
    }
    times = np.unique(np.concatenate([part.time for part in parts.values() if part is not None]))
    steps = np.diff(times)
    excess = np.concatenate([[0.0], np.cumsum(np.where(steps > _LONGEST_GAP, steps - _LONGEST_GAP, 0.0))])
    long = np.flatnonzero(steps > _LONGEST_GAP)
    if not len(long):
        return signals, []
    moved = {
        name: part and part._replace(time=part.time - excess[np.searchsorted(times, part.time)])
        for name, part in parts.items()
    }
    said = [
        f"The log tells nothing from {times[k]:.2f} s to {times[k + 1]:.2f} s: it is used as two drives." for k in long
    ]
    return Signals(signals.log, **moved, sources=signals.sources, remarks=signals.remarks), said[:3]  # type: ignore[arg-type]


def _check_match(signals: Signals) -> float:
    """Refuse columns that are swapped, turned round or in different units; return the delay [s] of best correlation."""
    given, seen = signals.commands, signals.velocities
    measured = np.stack([seen.v, seen.w])
    best, delay, found = -np.inf, 0.0, np.zeros((2, 2))
    for shift in np.arange(0.0, _LATEST, 0.01):
        place = np.searchsorted(given.time, seen.time - shift, side="right") - 1
        held = np.where(place >= 0, np.stack([given.v, given.w])[:, np.maximum(place, 0)], 0.0)
        table = _correlations(held, measured)
        if np.abs(table).sum() > best:
            best, delay, found, at = np.abs(table).sum(), float(shift), table, held
    straight, crossed = np.abs(np.diag(found)).sum(), np.abs(found[0, 1]) + np.abs(found[1, 0])
    if crossed > straight + 0.4 and crossed > 0.8:
        raise IdentifyError(
            f"{signals.log}: the measured speed follows the commanded turn rate, and the measured turn rate the "
            f"commanded speed: v and w are swapped, in {listed(['the commands', 'the odometry'], 'or')}"
        )
    for k, (name, unit) in enumerate((("speed", "m/s"), ("turn rate", "rad/s"))):
        power = float((at[k] ** 2).mean())
        if power < 1e-8 or abs(found[k, k]) < 0.5:
            continue
        gain = float((at[k] * measured[k]).mean()) / power
        if found[k, k] < 0:
            raise IdentifyError(
                f"{signals.log}: the measured {name} has the opposite sign of the commanded one: one of them counts "
                "the other way round (x is forward, turns to the left are positive)"
            )
        if gain > 4 or gain < 0.25:
            close = min(_FACTORS, key=lambda f: abs(np.log(gain) - np.log(f)) if gain > 1 else abs(np.log(gain * f)))
            raise IdentifyError(
                f"{signals.log}: the measured {name} is {shown(gain, digits=3)} times the commanded one: do they have "
                f"different units, such as {_FACTORS[close]}? Both must be in {unit}"
            )
    if found[0, 0] < 0.3 and found[1, 1] < 0.3:
        raise IdentifyError(
            f"{signals.log}: what was measured does not follow what was commanded (correlation "
            f"{found[0, 0]:.2f} of speeds, {found[1, 1]:.2f} of turn rates, at any delay up to {_LATEST:g} s): are "
            "these the commands of the same robot, by the same clock?"
        )
    return delay


def _correlations(held: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Of each command (2, n) with each measurement (2, n); 0 where one of them is constant."""
    a, b = held - held.mean(axis=1, keepdims=True), measured - measured.mean(axis=1, keepdims=True)
    size = np.sqrt((a**2).sum(axis=1))[:, None] * np.sqrt((b**2).sum(axis=1))[None]
    return np.divide(a @ b.T, size, out=np.zeros((2, 2)), where=size > 1e-9)


def _check_heading(signals: Signals, poses: Poses) -> None:
    """Refuse headings that do not belong to the turn rates: in degrees, or with v and w swapped everywhere."""
    seen = signals.velocities
    time = np.arange(poses.time[0], poses.time[-1], 0.25)
    if len(time) < 20:
        return
    rate = np.diff(np.interp(time, poses.time, poses.heading)) / 0.25
    middle = time[:-1] + 0.125
    v, w = (np.interp(middle, seen.time, each) for each in (seen.v, seen.w))
    _check_places(signals.log, poses, time, v)
    table = _correlations(np.stack([v, w]), np.stack([rate, rate]))[:, 0]
    if abs(table[0]) > 0.7 and abs(table[1]) < 0.4:
        raise IdentifyError(f"{signals.log}: the heading changes with v, and not with w: v and w are swapped")
    gain = float((w * rate).mean() / max((w * w).mean(), 1e-12))
    if table[1] < -0.7:
        raise IdentifyError(
            f"{signals.log}: the heading falls where w is positive: it must count to the left, counter-clockwise"
        )
    if table[1] > 0.7 and gain > 10:
        raise IdentifyError(
            f"{signals.log}: the heading changes {shown(gain, digits=3)} times as fast as w says: is it in degrees? In "
            "a CSV file the header says so: heading [deg]"
        )


def _check_places(log: str, poses: Poses, time: np.ndarray, v: np.ndarray) -> None:
    """Refuse positions that do not go where speed and heading lead: mirrored, turned, or in other units."""
    x, y, heading = (np.interp(time, poses.time, each) for each in poses[1:])
    moved, led = np.diff(x + 1j * y), 0.25 * v * np.exp(1j * (heading[1:] + heading[:-1]) / 2)
    if np.abs(led).sum() < 1.0 or np.abs(moved).sum() < 1e-6:
        return
    # moved = scaled and turned led + scaled and turned mirror image of led
    columns = np.stack([led, led.conj()], axis=1)
    (straight, mirrored), *_ = np.linalg.lstsq(columns, moved, rcond=None)
    if np.abs(moved - columns @ [straight, mirrored]).mean() > 0.5 * np.abs(moved).mean():
        return
    if abs(mirrored) > abs(straight):
        raise IdentifyError(
            f"{log}: x and y are a mirror image of where v and the heading lead: they are swapped, or one of them "
            "counts the other way round (x is where the heading is 0, y to the left of it)"
        )
    if not 0.25 < abs(straight) < 4:
        raise IdentifyError(
            f"{log}: the positions move {shown(abs(straight), digits=3)} times as far as v says: are they in other "
            "units than m? In a CSV file the header says so: x [mm]"
        )
    if abs(turned := float(np.degrees(np.angle(straight)))) > _TURNED:
        raise IdentifyError(
            f"{log}: the robot drives {shown(turned, digits=2)} degrees to the left of where its heading points: the "
            "heading must be 0 along x"
        )


def _usable(signals: Signals) -> tuple[np.ndarray, list[str]]:
    """The samples by which the model is judged (velocities,), and sentences about the others."""
    given, seen = signals.commands.time, signals.velocities.time
    said: list[str] = []
    usable = (seen >= given[0]) & (seen <= given[-1] + LOG_GAP)
    gaps = np.flatnonzero(np.diff(seen) > LOG_GAP)
    for k in gaps:
        usable &= (seen < seen[k] + 1e-9) | (seen > seen[k + 1] + SETTLING_TIME)
    silent = np.flatnonzero(np.diff(given) > LOG_GAP)
    spent = float(np.diff(given)[silent].sum())
    if spent > 0.2 * (given[-1] - given[0]):
        said.append("Commands come seldom: each is taken to hold until the next.")
        silent = silent[:0]
    for k in silent:
        usable &= (seen < given[k] + LOG_GAP) | (seen > given[k + 1] + SETTLING_TIME)
    for what, time, places in (("velocity", seen, gaps), ("command", given, silent)):
        if len(places):
            first = int(places[0])
            more = f", and {len(places) - 1} more such gaps" if len(places) > 1 else ""
            said.append(f"There is no {what} from {time[first]:.2f} s to {time[first + 1]:.2f} s{more}: left out.")
    parts = signals.velocities.v, signals.velocities.w
    if any(abs(np.median(each[:5])) > 0.1 * np.quantile(np.abs(each), 0.95) for each in parts):
        usable &= seen > seen[0] + 1.5
        said.append("The robot was moving when the log began: its first 1.5 s are left out.")
    return usable, said
