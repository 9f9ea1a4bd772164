"""Rule bases asked, and the emergency rule, on arrays."""

from collections.abc import Mapping

import numpy as np

from robotics.laws.rules.clearances import SECTOR
from robotics.laws.rules.emergency import ASIDE, COMES_NEARER, FAR, SETTLED, TURNING, UNSURE, EmergencySettings
from robotics.laws.rules.evaluation import ADDED, RuleBase
from tests.robotics.laws.rules.arrayform import quantities
from tests.robotics.laws.rules.arrayform.situation import Situation


def ask(base: RuleBase, situation: Situation, neutral: Mapping[str, float]) -> tuple[dict[str, np.ndarray], np.ndarray]:
    """What a rule base says in ``situation``, by output, (runs, robots) each; and its inputs (inputs, runs, robots).

    Where it is of pairs, turns of all other robots add up and of all else the least holds; the inputs are those of
    the robot for which the least was said. ``neutral`` is what it says of a robot that is not heard. A rule base
    without rules says nothing.
    """
    known = told(base, situation)
    said = answer(base, known) if base.fis.rules else {}
    if not base.of_pairs:
        return said, np.moveaxis(known, -1, 0)
    ignored = ~situation.seen.heard.hears | np.isnan(situation.others.gap)
    out = {}
    for name, values in said.items():
        values = np.where(ignored, neutral[name], values)
        out[name] = values.sum(axis=-1) if name in ADDED else values.min(axis=-1)
    worst = _most_urgent(said, ignored)
    inputs = np.take_along_axis(known, worst[..., None, None], axis=-2)[..., 0, :]
    alone = ignored.all(axis=-1)  # nobody is heard: there are no inputs to show
    return out, np.moveaxis(np.where(alone[..., None], np.nan, inputs), -1, 0)


def _most_urgent(said: Mapping[str, np.ndarray], ignored: np.ndarray) -> np.ndarray:
    """The place of the other robot of which the first output that does not add up is least, or the turn largest."""
    least = [name for name in said if name not in ADDED]
    if least:
        return np.asarray(np.where(ignored, np.inf, said[least[0]]).argmin(axis=-1))
    turn = np.abs(next(iter(said.values()))) if said else 0.0
    return np.asarray(np.where(ignored, -1.0, turn).argmax(axis=-1))


def told(base: RuleBase, situation: Situation) -> np.ndarray:
    """The inputs of a rule base (runs, robots, inputs), or of one of pairs (runs, robots, others, inputs)."""
    rows = [quantities.known(variable.name, situation) for variable in base.fis.inputs]
    if base.of_pairs:
        shape = (*situation.place.shape, situation.place.shape[1])
        rows = [
            np.broadcast_to(row if quantity.pair else row[..., None], shape)
            for row, quantity in zip(rows, base.inputs, strict=True)
        ]
    out = np.empty((*rows[0].shape, len(rows)))
    for k, (row, variable) in enumerate(zip(rows, base.fis.inputs, strict=True)):
        out[..., k] = np.nan_to_num(row, nan=variable.universe[1], posinf=variable.universe[1])
    return out


def answer(base: RuleBase, known: np.ndarray) -> dict[str, np.ndarray]:
    """The outputs of a rule base by name, with the axes of ``known`` but the last."""
    out = base.compiled(known)
    return {name: out[..., k] for name, k in base.outputs.items()}


def kept(
    guard: EmergencySettings, now: Situation, v: np.ndarray, w: np.ndarray, halted: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bring commands down to what is safe.

    Args:
        guard: The emergency rule's numbers.
        now: What the robots know.
        v: The speeds wanted [m/s] (runs, robots).
        w: The turn rates wanted [rad/s] (runs, robots).
        halted: For how long [s] each robot has stood still for what comes nearer (runs, robots); 0: it does not.

    Returns the safe speeds and turn rates, and for how long each robot has stood still now.
    """
    if not guard.on:
        return v, w, halted
    seen, them = now.seen, now.others
    begins = (now.nearest_room < guard.near) & (now.nearing > COMES_NEARER) & (halted == 0)
    goes_on = (halted > 0) & (now.nearing > SETTLED)
    halted = np.where(begins | (goes_on & (now.nearest_room < 2 * guard.near)), halted + now.dt, 0.0)
    # Where a team-mate is known to be there may be something else as well.
    clear = np.minimum(now.clear, now.echoes)
    front = np.minimum(clear[SECTOR.front_left], clear[SECTOR.front_right]) + TURNING
    v = np.minimum(v, np.maximum(_fastest(guard, front - guard.least, 0.0), 0.0))
    v = np.maximum(v, -np.maximum(_fastest(guard, clear[SECTOR.behind] - guard.least, 0.0), 0.0))
    halts = halted > 0
    v, w = np.where(halts | ((v < 0) & (now.way_back <= 0)), 0.0, v), np.where(halts, 0.0, w)
    if not seen.heard.fields:
        return v, w, halted
    forward = np.sign(np.where(v == 0, 1.0, v))[:, :, None]
    cos = np.cos(them.bearing) * forward
    dx, dy = them.x - seen.x[:, :, None], them.y - seen.y[:, :, None]
    distance = np.maximum(np.hypot(dx, dy), 1e-6)
    approach = np.maximum(-(dx * them.v_x + dy * them.v_y) / distance, 0.0)
    # An old message says less of where the other is.
    unsure = UNSURE * np.minimum(them.age, 1.0) * np.hypot(them.v_x, them.v_y)
    room = them.gap - guard.least - approach * guard.delay - unsure
    fastest = _fastest(guard, room, approach) / np.maximum(cos, ASIDE)
    limit = np.where((cos > ASIDE) & (them.gap < FAR), fastest, np.inf).min(axis=-1)
    return np.asarray(np.sign(v) * np.minimum(np.abs(v), limit)), w, halted


def _fastest(guard: EmergencySettings, room: np.ndarray, approach: np.ndarray | float) -> np.ndarray:
    """The largest v [m/s] with v t + v²/(2 a) + u v/a ≤ ``room`` [m]."""
    b = guard.delay + np.asarray(approach) / guard.braking
    root = np.sqrt(b**2 + 2 * np.maximum(room, 0.0) / guard.braking)
    return np.asarray(guard.braking * (root - b))
