"""The page ``docs/reference/file-scenario.md``: every key of a scenario's file and of a sweep's.

``python -m robotics.show.report.scenariopage > docs/reference/file-scenario.md`` makes it of the descriptions of both.
"""

from robotics.show.report.keys import sweep_table
from robotics.simulation.scenario.keys import scenario_table
from robotics.tables.page import key_reference

_HEAD = """\
# Scenario files

A scenario says which robots start where, on which paths with which timing, how they sense, what they hear, and what
stands in their way. It is a TOML file; units are SI, angles in radians, x is forward, y is to the left.

* `robotics new scenario --kind team -o mine.toml` writes one that runs, in which all that is optional stands as a
  comment: `--kind tracking`, `team` or `formation`, `--minimal` without comments. `robotics new sweep` likewise.
* `robotics scenario --explain robots.timing.speed` says of a key or a table what this page says.
* `robotics check mine.toml -o mine.png` judges it before anything runs and draws it to scale: speeds that the robots do
  not have, starts and goals too near to each other, paths through obstacles, radio and sensors that do not suffice.
* `robotics scenario --schema > scenario.schema.json` writes the JSON schema. An editor that knows schemas of TOML
  completes and checks a file whose first line is `#:schema ./scenario.schema.json`.
* `robotics run mine.toml --plot mine-run.png` simulates it.

A robot needs a `start`, a path and a timing:

```toml
duration = 30.0

[[robots]]
start = [0.0, 0.0, 0.7854]
path = { shape = "sine", amplitude = 1.0, x_end = 6.0 }
timing = { speed = 0.3, ramp = 1.0 }
```

"""
_SWEEP = """
# Sweep files

A sweep runs a scenario at many points, each under every controller with every seed: `robotics sweep mine.toml`.

"""


def page() -> str:
    """The text of the page, in Markdown."""
    return _HEAD + key_reference(scenario_table()) + _SWEEP + key_reference(sweep_table())


if __name__ == "__main__":
    print(page(), end="")
