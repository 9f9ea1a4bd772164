"""Fuzzy inference: Sugeno systems, membership functions, rules in English, MATLAB's files, data, pictures.

>>> import fuzzy
>>> speed = fuzzy.Sugeno(
...     inputs=[fuzzy.Variable("distance", (0, 2), {"near": fuzzy.LinearZ(0, 1), "far": fuzzy.LinearS(0, 1)}, "m")],
...     outputs=[fuzzy.Variable("v", (0, 1), {"stop": 0.0, "cruise": 0.5}, "m/s")],
...     rules=["if distance is near then v is stop", "if distance is far then v is cruise"],
... )
>>> float(speed([0.5])[0])
0.25

Make a system and ask it:
    Sugeno, Variable, Rule, Clause, Constant, Linear, parse_rule; infer, compile_sugeno; membership functions (Triangle,
    Gaussian, ... and MATLAB's trimf, gaussmf, ...) and membership_function, which makes one by name
Files, data and learning a start (the rest is in the package anfis):
    read_fis, read_mamdani, write_fis, parse_fis, format_fis, read_fll, write_fll, parse_fll,
    format_fll, find_fis, packaged_fis_files; identify,
    subtractive_clusters, fit_consequents, search_clusters, search_table; tune, a TunedSystem comes back
Mamdani systems, and how near a Sugeno system comes:
    Mamdani, read_mamdani_original, mamdani_difference, fit_to_mamdani; from_skfuzzy,
    a FromScikitFuzzy comes back
Take it to a microcontroller:
    write_c, verify_c; CFiles, Verified and a Lookup come back
Close the loop with one's own plant:
    step_response, plot_step_response, TransferFunction, FunctionPlant, PID, Scale; rule_table, Mac Vicar-Whelan's;
    tuned_pid, a rival; in python-control to_nlsys, linear_controller, linearised, describing_function, plot_bode,
    plot_describing_function; of a search plot_search, plot_front
Look and understand:
    explain, check, surface, Surface; plot_memberships, plot_rules, plot_surface, plot_structure, plot_rules_error,
    save_figure, write_figures; style, for figures of one's own; MATLAB's names plotmf, plotfis, gensurf, ruleview;
    editor, the designer in a notebook

Each name is imported from its module when it is first used. What is wrong with an input is an InputError, a ValueError.
"""

from fuzzy.lazynames import lazy_names
from fuzzy.notebookfigures import show_figures

TYPE_CHECKING = False  # type checkers take it as true by its name; importing typing would double the time

if TYPE_CHECKING:
    from fuzzy.ccode.compiler import CompilerError
    from fuzzy.ccode.lookup import Lookup
    from fuzzy.ccode.numbertype import ExportError
    from fuzzy.ccode.verification import Verified, verify_c
    from fuzzy.ccode.writing import CFiles, write_c
    from fuzzy.compiled.sugeno import CompiledSugeno, compile_sugeno
    from fuzzy.designer.notebook import editor
    from fuzzy.errors import InputError
    from fuzzy.figures.drawing import style
    from fuzzy.figures.figureset import write_figures
    from fuzzy.figures.frequency import plot_bode, plot_describing_function
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
    from fuzzy.figures.step import plot_step_response
    from fuzzy.figures.tuning import plot_front, plot_search
    from fuzzy.files.fisfile import (
        FisFileError,
        FisFileWarning,
        MamdaniError,
        MamdaniSystem,
        format_fis,
        parse_fis,
        read_fis,
        read_mamdani,
        write_fis,
    )
    from fuzzy.files.fllfile import FllFileError, parse_fll, read_fll
    from fuzzy.files.flltext import format_fll, write_fll
    from fuzzy.files.packaged import find_fis, packaged_fis_files
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
    from fuzzy.loop.controller import PID, LoopError, Scale
    from fuzzy.loop.nlsys import describing_function, linear_controller, linearised, to_nlsys
    from fuzzy.loop.plant import FunctionPlant, PlantError, TransferFunction
    from fuzzy.loop.response import StepResponse, step_response
    from fuzzy.loop.rival import tuned_pid
    from fuzzy.mamdani.likeness import Difference, fit_to_mamdani, mamdani_difference, read_mamdani_original
    from fuzzy.mamdani.scikitfuzzy import FromScikitFuzzy, from_skfuzzy
    from fuzzy.mamdani.system import Mamdani
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
        membership_function,
        pimf,
        psigmf,
        sigmf,
        smf,
        trapmf,
        trimf,
        zmf,
    )
    from fuzzy.membershipfunction import MembershipError, MembershipFunction
    from fuzzy.rule import Clause, Rule
    from fuzzy.starts.control import rule_table
    from fuzzy.system import Constant, FuzzySystemError, Linear, Sugeno, Variable
    from fuzzy.tuning.data import TunedSystem, tune

_HOMES = {
    "fuzzy.ccode.compiler": ("CompilerError",),
    "fuzzy.ccode.lookup": ("Lookup",),
    "fuzzy.ccode.numbertype": ("ExportError",),
    "fuzzy.ccode.verification": ("Verified", "verify_c"),
    "fuzzy.ccode.writing": ("CFiles", "write_c"),
    "fuzzy.compiled.sugeno": ("CompiledSugeno", "compile_sugeno"),
    "fuzzy.designer.notebook": ("editor",),
    "fuzzy.errors": ("InputError",),
    "fuzzy.figures.drawing": ("style",),
    "fuzzy.figures.figureset": ("write_figures",),
    "fuzzy.figures.frequency": ("plot_bode", "plot_describing_function"),
    "fuzzy.figures.plot": (
        "gensurf",
        "plot_memberships",
        "plot_rules",
        "plot_structure",
        "plot_surface",
        "plotfis",
        "plotmf",
        "ruleview",
        "save_figure",
    ),
    "fuzzy.figures.search": ("plot_rules_error",),
    "fuzzy.figures.step": ("plot_step_response",),
    "fuzzy.figures.tuning": ("plot_front", "plot_search"),
    "fuzzy.files.fisfile": (
        "FisFileError",
        "FisFileWarning",
        "MamdaniError",
        "MamdaniSystem",
        "format_fis",
        "parse_fis",
        "read_fis",
        "read_mamdani",
        "write_fis",
    ),
    "fuzzy.files.fllfile": ("FllFileError", "parse_fll", "read_fll"),
    "fuzzy.files.flltext": ("format_fll", "write_fll"),
    "fuzzy.files.packaged": ("find_fis", "packaged_fis_files"),
    "fuzzy.files.table": ("DataError",),
    "fuzzy.fitting.clustering": ("ClusteringError", "DataWarning", "subtractive_clusters"),
    "fuzzy.fitting.consequents": ("IdentificationError", "fit_consequents"),
    "fuzzy.fitting.identification": ("identify",),
    "fuzzy.fitting.search": ("SearchResult", "search_clusters", "search_table"),
    "fuzzy.inference": ("Inference", "InferenceWarning", "infer"),
    "fuzzy.insight.diagnosis": ("Finding", "check"),
    "fuzzy.insight.explanation": ("Explanation", "explain"),
    "fuzzy.insight.surfacegrid": ("Surface", "surface"),
    "fuzzy.language": ("RuleError", "parse_rule"),
    "fuzzy.loop.controller": ("LoopError", "PID", "Scale"),
    "fuzzy.loop.nlsys": ("describing_function", "linear_controller", "linearised", "to_nlsys"),
    "fuzzy.loop.plant": ("FunctionPlant", "PlantError", "TransferFunction"),
    "fuzzy.loop.response": ("StepResponse", "step_response"),
    "fuzzy.loop.rival": ("tuned_pid",),
    "fuzzy.mamdani.likeness": ("Difference", "fit_to_mamdani", "mamdani_difference", "read_mamdani_original"),
    "fuzzy.mamdani.scikitfuzzy": ("FromScikitFuzzy", "from_skfuzzy"),
    "fuzzy.mamdani.system": ("Mamdani",),
    "fuzzy.membership": (
        "Bell",
        "Gaussian",
        "LinearS",
        "LinearZ",
        "PiShape",
        "SShape",
        "Sigmoid",
        "SigmoidDifference",
        "SigmoidProduct",
        "Trapezoid",
        "Triangle",
        "TwoSidedGaussian",
        "ZShape",
        "dsigmf",
        "gauss2mf",
        "gaussmf",
        "gbellmf",
        "linsmf",
        "linzmf",
        "membership_function",
        "pimf",
        "psigmf",
        "sigmf",
        "smf",
        "trapmf",
        "trimf",
        "zmf",
    ),
    "fuzzy.membershipfunction": ("MembershipError", "MembershipFunction"),
    "fuzzy.rule": ("Clause", "Rule"),
    "fuzzy.starts.control": ("rule_table",),
    "fuzzy.system": ("Constant", "FuzzySystemError", "Linear", "Sugeno", "Variable"),
    "fuzzy.tuning.data": ("TunedSystem", "tune"),
}
if not TYPE_CHECKING:  # a type checker has the names above, and sees which there are not
    __getattr__, __dir__ = lazy_names(__name__, _HOMES)
show_figures()

__all__ = [
    "PID",
    "Bell",
    "CFiles",
    "Clause",
    "ClusteringError",
    "CompiledSugeno",
    "CompilerError",
    "Constant",
    "DataError",
    "DataWarning",
    "Difference",
    "Explanation",
    "ExportError",
    "Finding",
    "FisFileError",
    "FisFileWarning",
    "FllFileError",
    "FromScikitFuzzy",
    "FunctionPlant",
    "FuzzySystemError",
    "Gaussian",
    "IdentificationError",
    "Inference",
    "InferenceWarning",
    "InputError",
    "Linear",
    "LinearS",
    "LinearZ",
    "Lookup",
    "LoopError",
    "Mamdani",
    "MamdaniError",
    "MamdaniSystem",
    "MembershipError",
    "MembershipFunction",
    "PiShape",
    "PlantError",
    "Rule",
    "RuleError",
    "SShape",
    "Scale",
    "SearchResult",
    "Sigmoid",
    "SigmoidDifference",
    "SigmoidProduct",
    "StepResponse",
    "Sugeno",
    "Surface",
    "TransferFunction",
    "Trapezoid",
    "Triangle",
    "TunedSystem",
    "TwoSidedGaussian",
    "Variable",
    "Verified",
    "ZShape",
    "check",
    "compile_sugeno",
    "describing_function",
    "dsigmf",
    "editor",
    "explain",
    "find_fis",
    "fit_consequents",
    "fit_to_mamdani",
    "format_fis",
    "format_fll",
    "from_skfuzzy",
    "gauss2mf",
    "gaussmf",
    "gbellmf",
    "gensurf",
    "identify",
    "infer",
    "linear_controller",
    "linearised",
    "linsmf",
    "linzmf",
    "mamdani_difference",
    "membership_function",
    "packaged_fis_files",
    "parse_fis",
    "parse_fll",
    "parse_rule",
    "pimf",
    "plot_bode",
    "plot_describing_function",
    "plot_front",
    "plot_memberships",
    "plot_rules",
    "plot_rules_error",
    "plot_search",
    "plot_step_response",
    "plot_structure",
    "plot_surface",
    "plotfis",
    "plotmf",
    "psigmf",
    "read_fis",
    "read_fll",
    "read_mamdani",
    "read_mamdani_original",
    "rule_table",
    "ruleview",
    "save_figure",
    "search_clusters",
    "search_table",
    "sigmf",
    "smf",
    "step_response",
    "style",
    "subtractive_clusters",
    "surface",
    "to_nlsys",
    "trapmf",
    "trimf",
    "tune",
    "tuned_pid",
    "verify_c",
    "write_c",
    "write_figures",
    "write_fis",
    "write_fll",
    "zmf",
]
