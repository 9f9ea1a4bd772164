"""The presets of predictive laws, which entry points name."""

from robotics.laws.law import Preset
from robotics.plugins.predictive.mppi import PathIntegral
from robotics.plugins.predictive.nmpc import PredictiveControl

_MPPI = "model predictive path integral control with Nav2's horizon, noise and 1,000 samples, on a cost of tracking"
_NMPC = "iLQR over 1 s with wheel lag, latency and bounds; weights by Bryson's rule, not by search"
MPPI = Preset(PathIntegral, {}, "MPPI", _MPPI)
NMPC = Preset(PredictiveControl, {}, "Predictive control", _NMPC)
