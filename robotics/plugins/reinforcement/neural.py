"""A learnt policy as a tracking law: a small network from what a robot observes to its command.

    u = u_max ⊙ clip(W₃ tanh(W₂ tanh(W₁ z + b₁) + b₂) + b₃),   z = clip((o − μ) ⊙ s)

with the observation o of :mod:`robotics.plugins.reinforcement.observed`: the errors (5.9), the speeds by the encoders,
the reference's speeds now and a little later, its curvature there, and the command of the period before. The weights
are a file (:mod:`robotics.plugins.reinforcement.policyfile`), which reinforcement learning has written.

Stability: none is proved. It was shown by runs on random scenarios alone; where it is asked something unlike what it
was trained on, anything may come of it.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fuzzy.compiled.columns import Columns, codes, column, several
from fuzzy.compiled.jit import compiled_only
from fuzzy.quantity import quantity
from robotics.laws.equation import EquationLaw, equation
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting
from robotics.plugins.reinforcement.observed import LastColumns, entries, observe
from robotics.plugins.reinforcement.policyfile import Policy, PolicyColumns, load_policy
from robotics.world.vehicle.plant import Level

_LEVEL = codes(Level)


class NeuralDerived(Columns):
    """What the law makes of its policy and its setting."""

    level = column("", "what is commanded")
    high = several(0, "", "the limits of what is observed")


class NeuralWork(Columns):
    """What the equation works in."""

    units = several(0, "1", "two layers; the first begins as the observation")


@compiled_only
def answer(policy: PolicyColumns, work):  # type: ignore[no-untyped-def]
    """Answer the observation that begins ``work`` by a ``policy``, as PolicyColumns: two numbers within ±1."""
    layers, clip, rest = int(policy.layers), policy.clip, policy.rest
    count = int(rest[0])
    at = layers + 1
    for n in range(count):
        z = (work[n] - rest[at + n]) * rest[at + count + n]
        work[n] = min(max(z, -clip), clip)
    at += 2 * count
    here, there = 0, len(work) // 2
    for k in range(layers):
        before, units = int(rest[k]), int(rest[k + 1])
        for u in range(units):
            total = rest[at + units * before + u]
            for n in range(before):
                total += rest[at + u * before + n] * work[here + n]
            work[there + u] = math.tanh(total) if k + 1 < layers else min(max(total, -1.0), 1.0)
        at += units * before + units
        here, there = there, here
    return work[here], work[here + 1]


@equation
def neural(robot, aim, gain, memory, command, work, rules, known, lane, time, road, path):  # type: ignore[no-untyped-def]
    """Command what the policy answers."""
    observe(robot, aim, memory, time, known.ranges, lane, road, path, gain.high, work.units)
    policy = PolicyColumns(rules)
    one, two = answer(policy, work.units)
    memory.first, memory.second = one * policy.first * gain.first, two * policy.second * gain.second
    command.first, command.second = memory.first, memory.second
    velocities = gain.level == _LEVEL.velocity
    command.wish_v = memory.first if velocities else robot.v
    command.wish_w = memory.second if velocities else robot.w


@dataclass(frozen=True, kw_only=True)
class NeuralPolicy(EquationLaw):
    """A policy that reinforcement learning has found; ``ppo`` comes with the package."""

    policy: str | Policy = "ppo"  # the name of a packaged one, a .json file of `robotics reinforce`, or one itself
    first: float = quantity(1.0, "1", above=0)  # times what it answers: v, or the right wheel's torque
    second: float = quantity(1.0, "1", above=0)  # ω, or the left wheel's torque

    def __post_init__(self) -> None:
        super().__post_init__()
        _ = self.network

    knows = ("reference", "reference velocity", "curvature", "preview", "wheel speeds")
    equation = neural
    remembers, works, derived = LastColumns, NeuralWork, NeuralDerived

    @property
    def learnt_how(self) -> str:
        """The training of its policy."""
        return self.network.training

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

    def derive(self, setting: Setting) -> Mapping[str, Any]:
        """The limits of what each robot observes. Raises ControllerError where it was trained on other observations."""
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
        return {"level": _LEVEL._fields.index(self.level), "high": np.array(highs).T}

    def begin(self, setting: Setting, runs: int) -> np.ndarray:
        """It remembers its last command. Raises ControllerError where it was trained on other observations."""
        if setting.kind != "tracking":
            raise ControllerError(f"{setting.name} is a {setting.kind}; a learnt policy drives tracking scenarios")
        self.derive(setting)
        return super().begin(setting, runs)
