"""Other Python simulators of wheeled robots, each in a virtual environment of its own: robot-ticks a second.

None has the closed loop of :mod:`benchmarks.closedloop`: their robots take a velocity and have it at once, without
encoders, wheel loops, motors, friction, noise or latency, and here nobody asks them for a law: they get one command and
drive on. What they have instead is said in PEERS.

Run by :mod:`benchmarks.closedloop`. ``python -m benchmarks.robotsimulators NAME`` measures one, in the Python that
runs it, and prints one JSON object; it needs that simulator and numpy.
"""

import json
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path
from typing import Any, NamedTuple

ROBOTS, RUNS, PERIOD = 3, 1024, 0.05  # s
COMMAND = (0.3, 0.1)  # m/s, rad/s
LEAST = 1.0  # s: so long is each measured
BUILD = Path(__file__).parents[1] / "build"


class Peer(NamedTuple):
    """A simulator and what it models."""

    package: str
    needs: tuple[str, ...]  # packages to install; versions are those of constraints.txt
    models: str


PEERS = {
    "IR-SIM": Peer(
        "ir-sim", ("ir-sim",), "one run at a time, kinematic unicycles; here without sensors, collisions and pictures"
    ),
    "VMAS": Peer(
        "vmas",
        ("vmas", "torch==2.13.0"),
        "runs as a batch in torch, unicycles by Runge-Kutta, as forces on discs, with collisions; one thread",
    ),
}


def measured(name: str) -> dict[str, Any]:
    """What a peer's own Python measures. Raises ImportError with a sentence where it cannot be had."""
    folder = BUILD / name.lower()
    python = folder / "bin" / "python"
    if not (folder / "ready").exists():
        constraints = Path(__file__).parents[1] / "constraints.txt"
        wanted = ["--quiet", "--constraint", str(constraints), "numpy", *PEERS[name].needs]
        try:
            venv.create(folder, with_pip=True, clear=True)
            subprocess.run([python, "-m", "pip", "install", *wanted], check=True, capture_output=True, timeout=900)
        except (OSError, subprocess.SubprocessError):
            raise ImportError(f"{PEERS[name].package} cannot be installed here") from None
        (folder / "ready").touch()
    done = subprocess.run([python, Path(__file__), name], capture_output=True, text=True, timeout=600)
    if done.returncode != 0:
        raise ImportError(f"{PEERS[name].package} does not run: {(done.stderr.strip().splitlines() or ['?'])[-1]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def _rate(step: Any, robots: int) -> float:
    """Robot-ticks a second of a simulation whose ``step`` moves so many robots by a period."""
    for _ in range(3):
        step()
    steps, begun = 0, time.perf_counter()
    while (passed := time.perf_counter() - begun) < LEAST:
        step()
        steps += 1
    return steps * robots / passed


def irsim() -> dict[str, float]:
    """IR-SIM: three differential drives in one world."""
    import irsim as package
    import numpy as np

    robot = (
        "  - {{kinematics: {{name: diff}}, shape: {{name: circle, radius: 0.1}}, state: [0, {y}, 0], goal: [90, 0, 0]}}"
    )
    head = f"world: {{height: 200, width: 200, offset: [-100, -100], step_time: {PERIOD}, sample_time: {PERIOD}, "
    lines = [head + "collision_mode: unobstructed}", "robot:", *(robot.format(y=2 * i) for i in range(ROBOTS))]
    with tempfile.TemporaryDirectory() as folder:
        world = Path(folder, "world.yaml")
        world.write_text("\n".join(lines), encoding="utf-8")
        world_options = {"display": False, "disable_all_plot": True, "log_level": "ERROR"}
        simulation = package.make(str(world), **world_options)
    actions = [np.array(COMMAND).reshape(2, 1) for _ in range(ROBOTS)]
    return {"one run": _rate(lambda: simulation.step(actions), ROBOTS)}


def vmas() -> dict[str, float]:
    """VMAS: three differential drives in each of one and of RUNS worlds."""
    import torch
    from vmas import make_env
    from vmas.simulator.core import Agent, World
    from vmas.simulator.dynamics.diff_drive import DiffDrive
    from vmas.simulator.scenario import BaseScenario

    torch.set_num_threads(1)

    class Free(BaseScenario):  # type: ignore[misc,unused-ignore]
        """Robots far from each other, no task."""

        def make_world(self, batch_dim: int, device: Any, **kwargs: Any) -> Any:
            world = World(batch_dim, device, dt=PERIOD)
            for i in range(ROBOTS):
                drive = DiffDrive(world, integration="rk4")
                world.add_agent(Agent(name=f"robot {i}", u_range=[1, 5], u_multiplier=[1, 1], dynamics=drive))
            return world

        def reset_world_at(self, env_index: int | None = None) -> None:
            for i, agent in enumerate(self.world.agents):
                agent.set_pos(torch.tensor([0.0, 2.0 * i]), batch_index=env_index)

        def reward(self, agent: Any) -> Any:
            return torch.zeros(self.world.batch_dim)

        def observation(self, agent: Any) -> Any:
            return agent.state.pos

    found = {}
    for name, runs in (("one run", 1), (f"{RUNS:,} runs", RUNS)):
        worlds = make_env(Free(), num_envs=runs, continuous_actions=True, seed=0)
        actions = [torch.tensor(COMMAND).repeat(runs, 1) for _ in range(ROBOTS)]
        found[name] = _rate(lambda worlds=worlds, actions=actions: worlds.step(actions), runs * ROBOTS)
    return found


if __name__ == "__main__":
    from importlib.metadata import version

    asked = sys.argv[1]
    rates = {"IR-SIM": irsim, "VMAS": vmas}[asked]()
    print(json.dumps({"version": version(PEERS[asked].package), "robot_ticks_per_s": rates}))
