"""A tree of Sugeno systems: some of them take as inputs what others answer [MATLAB's ``fistree``].

A port is a variable of one of the systems, "system/variable". A connection joins an output to an input that takes it,
or an input to another that takes the same. Systems in a row are an incremental tree, systems side by side whose outputs
meet in another one an aggregated tree, and both at once a cascaded one: the depth and the number of connections are
free, but for circles. A tree of systems of two inputs has fewer rules than one system of all inputs, and says less.
"""

import json
import os
import re
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np
from array_api_compat import array_namespace

from fuzzy.errors import InputError
from fuzzy.files.atomic import write_together
from fuzzy.files.fisfile import format_fis
from fuzzy.inference import check_points, infer
from fuzzy.insight.description import as_dict, describe
from fuzzy.membershipfunction import Array, as_float, as_number, like
from fuzzy.naming import check_known
from fuzzy.plugins.trees.space import TreeSpace, tree_space
from fuzzy.shown import shown
from fuzzy.system import Linear, Sugeno, Terms, Variable
from fuzzy.words import counted, listed

TREE_FILE = "tree.toml"
_NAME = re.compile(r"\w(?:[\w .-]*\w)?")  # of a system: its file is called by it


class TreeError(InputError):
    """The error for systems that make no tree, for a file of one, and for values that are not those of its inputs."""


@dataclass(frozen=True)
class Tree:
    """Systems that take what others of them answer. It is called as a system is, with points (..., inputs).

    Where no connections are given they follow from the names: an input that is called as another system's output takes
    it, and inputs of one name are one input of the tree.

    Attributes:
        systems: The systems by their names in the tree, of letters, digits and "_ . -" or blanks.
        connections: Pairs of ports: ("grip/friction", "speed/friction") lets the input ``friction`` of ``speed`` take
            the output of ``grip``; a pair of inputs lets the second take what the first takes. None: by the names.
        answers: The ports, outputs of systems, that the tree answers with. None: those that no other system takes.
        name: The tree's name.
        inputs: The variables that the tree asks for, in the order of the systems; made on construction. They keep their
            names where no two have the same, else they are called as their ports are.
        outputs: Likewise those that it answers with.
        order: The names of the systems, each after those from which it takes something.
        columns: The ports of all values that there are: of the tree's inputs, then of the outputs in that order.
        wires: The places among these that the inputs of each system take, in the same order.

    Raises:
        TreeError: Parts that do not fit together; the message names the port.
    """

    systems: Mapping[str, Sugeno]
    connections: Sequence[tuple[str, str]] | None = None
    answers: Sequence[str] | None = None
    name: str = "tree"
    inputs: tuple[Variable, ...] = field(init=False, repr=False, compare=False)
    outputs: tuple[Variable, ...] = field(init=False, repr=False, compare=False)
    order: tuple[str, ...] = field(init=False, repr=False, compare=False)
    columns: tuple[str, ...] = field(init=False, repr=False, compare=False)
    wires: tuple[tuple[int, ...], ...] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        systems = Terms(_checked(self.systems))
        takes = {f"{name}/{v.name}": v for name, fis in systems.items() for v in fis.inputs}
        gives = {f"{name}/{v.name}": v for name, fis in systems.items() for v in fis.outputs}
        connections = _by_name(systems) if self.connections is None else _pairs(self.connections, takes, gives)
        for port, target in connections:
            _check_fit(port, target, (gives | takes)[port], takes[target], port in gives)
        source = {target: port for port, target in connections}
        roots = {port: _root(port, source) for port in takes}
        order = _ordered(systems, roots, gives)
        free = list(dict.fromkeys(root for root in roots.values() if root in takes))
        taken = set(roots.values())
        answers = tuple(p for p in gives if p not in taken) if self.answers is None else tuple(self.answers)
        for port in answers:
            check_known(port, gives, "output of a system", TreeError, where=self.name)
        if not 0 < len(answers) == len(set(answers)):
            raise TreeError(f"{self.name}: the answers are outputs, one at least and each once, got {list(answers)}")
        if idle := [name for name in systems if name not in _upstream(systems, roots, answers)]:
            raise TreeError(f"{self.name}: nothing that {listed(idle)} answers reaches {listed(answers)}")
        columns = (*free, *(f"{name}/{v.name}" for name in order for v in systems[name].outputs))
        place = {port: k for k, port in enumerate(columns)}
        made = {
            "systems": systems,
            "connections": connections,
            "answers": answers,
            "inputs": _variables(free, takes),
            "outputs": _variables(answers, gives),
            "order": order,
            "wires": tuple(tuple(place[roots[f"{n}/{v.name}"]] for v in systems[n].inputs) for n in order),
            "columns": columns,
        }
        for key, value in made.items():
            object.__setattr__(self, key, value)

    def __call__(self, x: Any) -> Array:
        """Evaluate the outputs (..., outputs) at ``x``, points (..., inputs) or values by the inputs' names.

        Each system is evaluated by :func:`fuzzy.infer`, on arrays of numpy or torch, through which gradients go to the
        points and to parameters that are tensors. Warns as that does; raises TreeError for other inputs.
        """
        values = self.values(x)
        xp = array_namespace(values[0])
        return xp.stack([values[k] for k in self.answer_columns], axis=-1)

    def evaluate(self, x: Any) -> dict[str, Array]:
        """The outputs (...) by their names at ``x``, points or values by the inputs' names; evaluated as by a call."""
        y = self(x)
        return {v.name: y[..., k] for k, v in enumerate(self.outputs)}

    def values(self, x: Any) -> list[Array]:
        """The value (...) of each of :attr:`columns` at ``x``: the tree's inputs, and what every system answers."""
        x = self.point(x)
        xp = array_namespace(x)
        values = [x[..., k] for k in range(len(self.inputs))]
        for name, wires in zip(self.order, self.wires, strict=True):
            y = infer(self.systems[name], xp.stack([values[k] for k in wires], axis=-1)).output
            values += [y[..., k] for k in range(y.shape[-1])]
        return values

    def point(self, x: Any) -> Array:
        """The points (..., inputs) of ``x``, which are such, or values (...) by the inputs' names. Raises TreeError."""
        if not isinstance(x, Mapping):
            x = as_float(x)
            check_points(self, x)
            return x
        names = [v.name for v in self.inputs]
        for name in x:
            check_known(name, names, "input", TreeError, where=self.name)
        if missing := [name for name in names if name not in x]:
            raise TreeError(f"{self.name}: no value for {listed(missing)}")
        arrays = [as_float(x[name]) for name in names]
        lead = next((a for a in arrays if not isinstance(a, np.ndarray)), arrays[0])
        xp = array_namespace(lead)
        return xp.stack(xp.broadcast_arrays(*(like(lead, a) for a in arrays)), axis=-1)

    @property
    def answer_columns(self) -> tuple[int, ...]:
        """The columns that are the tree's outputs."""
        return tuple(self.columns.index(port) for port in self.answers or ())

    @property
    def unused_inputs(self) -> tuple[str, ...]:
        """The ports of inputs that no rule asks for and of which no plane has a slope."""
        return tuple(
            f"{name}/{v.name}"
            for name, fis in self.systems.items()
            for i, v in enumerate(fis.inputs)
            if (fis.structure.term[i] < 0).all()
            and not any(_slope(t, i) for o in fis.outputs for t in o.terms.values())
        )

    def with_systems(self, systems: Mapping[str, Sugeno]) -> "Tree":
        """The tree with other ``systems`` of the same variables, such as learnt ones, under some of its names."""
        return replace(self, systems={**self.systems, **systems})

    def mapped(self, change: Callable[[Sugeno], Sugeno]) -> "Tree":
        """The tree with each of its systems as ``change`` makes it."""
        return self.with_systems({name: change(fis) for name, fis in self.systems.items()})

    def search_space(
        self, move: Collection[str] | None = None, symmetric: bool = True, data: tuple[Array, Array] | None = None
    ) -> TreeSpace:
        """What a search may move: that of each system, as :class:`fuzzy.tuning.systemspace.SystemSpace` has it.

        Args:
            move: The parts that may move; None: memberships and consequents.
            symmetric: Whether a symmetry of a system is kept.
            data: Inputs (samples, inputs) and outputs (samples, outputs), which say how far consequents may move.

        Raises TuningError for an unknown part.
        """
        return tree_space(self, move, symmetric, data)

    def write(self, folder: str | os.PathLike[str], comment: str = "") -> None:
        """Write the tree into a folder: tree.toml, and NAME.fis of each system. Files of these names are replaced.

        All are written before the first is put in its place, tree.toml comes last: an error leaves what was there.

        Args:
            folder: The folder, made if it is not there.
            comment: Lines that stand at the top of tree.toml.

        Raises:
            FisFileError: A system that the format .fis cannot hold.
            TreeError: A name that is no valid text.
            OSError: Nothing can be written.
        """
        texts = {TREE_FILE: _toml(self, comment)} | {f"{name}.fis": format_fis(f) for name, f in self.systems.items()}
        try:
            write_together(Path(folder), texts)
        except UnicodeEncodeError as error:
            raise TreeError(f"{folder}: a name holds no valid text: {error.object[error.start]!r}") from None

    def describe(self) -> str:
        """The tree in words: what goes where, and then each system."""
        asks, answers = (", ".join(v.label for v in variables) for variables in (self.inputs, self.outputs))
        lines = [f"{self.name}: {counted(len(self.systems), 'system')}", f"inputs: {asks}", f"outputs: {answers}"]
        lines += [f"{source} -> {target}" for source, target in self.connections or ()]
        lines += [f"{port}: no rule uses it" for port in self.unused_inputs]
        return "\n".join([*lines, *(f"\n{name}\n{indent(describe(self.systems[name]), '  ')}" for name in self.order)])

    def as_dict(self) -> dict[str, Any]:
        """The tree as dictionaries, lists, strings and floats."""
        return {
            "name": self.name,
            "type": "tree",
            "inputs": [v.name for v in self.inputs],
            "outputs": [v.name for v in self.outputs],
            "connections": [list(pair) for pair in self.connections or ()],
            "unused": list(self.unused_inputs),
            "systems": {name: as_dict(self.systems[name]) for name in self.order},
        }

    def __repr__(self) -> str:
        ends = (", ".join(v.name for v in variables) for variables in (self.inputs, self.outputs))
        return f"Tree({self.name!r}: {' -> '.join(ends)}; {counted(len(self.systems), 'system')})"


def _checked(systems: Mapping[str, Sugeno]) -> dict[str, Sugeno]:
    if not isinstance(systems, Mapping) or not systems:
        raise TreeError(f'a tree needs systems by their names, {{"grip": fis, ...}}, got {systems!r:.80}')
    for name, fis in systems.items():
        if not (isinstance(name, str) and _NAME.fullmatch(name)):
            raise TreeError(f'a system of a tree is called by letters, digits and "_ . -" or blanks, got {name!r}')
        if not isinstance(fis, Sugeno):
            raise TreeError(f"{name}: the systems of a tree are of the type Sugeno, got {type(fis).__name__}")
        if both := {v.name for v in fis.inputs} & {v.name for v in fis.outputs}:
            raise TreeError(f"{name}: an input and an output are both called {min(both)}; a port is one of them")
    if len({name.casefold() for name in systems}) < len(systems):
        raise TreeError(f"two systems have the same name but for capitals: {', '.join(systems)}")
    return dict(systems)


def _by_name(systems: Mapping[str, Sugeno]) -> tuple[tuple[str, str], ...]:
    """The connections that follow from the names of the variables."""
    found, first = [], dict[str, str]()
    for name, fis in systems.items():
        for v in fis.inputs:
            port = f"{name}/{v.name}"
            makers = [n for n, other in systems.items() if n != name and v.name in [o.name for o in other.outputs]]
            if len(makers) > 1:
                raise TreeError(
                    f"{port}: {listed(makers)} have an output of this name; say in connections which it takes"
                )
            if makers:
                found.append((f"{makers[0]}/{v.name}", port))
            elif v.name in first:
                found.append((first[v.name], port))
            else:
                first[v.name] = port
    return tuple(found)


def _pairs(
    given: Iterable[Any], takes: Mapping[str, Variable], gives: Mapping[str, Variable]
) -> tuple[tuple[str, str], ...]:
    """The connections as they were given, if the ports are there, and fit."""
    found: list[tuple[str, str]] = []
    for pair in given:
        if isinstance(pair, str) or not isinstance(pair, Sequence) or len(pair) != 2:
            raise TreeError(f'a connection is a pair of ports, ("grip/friction", "speed/friction"), got {pair!r:.80}')
        port, target = pair
        check_known(port, [*gives, *takes], "port", TreeError, where="connections")
        check_known(target, takes, "input of a system", TreeError, where="connections")
        if target in [t for _, t in found]:
            raise TreeError(f"connections: two connections end in {target}")
        found.append((port, target))
    return tuple(found)


def _check_fit(port: str, target: str, source: Variable, taker: Variable, is_output: bool) -> None:
    """Raise TreeError where the universe or the unit of ``source`` is none that ``taker`` can take."""
    (low, high), (least, most) = source.universe, taker.universe
    slack = 1e-9 * (most - least)
    inside = least - slack <= low and high <= most + slack
    if not (inside and (is_output or (low - slack <= least and most <= high + slack))):
        wanted = "must lie in" if is_output else "must be"
        raise TreeError(
            f"{port} -> {target}: the universe [{shown(low)} {shown(high)}] of the first {wanted} that of the second, "
            f"[{shown(least)} {shown(most)}]"
        )
    if source.unit and taker.unit and source.unit != taker.unit:
        raise TreeError(f"{port} -> {target}: the first is in {source.unit!r}, the second in {taker.unit!r}")


def _root(port: str, source: Mapping[str, str]) -> str:
    """The output, or the input that takes from nowhere, whose value an input has."""
    way = [port]
    while port in source and source[port] not in way:
        port = source[port]
        way.append(port)
    if port in source:
        raise TreeError(
            f"connections: these inputs take from each other in a circle: {' <- '.join([*way, source[port]])}"
        )
    return port


def _ordered(systems: Mapping[str, Sugeno], roots: Mapping[str, str], gives: Mapping[str, Variable]) -> tuple[str, ...]:
    """The names of the systems, each after those from which it takes something, else in their own order."""
    needs = {name: set[str]() for name in systems}
    for port, root in roots.items():
        if root in gives:
            needs[_system(port)].add(_system(root))
    order: list[str] = []
    while len(order) < len(systems):
        ready = [name for name in systems if name not in order and needs[name] <= {*order}]
        if not ready:
            raise TreeError(f"systems take from each other in a circle: {_circle(needs, {*order})}")
        order.append(ready[0])
    return tuple(order)


def _circle(needs: Mapping[str, set[str]], done: set[str]) -> str:
    """One circle of systems, as "a -> b -> a"."""
    way = [next(name for name in needs if name not in done)]
    while way[-1] not in way[:-1]:
        way.append(min(needs[way[-1]] - done))
    return " -> ".join(reversed(way[way.index(way[-1]) :]))


def _upstream(systems: Mapping[str, Sugeno], roots: Mapping[str, str], answers: Iterable[str]) -> set[str]:
    """The systems that have a say in the answers."""
    found, new = set[str](), {_system(port) for port in answers}
    while new:
        found |= new
        new = {_system(roots[f"{name}/{v.name}"]) for name in new for v in systems[name].inputs} - found
    return found


def _system(port: str) -> str:
    return port.partition("/")[0]


def _variables(ports: Sequence[str], known: Mapping[str, Variable]) -> tuple[Variable, ...]:
    """The variables at ports, called as these are where two have the same name."""
    names = [known[port].name for port in ports]
    return tuple(
        known[port] if names.count(name) == 1 else replace(known[port], name=port)
        for port, name in zip(ports, names, strict=True)
    )


def _slope(term: Any, place: int) -> bool:
    """Whether a consequent has a slope over the input at ``place``."""
    return isinstance(term, Linear) and as_number(term.slopes[place]) != 0


def _toml(tree: Tree, comment: str) -> str:
    assert tree.connections is not None
    lines = [f"# {line}".rstrip() for line in comment.splitlines()]
    lines += [f"name = {_text(tree.name)}", "connections = ["]
    lines += [f"    [{_text(port)}, {_text(target)}]," for port, target in tree.connections]
    lines += ["]", f"answers = [{', '.join(map(_text, tree.answers or ()))}]", "", "[systems]"]
    return "\n".join([*lines, *(f"{_text(name)} = {_text(f'{name}.fis')}" for name in tree.systems), ""])


def _text(value: str) -> str:
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
