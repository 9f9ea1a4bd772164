"""Learnt policies as files: a small network in JSON, what it observes, and how it was trained.

A file names its inputs in their order, so that no policy drives on observations that it was not trained on. All numbers
stand in SI units; a policy is read, checked, and nothing of it is run.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from math import isfinite
from pathlib import Path
from typing import Any, get_args

import numpy as np

from fuzzy.compiled.columns import Columns, column, several
from fuzzy.errors import quoted
from fuzzy.files.atomic import write_whole
from fuzzy.naming import check_known, expected
from robotics.laws.law import ControllerError
from robotics.world.vehicle.plant import Level

_FORMAT = 1
_MOST_BYTES = 20_000_000
MOST_UNITS = 4096  # of a layer
_KEYS = ("format", "level", "inputs", "offset", "scale", "clip", "layers", "most")

_POLICIES = Path(__file__).parent / "data" / "policies"


class PolicyColumns(Columns):
    """A policy as a row of numbers."""

    clip = column("1", "how far from 0 an input can be")
    first = column("m/s (N m)", "the command of an output 1")
    second = column("rad/s (N m)", "the same")
    layers = column("1", "how many there are")
    rest = several(0, "", "the layers' sizes, offset, scale, and the weights and biases of each layer")


@dataclass(frozen=True, eq=False)
class Policy:
    """A network with tanh between its layers: u = most · clip(net(clip((observation − offset) · scale)))."""

    level: Level  # what it commands
    inputs: tuple[str, ...]  # the entries that it observes, as of robotics.plugins.reinforcement.observed.entries
    offset: np.ndarray  # (inputs,) in the unit of each
    scale: np.ndarray  # (inputs,) 1 over the unit of each
    clip: float  # 1: how far from 0 an input can be
    layers: tuple[tuple[np.ndarray, np.ndarray], ...]  # weights (outputs, inputs) and biases (outputs,), each
    most: tuple[float, float]  # m/s and rad/s, or N m: the command of an output 1
    about: Mapping[str, Any] = field(default_factory=dict)  # how it was trained, for people

    @property
    def packed(self) -> np.ndarray:
        """The network as PolicyColumns."""
        sizes = [self.layers[0][0].shape[1], *(len(bias) for _, bias in self.layers)]
        parts: list[Any] = [[self.clip, *self.most, len(self.layers)], sizes, self.offset, self.scale]
        for weights, bias in self.layers:
            parts += [weights.ravel(), bias]
        return np.concatenate([np.asarray(part, dtype=float) for part in parts])

    @property
    def training(self) -> str:
        """What its training cost, in words."""
        steps, minutes = self.about.get("steps"), self.about.get("minutes")
        if not (isinstance(steps, int) and isinstance(minutes, (int, float))):
            return "learnt: its file does not say how"
        cores = self.about.get("cores", 1)
        return f"learnt in {steps:,} steps, {minutes:g} min on {cores} core{'s' if cores != 1 else ''}"

    @property
    def widest(self) -> int:
        """The number of units of its widest layer, the inputs included."""
        return max(len(self.inputs), *(len(bias) for _, bias in self.layers))

    def text(self) -> str:
        """The policy as its file has it."""
        table = {
            "format": _FORMAT,
            "level": self.level,
            "inputs": list(self.inputs),
            "offset": _numbers(self.offset),
            "scale": _numbers(self.scale),
            "clip": self.clip,
            "most": list(self.most),
            "about": dict(self.about),
            "layers": [{"weights": [_numbers(row) for row in w], "bias": _numbers(b)} for w, b in self.layers],
        }
        return json.dumps(table, ensure_ascii=False, indent=None, separators=(",", ": ")).replace(', "', ',\n"') + "\n"

    def write(self, path: str | Path) -> None:
        """Write it to a file, whole or not at all. Raises ControllerError."""
        try:
            write_whole(path, self.text())
        except OSError as error:
            raise ControllerError(f"{path}: cannot be written: {error.strerror}") from None


def policy_names() -> list[str]:
    """The names of the policies that come with the package."""
    return sorted(file.stem for file in _POLICIES.glob("*.json"))


def load_policy(name: str | Path) -> Policy:
    """Read the packaged policy of that name, or the ``.json`` file of that path. Raises ControllerError."""
    path = Path(name)
    if path.suffix != ".json":
        if str(name) not in policy_names():
            raise ControllerError(f"{expected(str(name), policy_names(), 'policy')}; or the path of a .json file")
        path = _POLICIES / f"{name}.json"
    try:
        stat = path.stat()
        if stat.st_size > _MOST_BYTES:
            raise ControllerError(f"{path}: a policy has at most {_MOST_BYTES} bytes; this file has {stat.st_size}")
        return _loaded(str(path), stat.st_mtime_ns, stat.st_size)
    except OSError as error:
        raise ControllerError(f"{path}: cannot be read: {error.strerror or error}") from None


@cache
def _loaded(path: str, changed: int, size: int) -> Policy:
    try:
        text = Path(path).read_text(encoding="utf-8")
    except UnicodeDecodeError:
        raise ControllerError(f"{path}: this is no text: a policy is JSON") from None
    return parse_policy(text, path)


def parse_policy(text: str, file: str = "<text>") -> Policy:
    """Read the policy of a JSON text. Raises ControllerError that names ``file`` and what is wrong."""
    try:
        table = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise ControllerError(f"{file}: this is no JSON: {error}") from None
    if not isinstance(table, dict) or table.get("format") != _FORMAT:
        raise ControllerError(f"{file}: this is no policy of format {_FORMAT}, as `robotics reinforce` writes it")
    for key in _KEYS:
        if key not in table:
            raise ControllerError(f"{file}: {key} is missing")
    try:
        return _made(table)
    except ControllerError as error:
        raise ControllerError(f"{file}: {error}") from None


def _made(table: Mapping[str, Any]) -> Policy:
    check_known(table["level"], get_args(Level), "level", ControllerError)
    inputs = table["inputs"]
    if not (isinstance(inputs, list) and inputs and all(isinstance(name, str) for name in inputs)):
        raise ControllerError(f"inputs must be names; got {quoted(inputs)}")
    count = len(inputs)
    offset, scale = (_array(table[name], (count,), name) for name in ("offset", "scale"))
    most = _array(table["most"], (2,), "most")
    clip = table["clip"]
    if isinstance(clip, bool) or not isinstance(clip, (int, float)) or not (isfinite(clip) and clip > 0):
        raise ControllerError(f"clip must be a number > 0; got {quoted(clip)}")
    layers = table["layers"]
    if not (isinstance(layers, list) and layers and all(isinstance(layer, dict) for layer in layers)):
        raise ControllerError("layers must be a list of tables, each with weights and bias")
    found, before = [], count
    for n, layer in enumerate(layers, start=1):
        bias = layer.get("bias")
        units = len(bias) if isinstance(bias, list) else 0
        if not 0 < units <= MOST_UNITS:
            raise ControllerError(f"layer {n}: bias must be 1 to {MOST_UNITS} numbers")
        weights = _array(layer.get("weights"), (units, before), f"layer {n}: weights")
        found.append((weights, _array(bias, (units,), f"layer {n}: bias")))
        before = units
    if before != 2:
        raise ControllerError(f"the last layer must have 2 outputs; it has {before}")
    if (most <= 0).any():
        raise ControllerError(f"most must be two numbers > 0; got {table['most']}")
    about, whole = table.get("about"), (float(most[0]), float(most[1]))
    known = about if isinstance(about, dict) else {}
    return Policy(table["level"], tuple(inputs), offset, scale, float(clip), tuple(found), whole, known)


def _array(value: Any, shape: tuple[int, ...], name: str) -> np.ndarray:
    """Numbers of a shape."""
    try:
        found = np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        found = np.empty(0)
    if found.shape != shape or not np.isfinite(found).all():
        raise ControllerError(f"{name} must be {' x '.join(map(str, shape))} finite numbers")
    return found


def _numbers(values: Sequence[float] | np.ndarray) -> list[float]:
    """Numbers of single precision, in as few digits as tell them apart."""
    return [float(str(np.float32(v))) for v in np.ravel(values)]
