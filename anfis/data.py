"""Samples to learn from: checked once at the edge, then handed out row by row."""

import warnings
from dataclasses import dataclass
from hashlib import sha256
from typing import Any

import numpy as np
from array_api_compat import is_torch_array

from fuzzy.files.table import DataError
from fuzzy.fitting.clustering import DataWarning
from fuzzy.system import Sugeno

__all__ = ["DataError", "DataWarning", "SampleArrays", "samples"]

_PORTION = 1_000_000  # rows looked at together, so that data on disk are never in memory as a whole


@dataclass(frozen=True, eq=False)
class SampleArrays:
    """Inputs (samples, inputs) and outputs (samples, outputs), in their own units.

    Arrays that lie on disk (numpy.memmap) stay there; a block is read when it is asked for.
    """

    x: Any
    y: Any
    dtype: Any = None  # None: numpy arrays in double precision, else torch's type of number
    device: str = "cpu"  # of torch

    @property
    def count(self) -> int:
        """How many samples there are."""
        return len(self.x)

    def to(self, dtype: Any, device: str) -> "SampleArrays":
        """The same samples as tensors of torch's ``dtype`` on ``device``, all at once unless they lie on disk."""
        import torch

        if isinstance(self.x, np.memmap):
            return SampleArrays(self.x, self.y, dtype, device)
        # torch shares memory with an array, but not with one that is read-only or runs backwards.
        x, y = (torch.as_tensor(np.require(a, requirements=["C", "W"])) for a in (self.x, self.y))
        return SampleArrays(x.to(device, dtype), y.to(device, dtype), dtype, device)

    def rows(self, which: Any) -> tuple[Any, Any]:
        """Inputs and outputs of the rows ``which`` (a slice or an index): tensors, or arrays in one piece."""
        if is_torch_array(self.x):
            return self.x[which], self.y[which]
        if is_torch_array(which):
            which = which.cpu().numpy()
        parts = self.x[which], self.y[which]
        if self.dtype is None:
            return tuple(np.require(part, np.float64, ["C", "W"]) for part in parts)  # type: ignore[return-value]
        import torch

        return tuple(torch.as_tensor(np.array(part), dtype=self.dtype, device=self.device) for part in parts)  # type: ignore[return-value]

    def digest(self) -> bytes:
        """A digest of the values, which differs for other samples."""
        digest = sha256(repr(self.count).encode())
        for start in range(0, self.count, _PORTION):
            for part in self.rows(slice(start, start + _PORTION)):
                digest.update((part.cpu().numpy() if is_torch_array(part) else part).tobytes())
        return digest.digest()


def samples(fis: Sugeno, x: Any, y: Any, what: str) -> SampleArrays:
    """Check ``x`` (samples, inputs) and ``y`` (samples,) or (samples, outputs) against ``fis``.

    Raises DataError naming the row and the column of the first value that is not finite, or the shape that was
    expected, or an input outside its universe if ``fis`` refuses those; warns (DataWarning) of constant input columns.
    """
    inputs, outputs = [v.name for v in fis.inputs], [v.name for v in fis.outputs]
    x, y = _array(x, what), _array(y, what)
    if y.ndim == 1:
        y = y[:, None]
    for values, names, kind in ((x, inputs, "inputs"), (y, outputs, "outputs")):
        if values.ndim != 2 or values.shape[1] != len(names):
            raise DataError(
                f"the {what} {kind} must be (samples, {len(names)}): {', '.join(names)}; got shape {values.shape}"
            )
    if len(x) != len(y):
        raise DataError(f"the {what} data have {len(x)} rows of inputs but {len(y)} of outputs")
    if len(x) == 0:
        raise DataError(f"the {what} data are empty")
    for values, names in ((x, inputs), (y, outputs)):
        for start in range(0, len(values), _PORTION):
            bad = np.argwhere(~np.isfinite(values[start : start + _PORTION]))
            if len(bad):
                row, column = int(bad[0][0]) + start, int(bad[0][1])
                raise DataError(
                    f"the {what} data: row {row + 1}, column {names[column]!r} is {values[row, column]}; "
                    "every value must be a finite number"
                )
    if fis.out_of_range == "error":
        low, high = np.array([v.universe for v in fis.inputs]).T
        outside = np.argwhere((x < low) | (x > high))
        if len(outside):
            row, column = outside[0]
            raise DataError(
                f"the {what} data: row {row + 1}, column {inputs[column]!r} is {x[row, column]:g}, outside "
                f"[{low[column]:g} {high[column]:g}], and {fis.name} refuses that (out_of_range = 'error')"
            )
    if what == "training" and len(x) > 1:
        for column, name in enumerate(inputs):
            if np.ptp(x[:, column]) == 0:
                warnings.warn(
                    f"input {name!r} is constant, {x[0, column]:g}, in all training data: nothing can be learnt of it",
                    DataWarning,
                    stacklevel=3,
                )
    return SampleArrays(x, y)


def _array(values: Any, what: str) -> Any:
    if isinstance(values, np.memmap):
        return values
    if is_torch_array(values):
        values = values.detach().cpu().numpy()
    try:
        if np.iscomplexobj(values):
            raise TypeError
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise DataError(f"the {what} data must be a table of real numbers") from None
