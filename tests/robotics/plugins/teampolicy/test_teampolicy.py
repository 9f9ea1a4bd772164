"""The learnt policy for teams: what it observes, answers and drives against numpy, its teacher, and its learning."""

from dataclasses import replace

import numpy as np
import pytest

from robotics.laws.law import ControllerError
from robotics.plugins.reactive.orca import Orca
from robotics.plugins.reinforcement.policyfile import Policy
from robotics.plugins.tasks.driving import run_row
from robotics.plugins.tasks.families import TaskFamily
from robotics.plugins.teampolicy.law import ALL, SECTORS, TEAM_INPUTS, TeamPolicy
from robotics.plugins.teampolicy.learning import (
    Driven,
    Networks,
    Pupil,
    TeamLearning,
    advantages,
    clearances,
    driven,
)
from robotics.simulation.loop import Simulation
from robotics.world.environment.collision import footprints, robot_clearance
from robotics.world.vehicle.plant import TruthColumns
from tests.robotics.plugins.reinforcement.test_neural import drawn, network

CROSSING = TaskFamily(task="crossing", fewest=3, most=3)


def plain(sizes=(6,), seed=0):
    """A random policy for teams, whose inputs are taken as they are."""
    one = drawn(sizes, seed, (0.4, 2.0), TEAM_INPUTS)
    return replace(one, offset=np.zeros(ALL), scale=np.ones(ALL), clip=10.0)


def moments(law, family, number=3, periods=120):
    """Of each period of a run: what it noted (ALL + 4, robots), its commands (2, robots) and the truth (robots,)."""
    scenario = family.scenario(number)
    one = Simulation(scenario.setting, law, (scenario.seed,), scenario.faults)
    for k, command in one.periods():
        notes = one.lanes.command[-ALL - 4 :].copy() if isinstance(law, Pupil) else None
        commands = np.array([command.first[0], command.second[0]])
        yield notes, commands, TruthColumns(one.rows(one.lanes.body.truth)[:, 0].copy())
        if k == periods:
            return


def test_it_drives_what_the_network_adds_to_what_it_wants():
    policy = plain((9, 5))
    law = Pupil(policy=policy)
    for notes, commands, _ in moments(law, CROSSING):
        for robot in range(3):
            seen = notes[:ALL, robot]
            added = network(policy, seen)
            assert notes[ALL : ALL + 2, robot] * policy.most == pytest.approx(added, abs=1e-12)
            ahead, left = law.fastest * seen[:2]
            v = np.clip(np.clip(ahead, 0, law.fastest) + added[0], 0, law.fastest)
            w = np.clip(np.clip(left / law.point, -law.quickest, law.quickest) + added[1], -law.quickest, law.quickest)
            assert commands[:, robot] == pytest.approx((v, w), abs=1e-12)


def test_who_tries_out_without_noise_drives_as_the_policy():
    policy = plain((9, 5))
    pairs = zip(moments(Pupil(policy=policy), CROSSING), moments(TeamPolicy(policy=policy), CROSSING), strict=True)
    assert all((one[1] == other[1]).all() for one, other in pairs)


def test_its_teacher_is_orca_as_long_as_that_does_not_back():
    point, margin = 0.06, 0.03
    full = replace(plain(), most=(1.0, 3.0))
    pupil = Pupil(
        policy=full, point=point, margin=point + margin, follows=True, teacher=Orca(point=point, margin=margin)
    )
    same = 0
    for (_, ours, _), (_, orcas, _) in zip(
        moments(pupil, CROSSING, periods=600), moments(pupil.teacher, CROSSING, periods=600), strict=True
    ):
        if (orcas[0] < 0).any():
            break
        assert ours == pytest.approx(orcas, abs=1e-3)
        same += 1
    assert same > 200


def test_it_observes_where_others_are_and_who_counts_first():
    """Without loss, latency and noise the nearest that is heard is where the truth has it, in the robot's frame."""
    law, told = Pupil(policy=plain()), TEAM_INPUTS.index("robot1_cos")
    seen = 0
    for notes, _, now in moments(law, CROSSING, periods=400):
        places, turned = now.x + 1j * now.y, np.exp(-1j * now.heading)
        for robot in range(3):
            cos, sin, _, far, *_, first = notes[told : told + 8, robot]
            apart = np.abs(places - places[robot])
            apart[robot] = np.inf
            nearest = int(np.argmin(apart))
            if first != 0 and apart[nearest] > 0.35 and np.sort(apart)[1] - apart[nearest] > 0.1:
                seen += 1
                distance = law.sight * (1 - far) + 2 * notes[TEAM_INPUTS.index("radius"), robot]
                assert abs(distance * (cos + 1j * sin) - (places[nearest] - places[robot]) * turned[robot]) < 0.08
                assert first == (1.0 if nearest < robot else -1.0)
    assert seen > 100


def test_things_are_seen_in_the_sector_in_which_they_are():
    """A lone way into a trap: of what stands ahead nothing is told behind the robot."""
    ahead, first, most = SECTORS // 2, TEAM_INPUTS.index("seen_1"), np.zeros(SECTORS)
    for notes, _, _ in moments(Pupil(policy=plain()), TaskFamily(task="trap", fewest=2, most=2), periods=700):
        most = np.maximum(most, notes[first : first + SECTORS].max(axis=1))
    assert max(most[ahead], most[ahead - 1]) > 0.3
    assert most[0] < max(most[ahead], most[ahead - 1])


def test_its_noise_is_its_seed_and_its_spread():
    def answers(**gains):
        return np.array(
            [notes[ALL : ALL + 2] for notes, *_ in moments(Pupil(policy=plain(), **gains), CROSSING, periods=60)]
        )

    calm, noisy, again = answers(), answers(spread=0.5), answers(spread=0.5)
    assert (noisy == again).all()
    assert (noisy != answers(spread=0.5, seed=2.0)).any()
    drawn = np.random.default_rng(1).normal(0, 0.5, 6 * (CROSSING.scenario(3).setting.ticks + 1))
    first = (noisy - calm)[0]  # of the first period, in which both observe the same
    assert first == pytest.approx(drawn[::-1][:6].reshape(3, 2).T, abs=1e-12)


def test_a_policy_of_other_inputs_is_refused():
    with pytest.raises(ControllerError, match="was not learnt for teams"):
        TeamPolicy(policy=drawn((4,)))


def test_a_robot_is_paid_for_its_way_and_no_longer_once_it_drove_into_something():
    about = TeamLearning(near=0.0, rough=0.0, contact=7.0)
    met = driven(TaskFamily(task="circle", fewest=5, most=5).scenario(2), Pupil(policy=plain((), 1)), about)
    assert len(met) == 5
    assert any(one.caused for one in met)
    for one in met:
        assert len(one.observed) == len(one.answered) + 1 == len(one.paid) + 1
        if one.caused:
            assert one.over
            assert one.paid[-1] < -6
        assert (one.paid[:-1] > -1).all()
    free = driven(CROSSING.scenario(5), Pupil(policy=plain((), 1), follows=True), about)
    nominal = CROSSING.scenario(5).facts["nominal_s"]
    assert [one.paid.sum() for one in free if one.over] == pytest.approx([nominal] * 3, rel=0.05)


def test_clearances_are_those_of_each_period():
    scenario = TaskFamily(task="course", fewest=2, most=2, discs=1).scenario(4)
    poses = np.array(
        [[now.x, now.y, now.heading] for _, _, now in moments(Pupil(policy=plain()), CROSSING, periods=30)]
    )
    gaps, sizes = clearances(scenario.setting, poses[:, :, :2]), footprints(scenario.setting.robots)
    x, y, heading = np.ascontiguousarray(poses[:, :, :2].transpose(1, 0, 2))
    others = robot_clearance(x, y, heading, sizes)
    assert (gaps <= others).all()
    alone = clearances(replace(scenario.setting, world=None), poses[:, :, :2])
    assert (alone == others).all()


def test_advantages_are_the_sum_over_all_that_follows():
    """Against the definition: Σ (γλ)^l δ of what follows, δ = r + γ V' − V."""
    rng = np.random.default_rng(0)
    paid, values, discount, smoothing = rng.normal(size=30), rng.normal(size=31), 0.9, 0.8
    delta = paid + discount * values[1:] - values[:-1]
    expected = [((discount * smoothing) ** np.arange(30 - k) * delta[k:]).sum() for k in range(30)]
    assert advantages(paid, values, discount, smoothing) == pytest.approx(expected, rel=1e-12)


def test_updates_find_the_answer_that_is_paid_best():
    """A problem of one period: paid is minus the squared distance of the answer to a linear function."""
    torch = pytest.importorskip("torch", reason="needs PyTorch")
    rng, spread, networks = np.random.default_rng(0), 0.2, Networks(TeamLearning(batch=64, units=8))

    def best_of(seen):
        return 0.4 * seen[:, :2] + (0.3, -0.2)

    def distance():
        seen = np.random.default_rng(1).uniform(-1, 1, (500, ALL))
        with torch.no_grad():
            return float(((networks.actor(torch.from_numpy(seen).float()).numpy() - best_of(seen)) ** 2).mean())

    begin = distance()
    for _ in range(30):
        runs = []
        seen = rng.uniform(-1, 1, (64, 2, ALL))
        with torch.no_grad():
            answers = networks.actor(torch.from_numpy(seen[:, 0]).float()).double().numpy() + rng.normal(
                0, spread, (64, 2)
            )
        paid = -((answers - best_of(seen[:, 0])) ** 2).sum(axis=1)
        for n in range(64):
            runs.append(Driven(seen[n], answers[n : n + 1], answers[n : n + 1], paid[n : n + 1], True, False))
        networks.improve(runs, spread, 1e-2)
    assert distance() < begin / 4


def test_the_packaged_policy_arrives_and_touches_nothing_where_there_is_room():
    assert isinstance(TeamPolicy().network, Policy)
    row = run_row(CROSSING.scenario(3), TeamPolicy())
    assert row["caused"] == row["deadlock"] == 0
