"""Gymnasium, an optional package: whoever imports this module needs it, and is told how to get it."""

from fuzzy.extras import install_command
from robotics.plugins.reinforcement.task import TaskError

try:
    import gymnasium as gymnasium
except ModuleNotFoundError:
    raise TaskError(f"environments need gymnasium: {install_command('gym')}") from None
