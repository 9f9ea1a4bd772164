"""A whole fleet from one command: the simulator and a controller for each robot of a scenario, until it is over.

    python -m fuzzyfleet_ros.fleet three-cross fuzzy --save run.npz

It needs no ``ros2 launch``, which the wheels of the package index do not have.
"""

import argparse
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence

from fuzzyfleet_ros.starting import missing

_PATIENCE = 10.0  # s that a node may take to end after it was told to


def node_command(module: str, parameters: Mapping[str, object], namespace: str = "") -> list[str]:
    """The command that starts a node of this package with some parameters.

    >>> node_command("controller", {"law": "fuzzy"}, "/robot1")[1:]
    ['-m', 'fuzzyfleet_ros.controller', '--ros-args', '-r', '__ns:=/robot1', '-p', 'law:=fuzzy']
    """
    words = [sys.executable, "-m", f"fuzzyfleet_ros.{module}", "--ros-args"]
    if namespace:
        words += ["-r", f"__ns:={namespace}"]
    for name, value in parameters.items():
        if value == "":
            continue
        shown = str(value).lower() if isinstance(value, bool) else str(value)
        words += ["-p", f"{name}:={shown}"]
    return words


def commands(
    scenario: str, law: str, robots: int, simulator: Mapping[str, object], controller: Mapping[str, object]
) -> list[list[str]]:
    """The commands that start the simulator, and then each robot's controller, with parameters beside the usual."""
    shared = {"scenario": scenario, "law": law}
    made = [node_command("simulator", {**shared, **simulator})]
    for i in range(robots):
        space = f"/robot{i + 1}" if robots > 1 else ""
        made.append(node_command("controller", {**shared, "member": i + 1, **controller}, space))
    return made


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the fleet; return the exit status: 0 where the simulator came to its end."""
    parser = argparse.ArgumentParser(prog="fleet", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("scenario", help="a scenario's name or .toml file")
    parser.add_argument("law", nargs="?", default="", help="a law as the command line names it (the scenario's)")
    parser.add_argument("--robot", default="", help="a robot's name or .toml file (the scenario's)")
    parser.add_argument("--seed", type=int, default=0, help="of all noise (0)")
    parser.add_argument("--duration", type=float, default=0.0, help="s (the scenario's)")
    parser.add_argument("--lockstep", action="store_true", help="as fast as it goes, each period together")
    parser.add_argument("--unstamped", action="store_true", help="velocities are Twist, not TwistStamped")
    parser.add_argument("--save", default="", help="a file .npz for the run")
    options = parser.parse_args(arguments)
    if lacks := missing(("fuzzy", "robotics")):
        print(f"fleet: {lacks}", file=sys.stderr)
        return 2
    from fuzzy.errors import InputError
    from fuzzyfleet_ros.names import scenario_of

    try:
        scenario = scenario_of(options.scenario, options.robot)
    except InputError as error:
        print(f"fleet: {error}", file=sys.stderr)
        return 2
    both: dict[str, object] = {"robot": options.robot, "lockstep": options.lockstep, "stamped": not options.unstamped}
    simulator = {**both, "seed": options.seed, "duration": options.duration, "save": options.save}
    # Whoever waits for slower ones in lockstep is no danger to anybody
    controller = {**both, "odom_timeout": 10.0} if options.lockstep else both
    law = options.law or scenario.controller or "fuzzy"
    return _together(commands(options.scenario, law, len(scenario.robots), simulator, controller))


def _together(lines: Sequence[Sequence[str]]) -> int:
    """Run the commands until the first has ended, or any other has failed; end the others."""
    running = [subprocess.Popen(line) for line in lines]
    status = None
    try:
        while status is None:
            failed = [process.returncode for process in running[1:] if process.poll()]
            status = failed[0] if failed else running[0].poll()
            time.sleep(0.05)
    except KeyboardInterrupt:
        status = 130
    for process in running:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
    for process in running:
        try:
            process.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
    return status


if __name__ == "__main__":
    sys.exit(main())
