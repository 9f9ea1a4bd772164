"""The bodies of all runs in MuJoCo, moved by the voltages of the robots' own wheel loops.

The wheel loops, the bounds of commands, the encoders and odometry are those of the simulator
(:mod:`robotics.world.vehicle.plant`), every 10 ms; what lies between a voltage and the angle of a wheel is MuJoCo's.
"""

from pathlib import Path
from typing import Any

import numpy as np

from fuzzy.extras import install_command
from robotics.laws.setting import Setting
from robotics.plugins.mujoco.mjcf import Ground, scene
from robotics.simulation.lanes import PlantLanes
from robotics.simulation.physics import Mover, PhysicsError
from robotics.world.vehicle import plant
from robotics.world.vehicle.plant import ParameterColumns, TruthColumns

# Coordinates of a robot: a free joint's place and quaternion, and two wheels; their rates
_PLACES, _RATES = 9, 8


def mujoco_module() -> Any:
    """The package ``mujoco``. Raises PhysicsError where it is not installed."""
    try:
        import mujoco
    except ImportError:
        raise PhysicsError(f"the plant mujoco needs MuJoCo: {install_command('mujoco')}") from None
    return mujoco


class Mujoco(Ground):
    """MuJoCo as the plant of a simulation: what ``--plant mujoco:friction=0.3`` means."""

    def opened(self, setting: Setting, body: PlantLanes) -> Mover:
        """What moves the robots. Raises PhysicsError for a scenario that it cannot have, and without the package."""
        return self.worlds(setting, body).move

    def filmed(self, name: str, target: Path) -> Any:
        """The same, which writes a film of the first run afterwards; ``name`` is what the plant is called."""
        mujoco_module()
        from robotics.plugins.mujoco.film import MujocoFilm

        return MujocoFilm(self.worlds, name, target)

    def worlds(self, setting: Setting, body: PlantLanes) -> "MujocoWorlds":
        """The worlds of all runs. Raises PhysicsError."""
        if setting.plant == "kinematic":
            raise PhysicsError('mujoco moves masses by motors: plant = "dynamic" is accepted in the scenario')
        if setting.world is not None and (setting.world.motion is not None or setting.world.runs > 1):
            raise PhysicsError("mujoco: an obstacle moves by itself; obstacles at rest are accepted")
        return MujocoWorlds(mujoco_module(), self, setting, body)


class MujocoWorlds:
    """One world a run, of one model."""

    def __init__(self, module: Any, ground: Ground, setting: Setting, body: PlantLanes) -> None:
        robots = setting.truth.robots if setting.truth else setting.robots
        world = None if setting.world is None else setting.world.rest
        self.module, self.robots = module, len(robots)
        self.holds_torque = body.code == plant.CODES["torque"]
        self.model = module.MjModel.from_xml_string(scene(robots, world, ground, emf=not self.holds_torque))
        self.substeps = round(body.step / ground.step)
        lanes = body.truth.shape[1]
        self.worlds = [module.MjData(self.model) for _ in range(lanes // self.robots)]
        truth = TruthColumns(body.truth)
        for run, data in enumerate(self.worlds):
            place, _ = self.coordinates(data)
            own = slice(run * self.robots, (run + 1) * self.robots)
            place[:, 0], place[:, 1] = truth.x[own], truth.y[own]
            place[:, 3], place[:, 6] = np.cos(truth.heading[own] / 2), np.sin(truth.heading[own] / 2)
        self.volts = np.zeros((2, lanes))

    def coordinates(self, data: Any) -> tuple[np.ndarray, np.ndarray]:
        """Views of a world's coordinates (robots, 9) and of their rates (robots, 8)."""
        place, rate = data.qpos[: _PLACES * self.robots], data.qvel[: _RATES * self.robots]
        return place.reshape(self.robots, _PLACES), rate.reshape(self.robots, _RATES)

    def move(self, k: int, body: PlantLanes, order: np.ndarray, stopped: np.ndarray, lost: np.ndarray) -> None:
        """As :func:`robotics.simulation.steps.move`: stop the robots that are lost, and move all by period ``k``."""
        stopped[lost] = k
        order[:, stopped >= 0] = 0.0
        flights = len(body.pending)
        body.pending[k % flights] = order
        earlier, command = (body.pending[(k - body.late_periods - n) % flights] for n in (1, 0))
        for step in range(body.steps):
            self.step(body, earlier if step < body.late_steps else command)

    def step(self, body: PlantLanes, held: np.ndarray) -> None:
        """Run the wheel loops, hold their voltages for 10 ms, and read the encoders."""
        state, truth = body.truth, TruthColumns(body.truth)
        before = np.stack([truth.right.angle, truth.left.angle])
        plant.run_wheel_loops(self.volts, state, body.parameters, held, body.step, body.code, body.scratch)
        for run, data in enumerate(self.worlds):
            own = slice(run * self.robots, (run + 1) * self.robots)
            place, rate = self.coordinates(data)
            volts = self.volts[:, own].T
            if self.holds_torque:  # as far as the supply goes against the back EMF
                robot = ParameterColumns(body.parameters)
                back, most = robot.ke[own, None] * rate[:, 6:], robot.voltage[own, None]
                volts = np.clip(volts, -most - back, most - back)
            data.ctrl[:] = volts.ravel()
            self.module.mj_step(self.model, data, self.substeps)
            _read(truth, own, place, rate)
            truth.work[own] += (data.actuator_force.reshape(-1, 2) * rate[:, 6:]).sum(axis=1) * body.step
        plant.read_wheels(state, body.parameters, before, body.step, body.scratch)


def _read(truth: TruthColumns, own: slice, place: np.ndarray, rate: np.ndarray) -> None:
    """Write where robots are and how they move: the middle of the axle, v along the heading, ω about the own axis."""
    x, y, _, q0, q1, q2, q3, right, left = place.T
    heading = np.arctan2(2 * (q0 * q3 + q1 * q2), 1 - 2 * (q2 * q2 + q3 * q3))
    turned = (heading - truth.heading[own] + np.pi) % (2 * np.pi) - np.pi
    truth.x[own], truth.y[own] = x, y
    truth.heading[own] += turned
    truth.v[own] = rate[:, 0] * np.cos(heading) + rate[:, 1] * np.sin(heading)
    truth.w[own] = rate[:, 5]
    truth.right.angle[own], truth.left.angle[own] = right, left
