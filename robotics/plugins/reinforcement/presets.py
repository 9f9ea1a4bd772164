"""The preset of the learnt policy, which an entry point names."""

from robotics.laws.law import Preset
from robotics.plugins.reinforcement.neural import NeuralPolicy

_PPO = "a network of 1,666 numbers that `robotics reinforce` has learnt; nothing of it is proved"
PPO = Preset(NeuralPolicy, {}, "Learnt policy (PPO)", _PPO)
