"""The command ``robotics reinforce``: a policy learnt by trial, which drives as a law."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from fuzzy.errors import InputError
from fuzzy.files.atomic import check_target
from fuzzy.shell.options import Json, Quiet, argument, option
from fuzzy.shell.progress import Mover, progress_bar
from fuzzy.shell.terminal import print_json
from robotics.commands.completion import arenas, scenarios
from robotics.studies.versions import versions

if TYPE_CHECKING:
    from robotics.plugins.reinforcement.training import Trained
    from robotics.simulation.scenario.description import Scenario

_RUNS = 20  # unseen seeds of each scenario by which policies are told and chosen


def reinforce(
    on: Annotated[
        list[str] | None,
        argument(
            "Scenarios of one robot to learn on, names or .toml files. Default: random ones.",
            "[SCENARIO]...",
            autocompletion=scenarios,
        ),
    ] = None,
    out: Annotated[Path, option("File into which the policy goes.", "--out", "-o", "FILE.json")] = Path("policy.json"),
    arena: Annotated[
        str | None,
        option("Learn on the sorts of random scenarios on which this arena tunes.", "ARENA", autocompletion=arenas),
    ] = None,
    draws: Annotated[int, option("Number of random scenarios.", min=1)] = 96,
    steps: Annotated[int, option("Control periods of all robots together.", min=1)] = 3_000_000,
    lanes: Annotated[int, option("Robots that drive at a time.", min=1)] = 512,
    seed: Annotated[int, option("The seed of the learner.", min=0)] = 1,
    repeats: Annotated[int, option("Learners with seeds from there on; the best is kept.", min=1)] = 1,
    json: Json = False,
    quiet: Quiet = False,
) -> None:
    """Learn a policy by reinforcement: PPO of stable-baselines3, paid by minus the arena's cost.

    The policy is a small network from errors, speeds and what lies ahead to v and turn rate. The arena's cost judges it
    on new runs: other random scenarios, or other seeds of the given ones.

    \b
    Example:
      robotics reinforce lyapunov-circle --steps 20000 --lanes 32 -o mine.json
      robotics run lyapunov-circle --controller ppo:policy=mine.json
    """
    from robotics.plugins.reinforcement.learning import Learning, learning_scenarios, validation_scenarios
    from robotics.plugins.reinforcement.training import train
    from robotics.simulation.scenario.reading import load_scenario

    if out.suffix != ".json":
        raise InputError(f"--out must be a .json file; got {out}")
    check_target(out)
    if on and arena is not None:
        raise InputError("scenarios or an --arena to draw them from; got both")
    if on:
        chosen = unseen = tuple(load_scenario(name) for name in on)
    else:
        chosen, unseen = learning_scenarios(arena, draws), validation_scenarios(arena)
    learning, found = Learning(steps=steps, lanes=lanes), []
    with progress_bar(quiet) as begin:
        for n in range(repeats):
            moved = Mover(begin(f"learning, seed {seed + n}", 100))

            def announce(done: int, moved: Mover = moved) -> None:
                moved(min(100 * done // steps, 100))

            found.append(train(chosen, learning, seed=seed + n, announce=announce))
    costs = [_cost(one, unseen) for one in found]
    best = min(range(repeats), key=lambda n: costs[n])
    found[best].policy.write(out)
    rows = [
        {"seed": one.seed, "steps": one.steps, "seconds": round(one.seconds, 1), "cost": cost}
        for one, cost in zip(found, costs, strict=True)
    ]
    if json:
        print_json({"file": str(out), "learners": rows, "kept": found[best].seed, "versions": versions()})
        return
    what = "unseen seeds of the same scenarios" if on else "unseen random scenarios"
    for row in rows:
        mark = " <- kept" if row["seed"] == found[best].seed and repeats > 1 else ""
        print(
            f"seed {row['seed']}: cost {row['cost']:.3g} on {what}, after {row['steps']} steps in "
            f"{row['seconds']:.0f} s{mark}"
        )
    print(f"{out}: it drives as --controller ppo:policy={out}")


def _cost(one: "Trained", unseen: "tuple[Scenario, ...]") -> float:
    """What a policy costs in the mean, where it has not learnt."""
    from robotics.plugins.reinforcement.learning import VALIDATION
    from robotics.plugins.reinforcement.neural import NeuralPolicy
    from robotics.studies.tuning.cost import Cost, costs_of

    law: Any = NeuralPolicy(policy=one.policy)
    return float(costs_of(Cost(), unseen, [law], range(VALIDATION, VALIDATION + _RUNS)).sum(axis=-1).mean())
