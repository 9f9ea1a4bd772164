"""Warnings before a run: what a law does not look at, and what will therefore happen."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from robotics.laws.catalogue import CATALOGUE
from robotics.laws.law import Law
from robotics.laws.setting import Setting
from robotics.measures.arrival import ARRIVAL_SPREAD
from robotics.simulation.safety.coverage import blind_spots
from robotics.world.environment.swept import ContactColumns, Watch
from robotics.world.paths.references import Reference

_LATE = ARRIVAL_SPREAD  # s: the lateness of one robot that is usual
MOST_COMPARED = 40  # robots: the paths of more are not compared


def forewarnings(setting: Setting, law: Law[Any], name: str) -> list[str]:
    """Sentences on what will go wrong, as far as it can be told before a run of a scenario.

    Args:
        setting: The compiled scenario; of an ensemble only the law's sensors are judged.
        law: The law that will drive it.
        name: What the sentences call the law.
    """
    sentences = [*blind(setting, law, name), *unmeasured(setting, name), *law.misgivings(setting)]
    sentences += blind_spots(setting, law)
    when, found = ("", {}) if law.yields else first_meetings(setting)
    if found:
        pairs = [f"robots {i + 1} and {j + 1} at t = {time:.1f} s" for (i, j), time in sorted(found.items())]
        sentences.append(
            f"{name} takes no care of other robots: on {setting.name}, {when}, these touch: {', '.join(pairs)}"
        )
    return sentences


def shortcomings(setting: Setting, laws: Mapping[str, Law[Any]]) -> dict[str, str]:
    """Few words on each of the ``laws``, given by name, that does not suit a scenario: what :func:`forewarnings` tells.

    That a law "does not avoid obstacles" or "ignores the others"; a law that suits the scenario is left out.
    """
    _, meet = first_meetings(setting)
    found = {}
    for name, law in laws.items():
        words = ["does not avoid obstacles"] if setting.world is not None and not law.looks else []
        if meet and not law.yields:
            words.append("ignores the others")
        if words:
            found[name] = ", ".join(words)
    return found


def first_meetings(setting: Setting) -> tuple[str, dict[tuple[int, int], float]]:
    """Who touch where none takes care, and in words when: all on time, or else one late; empty where nobody does."""
    if not setting.ensemble and 1 < len(setting.robots) <= MOST_COMPARED:
        for late, when in ((0.0, "if all are on time"), (_LATE, f"if one of them is {_LATE:g} s late")):
            if found := meetings(setting, late):
                return when, found
    return "", {}


def blind(setting: Setting, law: Law[Any], name: str) -> list[str]:
    """A sentence if ``law``, called ``name``, senses no obstacles where there are some."""
    if setting.world is None or law.looks:
        return []
    rest = setting.world.rest
    count = len(np.unique(rest.bodies[0, : rest.counts[0], -1]))
    has = "has some" if setting.ensemble else f"has {count}"
    return [f"{name} drives blind: it senses no obstacles, and {setting.name} {has}"]


def unmeasured(setting: Setting, name: str) -> list[str]:
    """A sentence if a law of formations, called ``name``, keeps robots in places that nobody measures."""
    preset = CATALOGUE.get(name.partition(":")[0])
    if preset is None or preset.kind != "formation" or setting.kind != "tracking" or len(setting.robots) == 1:
        return []
    return [
        f'{name} keeps robots in places: with kind = "formation" in the file of {setting.name} their place errors are '
        "measured, in place of each one's lateness"
    ]


def meetings(setting: Setting, late: float = 0.0) -> dict[tuple[int, int], float]:
    """The robots that touch if each follows its reference exactly, and the time [s] at which a pair first does.

    With ``late`` [s] one of the two is that late, either one. Robots that touch where they start are left out: they
    are there before any law acts.
    """
    times, robots = setting.times, len(setting.robots)
    on_time = poses_of(setting.references.sampled(times))
    poses = [on_time]
    if late:
        behind = poses_of(setting.references.sampled(np.maximum(times - late, 0.0)))
        behind[3:, :, times < late] = 0.0  # it stands until then
        poses = []
        for i in range(robots):
            one = on_time.copy()
            one[:, i] = behind[:, i]
            poses.append(one)
    stacked = np.stack(poses, axis=1)  # (5, runs, robots, samples)
    watch, ended = Watch.opened(setting.robots, float(times[0]), stacked[..., 0]).along(times, stacked, None)
    found: dict[tuple[int, int], float] = {}
    for row in np.concatenate([ended, watch.open_contacts()]):
        contact = ContactColumns(row)
        pair, mine = (int(contact.robot), int(contact.other)), int(contact.run)
        if contact.start > times[0] and (not late or mine in pair):
            found[pair] = min(found.get(pair, np.inf), float(contact.start))
    return found


def poses_of(references: Reference) -> np.ndarray:
    """``references``, each field (samples, robots), as poses with their velocities (5, robots, samples)."""
    return np.stack([np.asarray(row).T for row in references[:5]])
