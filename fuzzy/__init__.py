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
    format_fll, find_fis, packaged_fis_files, without_hedges; identify,
    subtractive_clusters, fit_consequents, search_clusters, search_table, select_inputs; tune, a TunedSystem comes back
Rules from nothing, exact for their size:
    search_rules, a RuleFront of RuleFrontPoints comes back; plot_rule_front
Mamdani systems, and how near a Sugeno system comes:
    Mamdani, read_mamdani_original, mamdani_difference, fit_to_mamdani; from_skfuzzy,
    a FromScikitFuzzy comes back
Interval type-2 systems, each term with a lower membership function:
    to_type2, Type2Sugeno, Lower, infer_type2, a Type2Inference comes back; compile_type2, CompiledType2; read_type2,
    matlab_type2; plot_footprint; write_c_type2
Trees of systems, some of which take the outputs of others:
    Tree, evaluated, described; compile_tree, CompiledTree; read_tree; explain_tree, a TreeExplanation comes
    back; plot_tree; train_tree, a TrainedTree comes back; identify_tree; write_c_tree, TreeCFiles come back; TreeError
Take it to a microcontroller:
    write_c, verify_c; CFiles, Verified and a Lookup come back
Close the loop with one's own plant:
    step_response, plot_step_response, certify_step, TransferFunction, FunctionPlant, PID, Scale;
    rule_table, Mac Vicar-Whelan's; tuned_pid, a rival; in python-control to_nlsys, linear_controller, linearised,
    describing_function, plot_bode, plot_describing_function; of a search plot_search, plot_front;
    from a PID to rules scale_from_pid, tune_loop; scheduled over an operating variable ScheduledTransferFunction,
    schedule_from_pids, pid_over_points;
    in C controller_code, write_controller, prove_controller
Look and understand:
    explain, check, interpretability, surface, Surface; plot_memberships, plot_rules, plot_surface, plot_structure,
    plot_rules_error, save_figure, write_figures; style, for figures of one's own; MATLAB's names plotmf, plotfis,
    gensurf, ruleview; editor, the designer in a notebook

Each name is imported from its module when it is first used. A wrong input raises an InputError, a ValueError.
"""

import _fuzzyfleet

_fuzzyfleet.check()

from fuzzy.lazynames import lazy_names  # noqa: E402
from fuzzy.notebookfigures import show_figures  # noqa: E402
from fuzzy.renamed import redirect  # noqa: E402

__getattr__, __dir__, __all__ = lazy_names(__name__)
redirect(
    {f"fuzzy.{name}": f"fuzzy.plugins.{name}" for name in ("ccode", "designer", "loop", "mamdani")}
    | {"fuzzy.hedges": "fuzzy.plugins.mamdani.hedges", "fuzzy.tuning.data": "fuzzy.plugins.tuning.data"}
    | {f"fuzzy.files.{name}": f"fuzzy.plugins.mamdani.{name}" for name in ("fllfile", "flltext")}
    | {"fuzzy.designer.steppanel": "fuzzy.plugins.loop.panel", "fuzzy.designer.steptask": "fuzzy.plugins.loop.steptask"}
    | {"fuzzy.figures.step": "fuzzy.plugins.loop.stepfigure", "fuzzy.figures.frequency": "fuzzy.plugins.loop.frequency"}
    | {"fuzzy.designer.esmodule": "fuzzy.esmodule", "fuzzy.starts": "fuzzy.plugins.designer.starts"}
)
show_figures()
