"""The tables of docs/howto/environments.md, made of the entries themselves: a test holds the page to them."""

from collections.abc import Sequence

from fuzzy.shown import shown
from robotics.plugins.reinforcement.observed import Entry, entries
from robotics.plugins.reinforcement.teamcolumns import team_entries
from robotics.simulation.scenario.reading import load_scenario


def observations() -> str:
    """What a robot observes: the EtsRo on a packaged scenario, and what is added where it reads range sensors."""
    setting = load_scenario("lyapunov-circle").setting
    return _table(entries(setting, "velocity"))


def heard() -> str:
    """What an agent of a team observes beside that of one other robot."""
    found = team_entries(load_scenario("three-cross").setting, "velocity", 0, False)
    return _table([entry for entry in found if entry.name.startswith("robot2_")])


def _table(found: Sequence[Entry]) -> str:
    rows = ["| entry | unit | within | meaning |", "| --- | --- | --- | --- |"]
    for entry in found:
        within = f"0 to {shown(entry.high)}" if entry.positive else f"±{shown(entry.high)}"
        rows.append(f"| `{entry.name}` | {entry.unit} | {within} | {entry.meaning} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    print(observations(), heard(), sep="\n")
