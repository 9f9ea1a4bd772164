"""Parameters, engines and the search: bounds, reproducibility, going on after a stop, fronts."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from fuzzy.tuning.engines import ENGINES, engine_of
from fuzzy.tuning.journal import resumable_search
from fuzzy.tuning.parameter import SearchParameter, TuningError, values_at
from fuzzy.tuning.search import pareto_front, search

SPACE = (
    SearchParameter(name="a", start=1.0, lower=0.1, upper=10.0, scale="log"),
    SearchParameter(name="b", start=0.0, lower=-2.0, upper=3.0),
    SearchParameter(name="c", start=2.0, lower=0.0, upper=4.0),
)
MIXED = (*SPACE, SearchParameter(name="d", start=1.0, choices=("low", "middle", "high")))


def bowl(values):
    """Least, 0, at a = 3, b = 1, c = 1, and d = "high" where there is a choice."""
    cost = np.log(values[:, 0] / 3) ** 2 + (values[:, 1] - 1) ** 2 + (values[:, 2] - 1) ** 2
    return cost + (values[:, 3] != 2 if values.shape[1] > 3 else 0.0)


@given(st.floats(1e-3, 1e3), st.floats(1.001, 1e3), st.floats(0, 1), st.sampled_from(["linear", "log"]))
def test_a_value_comes_back_from_its_unit_coordinate(lower, factor, unit, scale):
    parameter = SearchParameter(name="p", start=lower, lower=lower, upper=lower * factor, scale=scale)
    value = parameter.value_of(unit)
    assert parameter.lower <= value <= parameter.upper
    assert parameter.unit_of(value) == pytest.approx(unit, abs=1e-9)
    assert parameter.value_of(0) == parameter.lower
    assert parameter.value_of(1) == pytest.approx(parameter.upper, rel=1e-12)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"lower": 2.0, "upper": 1.0}, "low must be less than high"),
        ({"lower": 0.0, "upper": 1.0, "scale": "log"}, "low must be > 0"),
        ({"lower": 2.0, "upper": 3.0}, "starts at 1"),
        ({"scale": "logarithmic"}, "did you mean|unknown scale"),
        ({"upper": np.inf}, "low must be less than high"),
    ],
)
def test_a_parameter_that_makes_no_sense_is_refused(fields, message):
    with pytest.raises(TuningError, match=message):
        SearchParameter(name="p", start=1.0, **fields)


@pytest.mark.parametrize("engine", ["cmaes", "random"])
def test_engines_find_the_bottom_of_a_bowl(engine):
    found = search(bowl, SPACE, evaluations=600, seed=4, engine=engine)
    assert len(found) == 600
    assert found.values[0].tolist() == [1.0, 0.0, 2.0]
    assert found.costs[found.best] < (1e-6 if engine == "cmaes" else 0.02)


@pytest.mark.parametrize("engine", ["cmaes", "random"])
def test_engines_choose(engine):
    found = search(bowl, MIXED, evaluations=600, seed=2, engine=engine)
    assert found.costs[found.best] < 0.05
    assert found.table()["d"].iloc[found.best] == "high"


@pytest.mark.parametrize("engine", ["cmaes", "random"])
def test_choices_alone_are_searched(engine):
    space = tuple(SearchParameter(name=f"c{k}", start=0.0, choices=("a", "b", "c", "d")) for k in range(4))
    found = search(lambda v: (v != 3).sum(axis=1), space, evaluations=500, seed=1, engine=engine)
    assert found.costs.min() == 0


@settings(max_examples=20)
@given(st.sampled_from(sorted(ENGINES)), st.integers(0, 2**32), st.booleans())
def test_points_stay_within_the_bounds(engine, seed, mixed):
    space = MIXED if mixed else SPACE
    asked = engine_of(engine, space, seed)
    asked.begin(1.0)
    rng = np.random.default_rng(seed)
    for _ in range(4):
        points = asked.ask()
        values = values_at(space, points)
        for parameter, column in zip(space, values.T, strict=True):
            assert (parameter.lower <= column).all()
            assert (column <= parameter.upper).all()
        asked.tell(points, rng.random((len(points), 2)))


def two(values):
    """Two objectives between which there is a front: a towards 1, and towards 5."""
    far = (values[:, 1] - 1) ** 2 + (values[:, 2] - 1) ** 2
    return np.stack([np.log(values[:, 0]) ** 2 + far, np.log(values[:, 0] / 5) ** 2 + far], axis=1)


@pytest.mark.parametrize("engine", sorted(ENGINES))
@pytest.mark.parametrize("kept", [1, 40, 77, 150])
def test_a_search_that_was_stopped_goes_on_to_the_same_last_bit(engine, kept):
    whole = search(two, MIXED[:3], evaluations=150, seed=3, engine=engine, names=("one", "other"))
    ends = []
    search(
        two,
        MIXED[:3],
        evaluations=150,
        seed=3,
        engine=engine,
        names=("one", "other"),
        after=lambda e: ends.append(len(e)),
    )
    stop = max(end for end in ends if end <= kept)
    computed = []

    def counted(values):
        computed.append(len(values))
        return two(values)

    again = search(
        counted, SPACE, evaluations=150, seed=3, engine=engine, names=("one", "other"), known=whole.objectives[:stop]
    )
    assert sum(computed) == 150 - stop
    assert again.values.tobytes() == whole.values.tobytes()
    assert again.objectives.tobytes() == whole.objectives.tobytes()


def test_a_search_ends_when_it_is_told_to():
    found = search(bowl, SPACE, evaluations=1000, seed=0, after=lambda e: len(e) > 50)
    assert 50 < len(found) < 100


def test_costs_that_are_no_numbers_are_the_worst():
    def holes(values):
        cost = bowl(values)
        cost[values[:, 1] < 0.2] = np.nan
        return cost

    found = search(holes, SPACE, evaluations=400, seed=0)
    assert found.costs[found.best] < 0.01
    assert np.isinf(found.costs).any()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"evaluations": 0}, "evaluations must be"),
        ({"engine": "cma"}, "cmaes"),
        ({"parameters": ()}, "nothing may change"),
    ],
)
def test_a_search_that_cannot_be_is_refused(change, message):
    told = {"parameters": SPACE, "evaluations": 5, "seed": 0} | change
    with pytest.raises(TuningError, match=message):
        search(bowl, told.pop("parameters"), **told)


def test_a_front_of_three_objectives_is_not_searched():
    with pytest.raises(TuningError, match="between two objectives"):
        search(lambda v: np.stack([bowl(v)] * 3, axis=1), SPACE, evaluations=60, seed=0, engine="pareto", names="abc")


def test_the_front_of_a_known_problem_is_found():
    found = search(two, SPACE, evaluations=800, seed=0, engine="pareto", names=("one", "other"))
    front = found.objectives[found.front]
    # On the true front b = c = 1 and sqrt(one) + sqrt(other) = log 5
    assert len(front) > 15
    assert np.median(np.sqrt(front).sum(axis=1)) == pytest.approx(np.log(5), rel=0.02)
    assert front[:, 0].min() < 0.1
    assert front[:, 1].min() < 0.1


@given(arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 3)), elements=st.integers(0, 5).map(float)))
def test_a_front_is_what_nothing_beats(objectives):
    front = pareto_front(objectives)
    brute = [
        k
        for k, row in enumerate(objectives)
        if not any((other <= row).all() and (other < row).any() for other in objectives)
        and not any((other == row).all() for other in objectives[:k])
    ]
    assert sorted(front.tolist()) == brute


def test_a_folder_is_that_of_one_search(tmp_path):
    asked: list[int] = []

    def cost(values):
        asked.append(len(values))
        if len(asked) == 1:
            with pytest.raises(TuningError, match="another search is at work"):
                once({"law": "a", "seed": 1})
        return np.full(len(values), 1 / 3)

    def once(about, fresh=False):
        folder, engine = tmp_path / "one", "random"
        return resumable_search(
            cost, SPACE, about=about, folder=folder, fresh=fresh, evaluations=1, seed=0, engine=engine
        )

    assert once({"law": "a", "seed": 1}).costs.tolist() == [1 / 3]
    assert once({"law": "a", "seed": 1}).costs.tolist() == [1 / 3]
    assert asked == [1]  # the second time it was known
    with pytest.raises(TuningError, match="seed changed"):
        once({"law": "a", "seed": 2})
    once({"law": "a", "seed": 2}, fresh=True)
    assert asked == [1, 1]
    (tmp_path / "one" / "history.csv").write_text("evaluation,cost\n1,what\n")
    with pytest.raises(TuningError, match="history"):
        once({"law": "a", "seed": 2})
