"""The oracle of predictive control: the same problem, written once more in CasADi and solved by IPOPT.

CasADi is the extra ``mpc``; the package itself never imports it. The states are unknowns beside the commands (multiple
shooting), all inequalities are those of the problem, and the derivatives are exact.

Run ``python -m benchmarks.ipopt tests/data/predictive/ipopt.csv`` to make the stored costs of the tests anew.
"""

import argparse
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.predictiveproblems import random_problems
from benchmarks.predictivesolving import Problem, plans_of
from fuzzy.files.atomic import replacing
from robotics.simulation.scenario.robots import load_robot

OPTIONS: dict[str, Any] = {
    "print_time": False,
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "ipopt.tol": 1e-8,
    "ipopt.max_iter": 500,
}


class Ipopt:
    """The solver for all problems of the same horizon, robot and weights as ``like``."""

    def __init__(self, like: Problem) -> None:
        ca: Any = import_module("casadi")

        horizon = len(like.to)
        z, u = ca.SX.sym("z", 5, horizon + 1), ca.SX.sym("u", 2, horizon)
        given = ca.SX.sym("given", 2 + 5 + 3 * horizon + 2 * (horizon + 1) + 2 + 16)
        before, state, rest = given[:2], given[2:7], given[7:]
        to, rest = ca.reshape(rest[: 3 * horizon], 3, horizon), rest[3 * horizon :]
        follow, rest = ca.reshape(rest[: 2 * (horizon + 1)], 2, horizon + 1), rest[2 * (horizon + 1) :]
        end, tail = rest[:2], rest[2:]
        wheels = ca.DM([[1, 0], [0, 1], [1, like.half_axle], [1, -like.half_axle]])
        w, cost = like.weights, ca.SX(0)
        equal, bounded = [z[:, 0] - state], []
        for k in range(horizon):
            command, former = u[:, k], u[:, k - 1] if k > 0 else before
            equal.append(z[:, k + 1] - _after(ca, z[:, k], command, like.period, like.lag))
            bounded += [wheels @ command, wheels @ (command - former)]
            off, change = command - follow[:, k], command - former
            cost += w.deviation_v * off[0] ** 2 + w.deviation_w * off[1] ** 2
            cost += w.change_v * change[0] ** 2 + w.change_w * change[1] ** 2
            if k < horizon - 1:
                along, cross, turned = _errors(ca, z[:, k + 1], to[:, k])
                cost += w.along * along**2 + w.cross * cross**2 + w.turned * turned**2
        cost += _terminal(ca, z[:, horizon], u[:, -1], to[:, -1], end, follow[:, -1], tail)
        unknown = ca.vertcat(ca.vec(z), ca.vec(u))
        nlp = {"x": unknown, "p": given, "f": cost / 2, "g": ca.vertcat(*equal, *bounded)}
        self._cost = ca.Function("cost", [unknown, given], [cost / 2])
        self.solver = ca.nlpsol("solver", "ipopt", nlp, OPTIONS)
        self.limits = np.concatenate([np.zeros(5 * (horizon + 1)), np.tile([*like.tops, *like.rates], horizon)])
        self.states = 5 * (horizon + 1)

    def solve(self, problem: Problem, states: np.ndarray, commands: np.ndarray) -> tuple[float, bool]:
        """The least cost that is found from ``states`` (N + 1, 5) and ``commands`` (N, 2); whether IPOPT succeeded."""
        start = np.concatenate([states.ravel(), commands.ravel()])
        found: Any = self.solver(x0=start, p=_given(problem), lbg=-self.limits, ubg=self.limits)
        return float(found["f"]), bool(self.solver.stats()["success"])

    def cost(self, problem: Problem, states: np.ndarray, commands: np.ndarray) -> float:
        """The cost of a plan as it is."""
        return float(self._cost(np.concatenate([states.ravel(), commands.ravel()]), _given(problem)))


def _given(p: Problem) -> np.ndarray:
    """The numbers in which problems of the same kind differ, in the order of ``given``."""
    return np.concatenate([np.ravel(part) for part in (p.before, p.state, p.to, p.follow, p.end, p.tail)])


def _after(ca: Any, z: Any, u: Any, period: float, lag: float) -> Any:
    """The state after a period: the velocities exactly, the pose by the distance along the heading at half time."""

    def velocity(now: Any, command: Any, t: float) -> Any:
        return command + (now - command) * (np.exp(-t / lag) if lag > 0 else 0.0)

    def integral(now: Any, command: Any, t: float) -> Any:
        return command * t + (now - command) * lag * (1 - (np.exp(-t / lag) if lag > 0 else 0.0))

    distance, heading = integral(z[3], u[0], period), z[2] + integral(z[4], u[1], period / 2)
    return ca.vertcat(
        z[0] + distance * ca.cos(heading),
        z[1] + distance * ca.sin(heading),
        z[2] + integral(z[4], u[1], period),
        velocity(z[3], u[0], period),
        velocity(z[4], u[1], period),
    )


def _errors(ca: Any, z: Any, to: Any) -> tuple[Any, Any, Any]:
    dx, dy, turn = z[0] - to[0], z[1] - to[1], ca.cos(to[2])
    side = ca.sin(to[2])
    return turn * dx + side * dy, turn * dy - side * dx, 2 * ca.sin((z[2] - to[2]) / 2)


def _terminal(ca: Any, z: Any, u: Any, to: Any, end: Any, follow: Any, tail: Any) -> Any:
    along, cross, turned = _errors(ca, z, to)
    first = ca.vertcat(along, z[3] - end[0], u[0] - follow[0])
    second = ca.vertcat(cross, turned, z[4] - end[1], u[1] - follow[1])
    cost, place = 0, 0
    for error in (first, second):
        n = error.shape[0]
        for i in range(n):
            for j in range(i, n):
                cost += (1 if i == j else 2) * tail[place] * error[i] * error[j]
                place += 1
    return cost


def least_costs(problems: Sequence[Problem]) -> tuple[np.ndarray, np.ndarray]:
    """IPOPT's costs of problems of the same kind (problems,): from our solver's first guess, and from its result.

    Not-a-number is where IPOPT failed.
    """
    solver, found = Ipopt(problems[0]), []
    for starts in (plans_of(problems, iterations=0), plans_of(problems)):
        each = zip(problems, starts.states, starts.commands, strict=True)
        answers = [solver.solve(problem, states, commands) for problem, states, commands in each]
        found.append(np.array([cost if good else np.nan for cost, good in answers]))
    return found[0], found[1]


def write(path: Path, count: int, seed: int) -> None:
    """Write IPOPT's costs of random problems of an EtsRo as CSV."""
    problems = random_problems(count, seed, load_robot("etsro").robot)
    lines = [f"{a!r},{b!r}" for a, b in zip(*(costs.tolist() for costs in least_costs(problems)), strict=True)]
    with replacing(path) as part:
        part.write_text("\n".join(["from_first_guess,from_our_result", *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Write IPOPT's costs of random predictive problems as CSV.")
    parser.add_argument("path", type=Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    write(arguments.path, arguments.count, arguments.seed)
