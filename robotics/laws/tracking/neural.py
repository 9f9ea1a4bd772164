"""A learnt policy as a tracking law: a small network from what a robot observes to its command.

    u = u_max ⊙ clip(W₃ tanh(W₂ tanh(W₁ z + b₁) + b₂) + b₃),   z = clip((o − μ) ⊙ s)

with the observation o of :mod:`robotics.laws.tracking.observed`: the errors (5.9), the speeds by the encoders, the
reference's speeds now and a little later, its curvature there, and the command of the period before. The weights are a
file (:mod:`robotics.laws.tracking.policyfile`), which reinforcement learning has written.

Stability: none is proved. It was shown by runs on random scenarios alone; where it is asked something unlike what it
was trained on, anything may come of it.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fuzzy.compiled.jit import inner
from robotics.laws.equation import FIRST, SECOND, WISH_V, WISH_W, EquationLaw, V, W, equation
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.laws.tracking.observed import entries, observe
from robotics.laws.tracking.policyfile import Policy, load_policy
from robotics.quantity import check_quantities, quantity
from robotics.vehicle.plant import Level

FACTORS = 3  # gains before the limits of the observation: two factors, and whether velocities are commanded
CLIP, MOST_1, MOST_2, LAYERS, SIZES = range(5)  # places of a packed policy


@inner
def answer(rules, row, work):  # type: ignore[no-untyped-def]
    """Answer the observation that begins ``work`` by the policy in a ``row`` of ``rules``: two numbers within ±1."""
    layers, clip = int(rules[row, LAYERS]), rules[row, CLIP]
    count = int(rules[row, SIZES])
    at = SIZES + layers + 1
    for n in range(count):
        z = (work[n] - rules[row, at + n]) * rules[row, at + count + n]
        work[n] = min(max(z, -clip), clip)
    at += 2 * count
    half = len(work) // 2
    here, there = 0, half
    for k in range(layers):
        before, units = int(rules[row, SIZES + k]), int(rules[row, SIZES + k + 1])
        for u in range(units):
            total = rules[row, at + units * before + u]
            for n in range(before):
                total += rules[row, at + u * before + n] * work[here + n]
            work[there + u] = math.tanh(total) if k + 1 < layers else min(max(total, -1.0), 1.0)
        at += units * before + units
        here, there = there, here
    return work[here], work[here + 1]


@equation
def neural(i, known, memory, command, work):  # type: ignore[no-untyped-def]
    """Command what the policy answers."""
    g, gains, row = known.column[i], known.gains, known.base[i]
    observe(i, known.time, known.seen, known.ranges, known.road, known.path[i], memory, gains[FACTORS:], g, work)
    one, two = answer(known.rules, row, work)
    one, two = one * known.rules[row, MOST_1] * gains[0, g], two * known.rules[row, MOST_2] * gains[1, g]
    memory[0, i], memory[1, i] = one, two
    command[FIRST, i], command[SECOND, i] = one, two
    velocities = gains[2, g] > 0
    command[WISH_V, i] = one if velocities else known.seen[V, i]
    command[WISH_W, i] = two if velocities else known.seen[W, i]


@dataclass(frozen=True, kw_only=True)
class NeuralPolicy(EquationLaw):
    """A policy that reinforcement learning has found; ``ppo`` comes with the package."""

    policy: str | Policy = "ppo"  # the name of a packaged one, a .json file of `robotics reinforce`, or one itself
    first: float = quantity(1.0, "1", above=0)  # times what it answers: v, or the right wheel's torque
    second: float = quantity(1.0, "1", above=0)  # ω, or the left wheel's torque

    def __post_init__(self) -> None:
        check_quantities(self, ControllerError)
        _ = self.network

    knows = ("reference", "reference velocity", "curvature", "preview", "wheel speeds")
    equation = neural

    @cached_property
    def network(self) -> Policy:
        """The policy of the file."""
        return self.policy if isinstance(self.policy, Policy) else load_policy(self.policy)

    @property
    def name(self) -> str:
        """What messages call the policy."""
        return self.policy if isinstance(self.policy, str) else "at hand"

    @property
    def level(self) -> Level:
        """What the policy commands."""
        return self.network.level

    @property
    def needs(self) -> tuple[str, ...]:
        """The range sensors that it was trained with."""
        found = (name for name in self.network.inputs if name.startswith("range_"))
        return tuple(name.removeprefix("range_") for name in found)

    @property
    def working(self) -> int:
        """Room for two layers."""
        return 2 * self.network.widest

    def rule_rows(self) -> Sequence[np.ndarray]:
        """The network."""
        return (self.network.packed,)

    def gain_rows(self, setting: Setting) -> Sequence[Any]:
        """The factors, and the limits of what each robot observes."""
        highs = []
        for robot in range(len(setting.robots)):
            found = entries(setting, self.level, self.needs, robot)
            names = tuple(entry.name for entry in found)
            if names != self.network.inputs:
                strange = [name for name in self.network.inputs if name not in names] or list(self.network.inputs)
                raise ControllerError(
                    f"the policy {self.name} observes {', '.join(strange)}, in another order or not at all here; "
                    "train it anew with this version"
                )
            highs.append([entry.high for entry in found])
        velocities = float(self.level == "velocity")
        return [self.first, self.second, velocities, *np.array(highs).T]

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """It remembers its last command. Raises ControllerError where it was trained on other observations."""
        if setting.kind != "tracking":
            raise ControllerError(f"{setting.name} is a {setting.kind}; a learnt policy drives tracking scenarios")
        self.gain_rows(setting)
        return np.zeros((2, runs, len(setting.robots)))
