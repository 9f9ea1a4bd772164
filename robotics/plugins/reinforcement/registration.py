"""The ids by which Gymnasium makes the environments."""

import sys
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from typing import Any

TRACKING = "fuzzyfleet/Tracking-v0"
_REGISTRY = "gymnasium.envs.registration"


def register() -> None:
    """Register :data:`TRACKING`, for ``gymnasium.make`` and ``gymnasium.make_vec``, now or when Gymnasium is imported.

    Gymnasium takes a third of the time of ``robotics --help``, and reads no entry points since its version 1.0.
    """
    if _REGISTRY in sys.modules:
        _add(sys.modules[_REGISTRY])
    elif not any(isinstance(finder, _WhenImported) for finder in sys.meta_path):
        sys.meta_path.insert(0, _WhenImported())


def _add(registration: Any) -> None:
    if TRACKING not in registration.registry:
        here = "robotics.plugins.reinforcement"
        places = {"entry_point": f"{here}.single:TrackingEnv", "vector_entry_point": f"{here}.vector:TrackingVectorEnv"}
        registration.register(TRACKING, **places)


class _WhenImported:
    """Finds Gymnasium's registry where it is, once, and registers when it has been executed."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> ModuleSpec | None:
        if name != _REGISTRY:
            return None
        sys.meta_path.remove(self)
        spec = find_spec(name)
        if spec is not None and spec.loader is not None:
            execute = spec.loader.exec_module

            def and_register(module: Any) -> None:
                execute(module)
                _add(module)

            spec.loader.exec_module = and_register  # type: ignore[method-assign]
        return spec
