"""A rule base as a static nonlinearity of python-control: a ``control.nlsys`` without states.

The package ``control`` is optional and imported only by :func:`to_nlsys`.
"""

from typing import Any

import numpy as np

from fuzzy.extras import install_command
from fuzzy.loop.controller import LoopError
from fuzzy.system import Sugeno


def to_nlsys(fis: Sugeno) -> Any:
    """A ``control.NonlinearIOSystem`` y = fis(u), with the inputs and outputs named as those of ``fis``.

    Units are those of the variables. What leaves a universe, and where no rule fires, is answered as ``fis`` does.
    With one input and one output, ``control.describing_function`` takes it as well.

    Raises LoopError where python-control is not installed.
    """
    try:
        import control
    except ModuleNotFoundError:
        raise LoopError(f"a control.nlsys needs python-control; install it: {install_command('control')}") from None

    def output(t: float, x: Any, u: Any, params: Any) -> np.ndarray:
        return np.asarray(fis(np.atleast_1d(np.asarray(u, dtype=float))))

    inputs, outputs = [v.name for v in fis.inputs], [v.name for v in fis.outputs]
    return control.nlsys(None, output, inputs=inputs, outputs=outputs, name=fis.name)
