"""Starts and goals that lie nearer to each other than a law keeps robots apart."""

import numpy as np

from robotics.laws.setting import Setting


def near_ends(setting: Setting, least: float) -> dict[str, list[tuple[int, int, float]]]:
    """The pairs of robots (from 0, the lower first) whose "starts" or "goals" are no farther apart than ``least`` [m].

    Each pair comes with its distance [m]. An ensemble, whose runs have starts and goals of their own, has none.
    """
    if setting.starts.ndim == 3:
        return {"starts": [], "goals": []}
    paths = setting.references.joined
    ends = paths.at(paths.lengths)
    places = {"starts": setting.starts[:, :2].T, "goals": np.stack([ends.x, ends.y]).reshape(2, -1)}
    found = {}
    for name, (x, y) in places.items():
        apart = np.hypot(x[:, None] - x, y[:, None] - y)
        pairs = np.argwhere(np.triu(apart <= least, 1))
        found[name] = [(int(i), int(j), float(apart[i, j])) for i, j in pairs]
    return found


def told(what: str, pair: tuple[int, int, float]) -> str:
    """A pair of :func:`near_ends` in words, such as "the goals of robots 1 and 3 are 1.00 m apart"."""
    return f"the {what} of robots {pair[0] + 1} and {pair[1] + 1} are {pair[2]:.2f} m apart"
