"""The loop that goes with a system: plant, what happens to it, limits, scale factors, roles and the PID beside it.

It stands in ``Sugeno.loop`` as one line of JSON, so it is saved, undone and kept with the design. Only what differs
from the example that it began with is written.
"""

import json
import math
from collections.abc import Mapping
from typing import Any

from fuzzy.errors import InputError
from fuzzy.naming import check_known
from fuzzy.plugins.loop.controller import INPUT_ROLES, OUTPUT_ROLES, PID, LoopError, Scale, role_of
from fuzzy.plugins.loop.plant import PlantError, TransferFunction
from fuzzy.plugins.loop.plantfile import PLANT_EXAMPLES, numbers_of, plant_of_text
from fuzzy.plugins.loop.response import STEPS, Loop
from fuzzy.plugins.loop.scheduledplant import Course, ScheduledTransferFunction
from fuzzy.system import Sugeno

FACTORS = ("Ke", "Kde", "Kie", "Ku", "Kdu")
_TEXTS = ("numerator", "denominator")
_POINTS = ("points", "operating")  # transfer functions at operating points, and their variable over time
_OF_LOOP = ("reference", "duration", "sample_time", "disturbance_time", "disturbance", "noise", "rate_filter")
_LIMITS, _GAINS = ("low", "high"), ("Kp", "Ki", "Kd")  # None: no limit, by a rule
_ALWAYS = {"reference": 1.0, "noise": 0.0, "rate_filter": 0.0, "roles": {}, "operating": ""}
_LONGEST = 500  # characters of a text


def example_settings(name: str) -> dict[str, Any]:
    """The settings that an example makes, by their names."""
    example = PLANT_EXAMPLES[name]
    numerator, denominator = (
        " ".join(f"{c:g}" for c in row) for row in (example.plant.numerator, example.plant.denominator)
    )
    return {
        "example": name, "source": "", "points": example.points, "numerator": numerator, "denominator": denominator,
        "dead_time": example.plant.dead_time, "duration": example.duration, "sample_time": example.duration / STEPS,
        "disturbance_time": example.disturbance[0], "disturbance": example.disturbance[1],
        "low": example.limits[0], "high": example.limits[1], **dict(zip(FACTORS, example.scale, strict=True)),
        "Kp": None, "Ki": None, "Kd": None,
    }  # fmt: skip


def check_setting(name: str, value: Any) -> None:
    """Raise LoopError, which names the setting, for a value that it cannot have, and for one that no loop has."""
    if name == "roles":
        if not isinstance(value, dict) or not all(
            isinstance(v, str) and role in ("", *INPUT_ROLES, *OUTPUT_ROLES) for v, role in value.items()
        ):
            raise LoopError(f"roles are {', '.join((*INPUT_ROLES, *OUTPUT_ROLES))}, by variable").about(name)
    elif name == "example":
        check_known(value if isinstance(value, str) else "", PLANT_EXAMPLES, "example", LoopError)
    elif name in (*_TEXTS, *_POINTS, "source"):
        if not isinstance(value, str) or len(value) > _LONGEST * (40 if name in _POINTS else 1):
            what = "a file's name" if name == "source" else "numbers with blanks between"
            raise LoopError(f"{name} must be {what}").about(name)
    elif name in (*_OF_LOOP, "dead_time", *FACTORS, *_LIMITS, *_GAINS):
        lacks = value is None and name in (*_LIMITS, *_GAINS)
        if not lacks and (isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value)):
            raise LoopError(f"{name} must be a number, got {value!r}").about(name)
    else:
        check_known(name, [*_ALWAYS, *example_settings("lag")], "setting", LoopError)


def kept_text(settings: Mapping[str, Any]) -> str:
    """The line in which ``settings`` are kept."""
    usual = {**_ALWAYS, **example_settings(settings["example"])}
    own = {name: settings[name] for name in usual if name == "example" or settings[name] != usual[name]}
    return json.dumps(own).replace("'", "\\u0027")  # which would end the text in a .fis file


def kept_settings(text: str) -> dict[str, Any]:
    """All settings of the line ``text``. Raises LoopError where it is none."""
    try:
        own = json.loads(text)
        if not isinstance(own, dict):
            raise LoopError("it is no table of settings")
        for name, value in own.items():
            check_setting(name, value)
        return {**_ALWAYS, **example_settings(own.get("example", "lag")), **own}
    except (ValueError, RecursionError, InputError) as error:
        said = error if isinstance(error, InputError) else "it is no JSON"
        raise LoopError(f"the loop that is kept with the system cannot be read: {said}") from None


def design_settings(fis: Sugeno) -> dict[str, Any]:
    """The settings of a system's loop: those that it keeps, else of an example. Raises LoopError."""
    direct = [role_of(v.name) for v in fis.outputs] == ["u"]
    return kept_settings(fis.loop or ('{"example": "integrating"}' if direct else "{}"))


def settings_of(
    loop: Loop, plant: TransferFunction | ScheduledTransferFunction | str, roles: Mapping[str, str], pid: PID | None
) -> dict[str, Any]:
    """The settings of a loop that was not made of any: ``plant`` is a transfer function, or a file of the folder."""
    quiet = not math.isfinite(loop.disturbance_time)
    given: dict[str, Any] = {name: getattr(loop, name) for name in _OF_LOOP}
    given |= {"disturbance_time": 0.0, "disturbance": 0.0} if quiet else {}
    given |= {name: getattr(loop, name) if math.isfinite(getattr(loop, name)) else None for name in _LIMITS}
    given |= {name: getattr(loop.scale, name) for name in FACTORS} | {"sample_time": loop.period}
    given |= {name: getattr(pid, name) if pid else None for name in _GAINS} | {"roles": dict(roles)}
    given["operating"] = str(loop.operating or "")
    if isinstance(plant, str):
        given["source"] = plant
    elif isinstance(plant, ScheduledTransferFunction):
        given["points"] = str(plant)
    else:
        for name in _TEXTS:
            given[name] = " ".join(repr(float(c)) for c in getattr(plant, name))
        given["dead_time"] = plant.dead_time
    return {**_ALWAYS, **example_settings("lag"), **given}


def step_arguments(settings: Mapping[str, Any]) -> dict[str, Any]:
    """What :func:`fuzzy.step_response` takes beside a controller and a plant. Raises LoopError."""
    loop = loop_of(settings)
    roles = {name: role for name, role in settings["roles"].items() if role}
    low, high = loop.low, loop.high
    about: dict[str, Any] = {
        name: getattr(loop, name) for name in ("reference", "duration", "sample_time", "noise", "rate_filter")
    }
    disturbance = (loop.disturbance_time, loop.disturbance)
    about["operating"] = loop.operating
    return {**about, "scale": loop.scale, "roles": roles, "limits": (low, high), "disturbance": disturbance}


def transfer_of(settings: Mapping[str, Any]) -> TransferFunction | ScheduledTransferFunction:
    """The plant that is no file. Raises PlantError."""
    if settings["points"].strip():
        try:
            return plant_of_text(settings["points"])
        except PlantError as error:
            raise error.about("points") from None
    rows = [numbers_of(settings[name], name) for name in _TEXTS]
    return TransferFunction(rows[0], rows[1], settings["dead_time"])


def loop_of(settings: Mapping[str, Any]) -> Loop:
    """What happens to the loop, within which limits, by which factors. Raises LoopError."""
    low, high = (settings[name] for name in _LIMITS)
    given: dict[str, Any] = {name: float(settings[name]) for name in _OF_LOOP}
    return Loop(
        **given,
        low=-math.inf if low is None else low,
        high=math.inf if high is None else high,
        operating=Course.of(settings["operating"]) if settings["operating"].strip() else None,
        scale=Scale(*(float(settings[name]) for name in FACTORS)),
    )


def pid_of(settings: Mapping[str, Any]) -> PID | None:
    """The PID beside it; None: by a rule."""
    gains = [settings[name] for name in _GAINS]
    return PID(*(float(gain or 0.0) for gain in gains)) if any(gain is not None for gain in gains) else None
