"""The presets of laws as the thesis prints them, which entry points name."""

from robotics.laws.law import Preset
from robotics.laws.teams.graph_sliding_mode import GraphSlidingMode
from robotics.laws.teams.virtual_structure import VirtualStructure
from robotics.laws.tracking.lyapunov import Lyapunov
from robotics.plugins.thesis.fuzzy_hierarchy import FuzzyHierarchy

LYAPUNOV_THESIS = Preset(
    Lyapunov, {"ky": 1.0, "kpsi": 1.0}, "Lyapunov, thesis gains", "(2.30), (2.32) with the thesis's 1, 1, 1"
)
GRAPH_ESM_THESIS = Preset(
    GraphSlidingMode, {"form": "thesis"}, "Graph ESM, thesis form", "(3.4), (3.5) with K_ij = a_ij", "team"
)
VIRTUAL_STRUCTURE_THESIS = Preset(
    VirtualStructure,
    {"variant": "virtual", "tracker.ky": 1.0, "tracker.kpsi": 1.0, "tracker.catch_up": 0.0},
    "Virtual structure, thesis gains",
    "(4.10), (4.11) with the thesis's 1, 1, 1",
    "team",
)
HIERARCHY_LITERAL = Preset(
    FuzzyHierarchy,
    {},
    "Thesis hierarchy, literal",
    "(6.4), (6.5), (6.7) and Table 5.6 as printed, with the clock of the lag; d_min 0.6 m, ro_min 0.8 m",
    "team",
)
