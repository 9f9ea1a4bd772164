"""The command ``robotics team``: a random team of any size, written as a scenario."""

from pathlib import Path
from typing import Annotated

from fuzzy.errors import InputError
from fuzzy.shell.options import option
from robotics.commands.completion import controllers


def team(
    out: Annotated[Path, option("File into which the scenario goes.", "--out", "-o", "FILE.toml")],
    robots: Annotated[int, option("Number of robots, 2 to 2000.")] = 20,
    seed: Annotated[int, option("Seed of the paths.", min=0)] = 0,
    speed: Annotated[float, option("Mean speed on the longest path, m/s.")] = 0.25,
    controller: Annotated[
        str, option("Controller that the scenario names.", autocompletion=controllers)
    ] = "virtual-structure",
    graph: Annotated[str, option("Graph of who hears whom: complete, ring, line or star.")] = "complete",
) -> None:
    """Write a random team as a scenario: paths that every robot can drive, all due at the same time.

    \b
    Example:
      robotics team --robots 20 --seed 3 -o team.toml
      robotics run team.toml --plot team.png
    """
    from fuzzy.files.atomic import check_target, write_whole
    from robotics.simulation.scenario.random_team import team_toml
    from robotics.simulation.scenario.reading import parse_scenario

    check_target(out, ".toml")
    text = team_toml(robots, seed, speed=speed, controller=controller, radio=graph)
    scenario = parse_scenario(text, out.stem, str(out))
    try:
        write_whole(out, text)
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {error.strerror}") from None
    longest = max(path.length for path in scenario.trajectory.paths)
    print(f"{out}: {robots} robots, the longest path {longest:.1f} m, due at {scenario.trajectory.ends.max():.1f} s")
