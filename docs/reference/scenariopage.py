"""The page ``docs/reference/file-scenario.md``: every key of a scenario's file and of a sweep's.

``python docs/reference/scenariopage.py > docs/reference/file-scenario.md`` makes it of
``scenariopage.txt`` and of the descriptions of both.
"""

from pathlib import Path
from string import Template

from keypage import key_reference

from robotics.show.report.keys import sweep_table
from robotics.simulation.scenario.keys import scenario_table


def page() -> str:
    """The text of the page, in Markdown: ``scenariopage.txt`` with the keys of both files."""
    text = Path(__file__).with_suffix(".txt").read_text(encoding="utf-8")
    keys = {"scenario_keys": key_reference(scenario_table()), "sweep_keys": key_reference(sweep_table())}
    return Template(text).substitute(keys)


if __name__ == "__main__":
    print(page(), end="")
