"""Checkpoints of a training: its state as plain values and arrays, kept to the last bit.

A file holds torch's tensors, whatever learnt: only to write or read one is torch loaded.
"""

import io
from collections.abc import Callable
from contextlib import suppress
from copy import deepcopy
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from array_api_compat import is_torch_array

from anfis.data import SampleArrays
from anfis.methods.options import Options, TrainingError
from anfis.point import Array, Point
from anfis.state import Epoch, TrainingState
from fuzzy.extras import needed
from fuzzy.files.atomic import write_whole
from fuzzy.files.sealed import intact, is_sealed, sealed_archive

if TYPE_CHECKING:
    from anfis.compiled.network import CompiledNetwork
    from anfis.network import Network

_FORMAT = 2
_POINTS = ("point", "best_train", "best_check")


def dump(state: TrainingState, options: Options, fingerprint: str) -> dict[str, Any]:
    """The state as plain values and arrays of its own."""
    points = {
        name: {"free": list(getattr(state, name).free), "values": list(getattr(state, name).values)} for name in _POINTS
    }
    return deepcopy(
        {
            "format": _FORMAT,
            "options": asdict(options),
            "fingerprint": fingerprint,
            "epoch": state.epoch,
            "step": state.step,
            "since": state.since,
            "history": [tuple(row) for row in state.history],
            "memory": state.memory,
            **points,
        }
    )


def restore(
    source: str | Path | dict[str, Any],
    options: Options,
    fingerprint: str,
    like: Point | None = None,
    array: Callable[[Any], Array] | None = None,
) -> TrainingState:
    """The state that :func:`dump` made. Raises TrainingError if it is damaged, or belongs to another problem.

    Args:
        source: The state, or the file that :func:`save` wrote.
        options: The options of the training that goes on.
        fingerprint: That of its problem, as :func:`fingerprint_of` makes it.
        like: A point of its network, with whose shapes and types the saved ones are compared.
        array: Makes an array as its network has them, of the saved ones.
    """
    saved = deepcopy(source) if isinstance(source, dict) else _load(source)
    where = "" if isinstance(source, dict) else f"{source}: "
    try:
        if saved["fingerprint"] != fingerprint:
            raise TrainingError(f"{where}this checkpoint belongs to another system or other data")
        for name, value in asdict(options).items():
            if name not in ("epochs", "goal", "patience") and saved["options"][name] != value:
                raise TrainingError(
                    f"{where}this checkpoint was made with {name} = {saved['options'][name]!r}, not {value!r}"
                )
        history = tuple(Epoch(*row) for row in saved["history"])
        points = {name: Point(tuple(saved[name]["free"]), list(saved[name]["values"])) for name in _POINTS}
        if not _is_history(history, saved) or not all(_alike(point, like) for point in points.values()):
            raise TrainingError(f"{where}this checkpoint is damaged: its numbers do not fit the network")
        if array is not None:
            points = {name: Point(*_converted(tuple(point), array)) for name, point in points.items()}
        memory = saved["memory"] if array is None else _converted(saved["memory"], array)
        return TrainingState(
            epoch=saved["epoch"],
            step=saved["step"],
            history=history,
            since=saved["since"],
            memory=memory,
            least_train=min((row.train for row in history), default=float("inf")),
            least_check=min((row.check for row in history if row.check == row.check), default=float("inf")),
            **points,
        )
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        if isinstance(error, TrainingError):
            raise
        raise TrainingError(f"{where}this is no checkpoint of a training") from None


def _is_history(history: tuple[Epoch, ...], saved: dict[str, Any]) -> bool:
    """Whether the epochs are whole and in a row, and the counters beside them fit."""
    counters = (saved["epoch"], saved["since"])
    whole = all(type(value) is int and value >= 0 for value in counters) and isinstance(saved["memory"], dict)
    rows = all(type(row.epoch) is int and all(isinstance(v, (int, float)) for v in row) for row in history)
    return (
        whole
        and rows
        and isinstance(saved["step"], float)
        and [row.epoch for row in history] == list(range(len(history)))
        and saved["epoch"] in (len(history) - 1, len(history))
        and saved["since"] <= len(history)
    )


def _alike(point: Point, like: Point | None) -> bool:
    """Whether ``point`` is of finite numbers, of the shapes and types of ``like``."""
    arrays = (*point.free, *point.values)
    # A difference from itself is 0 for finite numbers only.
    if not all(_is_array(each) and not bool((each - each != 0).any()) for each in arrays):
        return False
    if like is None:
        return True
    parts = ((point.free, like.free), (point.values, like.values))
    return all([_kind(each) for each in a] == [_kind(each) for each in b] for a, b in parts)


def _is_array(value: Any) -> bool:
    return isinstance(value, np.ndarray) or bool(is_torch_array(value))


def _kind(array: Array) -> tuple[tuple[int, ...], str]:
    """Shape and type of number, which do not depend on the library."""
    return tuple(array.shape), str(array.dtype).removeprefix("torch.")


def _converted(value: Any, array: Callable[[Any], Array]) -> Any:
    """A value of plain values and arrays with every array of the other library made one of ``array``'s."""
    if isinstance(value, dict):
        return {name: _converted(part, array) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)(_converted(part, array) for part in value)
    if not _is_array(value) or isinstance(value, np.ndarray) == isinstance(array(np.zeros(1)), np.ndarray):
        return value
    return array(value)


def fingerprint_of(network: "Network | CompiledNetwork", data: SampleArrays, checking: SampleArrays | None) -> str:
    """What must be the same to go on: the system's structure, what is scaled by what, and the data."""
    fis = network.fis
    structure = (
        [(v.name, v.universe, tuple(v.terms)) for v in (*fis.inputs, *fis.outputs)],
        [type(term).__name__ for v in (*fis.inputs, *fis.outputs) for term in v.terms.values()],
        fis.rules,
        (fis.and_method, fis.or_method, fis.defuzzification, fis.out_of_range),
        [sign.tolist() for sign in network.premises.signs],
        [order.tolist() for order in network.premises.order],
    )
    digest = sha256(repr(structure).encode())
    if hasattr(network, "type2"):
        digest.update(network.type2.reduction.encode())
    for part in (data, checking):
        digest.update(b"none" if part is None else part.digest())
    return digest.hexdigest()


def with_tensors(state: dict[str, Any]) -> dict[str, Any]:
    """What :func:`dump` made as a file holds it."""
    torch = needed("torch", "a checkpoint")
    held: dict[str, Any] = _converted(state, lambda numbers: torch.from_numpy(numbers.copy()))
    return held


def save(state: dict[str, Any], path: str | Path) -> None:
    """Write what :func:`dump` made, with a checksum; the file appears whole or not at all. Raises OSError."""
    torch = needed("torch", "a checkpoint")
    content = io.BytesIO()
    torch.save(with_tensors(state), content)
    write_whole(path, sealed_archive(content.getvalue()))


def _load(path: str | Path) -> dict[str, Any]:
    torch = needed("torch", "a checkpoint")
    try:
        content = Path(path).read_bytes()
    except OSError as error:
        raise TrainingError(f"{path}: cannot be read: {error.strerror or error}") from None
    if is_sealed(content) and not intact(content):
        raise TrainingError(f"{path}: this checkpoint is damaged: its checksum is not that of its contents")
    saved = None
    if is_sealed(content):
        with suppress(Exception):  # what pickle and torch raise for bytes that are none of theirs has no end
            saved = torch.load(io.BytesIO(content), weights_only=True)
    if not isinstance(saved, dict) or saved.get("format") != _FORMAT:
        raise TrainingError(f"{path}: this is no checkpoint of a training, or a damaged one")
    return saved
