"""The presets of reactive laws, which entry points name."""

from robotics.laws.law import Preset
from robotics.plugins.reactive.dynamic_window import DynamicWindow
from robotics.plugins.reactive.orca import Orca
from robotics.plugins.reactive.potential_field import PotentialField
from robotics.plugins.reactive.stop_and_wait import StopAndWait

_ORCA = (
    "reciprocal avoidance of what is heard by radio and of what sensors see; a point ahead of the axle, keeping right"
)
STOP_AND_WAIT = Preset(StopAndWait, {}, "Stop and wait", "stands while something is ahead; numbers by hand", "team")
POTENTIAL_FIELD = Preset(PotentialField, {}, "Potential field", "Khatib (1986) on range sensors; by hand", "team")
DYNAMIC_WINDOW = Preset(
    DynamicWindow, {}, "Dynamic window", "Fox et al. (1997) on range sensors; weights as there", "team"
)
ORCA = Preset(Orca, {}, "ORCA", _ORCA, "team")
