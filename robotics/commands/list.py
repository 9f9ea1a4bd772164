"""The command ``robotics list``."""

import sys

from fuzzy.shell.terminal import print_json
from robotics.commands.shared import Json


def list_(json: Json = False) -> None:
    """List the scenarios and the controllers, those of other installed packages too.

    Example: robotics list
    """
    from robotics.laws.catalogue import gains_of, make_controller, presets, unusable_laws
    from robotics.scenario.reading import load_scenario, scenario_names

    scenarios = [load_scenario(name) for name in scenario_names()]
    gains = {name: gains_of(make_controller(name)) for name in presets()}
    for reason in unusable_laws().values():
        print(f"robotics: {reason}", file=sys.stderr)
    if json:
        print_json(
            {
                "scenarios": [
                    {"name": s.name, "kind": s.kind, "title": s.title, "source": s.source} for s in scenarios
                ],
                "controllers": [
                    {"name": name, "title": preset.title, "note": preset.note, "gains": gains[name]}
                    for name, preset in presets().items()
                ],
            }
        )
        return
    print("Scenarios (a name, or the path of a .toml file)")
    for s in scenarios:
        print(f"  {s.name:16} {s.title}")
    print("\nControllers (a name, or name:gain=value,gain=value)")
    for name, preset in presets().items():
        print(f"  {name:16} {preset.title}: {preset.note}")
        print(
            " " * 19 + ", ".join(f"{k}={v:g}" if isinstance(v, float) else f"{k}={v}" for k, v in gains[name].items())
        )
