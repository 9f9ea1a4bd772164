"""Rule bases learnt from what another law does."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

import anfis
from fuzzy.files.fisfile import read_fis
from robotics.laws.catalogue import make_controller
from robotics.laws.law import ControllerError
from robotics.measures.tracking import cross_track_error
from robotics.plugins.learning.demonstrations import (
    Demonstrations,
    crossing_course,
    demonstrate,
    disturbed,
    joined,
    scenario_course,
)
from robotics.plugins.learning.imitation import blank, drives, fitted, imitate, rmse, write_rule_base
from robotics.plugins.learning.lesson import ImitationError, ImitationPlan
from robotics.plugins.learning.tandem import TeacherAndPupil, _share
from robotics.simulation.loop import drive, simulate
from robotics.simulation.scenario.reading import load_scenario, parse_scenario
from tests.robotics.laws.rules.arrayform.evaluation import told
from tests.robotics.laws.rules.arrayform.laws import InterpretedTeam

BEND = parse_scenario(
    """
title = "a bend, from beside it"
duration = 8.0

[sensing]
posture = "pose"
position_noise = 0.003
heading_noise = 0.003

[[robots]]
start = [-0.2, 0.2, 0.0]
path = { shape = "sine", amplitude = 0.5, wavenumber = 1.5, x_end = 3.0 }
timing = { x_rate = 0.3 }
""",
    "bend",
)
TRACKING = ("x_err", "y_err", "heading_err", "target_v", "target_w")


def lesson(**changes):
    tiny = {
        "teacher": "lyapunov",
        "courses": (scenario_course(BEND),),
        "inputs": TRACKING,
        "seeds": tuple(range(4)),
        "rules": 4,
        "rounds": 1,
        "options": anfis.Options(epochs=3, ridge=1e-5),
    }
    return ImitationPlan(**{**tiny, **changes})


@pytest.fixture(scope="module")
def learnt():
    return imitate(lesson())


@pytest.mark.long
def test_the_learner_tracks_as_its_teacher_does(learnt, tmp_path):
    """On seeds that were not learnt from; a rule base that says nothing stays where it is, 0.2 m beside the path."""
    file = tmp_path / "learnt.fis"
    write_rule_base(learnt, file)
    off = {
        name: float(
            np.sqrt(np.mean(cross_track_error(simulate(BEND, make_controller(name), range(20, 23)))[..., 60:] ** 2))
        )
        for name in ("lyapunov", f"fuzzy:rule_base={file}")
    }
    taught, own = off.values()
    assert own < 0.02
    assert own < 2 * taught + 0.005
    driven = drives(learnt.lesson, file, range(20, 23))["bend"]
    assert driven["teacher"].keys() == driven["learnt"].keys()
    assert driven["learnt"]["robots stopped"] == 0


def test_what_is_written_says_where_it_comes_from_and_has_units(learnt, tmp_path):
    file = tmp_path / "learnt.fis"
    write_rule_base(learnt, file)
    text = file.read_text(encoding="utf-8")
    assert text.startswith("% 4 rules learnt from lyapunov for fuzzy:rule_base; driven were bend\n")
    system = read_fis(file)
    assert [(v.name, v.unit) for v in system.inputs[:3]] == [("x_err", "m"), ("y_err", "m"), ("heading_err", "rad")]
    assert [(v.name, v.unit) for v in system.outputs] == [("v", "m/s"), ("w", "rad/s")]
    assert len(system.rules) == 4


@pytest.mark.long
def test_the_same_lesson_gives_the_same_file(learnt, tmp_path):
    for name, found in (("a", learnt), ("b", imitate(lesson()))):
        write_rule_base(found, tmp_path / f"{name}.fis")
        np.save(tmp_path / f"{name}.npy", found.table()[1])
    assert (tmp_path / "a.fis").read_bytes() == (tmp_path / "b.fis").read_bytes()
    assert (tmp_path / "a.npy").read_bytes() == (tmp_path / "b.npy").read_bytes()


def test_the_table_holds_what_the_teacher_would_do(learnt):
    """(2.30) and (2.32), computed again from the inputs; the target is the sample due if nobody looks ahead."""
    names, values = learnt.table()
    assert names[:4] == ["round", "seed", "moment", "x_err [m]"]
    assert set(values[:, 0]) == {0, 1}
    assert set(values[:, 1]) == {0, 1, 2, 3}
    due = imitate(lesson(into="fuzzy:look_ahead=0,rule_base", rounds=0, options=anfis.Options(epochs=0, ridge=1e-5)))
    x, y, heading, v_d, w_d, v, w = due.table()[1][:, 3:].T
    np.testing.assert_allclose(w, w_d + v_d * (10 * y + 5 * np.sin(heading)), atol=1e-9)
    np.testing.assert_allclose(v, v_d * np.cos(heading) + x, atol=1e-9)


@pytest.mark.filterwarnings("ignore:input 'target_v' is constant")
def test_a_correction_is_what_the_teacher_adds_to_the_velocity_that_it_reads_ahead():
    """Of (2.30) and (2.32) what is left: x_e, and v_d (10 y_e + 5 sin ψ_e), of a reference with one speed."""
    course = replace(
        BEND, robots=tuple(replace(r, timing=replace(r.timing, x_rate=None, speed=0.3)) for r in BEND.robots)
    )
    plan = lesson(
        teacher="lyapunov:lead=auto",
        courses=(scenario_course(course),),
        inputs=TRACKING[:4],
        outputs=("dv", "dw"),
        into="fuzzy:lead=auto,smooth=0.2,rule_base",
        options=anfis.Options(epochs=0, ridge=1e-5),
    )
    found = imitate(plan)
    x, y, heading, v_d, dv, dw = found.table()[1][:, 3:].T
    under_way = v_d == v_d.max()  # not after the path's end, of which the lead knows before
    np.testing.assert_allclose(dv[under_way], x[under_way], atol=1e-9)
    np.testing.assert_allclose(dw[under_way], (v_d * (10 * y + 5 * np.sin(heading)))[under_way], atol=1e-9)
    assert under_way.sum() > 100
    assert [(v.name, v.unit) for v in found.system.outputs] == [("dv", "m/s"), ("dw", "rad/s")]


def test_two_laws_in_tandem_change_nothing_for_the_one_that_drives():
    """Both tell the other robots what they tell them alone."""
    scenario = load_scenario("three-cross")
    short = replace(scenario.setting, ticks=120)
    teacher, pupil = make_controller("right-of-way"), make_controller("fuzzy-team")
    both = TeacherAndPupil(teacher=teacher, pupil=pupil, learns="crash")
    for alone, tandem in ((teacher, both), (pupil, replace(both, driver="pupil"))):
        one, other = ([state.truth for state in drive(short, law, [3])][-1] for law in (alone, tandem))
        np.testing.assert_array_equal(one, other)


@dataclass(frozen=True, kw_only=True, eq=False)
class Overseen(TeacherAndPupil):
    """Notes by how much what the pupil's rule base of crash is told differs from what it knows on arrays."""

    setting: Any
    memories: list[Any] = field(default_factory=list)
    apart: list[float] = field(default_factory=list)

    def control(self, seen, memory, dt):
        """Look at the same on arrays."""
        arrays, mine = InterpretedTeam.of(self.pupil), _share(seen, "pupil", self.pupil)
        before = self.memories[-1] if self.memories else arrays.init(self.setting, len(seen.x))
        situation = arrays.situation(mine, before, dt)
        command, after = super().control(seen, memory, dt)
        heard = situation.seen.heard.hears & ~np.isnan(situation.others.gap)
        known = np.where(heard[..., None], told(arrays.rule_bases["crash"], situation), np.nan)
        np.testing.assert_array_equal(np.isnan(after.known), np.isnan(known))
        self.apart.append(float(np.nanmax(np.abs(after.known - known), initial=0.0)))
        self.memories.append(arrays.control(mine, before, dt)[1])
        return command, after


@pytest.mark.parametrize("driver", ["teacher", "pupil"])
def test_of_pairs_a_pupil_is_told_of_each_other_robot_what_it_knows(driver):
    scenario = load_scenario("three-cross")
    short = replace(scenario.setting, ticks=150)
    teacher, pupil = make_controller("right-of-way"), make_controller("fuzzy-team")
    both = Overseen(teacher=teacher, pupil=pupil, learns="crash", driver=driver, setting=short)
    *_, last = drive(short, both, [3, 4])
    assert last.memory.known.shape == (2, 3, 3, len(both.pupil.bases["crash"].inputs))
    assert np.isfinite(last.memory.known).any(axis=-1).sum() == 12  # each of three hears two others, in two runs
    assert len(both.apart) == 151
    assert max(both.apart) < 1e-9


def test_disturbances_depend_on_the_runs_own_seed_alone_and_spare_half_of_the_runs():
    setting, pushes = disturbed(BEND.setting, range(8), 1.0)
    one, alone = disturbed(BEND.setting, [9, 3], 1.0)
    moved = (setting.starts != BEND.setting.starts).any(axis=(1, 2))
    np.testing.assert_array_equal(moved, [0, 1, 0, 1, 1, 0, 1, 0])
    assert 0 < moved[3::4].sum() < 2  # of the checking seeds, too
    np.testing.assert_array_equal(one.starts[1], setting.starts[3])
    np.testing.assert_array_equal(alone[:, :, 1], pushes[:, :, 3])
    assert np.std(pushes[:, 0, moved]) == pytest.approx(0.05, rel=0.4)


PAIRS = {
    "teacher": "right-of-way",
    "courses": (crossing_course(3),),
    "into": "fuzzy-team:crash_rule_base",
    "inputs": ("meeting", "right_of_way"),
    "outputs": ("speed",),
}


def test_of_pairs_each_other_robot_that_is_heard_is_a_sample():
    both = TeacherAndPupil(teacher=make_controller("right-of-way"), pupil=make_controller("fuzzy-team"), learns="crash")
    samples, outcome = demonstrate(crossing_course(3), both, ("speed",), (0,), 0)
    many = np.bincount(samples.moment)
    assert many.max() == 2
    assert len(many) == len(samples.said) == len(samples.held_back)
    assert not outcome.touched.any()
    assert not outcome.missing.any()
    assert samples.said.max() < 0.6


def test_for_whom_of_two_the_teacher_waits_is_found_out():
    """It drives 0.02 m/s if one of them is nearer than 1 m to the meeting and goes first, otherwise 0.2 m/s."""
    rng = np.random.default_rng(1)
    moments = 600
    known = np.stack([rng.uniform(0, 4, 2 * moments), rng.choice([-1.0, 1.0], 2 * moments)], axis=1)
    waits = ((known[:, 0] < 1) & (known[:, 1] < 0)).reshape(moments, 2).any(axis=1)
    said = np.where(waits, 0.02, 0.2)[:, None]
    seed = np.arange(moments) % 8
    samples = Demonstrations(known, np.repeat(np.arange(moments), 2), said, seed, seed * 0, np.asarray(waits))
    system = fitted(lesson(**PAIRS, seeds=tuple(range(8)), rules=12), samples, 0.35, lambda: None).system
    asked = system([[0.4, -1.0], [0.4, 1.0], [2.0, -1.0], [3.5, -1.0], [2.5, 1.0]])[:, 0]
    assert asked[0] < 0.12
    assert asked[1:].min() > 0.35


def test_of_pairs_the_least_counts_and_more_than_the_teacher_drove_is_no_error():
    zero = np.zeros(1, int)
    samples = Demonstrations(
        np.array([[1.0, -1], [3, 1]]), np.zeros(2, int), np.array([[0.1]]), zero, zero, np.array([True])
    )
    base = blank(lesson(**PAIRS))
    assert rmse(base, samples, True)[0] == pytest.approx(0.1)
    held_back = samples._replace(said=np.array([[-0.3]]))
    assert rmse(base, held_back, True)[0] == pytest.approx(0.3)
    assert rmse(base, held_back._replace(held_back=np.array([False])), True)[0] == 0.0


def test_samples_of_some_moments_keep_their_numbers():
    moments = np.arange(3)
    known, held_back = np.arange(6.0)[:, None], np.zeros(3, dtype=bool)
    part = Demonstrations(known, np.repeat(moments, 2), moments[:, None] + 0.0, moments, moments, held_back)
    both = joined([part, part])
    np.testing.assert_array_equal(both.moment, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5])
    chosen = both.where(np.array([False, True, False, False, False, True]))
    np.testing.assert_array_equal(chosen.known[:, 0], [2, 3, 4, 5])
    np.testing.assert_array_equal(chosen.moment, [0, 0, 1, 1])
    np.testing.assert_array_equal(chosen.said[:, 0], [1, 2])


@pytest.mark.parametrize(
    ("changes", "error", "said"),
    [
        ({"inputs": ("x_er",)}, ControllerError, "did you mean 'x_err'"),
        ({"inputs": ("y_err", "y_err")}, ImitationError, "the input 'y_err' is given twice"),
        ({"outputs": ("vv",)}, ImitationError, "unknown output that a teacher shows 'vv'; did you mean 'v'"),
        ({"outputs": ()}, ImitationError, "needs an output"),
        ({"inputs": ("x_err", "heading_err")}, ImitationError, "add another input, such as y_err"),
        ({"inputs": ("gap", "y_err")}, ImitationError, r"each other robot \(gap\) belong to the output speed"),
        ({"seeds": (0,)}, ImitationError, "at least two seeds"),
        ({"courses": ()}, ImitationError, "at least one scenario or stress test"),
        ({"into": "fuzzy"}, ImitationError, "such as fuzzy:rule_base; got 'fuzzy'"),
    ],
)
def test_a_lesson_that_cannot_be_is_refused(changes, error, said):
    with pytest.raises(error, match=said):
        lesson(**changes)


def test_a_gain_that_takes_no_such_rule_base_is_refused():
    with pytest.raises(ImitationError, match=r"into fuzzy:lateral_rule_base: .* the rule base: λ has one input"):
        imitate(lesson(into="fuzzy:lateral_rule_base"))
    with pytest.raises(ImitationError, match=r"into fuzzy-team:crash_rule_base: .* unknown output of crash 'v'"):
        imitate(lesson(into="fuzzy-team:crash_rule_base"))


def test_a_teacher_that_cannot_drive_says_why():
    with pytest.raises(ControllerError, match='needs a scenario of kind = "team"'):
        imitate(lesson(teacher="right-of-way"))
