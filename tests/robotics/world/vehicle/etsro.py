"""The EtsRo, the robot of the packaged scenarios, for tests that need any robot or that one."""

from robotics.simulation.scenario.robots import load_robot

ETSRO = load_robot("etsro").robot
