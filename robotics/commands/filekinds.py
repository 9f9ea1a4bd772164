"""The kinds of files that one writes oneself: for each its keys, its reader, and values to begin with.

A kind that is registered here has its explanation, its JSON schema and its commented file.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from robotics.tables.keys import KeyTable


@dataclass(frozen=True)
class FileKind:
    """One kind of file. What it needs is imported by its functions, when they are called."""

    title: str
    table: Callable[[], KeyTable]
    read: Callable[[str], Any]  # of a file's text; raises an InputError for one that cannot be read
    values: Mapping[str, Mapping[str, Any]]  # to begin with, as the file has them, by --kind; the first is the default
    use: str  # the command that uses a file, with FILE for its name


def _scenario_table() -> KeyTable:
    from robotics.scenario.keys import scenario_table

    return scenario_table()


def _read_scenario(text: str) -> Any:
    from robotics.scenario.reading import parse_scenario

    return parse_scenario(text, "new")


def _robot_table() -> KeyTable:
    from robotics.scenario.keys import robot_file_table

    return robot_file_table()


def _read_robot(text: str) -> Any:
    from robotics.scenario.robots import parse_robot

    return parse_robot(text, "new")


def _sweep_table() -> KeyTable:
    from robotics.experiments.sweeps.keys import sweep_table

    return sweep_table()


def _read_sweep(text: str) -> Any:
    from robotics.experiments.sweeps.plan import plan_sweep
    from robotics.experiments.sweeps.reading import parse_sweep

    return plan_sweep(parse_sweep(text, "new"))


def _study_table() -> KeyTable:
    from robotics.report.keys import study_table

    return study_table()


def _read_study(text: str) -> Any:
    from robotics.report.plan import parse_study

    return parse_study(text, "new")


def _tuning_table() -> KeyTable:
    from robotics.tuning.file import tuning_table

    return tuning_table()


def _read_tuning(text: str) -> Any:
    from robotics.tuning.file import parse_tuning

    return parse_tuning(text, "new")


_SENSING = {"posture": "pose", "position_noise": 0.003, "heading_noise": 0.003}
_TIMING = {"duration": 30.0, "ramp": 2.0}


def _lane(y: float, to: float) -> dict[str, Any]:
    path = {"shape": "quintic", "start": [0.0, y], "end": [6.0, to]}
    return {"start": [0.0, y, 0.0], "path": path, "timing": _TIMING}


_SCENARIOS: dict[str, dict[str, Any]] = {
    "tracking": {
        "title": "One robot follows a sine",
        "source": "all numbers are choices",
        "kind": "tracking",
        "controller": "fuzzy",
        "duration": 30.0,
        "sensing": _SENSING,
        "robots": [
            {
                "start": [0.0, 0.0, 0.7854],
                "path": {"shape": "sine", "amplitude": 1.0, "wavenumber": 1.0, "x_end": 6.0},
                "timing": {"speed": 0.3, "ramp": 1.0},
            }
        ],
    },
    "team": {
        "title": "Three robots arrive together",
        "source": "all numbers are choices",
        "kind": "team",
        "controller": "virtual-structure",
        "duration": 40.0,
        "sensing": _SENSING,
        "radio": {"graph": "complete", "period": 0.05},
        "robots": [_lane(1.5, 2.5), _lane(0.0, 0.5), _lane(-1.5, -2.7)],
    },
    "formation": {
        "title": "Three robots in a triangle along a sine",
        "source": "all numbers are choices",
        "kind": "team",
        "controller": "virtual-structure",
        "duration": 47.0,
        "sensing": _SENSING,
        "radio": {"graph": "complete", "period": 0.05},
        "robots": [{"offset": [0.55, 0.0]}, {"offset": [-0.34, 0.45]}, {"offset": [-0.34, -0.45]}],
        "virtual": {
            "path": {"shape": "sine", "amplitude": 0.4, "wavenumber": 1.0, "x_end": 8.0},
            "timing": {"duration": 42.0, "ramp": 2.0},
        },
    },
}
_ROBOT = {
    "title": "A small robot on two wheels",
    "source": "all numbers are choices",
    "body_mass": 2.0,
    "length": 0.25,
    "width": 0.2,
    "half_axle": 0.09,
    "wheel_radius": 0.04,
    "supply_voltage": 12.0,
    "stall_torque": 1.0,
    "no_load_speed": 15.0,
    "counts_per_turn": 1000.0,
    "sensors": [{"name": "nose", "x": 0.12, "half_cone": 0.26, "rays": 5, "range": 2.0}],
}
_SWEEP = {
    "title": "Latency against a gain of the Lyapunov law",
    "scenario": "lyapunov-sine",
    "controllers": ["lyapunov"],
    "seeds": 2,
    "method": "grid",
    "scenario_fields": {"latency": [0.0, 0.1]},
    "controller_parameters": {"ky": {"low": 5.0, "high": 20.0, "count": 2}},
}

_STUDY = {
    "title": "The fuzzy law against the nonlinear one",
    "author": "Your name",
    "text": "What the study asks, in a few sentences.",
    "scenarios": ["lyapunov-circle", "lyapunov-sine"],
    "controllers": ["fuzzy", "lyapunov"],
    "seeds": 20,
    "claims": [
        {
            "name": "The fuzzy law is not much worse",
            "says": "On both paths its error is less than 10 % larger.",
            "metric": "rms_cross_track_m",
            "of": "fuzzy",
            "against": ["lyapunov"],
            "no_worse_by_percent": 10.0,
        }
    ],
}
_TUNING = {
    "title": "Half as much steering",
    "move": ["gains", "consequents"],
    "bounds": {"look_ahead": {"low": 0.2, "high": 1.0, "scale": "log"}},
    "cost": [
        {"metric": "rms_cross_track_under_way_m", "scale": 0.01, "objective": "precision"},
        {"metric": "w_variation_late_radps2", "scale": 0.5, "objective": "effort"},
    ],
}

FILE_KINDS: dict[str, FileKind] = {
    "scenario": FileKind(
        "a scenario", _scenario_table, _read_scenario, _SCENARIOS, "robotics check FILE, then robotics run FILE"
    ),
    "robot": FileKind("a robot", _robot_table, _read_robot, {"robot": _ROBOT}, "robotics robot FILE"),
    "sweep": FileKind("a sweep", _sweep_table, _read_sweep, {"sweep": _SWEEP}, "robotics sweep FILE"),
    "tuning": FileKind(
        "a tuning",
        _tuning_table,
        _read_tuning,
        {"tuning": _TUNING},
        "robotics tune fuzzy lyapunov-sine --space FILE",
    ),
    "study": FileKind("a study", _study_table, _read_study, {"study": _STUDY}, "robotics study FILE"),
}
