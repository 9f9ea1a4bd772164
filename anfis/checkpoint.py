"""Checkpoints of a training: its state as plain values and tensors, kept to the last bit."""

import pickle
from copy import deepcopy
from dataclasses import asdict
from hashlib import sha256
from pathlib import Path
from typing import Any

import torch

from anfis.data import Samples
from anfis.methods.options import Options, TrainingError
from anfis.network import Network, Point
from anfis.state import Epoch, State
from fuzzy.files.atomic import replacing

_POINTS = ("point", "best_train", "best_check")


def dump(state: State, options: Options, fingerprint: str) -> dict[str, Any]:
    """The state as plain values and tensors of its own, which torch.save keeps to the last bit."""
    points = {
        name: {"free": list(getattr(state, name).free), "values": list(getattr(state, name).values)} for name in _POINTS
    }
    return deepcopy(
        {
            "format": 1,
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


def restore(source: str | Path | dict[str, Any], options: Options, fingerprint: str) -> State:
    """The state that :func:`dump` made. Raises TrainingError if it belongs to another problem."""
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
        return State(
            epoch=saved["epoch"],
            step=saved["step"],
            history=history,
            since=saved["since"],
            memory=saved["memory"],
            least_train=min((row.train for row in history), default=float("inf")),
            least_check=min((row.check for row in history if row.check == row.check), default=float("inf")),
            **points,
        )
    except (KeyError, TypeError, AttributeError):
        raise TrainingError(f"{where}this is no checkpoint of a training") from None


def fingerprint_of(network: Network, data: Samples, checking: Samples | None) -> str:
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
    for part in (data, checking):
        digest.update(b"none" if part is None else part.digest())
    return digest.hexdigest()


def save(state: dict[str, Any], path: str | Path) -> None:
    """Write what :func:`dump` made; the file appears whole or not at all."""
    with replacing(path) as temporary, temporary.open("wb") as file:
        torch.save(state, file)


def _load(path: str | Path) -> dict[str, Any]:
    try:
        saved = torch.load(path, weights_only=True)
    except OSError as error:
        raise TrainingError(f"{path}: cannot be read: {error.strerror or error}") from None
    except (RuntimeError, pickle.UnpicklingError, EOFError, ValueError, KeyError):
        raise TrainingError(f"{path}: this is no checkpoint of a training") from None
    if not isinstance(saved, dict):
        raise TrainingError(f"{path}: this is no checkpoint of a training")
    return saved
