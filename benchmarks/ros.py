"""Does the loop over ROS 2 keep its time? Three robots at 20 Hz over DDS, and a drive in lockstep beside none of it.

Real time: the simulator and three controllers, each a process of its own, drive the scenario three-cross; a fifth
listens to the three ``cmd_vel``. The period's error is how far the time between two commands of a robot is from 50 ms:
as they arrive here, and as the controllers stamped them. Beside it stands the same error of a process that does nothing
but sleep at the same time: what the machine itself is good for then. Aimed for, on a quiet machine: 99 % within 5 ms.

Lockstep: the same fleet as fast as it goes, and how far its tracks are from those of ``robotics run``.

Run ``python -m benchmarks.ros [--json] [--quick]``. DDS stays on this machine.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.reporting import heading, machine, start
from robotics.simulation.loop import simulate
from robotics.simulation.run import load_run
from robotics.simulation.scenario.reading import load_scenario

PERIOD, SECONDS, QUICK, WARM = 0.05, 60.0, 10.0, 2.0  # s; of the first seconds nothing is counted
SCENARIO, LAW, ROBOTS = "three-cross", "right-of-way", 3
AIM, NEAR = 5e-3, 1e-3  # s, m
PACKAGE = Path(__file__).parent.parent / "ros"


def errors_of(times: Sequence[float]) -> np.ndarray:
    """How far the time [s] between each two of ``times`` is from a period, after the first seconds."""
    later = np.asarray(times)
    return np.abs(np.diff(later[later > later[0] + WARM]) - PERIOD)


def told(errors: np.ndarray) -> dict[str, float]:
    """Median, 99th percentile and maximum [ms]."""
    parts = (np.quantile(errors, 0.5), np.quantile(errors, 0.99), errors.max())
    return dict(zip(("median_ms", "p99_ms", "max_ms"), (1e3 * float(part) for part in parts), strict=True))


def asleep(seconds: float) -> list[float]:
    """When a loop wakes [s] that only sleeps until the next period."""
    begin, times = time.monotonic(), []
    for k in range(1, int(seconds / PERIOD)):
        time.sleep(max(0.0, begin + k * PERIOD - time.monotonic()))
        times.append(time.monotonic())
    return times


def real_time(seconds: float) -> dict[str, Any]:
    """The errors of the commands of three robots, and what the processes have used of the processor."""
    import rclpy
    from geometry_msgs.msg import TwistStamped
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node

    from fuzzyfleet_ros.fleet import commands

    arrived: list[list[float]] = [[] for _ in range(ROBOTS)]
    stamped: list[list[float]] = [[] for _ in range(ROBOTS)]
    rclpy.init()
    node, executor = Node("listener"), SingleThreadedExecutor()
    executor.add_node(node)
    for i in range(ROBOTS):

        def note(message: TwistStamped, i: int = i) -> None:
            arrived[i].append(time.monotonic())
            stamped[i].append(message.header.stamp.sec % 10_000 + 1e-9 * message.header.stamp.nanosec)

        node.create_subscription(TwistStamped, f"/robot{i + 1}/cmd_vel", note, 10)
    fleet = [subprocess.Popen(line) for line in commands(SCENARIO, LAW, ROBOTS, {"duration": seconds}, {})]
    line = f"import json; from benchmarks.ros import asleep; print(json.dumps(asleep({seconds})))"
    sleeper = subprocess.Popen([sys.executable, "-c", line], stdout=subprocess.PIPE, text=True)
    used = {process.pid: 0.0 for process in fleet}
    look = 0.0
    try:
        while fleet[0].poll() is None:
            executor.spin_once(timeout_sec=0.5)
            if time.monotonic() > look + 1.0:
                look = time.monotonic()
                used |= {process.pid: spent for process in fleet if (spent := _processor_time(process.pid)) > 0}
    finally:
        for process in fleet:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
        for process in fleet:
            process.wait(20)
        node.destroy_node()
        rclpy.shutdown()
    end = min(times[0] for times in arrived) + seconds  # after it the simulator is gone, and the robots are let stand
    within = [[t for t in times if t < end] for times in arrived]
    marks = [marks[: len(times)] for marks, times in zip(stamped, within, strict=True)]
    woken = json.loads(sleeper.communicate(timeout=20)[0])
    return {
        "asleep": told(errors_of(woken)),
        "arrived": told(np.concatenate([errors_of(times) for times in within])),
        "stamped": told(np.concatenate([errors_of(times) for times in marks])),
        "commands": sum(len(times) for times in within),
        "cpu_s": {"simulator": used[fleet[0].pid], "controllers": [used[p.pid] for p in fleet[1:]]},
    }


def _processor_time(pid: int) -> float:
    """What a process has used of the processor [s], where the system tells."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return 0.0
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def lockstep(seconds: float) -> dict[str, float]:
    """How far a drive in lockstep is from that of the simulator alone [m], and how many periods a second it does."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "run.npz"
        words = [SCENARIO, LAW, "--lockstep", "--duration", str(seconds), "--save", str(file)]
        begun = time.monotonic()
        subprocess.run([sys.executable, "-m", "fuzzyfleet_ros.fleet", *words], check=True)
        took = time.monotonic() - begun
        run = load_run(file)
    alone = simulate(replace(load_scenario(SCENARIO), duration=seconds), LAW, [0])
    apart = np.hypot(run["x"] - alone["x"], run["y"] - alone["y"])
    return {"farthest_m": float(apart.max()), "wall_s": took, "simulated_s": seconds}


def measure(quick: bool) -> dict[str, Any]:
    """Everything; ``quick``: a sixth of the time."""
    sys.path.insert(0, str(PACKAGE))
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [str(PACKAGE), os.environ.get("PYTHONPATH", "")]))
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ["ROS_DOMAIN_ID"] = str(1 + os.getpid() % 100)
    seconds = QUICK if quick else SECONDS
    result = machine(["fuzzyfleet", "ros-rclpy", "ros-rmw-fastrtps-cpp"])
    return result | {
        "seconds": seconds,
        "load": os.getloadavg()[0],
        "real_time": real_time(seconds),
        "lockstep": lockstep(seconds),
    }


def report(result: dict[str, Any]) -> str:
    """The tables."""
    real = result["real_time"]
    rows = {
        "a loop that only sleeps": real["asleep"],
        "commands as they arrive": real["arrived"],
    }
    rows["commands as stamped"] = real["stamped"]
    text = [
        heading(result),
        f"load of the machine before: {result['load']:.1f}",
        "",
        f"Three robots at 20 Hz over DDS, {result['seconds']:g} s: the period's error [ms]",
        f"{'':26}{'median':>9}{'99 %':>9}{'most':>9}",
        *(f"{name:26}{r['median_ms']:9.2f}{r['p99_ms']:9.2f}{r['max_ms']:9.2f}" for name, r in rows.items()),
    ]
    held = real["arrived"]["p99_ms"] <= 1e3 * AIM
    cpu = real["cpu_s"]
    spent = ", ".join(f"{seconds:.1f}" for seconds in cpu["controllers"])
    text += [
        f"aim: 99 % within {1e3 * AIM:g} ms: {'reached' if held else 'missed'}; {real['commands']} commands",
        f"processor: simulator {cpu['simulator']:.1f} s, controllers {spent} s, starts included",
    ]
    step = result["lockstep"]
    near = "reached" if step["farthest_m"] <= NEAR else "missed"
    return "\n".join(
        [
            *text,
            "",
            f"Lockstep: {step['simulated_s']:g} s took {step['wall_s']:.1f} s with all starts; tracks at most "
            f"{step['farthest_m']:.2g} m from those of robotics run (aim: {NEAR:g} m: {near})",
        ]
    )


def main() -> None:
    try:
        import rclpy  # noqa: F401
    except ImportError:
        print("benchmarks.ros is left out: rclpy is not installed (pip install '.[ros]')")
        return
    start(__doc__, measure, report, quick="a sixth of the time")


if __name__ == "__main__":
    main()
