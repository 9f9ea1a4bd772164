"""The presets of predictive laws, which entry points name."""

from robotics.laws.law import Preset
from robotics.plugins.predictive.mppi import PathIntegral
from robotics.plugins.predictive.mppi_ranges import IntegralAround
from robotics.plugins.predictive.nmpc import PredictiveControl
from robotics.plugins.predictive.nmpc_discs import PredictiveAround

_MPPI = "model predictive path integral control with Nav2's horizon, noise and 1,000 samples, on a cost of tracking"
_NMPC = "iLQR over 1 s with wheel lag, latency and bounds; weights by Bryson's rule, not by search"
MPPI = Preset(PathIntegral, {}, "MPPI", _MPPI)
NMPC = Preset(PredictiveControl, {}, "Predictive control", _NMPC)
_RANGES = "MPPI over 2 s on range sensors: a disc around each point that is seen; numbers by hand"
_DISCS = "iLQR over 2 s, with a disc around each robot that is heard and each point that is seen; numbers by hand"
MPPI_RANGES = Preset(IntegralAround, {}, "MPPI on ranges", _RANGES, "team")
NMPC_DISCS = Preset(PredictiveAround, {}, "Predictive control with discs", _DISCS, "team")
