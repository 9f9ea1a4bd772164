"""Random trees, seeded, and what they answer by calls of their systems that know nothing of trees."""

from functools import cache
from typing import Literal

import numpy as np

import fuzzy

SMOOTH = (
    lambda at, wide: fuzzy.Gaussian(wide, at),
    lambda at, wide: fuzzy.Bell(wide, 2.0, at),
    lambda at, wide: fuzzy.Sigmoid(3 / wide, at),
)
EDGED = (
    lambda at, wide: fuzzy.Triangle(at - wide, at, at + wide),
    lambda at, wide: fuzzy.LinearS(at - wide, at + wide),
)


def random_system(rng, smooth):
    """A system of 1 to 3 inputs and 1 or 2 outputs, all in [-1, 1], of 2 to 5 rules."""
    kinds = SMOOTH if smooth else (*SMOOTH, *EDGED)

    def function():
        return kinds[rng.integers(len(kinds))](rng.uniform(-1, 1), rng.uniform(0.5, 1.5))

    inputs = [
        fuzzy.Variable(f"x{i}", (-1, 1), {f"t{k}": function() for k in range(2)}) for i in range(rng.integers(1, 4))
    ]
    outputs = []
    for o in range(rng.integers(1, 3)):
        plane = fuzzy.Linear(rng.uniform(-0.5, 0.5, len(inputs)).tolist(), rng.uniform(-0.3, 0.3))
        outputs.append(fuzzy.Variable(f"y{o}", (-1, 1), {"c": rng.uniform(-1, 1), "p": plane}))
    rules = []
    for _ in range(rng.integers(2, 6)):
        used = sorted(rng.choice(len(inputs), rng.integers(1, len(inputs) + 1), replace=False))
        word = " and " if smooth or rng.random() < 0.7 else " or "
        when = word.join(f"x{i} is {'not ' * (rng.random() < 0.2)}t{rng.integers(2)}" for i in used)
        then = " and ".join(f"{v.name} is {'cp'[rng.integers(2)]}" for v in outputs)
        rules.append(f"if {when} then {then}")
    how: Literal["wtaver", "wtsum"] = "wtaver" if rng.random() < 0.8 else "wtsum"
    return fuzzy.Sugeno(inputs, outputs, rules, defuzzification=how, out_of_range="ignore")


def random_tree(seed, smooth=False):
    """A tree of 2 to 6 systems; each input comes from a system, is shared with another, or is the tree's own."""
    rng = np.random.default_rng(seed)
    names = [f"s{k}" for k in range(rng.integers(2, 7))]
    systems = {name: random_system(rng, smooth) for name in names}
    connections, above, free = list[tuple[str, str]](), list[str](), list[str]()
    for name, fis in systems.items():
        for v in fis.inputs:
            port, chance = f"{name}/{v.name}", rng.random()
            if above and chance < 0.6:
                connections.append((above[rng.integers(len(above))], port))
            elif free and chance < 0.75:
                connections.append((free[rng.integers(len(free))], port))
            free.append(port)  # also of one that takes from elsewhere: the next one then takes the same
        above += [f"{name}/{v.name}" for v in fis.outputs]
    mixed = {name: systems[name] for name in rng.permutation(names).tolist()}
    return fuzzy.Tree(mixed, [connections[k] for k in rng.permutation(len(connections))])


def by_hand(tree, x, evaluate):
    """What the tree answers at ``x`` (points, inputs), by following the connections back from each answer.

    ``evaluate(fis, points)`` gives the outputs (points, outputs) of a system.
    """
    taken = {target: source for source, target in tree.connections}
    own = {v.name: x[:, k] for k, v in enumerate(tree.inputs)}

    @cache
    def value(port):
        name, variable = port.split("/")
        fis = tree.systems[name]
        if variable in [v.name for v in fis.outputs]:
            points = np.stack([value(f"{name}/{v.name}") for v in fis.inputs], axis=-1)
            return evaluate(fis, points)[:, [v.name for v in fis.outputs].index(variable)]
        if port in taken:
            return value(taken[port])
        return own[port] if port in own else own[variable]

    return np.stack([value(port) for port in tree.answers], axis=-1)
