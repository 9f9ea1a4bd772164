"""The preset of the learnt policy for teams, which an entry point names."""

from robotics.laws.law import Preset
from robotics.plugins.teampolicy.law import TeamPolicy

_NOTE = "a network that imitated ORCA, and went on by PPO; nothing of it is proved"
PPO_TEAM = Preset(TeamPolicy, {}, "Learnt policy for teams (PPO)", _NOTE, "team")
