"""The report's chapter on teams: graph, virtual structure, fuzzy cooperation; thesis 3, 4, 5.3 and 5.4."""

from functools import partial
from itertools import product, zip_longest

from fuzzy.figures.drawing import PAGE_WIDTH
from robotics.laws.catalogue import label
from robotics.laws.tracking.fuzzy_tracking import load_rule_base
from robotics.measures.evidence import mean_of, rate_of
from robotics.measures.leading import Lead, lead
from robotics.measures.quantities import MEASURED_QUANTITIES, measured, runs_touched
from robotics.plugins.thesis import team_runs
from robotics.plugins.thesis.claims import Needed, judged
from robotics.plugins.thesis.figures import plot_recovery, plot_robot_errors, plot_scaling
from robotics.plugins.thesis.recovery import Recovery, Scaling
from robotics.plugins.thesis.rows import TABLES, TEXTS, film_of, run_columns
from robotics.plugins.thesis.states import plot_states
from robotics.plugins.thesis.team_runs import DUELS, EXPERIMENTS, OUTAGES, RECOVERERS, TEAM_TESTS, Results
from robotics.show.figures.run import plot_run
from robotics.show.report.chapter import Chapter, Grid, Picture
from robotics.show.report.wording import shown
from robotics.simulation.scenario.reading import load_scenario

_COLUMNS = ("mean |x_err| [m]", "mean |y_err| [m]", "mean |ψ_err| [rad]", "mean error norm (“MSE”)")
# Tables 5.7 and 5.8 as printed, the columns x_err, y_err, α and MSE, of robots 1 to 3, with their misprints
PRINTED_TEAMS = TABLES.table("printed.teams")
# Runs to play in the report
FILMS: list[tuple[str, str]] = [(on, law) for on, law in TABLES.table("films")]


def chapter_of(results: Results) -> Chapter:
    """Write the chapter from the results of its experiments."""
    return TEXTS.chapter(
        "teams",
        tables=[_experiments(results)],
        details=[*(_duel(results, test) for test in TEAM_TESTS), _table_5_6(), _recovery(results), _scaling(results)],
        pictures=_pictures(results),
        claims=judged("teams", partial(team_runs.values, results)),
        films=[film_of(results[Needed(*item, False)], *item, "team") for item in FILMS],
        leads=[_lead(results, test) for test in TEAM_TESTS],
    )


def _lead(results: Results, test: str) -> Lead:
    runs = {law: results[Needed(test, law, False)] for law in DUELS}
    values_ = {law: measured(run, "timetable_error_norm", "mean") for law, run in runs.items()}
    return lead(test, "mean error norm", "m, rad", values_, {law: runs_touched(run) for law, run in runs.items()})


def _table_5_6() -> Grid:
    printed, driven = (load_rule_base(name) for name in ("tracking-literal", "tracking"))
    rows = [
        (str(n), *map(str, pair)) for n, pair in enumerate(zip_longest(printed.rules, driven.rules, fillvalue=""), 1)
    ]
    return TEXTS.grid("teams.table-5-6", rows)


def _experiments(results: Results) -> Grid:
    return Grid.of(
        TEXTS.text("teams.experiments.caption"),
        [results[Needed(scenario, law, False)] for scenario, laws in EXPERIMENTS.items() for law in laws],
        run_columns(
            "experiment",
            {"runs": lambda run: str(len(run.seeds))},
            **TEXTS.table("teams.experiments.columns"),
        ),
    )


_TABLES = {"unequal-lengths": "5.7", "start-off-paths": "5.8"}


def _duel(results: Results, test: str) -> Grid:
    rows = [
        (f"thesis, {kind} (printed)", *(", ".join(column) for column in PRINTED_TEAMS[test][kind]), "")
        for kind in ("nonlinear", "fuzzy")
    ]
    for law, title in DUELS.items():
        run = results[Needed(test, law, False)]
        means = team_runs.mean_errors(run)
        numbers = [", ".join(shown(mean_of(means[:, i, k]), "1") for i in range(3)) for k in range(4)]
        reached = MEASURED_QUANTITIES["path_settling_time_s"].measure(run)
        rows.append((title, *numbers, ", ".join(shown(mean_of(reached[:, i]), "s") for i in range(3))))
    caption = TEXTS.text("teams.duel.caption", table=_TABLES[test], seeds=len(run.seeds))
    return Grid(caption, ("controller", *_COLUMNS, "on the path for good"), rows)


def _recovery(results: Results) -> Grid:
    def cell(law: str, outage: float) -> str:
        found: Recovery = results["recovery", law, outage]
        share = f"{shown(rate_of(found.recovered), '1')} of {len(found.recovered)} runs"
        return f"{share}, {shown(mean_of(found.deviation), 'm')}"

    return Grid.of(
        TEXTS.text("teams.recovery.caption"),
        RECOVERERS,
        {"controller": label} | {f"{outage:g} s": partial(cell, outage=outage) for outage in OUTAGES},
    )


def _scaling(results: Results) -> Grid:
    return Grid.of(
        TEXTS.text("teams.scaling.caption"),
        _scalings(results),
        {
            "robots": lambda s: str(s.robots),
            "messages lost": lambda s: f"{100 * s.loss:g} %",
            "spread of arrivals [s]": lambda s: f"{s.spread:.2f}",
            "last arrival after the reference [s]": lambda s: f"{s.late:.1f}",
            "largest s_i − s_j": lambda s: f"{s.gap:.4f}",
        },
    )


def _scalings(results: Results) -> list[Scaling]:
    return [found for key, found in results.items() if key[0] == "scaling"]


def _pictures(results: Results) -> list[Picture]:
    recovered = [results["recovery", *key] for key in product(RECOVERERS, OUTAGES)]
    plots = {
        "team-states": partial(plot_states, ("cooperation-literal", "cooperation")),
        "team-recovery": partial(plot_recovery, recovered, PAGE_WIDTH),
        "team-scaling": partial(plot_scaling, _scalings(results), PAGE_WIDTH),
    }
    return [
        *(_page(results, scenario, figures) for scenario, figures in TABLES.table("figures").items()),
        *(_errors(results, test) for test in TEAM_TESTS),
        *(TEXTS.picture(name, plot) for name, plot in plots.items()),
    ]


def _page(results: Results, scenario: str, figures: str) -> Picture:
    """The page of a scenario's first law."""
    law = EXPERIMENTS[scenario][0]
    run = results[Needed(scenario, law, False)]
    return TEXTS.picture(
        f"team-{scenario}",
        partial(plot_run, run, width=PAGE_WIDTH),
        key="team-page",
        title=load_scenario(scenario).title,
        law=label(law),
        figures=figures,
        scenario=scenario,
    )


def _errors(results: Results, test: str) -> Picture:
    found = {}
    for law, title in DUELS.items():
        means = team_runs.mean_errors(results[Needed(test, law, False)])
        found[title] = [[mean_of(means[:, i, k]) for i in range(means.shape[1])] for k in range(means.shape[2])]
    return TEXTS.picture(
        f"team-errors-{test}",
        partial(plot_robot_errors, found, (*_COLUMNS[:3], "mean error norm [m, rad]"), PAGE_WIDTH),
        key="team-errors",
        title=load_scenario(test).title,
        table=_TABLES[test],
        test=test,
    )
