"""The radio and the faults: closed forms for age, loss and bursts, and messages that say when and by whom."""

from itertools import product
from math import ceil
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import robotics.world.radio.channel
from robotics.laws.teams.neighbours import alone
from robotics.world.radio.channel import AirColumns, Channel, Heard, broadcast, receive
from robotics.world.radio.description import RADIO_PRESETS, Radio, RadioError
from robotics.world.radio.faults import FAULTS, Fault, Faults, notice, untroubled
from robotics.world.radio.graph import adjacency
from tests.robotics.laws.rules.arrayform.neighbours import alone_for, smallest_heard

TICK = 0.05


def talk(radio, robots=3, seeds=(0,), periods=60, tick=TICK, place=None, faults=()):
    """Every robot says the time and its number; values (periods, 2, runs, i, j), age (periods, runs, i, j)."""
    runs, lanes = len(seeds), len(seeds) * robots
    channel = Channel.opened(radio, ("time", "number"), robots, seeds, tick)
    air = channel.silence(runs, robots)
    trouble = untroubled(runs, robots)
    if faults:
        trouble = Faults.drawn(faults, robots, seeds).trouble(np.arange(runs))
    values, ages, said = [], [], np.empty((2, lanes))
    for k in range(periods):
        air = channel.supplied(air, k)
        notice(trouble, k * tick, robots)
        receive(air, k, tick, trouble.cut)
        heard = channel.heard(air)
        values.append(heard.values.copy())
        ages.append(heard.age.copy())
        said[0], said[1] = k * tick, np.tile(np.arange(1.0, robots + 1), runs)
        x, y = np.zeros((2, runs, robots)) if place is None else place(k * tick)
        broadcast(air, k, tick, trouble.cut, said, *(np.array(row, dtype=float).ravel() for row in (x, y)))
    return np.array(values), np.array(ages)


def troubled(drawn, time):
    """Who is at fault at a time, (runs, robots, ...) each."""
    found = drawn.trouble(np.arange(len(drawn.starts)))
    notice(found, time, drawn.robots)
    shape = len(drawn.starts), drawn.robots
    return found._replace(**{n: getattr(found, n).reshape(*shape, *getattr(found, n).shape[1:]) for n in ACTING})


ACTING = ("failed", "held", "cut", "code")


def off_diagonal(robots):
    return ~np.eye(robots, dtype=bool)


def arrived(age):
    """Which messages of a radio without latency that speaks every period came through (periods - 1, runs, i, j)."""
    return np.abs(age[1:] - TICK) < 1e-9


# Content and age ------------------------------------------------------------------------------------------------


@given(
    graph=st.sampled_from(["star", "ring", "line", "complete"]),
    robots=st.integers(2, 5),
    every=st.integers(1, 4),
    latency=st.sampled_from([0.0, 0.03, 0.05, 0.12, 0.3]),
    jitter=st.sampled_from([0.0, 0.02, 0.2, 0.45]),
    loss=st.sampled_from([0.0, 0.3]),
    burst=st.sampled_from([0.0, 0.1]),
    seed=st.integers(0, 2**32),
)
@settings(max_examples=60)
def test_what_is_heard_is_what_was_said_then(graph, robots, every, latency, jitter, loss, burst, seed):
    radio = Radio(graph=graph, period=every * TICK, latency=latency, jitter=jitter, loss=loss, burst_start=burst)
    values, age = talk(radio, robots, (seed, 7))
    time = np.arange(len(age))[:, None, None, None] * TICK
    heard = np.isfinite(age)
    graph_of = np.broadcast_to(adjacency(graph, robots) > 0, age.shape)
    assert not heard[~graph_of].any()
    np.testing.assert_array_equal(np.isnan(values), np.stack([~heard, ~heard], axis=1))
    sent = np.broadcast_to(time, age.shape)[heard] - age[heard]
    np.testing.assert_allclose(values[:, 0][heard], sent, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(
        values[:, 1][heard], np.broadcast_to(np.arange(1, robots + 1), age.shape)[heard]
    )  # by the sender
    messages = sent / (every * TICK)
    np.testing.assert_allclose(messages, np.round(messages), rtol=0, atol=1e-9)  # sent at a radio's period
    soonest = max(1, ceil(latency / TICK - 1e-9)) * TICK
    assert age[heard].min(initial=np.inf) >= soonest - 1e-9
    births = np.where(heard, time - age, -np.inf)
    assert (births[1:] >= births[:-1] - 1e-9).all()  # nothing older replaces anything newer
    if loss == burst == 0:
        longest = max(1, ceil((latency + jitter) / TICK - 1e-9)) * TICK + (every - 1) * TICK
        assert age[heard].max() <= longest + 1e-9
        assert heard[-1][graph_of[-1]].all()


@pytest.mark.parametrize(("every", "latency"), list(product([1, 2, 3], [0.0, 0.03, 0.05, 0.06, 0.25])))
def test_age_is_a_sawtooth_from_the_latency_up_by_the_period(every, latency):
    _, age = talk(Radio(period=every * TICK, latency=latency), periods=40)
    late = max(1, ceil(latency / TICK - 1e-9))
    links = off_diagonal(3)
    for k in range(40):
        expected = np.inf if k < late else (late + (k - late) % every) * TICK
        np.testing.assert_allclose(age[k, 0][links], expected, rtol=1e-12)


def test_the_control_period_need_not_be_50_ms():
    _, age = talk(Radio(period=0.06, latency=0.05), periods=20, tick=0.02)
    expected = [(3 + (k - 3) % 3) * 0.02 for k in range(3, 20)]
    np.testing.assert_allclose(age[3:, 0, 0, 1], expected, rtol=1e-12)


def test_jitter_is_uniform_on_top_of_the_latency():
    """A message every 0.5 s, later by 0.03 s + U(0, 0.2 s), is heard after m periods of 50 ms with P by closed form."""
    _, age = talk(Radio(period=0.5, latency=0.03, jitter=0.2), robots=4, seeds=range(30), periods=400)
    links = off_diagonal(4)
    fresh = age[1:][:, :, links] < age[:-1][:, :, links]  # heard just now; before the first, infinite
    delay = np.round(age[1:][:, :, links][fresh] / TICK)
    edges = np.clip((np.arange(6) * TICK - 0.03) / 0.2, 0, 1)
    probability = np.diff(edges)
    n = len(delay)
    assert n == pytest.approx(40 * 30 * 12, rel=0.001)
    for m, p in enumerate(probability, start=1):
        assert (delay == m).mean() == pytest.approx(p, abs=4.5 * np.sqrt(p * (1 - p) / n))
    assert probability.sum() == pytest.approx(1)
    assert delay.max() <= 5


def test_messages_that_overtake_each_other_leave_the_newest():
    """Each of them is up to 20 periods late; what is heard is then the newest of those that are there."""
    radio = Radio(jitter=1.0)
    _, age = talk(radio, robots=2, seeds=range(40), periods=300)
    late = age[40:, :, 0, 1] / TICK
    # P(age > m) = Π_{j=1..m} P(message j periods old not there yet) = Π (1 − j/20)
    survival = np.cumprod([1 - j / 20 for j in range(1, 20)])
    for m in (1, 3, 5, 8):
        n = late.size / 6  # neighbouring periods are correlated
        p = survival[m - 1]
        assert (late > m + 0.5).mean() == pytest.approx(p, abs=4 * np.sqrt(p * (1 - p) / n))


# Loss -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("loss", [0.0, 0.05, 0.4, 1.0])
def test_independent_loss_has_its_rate_and_no_memory(loss):
    _, age = talk(Radio(loss=loss), robots=4, seeds=range(40), periods=200)
    lost = ~arrived(age)[:, :, off_diagonal(4)]
    n, sigma = lost.size, np.sqrt(loss * (1 - loss))
    assert lost.mean() == pytest.approx(loss, abs=4 * sigma / np.sqrt(n))
    centred = lost - loss
    for a, b in ((centred[1:], centred[:-1]), (centred[:, 1:], centred[:, :-1]), (centred[..., 1:], centred[..., :-1])):
        assert abs((a * b).mean()) <= 4 * sigma**2 / np.sqrt(a.size)


def bad_of(start, end, periods=400, burst_loss=1.0, loss=0.0):
    _, age = talk(
        Radio(burst_start=start, burst_end=end, burst_loss=burst_loss, loss=loss), 4, range(30), periods=periods
    )
    return ~arrived(age)[:, :, off_diagonal(4)]


@pytest.mark.parametrize(("start", "end"), [(0.02, 0.2), (0.1, 0.3), (0.3, 0.9)])
def test_bursts_have_the_stationary_loss_and_the_mean_lengths_of_gilbert_and_elliott(start, end):
    lost = bad_of(start, end)
    memory = 1 - start - end
    share = start / (start + end)
    settled = lost[100:]
    effective = settled.size * (1 - memory) / (1 + memory)  # an AR(1)-like chain
    assert settled.mean() == pytest.approx(share, abs=4.5 * np.sqrt(share * (1 - share) / effective))
    # From the start, good, towards the stationary share: π (1 − (1 − p − r)^(k + 1))
    for k in range(8):
        expected = share * (1 - memory ** (k + 1))
        assert lost[k].mean() == pytest.approx(expected, abs=4.5 * np.sqrt(expected / lost[k].size))
    chains = lost.reshape(len(lost), -1).T
    bursts, gaps = [], []
    for chain in chains:
        turns = np.flatnonzero(np.diff(chain))
        lengths, kinds = np.diff(turns), chain[turns[:-1] + 1]
        bursts.extend(lengths[kinds])
        gaps.extend(lengths[~kinds])
    for lengths, rate in ((np.array(bursts), end), (np.array(gaps), start)):
        n = len(lengths)
        # Geometric: mean 1/rate, standard deviation √(1 − rate)/rate; a chain cut short misses a few long ones.
        slack = 4.5 * np.sqrt(1 - rate) / rate / np.sqrt(n) + 1 / rate * (1 / rate) / len(lost)
        assert np.mean(lengths) == pytest.approx(1 / rate, abs=slack)
        assert np.mean(lengths == 1) == pytest.approx(rate, abs=4.5 * np.sqrt(rate / n) + 0.02 * rate)


def test_a_bad_link_may_lose_only_some_and_a_good_one_some_too():
    lost = bad_of(0.1, 0.3, burst_loss=0.6, loss=0.1)
    assert lost[100:].mean() == pytest.approx(0.25 * 0.6 + 0.75 * 0.1, abs=0.01)
    both = (lost[101:] & lost[100:-1]).mean()
    # P(lost twice) = Σ P(states) losses, P(bad, bad) = 0.25 · 0.7 and so on
    pairs = 0.25 * 0.7 * 0.36 + 2 * 0.25 * 0.3 * 0.06 + 0.75 * 0.9 * 0.01
    assert both == pytest.approx(pairs, abs=0.008)


def test_a_bad_link_is_never_better_than_a_good_one():
    lost = bad_of(0.2, 0.2, burst_loss=0.0, loss=0.3)
    assert lost.mean() == pytest.approx(0.3, abs=4 * np.sqrt(0.21 / lost.size))


def test_links_go_bad_each_by_itself():
    lost = bad_of(0.1, 0.3)[100:]
    for a, b in ((0, 1), (0, 3), (2, 9)):
        correlation = np.corrcoef(lost[..., a].ravel(), lost[..., b].ravel())[0, 1]
        assert abs(correlation) < 4.5 * np.sqrt(4 / lost[..., a].size)
    runs = np.corrcoef(lost[:, 0].ravel(), lost[:, 1].ravel())[0, 1]
    assert abs(runs) < 4.5 * np.sqrt(4 / lost[:, 0].size)


# Seeds ----------------------------------------------------------------------------------------------------------

HARD = Radio(loss=0.2, burst_start=0.05, jitter=0.3, latency=0.02)


def test_a_seed_has_the_same_radio_alone_and_among_others():
    seeds = (5, 0, 17, 3, 2**40)
    values, age = talk(HARD, 4, seeds, periods=80)
    for i, seed in enumerate(seeds):
        alone_values, alone_age = talk(HARD, 4, (seed,), periods=80)
        assert age[:, i].tobytes() == alone_age[:, 0].tobytes()
        assert values[:, :, i].tobytes() == alone_values[:, :, 0].tobytes()
    assert age[:, 0].tobytes() != age[:, 1].tobytes()
    again = talk(HARD, 4, (5, 5), periods=80)[1]
    assert again[:, 0].tobytes() == again[:, 1].tobytes() == age[:, 0].tobytes()


def test_how_many_numbers_are_drawn_at_a_time_does_not_matter(monkeypatch):
    _, age = talk(HARD, 4, (1, 2), periods=300)  # more than a block of 256
    for block in (1, 500, 10_000):
        monkeypatch.setattr(robotics.world.radio.channel, "_MOST_DRAWS", block)
        assert talk(HARD, 4, (1, 2), periods=300)[1].tobytes() == age.tobytes()


# Who hears whom -------------------------------------------------------------------------------------------------


def test_one_way_edges_are_heard_one_way():
    _, age = talk(Radio(graph="edges", edges=((1, 2), (3, 1))))
    assert np.isfinite(age[-1, 0]).tolist() == [[False, False, True], [True, False, False], [False, False, False]]


def test_range_is_by_the_places_when_the_message_is_sent():
    """Robot 2 drives away from robot 1 at 1 m/s and robot 3 stands 1.5 m from it; range 2 m."""
    place = lambda t: np.array([[[0.0, t, -1.5]], [[0.0, 0.0, 0.0]]])  # noqa: E731
    _, age = talk(Radio(range=2.0, latency=0.3), periods=100, place=place)
    time = np.arange(100) * TICK
    expected = np.where(time < 0.3 - 1e-9, np.inf, np.where(time <= 2.3 + 1e-9, 0.3, time - 2.0))
    np.testing.assert_allclose(age[:, 0, 0, 1], expected, rtol=1e-9)
    np.testing.assert_allclose(age[:, 0, 1, 0], expected, rtol=1e-9)
    assert np.nanmax(age[20:, 0, 0, 2]) == pytest.approx(0.3)
    apart = np.where(time < 0.3 - 1e-9, np.inf, np.where(time <= 0.8 + 1e-9, 0.3, time - 0.5))
    np.testing.assert_allclose(age[:, 0, 1, 2], apart, rtol=1e-9)


@given(st.integers(0, 2**32), st.floats(0.1, 2.0))
@settings(max_examples=30)
def test_range_and_graph_both_limit(seed, reach):
    spots = np.random.default_rng(seed).uniform(-1, 1, (2, 2, 6))  # two runs with places of their own
    _, age = talk(Radio(graph="ring", range=reach), 6, (0, 1), periods=3, place=lambda t: spots)
    for run in range(2):
        gap = np.linalg.norm(spots[:, run, :, None] - spots[:, run, None, :], axis=0)
        np.testing.assert_array_equal(np.isfinite(age[-1, run]), (adjacency("ring", 6) > 0) & (gap <= reach))


def test_on_the_very_limit_of_the_range_one_is_heard():
    place = lambda t: np.array([[[0.0, 3.0]], [[0.0, 4.0]]])  # noqa: E731
    assert np.isfinite(talk(Radio(range=5.0), 2, periods=3, place=place)[1][-1, 0, 0, 1])
    assert not np.isfinite(talk(Radio(range=4.999), 2, periods=3, place=place)[1][-1, 0, 0, 1])


# What robots make of it -----------------------------------------------------------------------------------------


@given(st.integers(0, 2**32), st.integers(1, 9), st.integers(1, 3))
@settings(max_examples=60)
def test_values_are_brought_up_to_date_and_compared_over_those_heard(seed, robots, runs):
    """Link by link: what was not heard counts for nothing, and a rate is believed for half a second."""
    rng = np.random.default_rng(seed)
    links = (runs, robots, robots)
    hears = (rng.random((robots, robots)) < 0.6) & ~np.eye(robots, dtype=bool)
    known = hears & (rng.random(links) < 0.8)
    age = np.where(known, rng.choice([0.05, 0.45, 0.5, 0.55, 20.0], links), np.inf)
    heard = Heard(("rate", "other", "value"), np.where(known, rng.standard_normal((3, *links)), np.nan), age, hears)
    planes = np.empty((AirColumns.size + 3, runs * robots, robots))
    air = AirColumns(planes)
    air.age, air.hears = age.reshape(-1, robots), np.tile(hears, (runs, 1))
    air.values[...] = heard.values.reshape(3, -1, robots)
    mine = rng.standard_normal((runs, robots))
    theirs = heard.now("value", by="rate")
    least, quiet = smallest_heard(mine, theirs, hears), alone_for(heard, 5.0)
    for r, i in np.ndindex(runs, robots):
        told = {
            j: heard.values[2, r, i, j] + heard.values[0, r, i, j] * min(age[r, i, j], 0.5)
            for j in range(robots)
            if known[r, i, j]
        }
        lane, own = r * robots + i, mine[r, i]
        assert {j for j in range(robots) if not np.isnan(theirs[r, i, j])} == set(told)
        assert all(theirs[r, i, j] == pytest.approx(value, rel=1e-14) for j, value in told.items())
        assert least[r, i] == pytest.approx(min([own, *told.values()]), rel=1e-14)
        assert quiet[r, i] == min([5.0, *(age[r, i, j] for j in told)]) == alone(planes, lane, 5.0)


# Faults ---------------------------------------------------------------------------------------------------------

CUTS = {"failure": True, "delay": True, "silence": True, "stall": False}


@pytest.mark.parametrize("kind", list(FAULTS))
def test_a_fault_silences_its_robot_for_its_time_and_no_other(kind):
    fault = Fault(robot=2, kind=kind, start=1.0, duration=0.5)
    _, age = talk(Radio(), faults=(fault,))
    time = np.arange(len(age)) * TICK
    for i, j in ((0, 1), (1, 0), (1, 2), (2, 1)):
        expected = np.where(time < TICK / 2, np.inf, TICK)
        if CUTS[kind]:
            # The last to arrive was sent at 0.9 s; the first after the outage is sent at 1.5 s and heard at 1.55 s.
            inside = (time > 1 - 1e-9) & (time < 1.55 - 1e-9)
            expected = np.where(inside, time - 0.9, expected)
        np.testing.assert_allclose(age[:, 0, i, j], expected, rtol=0, atol=1e-9)
    for i, j in ((0, 2), (2, 0)):
        np.testing.assert_allclose(age[1:, 0, i, j], TICK, rtol=1e-12)


def test_silence_of_one_link_leaves_the_others():
    fault = Fault(robot=1, other=3, kind="silence", start=0.5, duration=1.0)
    _, age = talk(Radio(), faults=(fault,))
    time = np.arange(len(age)) * TICK
    for i, j in product(range(3), range(3)):
        if i == j:
            continue
        longest = 1.1 if {i, j} == {0, 2} else TICK
        assert age[1:, 0, i, j].max() == pytest.approx(longest)
    grows = np.diff(age[:, 0, 0, 2])[(time[1:] > 0.5) & (time[1:] < 1.55 - 1e-9)]
    np.testing.assert_allclose(grows, TICK, rtol=1e-9)  # one period a period
    condition = troubled(Faults.drawn((fault,), 3, (0,)), 1.0)
    assert condition.cut.sum() == 2
    assert not condition.code.any()  # no robot's fault


def test_what_is_on_its_way_when_an_outage_begins_is_lost():
    fault = Fault(robot=1, kind="failure", start=0.5, duration=1.0)
    values, _ = talk(Radio(latency=0.3), 2, faults=(fault,))
    heard = values[:, 0, 0, 1, 0]
    time = np.arange(len(heard)) * TICK
    np.testing.assert_allclose(heard[(time >= 0.5) & (time < 1.8 - 1e-9)], 0.15, atol=1e-9)  # sent 0.3 s before 0.45
    np.testing.assert_allclose(heard[time >= 1.8 - 1e-9], time[time >= 1.8 - 1e-9] - 0.3, atol=1e-9)


def test_a_fault_of_a_robot_is_told_by_its_code_and_that_of_no_other():
    """Two robots left without anybody to hear are not at fault themselves."""
    codes: dict[Any, int] = {"failure": 1, "delay": 2, "silence": 3, "stall": 4}
    for kind, code in codes.items():
        drawn = Faults.drawn((Fault(robot=2, kind=kind, start=1.0, duration=1.0),), 2, (0, 1))
        for time in (0.95, 2.0):
            assert not any(getattr(troubled(drawn, time), name).any() for name in ACTING)
        condition = troubled(drawn, 1.0)
        assert condition.code.tolist() == [[0, code]] * 2
        assert condition.failed.tolist() == [[False, kind in ("failure", "stall")]] * 2
        assert condition.held.tolist() == [[False, kind == "delay"]] * 2
        assert condition.cut[:, 0, 1].tolist() == condition.cut[:, 1, 0].tolist() == [CUTS[kind]] * 2


def test_the_gravest_of_several_faults_is_told_and_all_of_them_act():
    faults = (
        Fault(robot=1, kind="silence", start=0.0, duration=4.0),
        Fault(robot=1, kind="delay", start=1.0, duration=1.0),
        Fault(robot=1, kind="stall", start=1.5, duration=1.0),
        Fault(robot=1, kind="failure", start=2.0, duration=1.0),
        Fault(robot=3, kind="stall", start=0.0, duration=9.0),
        Fault(robot=2, kind="failure", start=0.0, duration=9.0),
    )
    drawn = Faults.drawn(faults, 3, (0,))
    told = [troubled(drawn, t).code[0].tolist() for t in (0.5, 1.2, 1.7, 2.2, 2.7, 3.5, 5.0)]
    assert told == [[c, 1, 4] for c in (3, 2, 4, 1, 1, 3, 0)]
    both = troubled(drawn, 1.7)
    assert both.failed[0, 0]
    assert both.held[0, 0]
    assert both.cut[0, 0].all()


def test_random_starts_are_even_and_each_seed_has_its_own():
    faults = (
        Fault(robot=1, kind="failure", start=10.0, duration=2.0, start_until=30.0),
        Fault(robot=2, kind="delay", start=5.0, duration=2.0),
    )
    drawn = Faults.drawn(faults, 2, range(1000))
    starts = drawn.starts[:, 0]
    assert (drawn.starts[:, 1] == 5.0).all()
    assert 10 <= starts.min() < 10.2
    assert 29.8 < starts.max() <= 30
    grid = np.linspace(10, 30, 21)
    gap = np.abs(np.searchsorted(np.sort(starts), grid) / 1000 - (grid - 10) / 20).max()
    assert gap < 1.95 / np.sqrt(1000)  # Kolmogorov and Smirnov at 0.1 %
    np.testing.assert_array_equal(Faults.drawn(faults, 2, (400, 3)).starts, drawn.starts[[400, 3]])
    for time in (12.0, 20.0, 29.0):
        inside = (starts <= time) & (time < starts + 2)
        np.testing.assert_array_equal(troubled(drawn, time).failed[:, 0], inside)


# What cannot be -------------------------------------------------------------------------------------------------


def test_the_preset_fits_three_robots_and_not_twenty():
    """Thesis 4.5, 9600 baud: 96 bytes in 0.1 s. A message of four values is 9 + 8 bytes."""
    zigbee = Radio(**RADIO_PRESETS["zigbee-9600"])
    assert zigbee.baud / 10 * zigbee.period == 96
    zigbee.check_bandwidth(3, 4)
    zigbee.check_bandwidth(5, 4)  # 85 bytes
    with pytest.raises(
        RadioError, match=r"6 robots × \(9 \+ 4 × 2\) bytes = 102 bytes every 0.1 s do not fit into the 96"
    ):
        zigbee.check_bandwidth(6, 4)
    with pytest.raises(RadioError, match=r"20 robots .* = 340 bytes .* 9600 baud carry; period must be >= 0.36 s"):
        zigbee.check_bandwidth(20, 4)
    Radio(**RADIO_PRESETS["zigbee-9600"] | {"period": 0.36}).check_bandwidth(20, 4)
    with pytest.raises(RadioError, match=r"period must be >= 0.36 s"):
        Radio(**RADIO_PRESETS["zigbee-9600"] | {"period": 0.35}).check_bandwidth(20, 4)
    Radio(baud=9600.0, period=0.1, header_bytes=0).check_bandwidth(12, 4)  # 96 bytes: exactly
    Radio().check_bandwidth(1000, 100)  # no baud rate, no limit
    with pytest.raises(RadioError, match="do not fit"):
        Channel.opened(zigbee, tuple("abcd"), 20, (0,), TICK)


@given(st.integers(1, 60), st.integers(1, 12), st.integers(0, 20), st.sampled_from([1200.0, 9600.0, 115200.0]))
@settings(max_examples=80)
def test_the_period_that_an_error_names_is_the_least_that_fits(robots, values, header, baud):
    radio = Radio(baud=baud, period=0.01, header_bytes=header)
    try:
        radio.check_bandwidth(robots, values)
    except RadioError as error:
        least = float(str(error).split(">= ")[1].split(" s")[0])
    else:
        assert robots * (header + 2 * values) * 10 / baud <= 0.01 + 1e-9
        return
    Radio(baud=baud, period=least, header_bytes=header).check_bandwidth(robots, values)
    with pytest.raises(RadioError):
        Radio(baud=baud, period=least - 0.01 + 1e-12, header_bytes=header).check_bandwidth(robots, values)


@pytest.mark.parametrize(
    ("settings", "field", "message"),
    [
        ({"graph": "starr"}, "graph", "graph must be one of 'star', 'ring', 'line', 'complete', 'edges'; got 'starr'"),
        ({"hub": 0}, "hub", "hub must be a whole number >= 1; got 0"),
        ({"hub": 1.5}, "hub", "hub must be a whole number >= 1; got 1.5"),
        ({"header_bytes": -1}, "header_bytes", "header_bytes must be a whole number >= 0"),
        ({"value_bytes": 0}, "value_bytes", "value_bytes must be a whole number >= 1"),
        ({"graph": "edges"}, "edges", 'belong to graph = "edges"'),
        ({"edges": ((1, 2),)}, "edges", 'belong to graph = "edges"'),
        ({"graph": "edges", "edges": ((1, 2), (2, 2))}, "edges", "edges: robot 2 needs no radio to hear itself"),
        ({"loss": 1.2}, "loss", "loss must be a finite number, >= 0 and <= 1; got 1.2"),
        ({"burst_end": 0.0}, "burst_end", "burst_end must be a finite number, > 0 and <= 1"),
        ({"period": 0.0}, "period", "period must be a finite number in s, > 0 and <= 60"),
        ({"latency": -0.1}, "latency", "latency must be"),
        ({"jitter": float("nan")}, "jitter", "jitter must be"),
        ({"range": 0.0}, "range", "range must be a finite number in m, > 0"),
        ({"baud": -9600.0}, "baud", "baud must be"),
    ],
)
def test_radios_that_cannot_be_are_refused(settings, field, message):
    with pytest.raises(RadioError) as caught:
        Radio(**settings)
    assert message in str(caught.value)
    assert caught.value.at[-1] == field


@pytest.mark.parametrize(
    ("radio", "field", "message"),
    [
        (Radio(graph="star", hub=4), "hub", "hub: robots are 1 to 3, got 4"),
        (Radio(graph="edges", edges=((1, 2), (2, 5))), "edges", "edges: robots are 1 to 3, got 5"),
        (Radio(graph="edges", edges=((0, 2),)), "edges", "got 0"),
    ],
)
def test_robots_that_do_not_exist_are_named(radio, field, message):
    with pytest.raises(RadioError) as caught:
        radio.adjacency(3)
    assert message in str(caught.value)
    assert caught.value.at[-1] == field


@pytest.mark.parametrize(
    ("settings", "field", "message"),
    [
        ({"kind": "broken"}, "kind", "kind must be one of 'failure', 'stall', 'delay', 'silence'; got 'broken'"),
        ({"duration": 0.0}, "duration", "duration must be a finite number in s, > 0"),
        ({"start": -1.0}, "start", "start must be a finite number in s, >= 0"),
        ({"other": 2}, "other", 'for kind = "silence"'),
        ({"kind": "silence", "other": 1}, "other", "the far end of a link"),
        ({"start": 5.0, "start_until": 4.0}, "start_until", "start_until must be >= start, 5 s; got 4"),
    ],
)
def test_faults_that_cannot_be_are_refused(settings, field, message):
    with pytest.raises(RadioError) as caught:
        Fault(**{"robot": 1, "kind": "failure"} | settings)
    assert message in str(caught.value)
    assert caught.value.at[-1] == field
