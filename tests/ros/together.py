"""Nodes of a test: made, spun together in one process, and destroyed; and robots driven without ROS."""

import time
from contextlib import contextmanager

import numpy as np

from fuzzyfleet_ros.frames import Posture
from fuzzyfleet_ros.loopback import Loopback
from fuzzyfleet_ros.onboard import Onboard, OwnState, Perceived


@contextmanager
def spun(*makers):
    """The nodes that ``makers`` return, and a function that spins them until something is so, or time is up."""
    from rclpy.executors import SingleThreadedExecutor

    executor, nodes = SingleThreadedExecutor(), []
    try:
        for make in makers:
            nodes.append(make())
            executor.add_node(nodes[-1])

        def until(so, seconds=20.0):
            end = time.monotonic() + seconds
            while not so():
                if time.monotonic() > end:
                    return False
                executor.spin_once(timeout_sec=0.02)
            return True

        yield nodes, until
    finally:
        executor.shutdown()
        for node in nodes:
            node.destroy_node()


def given(**parameters):
    """The options of a node with these parameters."""
    from rclpy.parameter import Parameter

    return {"parameter_overrides": [Parameter(name, value=value) for name, value in parameters.items()]}


def controller(namespace="", **parameters):
    """What makes a controller with these parameters."""
    from fuzzyfleet_ros.controllernode import Controller

    return lambda: Controller(namespace=namespace, **given(**parameters))


def simulator(**parameters):
    """What makes a simulator with these parameters."""
    from fuzzyfleet_ros.simulatornode import Simulator

    return lambda: Simulator(**given(**parameters))


def drive(scenario, law, seed=0, deaf=()):
    """Drive a scenario by a computer on board of each robot; robots in ``deaf`` hear nothing."""
    setting = scenario.setting
    boards = [Onboard.of(setting, law, i, scales=False) for i in range(len(setting.robots))]
    memories, received = [board.begin() for board in boards], [board.silence() for board in boards]
    loop = Loopback(setting, law, seed, patience=float("inf"), keeps=True)
    while True:
        seen = loop.sense()
        known = [OwnState(Posture(*seen.posture[:, i]), *seen.velocity[:, i]) for i in range(len(boards))]
        for i, board in enumerate(boards):
            for j in board.senders if board.fields and i not in deaf else ():
                if np.isfinite(age := seen.heard.age[0, i, j]):
                    received[i] = received[i].with_message(j, loop.time, age, seen.heard.values[:, 0, i, j].tolist())
            others = {j: known[j] for j in range(len(boards)) if j != i} if board.sees_others else {}
            ranges = dict(zip(loop.names, seen.ranges[i], strict=True))
            order, memories[i] = board.step(Perceived(loop.time, known[i], others, received[i], ranges), memories[i])
            loop.command(i, order.v, order.w)
            if order.message:
                loop.speak(i, order.message)
        over = loop.over
        loop.advance()
        if over:
            return loop.run("driven")


def farthest(one, other):
    """How far apart [m] the tracks of two runs are at most, over the time of the first."""
    n = len(one.time)
    return float(np.hypot(one["x"] - other["x"][..., :n], one["y"] - other["y"][..., :n]).max())
