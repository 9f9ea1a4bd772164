"""Training as a whole: what comes back, when it stops, how it goes on, and what it must not choke on."""

import warnings
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import anfis
import fuzzy
from anfis import DataWarning, Options, TrainingError
from anfis.checkpoint import save, with_tensors
from anfis.state import Epoch
from fuzzy.files.fisfile import format_fis, parse_fis
from fuzzy.system import Linear
from tests.anfis.training_problem import CHECK, FIS, TRAINED, X, Y, grid, rmse

torch.set_num_threads(1)


# What comes back ----------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(
    seed=st.integers(0, 10_000),
    kind=st.sampled_from(["gaussmf", "gbellmf", "trimf", "pimf", "psigmf", "dsigmf", "trapmf", "gauss2mf"]),
    step=st.sampled_from([0.01, 0.3]),
)
def test_hybrid_never_ends_above_its_start(seed, kind, step):
    random = np.random.default_rng(seed)
    x = random.uniform(-2, 2, (40, 2))
    y = np.sin(2 * x[:, 0]) * x[:, 1] + 0.1 * random.normal(size=40)
    fis = grid(x, kind)
    result = anfis.train(fis, x, y, Options(epochs=8, step=step))
    assert rmse(result.system, x, y) <= rmse(fis, x, y)
    assert rmse(result.system, x, y) <= result.history[0].train * (1 + 1e-9)
    assert rmse(result.system, x, y) == pytest.approx(min(row.train for row in result.history), rel=1e-6)


@pytest.mark.parametrize("method", TRAINED)
def test_the_systems_are_those_of_least_error(method):
    x, y = X[:20], Y[:20]  # few enough that checking and training errors part
    check = CHECK[0][20:], CHECK[1][20:] + 0.1
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)
        result = anfis.train(FIS, x, y, Options(method=method, epochs=15, step=0.1, rate=0.05), check=check)
    assert len(result.history) <= 16
    least = min(result.history, key=lambda row: row.check)
    assert result.best == least.epoch
    assert rmse(result.system, *check) == pytest.approx(least.check, rel=1e-6)
    assert rmse(result.least_train, x, y) == pytest.approx(min(row.train for row in result.history), rel=1e-6)
    assert list(result.table().columns) == ["epoch", "train", "check", "step", "rank"]


def test_least_squares_moves_the_consequents_only():
    result = anfis.train(FIS, X, Y, Options(method="least-squares", epochs=20))
    assert len(result.history) == 1
    assert result.system.inputs == FIS.inputs
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DataWarning)
        fitted = fuzzy.fit_consequents(FIS, X, Y)
    np.testing.assert_allclose(result.system(X), fitted(X), rtol=1e-8)


@pytest.mark.parametrize("options", [{}, {"method": "backprop", "batch": 16, "seed": 4}, {"method": "second-order"}])
def test_the_same_seed_gives_the_same_bytes(options):
    first, second = (anfis.train(FIS, X, Y, Options(epochs=5, **options)) for _ in range(2))
    assert format_fis(first.system) == format_fis(second.system)
    assert repr(first.history) == repr(second.history)


def test_mini_batches_follow_the_seed():
    a, b = (anfis.train(FIS, X, Y, Options(method="backprop", batch=16, epochs=2, seed=s)) for s in (0, 1))
    assert format_fis(a.system) != format_fis(b.system)


def test_a_saved_system_answers_the_same_to_the_last_bit():
    system = anfis.train(FIS, X, Y, Options(epochs=5)).system
    assert (parse_fis(format_fis(system))(X) == system(X)).all()


def test_second_order_beats_hybrid():
    hybrid = anfis.train(FIS, X, Y, Options(epochs=20))
    second = anfis.train(FIS, X, Y, Options(method="second-order", epochs=20))
    errors = [row.train for row in second.history]
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < hybrid.history[-1].train


def test_one_rule_has_nothing_to_move():
    fis = fuzzy.Sugeno(
        [fuzzy.Variable("x", (0, 1), {"t": fuzzy.Gaussian(0.5, 0.5)})],
        [fuzzy.Variable("y", (0, 1), {"c": Linear((0.0,), 0.0)})],
        ["if x is t then y is c"],
    )
    x = np.linspace(0, 1, 9)[:, None]
    for method in ("hybrid", "second-order"):
        result = anfis.train(fis, x, 2 * x[:, 0] + x[:, 0] ** 2, Options(method=method, epochs=5))
        assert result.system.inputs == fis.inputs
        assert result.stopped == "converged"


# Stopping and going on ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "options",
    [
        {"method": "hybrid"},
        {"method": "hybrid", "batch": 17, "keep_order": True},
        {"method": "backprop"},
        {"method": "backprop", "batch": 16, "seed": 3},
        {"method": "backprop", "optimiser": "SGD", "rate": 0.001},
        {"method": "second-order"},
    ],
)
def test_resumed_is_uninterrupted_to_the_last_bit(options, tmp_path):
    file = tmp_path / "run.pt"
    whole = anfis.train(FIS, X, Y, Options(epochs=12, **options), check=CHECK)
    part = anfis.train(FIS, X, Y, Options(epochs=5, **options), check=CHECK, checkpoint=file)
    for source in (file, part.state, part.state):  # twice: going on must not change what it goes on from
        resumed = anfis.train(FIS, X, Y, Options(epochs=12, **options), check=CHECK, resume=source)
        assert format_fis(resumed.system) == format_fis(whole.system)
        assert format_fis(resumed.least_train) == format_fis(whole.least_train)
        assert resumed.history == whole.history
        assert resumed.best == whole.best


def interrupt_at(epoch: int):
    def callback(row: Epoch) -> None:
        if row.epoch == epoch:
            raise KeyboardInterrupt

    return callback


@pytest.mark.parametrize("method", TRAINED)
def test_an_interrupt_returns_the_best_so_far(method, tmp_path):
    options = Options(method=method, epochs=9)
    result = anfis.train(FIS, X, Y, options, callback=interrupt_at(4), checkpoint=tmp_path / "c.pt")
    assert result.stopped == "interrupted"
    assert [row.epoch for row in result.history] == [0, 1, 2, 3, 4]
    assert rmse(result.system, X, Y) == pytest.approx(min(row.train for row in result.history), rel=1e-6)
    whole = anfis.train(FIS, X, Y, options)
    for source in (result.state, tmp_path / "c.pt"):
        assert repr(anfis.train(FIS, X, Y, options, resume=source).history) == repr(whole.history)


def test_an_interrupt_in_the_middle_of_an_epoch(monkeypatch):
    """The optimiser's memory is that of the last whole epoch."""
    options = Options(method="backprop", epochs=6, batch=10)
    whole = anfis.train(FIS, X, Y, options)
    step, count = torch.optim.Adam.step, 0

    def interrupted(self, *arguments):
        nonlocal count
        count += 1
        if count == 21:
            raise KeyboardInterrupt
        return step(self, *arguments)

    with monkeypatch.context() as patch:
        patch.setattr(torch.optim.Adam, "step", interrupted)
        part = anfis.train(FIS, X, Y, options)
    assert part.stopped == "interrupted"
    resumed = anfis.train(FIS, X, Y, options, resume=part.state)
    assert format_fis(resumed.system) == format_fis(whole.system)


def test_an_interrupt_before_anything_is_known_passes_through():
    with pytest.raises(KeyboardInterrupt):
        anfis.train(FIS, X, Y, Options(), resume=None, callback=None, check=interrupting())


def interrupting():
    class Interrupting:
        def __array__(self, *_, **__):
            raise KeyboardInterrupt

    return Interrupting(), Y


def test_a_callback_and_a_goal_stop():
    seen: list[Epoch] = []
    result = anfis.train(FIS, X, Y, Options(epochs=9), callback=lambda row: seen.append(row) or row.epoch < 3)
    assert result.stopped == "callback"
    assert [row.epoch for row in seen] == [0, 1, 2, 3]
    goal = seen[2].train
    result = anfis.train(FIS, X, Y, Options(epochs=9, goal=goal))
    assert result.stopped == "goal"
    assert result.history[-1].epoch == 2


def test_patience_watches_the_checking_error_or_else_the_training_error():
    far = CHECK[0], CHECK[1] + np.linspace(-1, 1, 30)
    result = anfis.train(FIS, X, Y, Options(epochs=200, step=0.05, patience=3), check=far)
    assert result.stopped == "patience"
    assert result.history[-1].epoch == result.best + 3
    result = anfis.train(FIS, X, Y, Options(epochs=15, patience=2))
    assert result.stopped == "epochs"
    assert result.history[-1].epoch == 15


def test_divergence_keeps_the_best():
    result = anfis.train(FIS, X, Y, Options(method="backprop", optimiser="SGD", rate=1e300, epochs=5))
    assert result.stopped == "diverged"
    assert np.isfinite(rmse(result.system, X, Y))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"x": X + 1}, "another system or other data"),
        ({"y": np.r_[Y[:-1], 5.0]}, "another system or other data"),
        ({"fis": grid(X, "gbellmf")}, "another system or other data"),
        ({"fis": grid(X * 2)}, "another system or other data"),
        ({"check": CHECK}, "another system or other data"),
        ({"options": Options(step=0.02)}, "made with step = 0.01, not 0.02"),
    ],
)
def test_a_checkpoint_of_something_else_is_refused(changes, message, tmp_path):
    file = tmp_path / "c.pt"
    anfis.train(FIS, X, Y, Options(epochs=1), checkpoint=file)
    given_ = {"fis": FIS, "x": X, "y": Y, "options": Options(), **changes}
    with pytest.raises(TrainingError, match=message):
        anfis.train(**given_, resume=file)


def test_what_is_no_checkpoint(tmp_path):
    (tmp_path / "text.pt").write_text("no checkpoint")
    torch.save([1, 2], tmp_path / "list.pt")
    torch.save({"a": 1}, tmp_path / "dict.pt")
    for name, message in [
        ("none", "cannot be read"),
        *((f"{n}.pt", "no checkpoint") for n in ("text", "list", "dict")),
    ]:
        with pytest.raises(TrainingError, match=message):
            anfis.train(FIS, X, Y, resume=tmp_path / name)


@pytest.mark.parametrize("method", ["hybrid", "backprop"])
def test_every_flipped_bit_of_a_checkpoint_is_refused(method, tmp_path):
    file, options = tmp_path / "c.ck", Options(epochs=1, method=method)
    anfis.train(FIS, X, Y, options, checkpoint=file)
    content = file.read_bytes()
    for bit in range(5, 8 * len(content), len(content) // 4):
        flipped = bytearray(content)
        flipped[bit // 8] ^= 1 << bit % 8
        file.write_bytes(flipped)
        with pytest.raises(TrainingError, match=r"c\.ck: this"):
            anfis.train(FIS, X, Y, options, resume=file)


@pytest.mark.parametrize(
    ("method", "change"),
    [
        ("hybrid", lambda s: s["point"]["free"].__setitem__(0, s["point"]["free"][0][:-1])),
        ("hybrid", lambda s: s["best_check"]["values"].pop()),
        ("hybrid", lambda s: s["memory"]["gradient"].pop()),
        ("hybrid", lambda s: s.update(epoch=7)),
        ("backprop", lambda s: s["memory"]["optimiser"]["param_groups"][0].update(lr=3.0)),
        ("backprop", lambda s: s["memory"]["optimiser"]["state"][0].update(exp_avg=torch.zeros(99))),
    ],
)
def test_a_state_that_does_not_fit_the_network_is_refused(method, change):
    options = Options(epochs=2, method=method)
    state = anfis.train(FIS, X, Y, options).state
    change(state)
    with pytest.raises(TrainingError, match="this checkpoint is damaged"):
        anfis.train(FIS, X, Y, options, resume=state)


def test_a_checkpoint_without_a_checksum_or_of_another_format_is_refused(tmp_path):
    file, part = tmp_path / "other.ck", anfis.train(FIS, X, Y, Options(epochs=1))
    torch.save(with_tensors(part.state), file)
    with pytest.raises(TrainingError, match=r"other\.ck: this is no checkpoint of a training, or a damaged one"):
        anfis.train(FIS, X, Y, Options(epochs=2), resume=file)
    save(part.state | {"format": 1}, file)
    with pytest.raises(TrainingError, match=r"other\.ck: this is no checkpoint of a training, or a damaged one"):
        anfis.train(FIS, X, Y, Options(epochs=2), resume=file)


def test_a_checkpoint_that_cannot_be_written_is_said_once_and_learning_goes_on(tmp_path, monkeypatch):
    def full(path, content):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("pathlib.Path.write_bytes", full)
    with pytest.warns(UserWarning, match=r"c\.ck: No space left on device; learning goes on") as told:
        result = anfis.train(FIS, X, Y, Options(epochs=3), checkpoint=tmp_path / "c.ck")
    assert len(told) == 1
    assert result.stopped == "epochs"
    assert list(tmp_path.iterdir()) == []


# What is said of it -------------------------------------------------------------------------------------------


def test_learning_that_adds_nothing_and_learning_by_heart_are_said():
    """Noise is learnt by heart; a smooth function is not, and learning it adds something."""
    random = np.random.default_rng(3)
    x = random.uniform(-1, 1, (60, 2))
    noise = random.normal(size=60)
    fis = fuzzy.identify(x[:30], noise[:30], "grid", mfs=3)
    heart = anfis.train(fis, x[:30], noise[:30], Options(epochs=6), check=(x[30:], noise[30:]))
    times = heart.check_rmse / heart.rmse
    assert times > 1.5
    assert f"the checking error is {times:.1f} times the training error: fewer rules, or more data" in heart.remarks
    good = anfis.train(
        grid(x, "gaussmf"), x[:40], np.sin(3 * x[:40, 0]), Options(epochs=30), check=(x[40:], np.sin(3 * x[40:, 0]))
    )
    assert good.best > 1
    assert not any("added nothing" in said for said in good.remarks)
    unlearnt = replace(good, best=1)
    assert (
        unlearnt.remarks[0] == f"learning added nothing over the start: epoch 1 of {len(good.history) - 1} is the best"
    )
    assert not replace(unlearnt, history=good.history[:2]).added_nothing  # there was one epoch
