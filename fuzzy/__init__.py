"""Fuzzy inference: Sugeno systems, membership functions, rules in English, MATLAB's files, data, pictures.

>>> import fuzzy
>>> speed = fuzzy.Sugeno(
...     inputs=[fuzzy.Variable("distance", (0, 2), {"near": fuzzy.LinearZ(0, 1), "far": fuzzy.LinearS(0, 1)}, "m")],
...     outputs=[fuzzy.Variable("v", (0, 1), {"stop": 0.0, "cruise": 0.5}, "m/s")],
...     rules=["if distance is near then v is stop", "if distance is far then v is cruise"],
... )
>>> float(speed([0.5])[0])
0.25

What needs matplotlib or Numba (pictures, the compiled evaluator) is imported when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from fuzzy.errors import InputError
from fuzzy.files.fisfile import FisFileError, FisFileWarning, format_fis, parse_fis, read_fis, write_fis
from fuzzy.files.table import DataError
from fuzzy.fitting.clustering import ClusteringError, DataWarning, subtractive_clusters
from fuzzy.fitting.consequents import IdentificationError, fit_consequents
from fuzzy.fitting.identification import identify
from fuzzy.fitting.search import SearchResult, search_clusters, search_table
from fuzzy.inference import Inference, InferenceWarning, infer
from fuzzy.insight.diagnosis import Finding, check
from fuzzy.insight.explanation import Explanation, explain
from fuzzy.insight.surfacegrid import Surface, surface
from fuzzy.language import RuleError, parse_rule
from fuzzy.membership import (
    Bell,
    Gaussian,
    LinearS,
    LinearZ,
    PiShape,
    Sigmoid,
    SigmoidDifference,
    SigmoidProduct,
    SShape,
    Trapezoid,
    Triangle,
    TwoSidedGaussian,
    ZShape,
    dsigmf,
    gauss2mf,
    gaussmf,
    gbellmf,
    linsmf,
    linzmf,
    pimf,
    psigmf,
    sigmf,
    smf,
    trapmf,
    trimf,
    zmf,
)
from fuzzy.membershipfunction import MembershipError, MembershipFunction, membership_function
from fuzzy.rule import Clause, Rule
from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Variable

if TYPE_CHECKING:
    from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
    from fuzzy.designer.notebook import editor
    from fuzzy.figures.plot import (
        gensurf,
        plot_memberships,
        plot_rules,
        plot_structure,
        plot_surface,
        plotfis,
        plotmf,
        ruleview,
        save_figure,
    )
    from fuzzy.figures.search import plot_rules_error
    from fuzzy.files.packaged import find_fis, packaged_fis_files

_MODULES = {
    "fuzzy.compiled.sugeno": ("CompiledSugeno", "compile_sugeno"),
    "fuzzy.designer.notebook": ("editor",),
    "fuzzy.figures.plot": (
        *("gensurf", "plot_memberships", "plot_rules", "plot_structure", "plot_surface"),
        *("plotfis", "plotmf", "ruleview", "save_figure"),
    ),
    "fuzzy.figures.search": ("plot_rules_error",),
    "fuzzy.files.packaged": ("find_fis", "packaged_fis_files"),
}
_HOME = {name: module for module, names in _MODULES.items() for name in names}


def __getattr__(name: str) -> Any:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module 'fuzzy' has no attribute {name!r}")


__all__ = [
    "Bell",
    "Clause",
    "ClusteringError",
    "CompiledSugeno",
    "Constant",
    "DataError",
    "DataWarning",
    "Explanation",
    "Finding",
    "FisFileError",
    "FisFileWarning",
    "FuzzySystemError",
    "Gaussian",
    "IdentificationError",
    "Inference",
    "InferenceWarning",
    "InputError",
    "Linear",
    "LinearS",
    "LinearZ",
    "MembershipError",
    "MembershipFunction",
    "PiShape",
    "Rule",
    "RuleError",
    "SShape",
    "SearchResult",
    "Sigmoid",
    "SigmoidDifference",
    "SigmoidProduct",
    "Sugeno",
    "Surface",
    "Trapezoid",
    "Triangle",
    "TwoSidedGaussian",
    "Variable",
    "ZShape",
    "check",
    "compile_sugeno",
    "dsigmf",
    "editor",
    "explain",
    "find_fis",
    "fit_consequents",
    "format_fis",
    "gauss2mf",
    "gaussmf",
    "gbellmf",
    "gensurf",
    "identify",
    "infer",
    "linsmf",
    "linzmf",
    "membership_function",
    "packaged_fis_files",
    "parse_fis",
    "parse_rule",
    "pimf",
    "plot_memberships",
    "plot_rules",
    "plot_rules_error",
    "plot_structure",
    "plot_surface",
    "plotfis",
    "plotmf",
    "psigmf",
    "read_fis",
    "ruleview",
    "save_figure",
    "search_clusters",
    "search_table",
    "sigmf",
    "smf",
    "subtractive_clusters",
    "surface",
    "trapmf",
    "trimf",
    "write_fis",
    "zmf",
]
