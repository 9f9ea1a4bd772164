"""Passive safety: nothing is driven into, by an oracle of its own; and each assumption that is broken breaks it."""

import math
from dataclasses import replace
from math import floor, inf

import numpy as np
import pytest

import robotics
from benchmarks.safety_attack import (
    FAMILIES,
    HARD,
    LAWS,
    ROBOTS,
    BadLaw,
    attack,
    broken_assumption,
    contact_speed,
    shuffled_team,
)
from benchmarks.safety_search import Scripted, Search, search
from fuzzy.compiled.jit import kernel
from robotics.laws.law import ControllerError
from robotics.laws.setting import Setting, TrueParameters
from robotics.plugins.stress.lanes import Lanes
from robotics.plugins.stress.obstaclecourse import ObstacleOutcome, obstacle_ensemble, stress_obstacles
from robotics.plugins.stress.tally import run_ensemble
from robotics.simulation.loop import Simulation, record_run
from robotics.simulation.safety.assumptions import AT_REST, OVERSHOOT, STOP_NEAR, radio_delay, stopping
from robotics.simulation.safety.coverage import blind_directions, blind_spots
from robotics.simulation.safety.ground import (
    FREE_GROUND,
    NEVER_SEEN,
    OF_MOVING,
    GuardColumns,
    find_barred,
    find_free,
    is_clear,
    put,
    set_free,
    take_in,
)
from robotics.simulation.safety.monitor import AWAY
from robotics.simulation.safety.opening import given_rows
from robotics.simulation.safety.others import BACK_GROWS, TURN_GROWS, HeardPosture, apart
from robotics.simulation.safety.view import covered_speed
from robotics.simulation.scenario.robots import load_robot
from robotics.studies.inspection import inspect_scenario
from robotics.world.environment.collision import footprints, obstacle_clearance, rectangle_gap
from robotics.world.environment.world import Disc, Geometry, World, compile_worlds
from robotics.world.paths.path import Line
from robotics.world.paths.trajectory import Timing
from robotics.world.radio.description import Radio
from robotics.world.sensing.raycasting import SensorColumns
from robotics.world.sensing.sonar import RangeSensor
from robotics.world.vehicle.plant import Plant, TruthColumns, initial_state, parameters

FIELD, DISC, CROSSING = (next(f for f in FAMILIES if f.name == name) for name in ("field", "disc", "crossing-bad"))
RAGING = BadLaw(kind=float(LAWS.index("raging")), safe="yes")


def caused(setting: Setting, law: BadLaw, runs: int) -> int:
    """In how many runs a robot caused a contact."""
    return int(run_ensemble(ObstacleOutcome, setting, law, range(runs)).caused.any(axis=1).sum())


def course(runs: int, seconds: float = 15.0, **more: object) -> Setting:
    ensemble = obstacle_ensemble(range(runs), "A", 1, **more)  # type: ignore[arg-type]
    return replace(ensemble, ticks=round(seconds / ensemble.period), divergence=1e6)


# The guarantee ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("robot", ROBOTS)
def test_bad_laws_drive_into_nothing_and_without_the_monitor_they_do(robot):
    found = {}
    for safe in ("no", "yes"):
        rows = [attack(FIELD, robot, "raging", 12, 0, safe), attack(CROSSING, robot, "chasing", 12, 0, safe)]
        found[safe] = [row["caused"] for row in rows]
    assert min(found["no"]) > 0
    assert found["yes"] == [0, 0]


def test_rule_bases_of_random_numbers_drive_into_nothing():
    setting, found = course(12), {}
    for safe in ("no", "yes"):
        law = shuffled_team(3, safe)
        found[safe] = int(run_ensemble(ObstacleOutcome, setting, law, range(12)).caused.any(axis=1).sum())
    assert found["no"] > 0
    assert found["yes"] == 0


def test_a_search_for_the_worst_finds_contacts_without_the_monitor_only():
    assert search("turtlebot3-burger", 32, 0, "no")["contacts"] > 0
    guarded = search("turtlebot3-burger", 32, 0, "yes")
    assert guarded["contacts"] == 0
    assert 0.03 < guarded["least"] < 0.5  # and it does come near


def test_in_each_period_the_robot_can_stop_before_it_touches_anything():
    """The inequality itself, by the true plant, from the true state: a stop from the next period on stays clear."""
    setting, seed = course(8), 3
    simulation = Simulation(setting, RAGING, tuple(range(8)))
    robot, sizes = setting.robots[0], footprints(setting.robots)
    plant = Plant(np.repeat(parameters(robot)[:, None], 8, axis=1), steps=1)
    here = setting.world.rest
    least, fastest = inf, 0.0
    for k, _ in simulation.periods():
        lanes = simulation.lanes
        state, order, none = lanes.body.truth.copy(), lanes.order.copy(), np.zeros((2, 8))
        fastest = max(fastest, float(TruthColumns(state).v.max()))
        for step in range(60 if k % 4 == seed else 0):
            state = plant.advance(state, order, order if step < 5 else none, 0, "velocity")
            now = TruthColumns(state)
            pose = now.x[:, None], now.y[:, None], now.heading[:, None]
            least = min(least, float(obstacle_clearance(*pose, sizes, here).min()))
    assert fastest > 0.7
    assert 0 < least < 0.1


@pytest.mark.parametrize("name", ROBOTS)
def test_the_stopping_model_goes_as_far_as_the_plant_from_any_motion(name):
    robot, rng = load_robot(name).robot, np.random.default_rng(1)
    v = rng.uniform(0, 1, 40) * min(robot.v_max, robot.wheel_speed_limit)
    w = rng.uniform(0, 1, 40) * np.minimum(robot.w_max, (robot.wheel_speed_limit - v) / robot.half_axle)
    plant = Plant(np.repeat(parameters(robot)[:, None], 40, axis=1), steps=1)
    state, command = initial_state(np.zeros((40, 3))), np.stack([v, w])
    for _ in range(300):
        state = plant.advance(state, command, command, 0, "velocity")
    begin, way, turned = TruthColumns(state.copy()), np.zeros(40), np.zeros(40)
    for _ in range(300):
        state = plant.advance(state, 0 * command, 0 * command, 0, "velocity")
        now = TruthColumns(state)
        way, turned = way + 0.01 * np.maximum(now.v, 0), turned + 0.01 * np.maximum(now.w, 0)
    foreseen = stopping(robot).ways(np.array(begin.v), np.array(begin.w), robot.half_axle)
    near = STOP_NEAR * robot.turning_circle
    assert (way <= foreseen[0] + near).all()
    assert (turned <= foreseen[1] + near / robot.half_axle).all()
    assert (way > 0.5 * foreseen[0] - 0.01).mean() > 0.8  # and not so much farther that it forbids everything


@pytest.mark.parametrize("name", ROBOTS)
def test_no_rim_speeds_up_faster_than_is_foreseen(name):
    robot, rng = load_robot(name).robot, np.random.default_rng(4)
    plant = Plant(np.repeat(parameters(robot)[:, None], 500, axis=1), steps=1)
    state, sides, most = initial_state(np.zeros((500, 3))), np.array([[1.0], [-1.0]]) * robot.half_axle, 0.0
    for _ in range(40):
        v = rng.uniform(-1, 1, 500) * min(robot.v_max, robot.wheel_speed_limit)
        w = rng.uniform(-1, 1, 500) * np.minimum(robot.w_max, (robot.wheel_speed_limit - np.abs(v)) / robot.half_axle)
        for _ in range(6):
            now = TruthColumns(state)
            before = now.v + sides * now.w
            state = plant.advance(state, np.stack([v, w]), np.stack([v, w]), 0, "velocity")
            now = TruthColumns(state)
            after = now.v + sides * now.w
            most = max(most, float((np.abs(after) - np.abs(before))[before * after > 0].max(initial=0.0)) / 0.01)
    assert most < stopping(robot).rise
    if not robot.v_rate_max:
        assert most > 0.6 * stopping(robot).rise  # it is no bound of something else


@pytest.mark.parametrize("name", ["etsro", "pioneer-3dx"])
def test_orders_that_fall_gently_swing_no_end_of_the_rear_edge_back_where_hard_brakes_do(name):
    robot, rng = load_robot(name).robot, np.random.default_rng(2)
    v = rng.uniform(0.1, 1, 60) * min(robot.v_max, robot.wheel_speed_limit)
    w = rng.uniform(0, 1, 60) * np.minimum(2 * v / robot.width, (robot.wheel_speed_limit - v) / robot.half_axle)
    plant, model = Plant(np.repeat(parameters(robot)[:, None], 60, axis=1), steps=5), stopping(robot, gentle=True)
    begin, least = initial_state(np.zeros((60, 3))), []
    for _ in range(60):
        begin = plant.advance(begin, np.stack([v, w]), np.stack([v, w]), 0, "velocity")
    for gentle in (True, False):
        state, order, back = begin.copy(), np.stack([v, w]), 0.0
        for _ in range(60):
            less = np.array([[model.v_rate], [model.w_rate]]) * 0.05 if gentle else inf
            order = np.maximum(order - less, 0.0)
            state = plant.advance(state, order, order, 0, "velocity")
            now = TruthColumns(state)
            back = min(back, float((now.v - np.abs(now.w) * robot.width / 2).min()))
        least.append(back)
    assert least[0] > -0.025
    assert least[1] < -0.1


def test_where_nothing_looks_behind_among_what_moves_orders_fall_gently():
    setting, _ = DISC.drawn(range(6), "etsro")
    change = 0.05 * stopping(setting.robots[0], gentle=True).v_rate
    for others_speed, gently in ((None, True), (0.0, False)):
        simulation = Simulation(replace(setting, others_speed=others_speed), RAGING, tuple(range(6)))
        orders = np.array([simulation.lanes.order[0].copy() for _ in simulation.periods()])
        assert orders.max() > 0.5
        assert (np.diff(orders, axis=0).min() >= -change - 1e-9) == gently


@pytest.mark.parametrize(("seed", "kind", "robots"), [(19, "U", 1), (30552, "A", 3)])
def test_a_robot_backs_away_before_it_stands_for_ever(seed, kind, robots):
    """Where it may not turn, beside a trap's end; and from an echo between the two cones ahead, that see it no more."""
    lanes: Lanes = "crossing" if robots > 1 else "beside"
    assert stress_obstacles("fuzzy-team:safe=yes", [seed], kind, robots, lanes=lanes).succeeded.all()


# Each assumption, broken -----------------------------------------------------------------------------------------


def test_it_holds_with_the_stated_latency_and_breaks_with_a_longer_one():
    setting = replace(course(30), latency=0.1)
    assert caused(setting, RAGING, 30) == 0
    late = TrueParameters(robots=setting.robots, latency=0.6)
    assert caused(replace(setting, truth=late), RAGING, 30) > 0


def test_it_breaks_with_weaker_brakes():
    setting = course(30)
    weak = replace(setting.robots[0], torque_limit=0.025)
    assert caused(replace(setting, truth=TrueParameters(robots=(weak,), latency=0.0)), RAGING, 30) > 0


def test_it_breaks_with_sensors_that_see_nothing_and_the_attack_tells_those_from_blind_spots():
    setting, runs = course(30), range(30)
    blinded = {name: replace(one, failure_start=0.0) for name, one in setting.sensors[0].items()}
    broken = []
    aside = RangeSensor(axis=1.3, half_cone=0.25, rays=9)
    for carried in (blinded, {"behind": RangeSensor(axis=np.pi)}, {"aside": aside}):
        blind = replace(setting, sensors=(carried,))
        driven = run_ensemble(ObstacleOutcome, blind, RAGING, runs).caused.any(axis=1)
        assert driven.any()
        first = int(np.argmax(driven))
        broken.append(broken_assumption(blind, RAGING, runs, None, first))
        assert contact_speed(blind, RAGING, runs, None, first) > AT_REST
    assert broken == ["", "unseen", "partly"]


def test_it_breaks_where_others_are_faster_than_stated():
    """A disc comes head-on: the robot does not drive into it; one that believes the disc to rest does."""
    setting = course(30, 8.0)
    begins = setting.references.joined.at(np.zeros(30))
    ahead = np.array([np.cos(begins.heading), np.sin(begins.heading)]).T
    starts = np.array([begins.x, begins.y]).T
    worlds = []
    for start, end in zip((starts + 3 * ahead).tolist(), (starts - 6 * ahead).tolist(), strict=True):
        path = Line(start=(start[0], start[1]), end=(end[0], end[1]))
        worlds.append(World(obstacles=(Disc(radius=0.3, path=path, timing=Timing(speed=0.8)),), known=False))
    coming = replace(setting, world=compile_worlds(worlds))
    assert caused(coming, RAGING, 30) == 0
    assert caused(replace(coming, others_speed=0.0), RAGING, 30) > 5
    assert met_in_motion(coming) <= 1  # one drives on past a disc that comes up beside it
    assert met_in_motion(replace(coming, others_speed=0.0)) > 5


def met_in_motion(setting: Setting) -> int:
    """In how many runs a robot drives ahead when something first touches it."""
    simulation, sizes = Simulation(setting, RAGING, tuple(range(30))), footprints(setting.robots)
    speed = np.full(30, np.nan)
    for k, _ in simulation.periods():
        now = TruthColumns(simulation.rows(simulation.lanes.body.truth))
        gap = obstacle_clearance(now.x, now.y, now.heading, sizes, Geometry(*setting.world.at(k * setting.period)))
        speed = np.where((gap[:, 0] <= 0) & np.isnan(speed), now.v[:, 0], speed)
    assert np.isfinite(speed).sum() > 5
    return int((speed > 0.02).sum())


BACK, ROUND = [[0.5, 0.0], [-0.5, 0.0], [-0.5, 0.0]], [[0.0, 0.0], [0.0, 2.5], [0.0, 2.5]]


def followed(
    robot: str, script: list[list[float]], speed: float, others_speed: float | None = None
) -> tuple[int, float]:
    """A robot follows a script of three seconds; a disc follows it.

    Returns:
        In how many of ten runs the robot causes a contact, and how far it goes back [m].
    """
    setting = obstacle_ensemble(range(10), "A", 1, robot=load_robot(robot))
    begins, behind = (
        setting.references.joined.at(np.zeros(10)),
        setting.robots[0].length / 2 + 2.6 * setting.robots[0].turning_circle,
    )
    worlds = []
    for x, y, heading in zip(begins.x.tolist(), begins.y.tolist(), begins.heading.tolist(), strict=True):
        start, end = ((x + d * math.cos(heading), y + d * math.sin(heading)) for d in (-behind, 3.0))
        disc = Disc(radius=0.2, path=Line(start=start, end=end), timing=Timing(speed=speed))
        worlds.append(World(obstacles=(disc,), known=False))
    setting = replace(setting, world=compile_worlds(worlds), ticks=60, divergence=1e6, others_speed=others_speed)
    law = Scripted(script=np.tile(script, (10, 1, 1, 1)), seconds=1.0, safe="yes")
    simulation, way = Simulation(setting, law, tuple(range(10))), np.zeros(10)
    for _ in simulation.periods():
        way += setting.period * np.maximum(-TruthColumns(simulation.lanes.body.truth).v, 0.0)
    return int(run_ensemble(ObstacleOutcome, setting, law, range(10)).caused.any(axis=1).sum()), float(way.max())


def test_among_what_moves_no_robot_goes_back_where_its_sensors_do_not_look():
    assert followed("etsro", BACK, 0.2, others_speed=0.0)[0] > 5  # it believes the disc to rest, and goes back
    contacts, way = followed("etsro", BACK, 0.2)
    assert contacts == 0
    assert way < 0.05  # 0.02 m/s for two seconds, and what the wheels swing back when they brake
    contacts, way = followed("mir100", BACK, 0.2)  # sees all round
    assert contacts == 0
    assert way > 0.2


def test_among_what_moves_no_robot_turns_its_rear_edge_back_where_its_sensors_do_not_look():
    assert followed("etsro", ROUND, 0.15, others_speed=0.0)[0] > 5
    assert followed("etsro", ROUND, 0.15)[0] == 0


@pytest.mark.parametrize("seed", [40130, 60132])
def test_who_backs_away_goes_on_until_its_way_is_clear_and_seen(seed):
    """Else it goes ahead and back by turns, for ever, between echoes that it no longer sees."""
    assert stress_obstacles("fuzzy-team:safe=yes", [seed], robots=3, lanes="crossing").arrived.all()


def test_what_has_passed_bars_no_way():
    """Echoes of discs and robots that have gone remain where nothing looks; robots drive on all the same."""
    seeds = (0, 1, 7, 8)
    outcome = stress_obstacles("fuzzy-team:safe=yes", seeds, robots=3, disturbance=HARD, moving=2, lanes="crossing")
    assert outcome.arrived.all()


@kernel
def echoed(ground, window, given, table, rays, stamp, of_robot, reading=0.3):
    take_in(
        ground, window, GuardColumns(given, 0), SensorColumns(table, 0), rays, 0, rays.shape[1], reading, stamp,
        of_robot, 0.0, 0.0, 1.0, 0.0,
    )  # fmt: skip


@kernel
def freed(ground, window, given, near, table, rays, reading, x, y, heading):
    find_free(ground, window, near)
    set_free(
        ground, window, GuardColumns(given, 0), near, SensorColumns(table, 0), rays, 0, rays.shape[1], reading,
        x, y, math.cos(heading), math.sin(heading),
    )  # fmt: skip


def test_an_echo_at_the_least_distance_frees_nothing_before_it():
    """What is nearer than a sensor can read reads its minimum: it may be anywhere up to there."""
    setting = course(1)
    given = np.array([given_rows(setting.robots[0], setting, 0, 0.05)]).T.copy()
    table = np.zeros((SensorColumns.size, 1))
    SensorColumns(table, 0).range = 1.0
    rays = np.array([[math.cos(0.3)], [math.sin(0.3)]])
    for minimum, frees in ((0.3, False), (0.1, True)):
        SensorColumns(table, 0).minimum = minimum
        ground, window = np.zeros((48, 48), dtype=np.int64), np.full(2, -24)
        echoed(ground, window, given, table, rays, 5, False)
        freed(ground, window, given, np.zeros_like(ground), table, rays, 0.3, 0.0, 0.0, 0.0)
        assert (ground == FREE_GROUND).any() == frees
        assert (ground == 5).any()


@pytest.mark.parametrize(
    ("incidence", "near", "stays"), [(60, 1.5, True), (90, 1.5, False), (60, 5.0, True), (60, 9.0, False)]
)
def test_what_may_be_too_steep_to_be_heard_again_is_not_freed(incidence, near, stays):
    """A body comes in at the edge of a cone, its face at 20° to the ray; what stands alone is heard."""
    setting = course(1)
    given = np.array([given_rows(setting.robots[0], setting, 0, 0.05)]).T.copy()
    table = np.zeros((SensorColumns.size, 1))
    sensor = SensorColumns(table, 0)
    sensor.range, sensor.sin_half = 3.0, math.sin(math.radians(37))
    sensor.cos_incidence = math.cos(math.radians(incidence)) if incidence < 90 else 0.0
    angles = np.radians(np.linspace(-37, 37, 75))
    # cells from the sensor
    edge, along, across = (np.exp(1j * np.radians(angle)) for angle in (37, 17, 107))
    face = near * edge + along * np.array([0, 1.5])
    behind, alone, lone = (face[:, None] + across * np.array([0.7, 1.4])).ravel(), 2.5 + 0j, 1.5 * edge.conjugate()
    hidden = near * edge + 3.0 * along + 0.8 * across  # behind the face, never seen
    ground, window = np.full((48, 48), FREE_GROUND), np.full(2, -24)
    for z in (*face, *behind, alone, lone):
        ground[floor(z.real), floor(z.imag)] = 5
    ground[floor(hidden.real), floor(hidden.imag)] = NEVER_SEEN
    freed(ground, window, given, np.zeros_like(ground), table, np.array([np.cos(angles), np.sin(angles)]), 2.0, 0, 0, 0)
    assert (ground[floor(face[1].real), floor(face[1].imag)] == 5) == stays
    assert (ground[floor(hidden.real), floor(hidden.imag)] == NEVER_SEEN) == (incidence == 60)
    for z in (alone, lone):
        assert ground[floor(z.real), floor(z.imag)] == FREE_GROUND


def test_ground_behind_a_face_that_is_too_steep_is_not_backed_over():
    """Seed 11000482: a robot came in front of a box, turned, and backed round it to a face that no cone had met."""
    assert attack(FIELD, "etsro", "random", 50, 11000450, "yes")["caused"] == 0


def test_ground_beside_an_echo_is_not_free_before_it_is_seen():
    """Seed 13000184: a robot drove round the corner of a box, and its side swung into the face behind."""
    assert attack(FIELD, "etsro", "rules", 50, 13000150, "yes")["caused"] == 0


def test_rays_that_go_past_free_ground_free_the_same_as_those_that_stop_at_every_step():
    setting = course(1)
    given = np.array([given_rows(setting.robots[0], setting, 0, 0.05)]).T.copy()
    cell, rng, table = float(GuardColumns(given, 0).cell), np.random.default_rng(8), np.zeros((SensorColumns.size, 1))
    SensorColumns(table, 0).range = 3.0
    rays = np.exp(1j * np.linspace(-3, 3, 90))
    for share in (0.5, 0.9, 0.98, 1.0):
        ground = np.where(rng.random((48, 48)) < share, FREE_GROUND, rng.integers(-9, 9, (48, 48)))
        place, heading = rng.uniform(-30, 30, 2) * cell, rng.uniform(-np.pi, np.pi)
        window = np.floor(place / cell).astype(np.int64) - 24
        reading, plain = rng.uniform(0.3, 1.5), ground.copy()
        for ray in rays * np.exp(1j * heading):
            for r in 0.7 * cell * np.arange(100):
                at = np.floor((place + r * np.array([ray.real, ray.imag])) / cell).astype(np.int64)
                away = complex(*((at + 0.5) * cell - place))
                if (at < window).any() or (at >= window + 48).any() or r > reading - 0.36 * cell:
                    break
                if abs(away) <= reading - 0.36 * cell and abs((np.conj(ray) * away).imag) <= 0.36 * cell:
                    plain[tuple(at % 48)] = FREE_GROUND
        assert (plain != ground).any() == (share < 1)
        freed(
            ground,
            window,
            given,
            np.zeros_like(ground),
            table,
            np.stack([rays.real, rays.imag]),
            reading,
            *place,
            heading,
        )
        assert (ground == plain).all()


def test_the_echo_of_a_robot_takes_nothing_away_that_stands():
    setting = course(1)
    given = np.array([given_rows(setting.robots[0], setting, 0, 0.05)]).T.copy()
    table = np.zeros((SensorColumns.size, 1))
    SensorColumns(table, 0).range = 1.0
    ground, window = np.zeros((48, 48), dtype=np.int64), np.full(2, -24)
    rays = np.array([[1.0], [0.0]])
    echoed(ground, window, given, table, rays, 5, False)
    stands = ground.copy()
    echoed(ground, window, given, table, rays, 6, True)
    assert (stands == 5).any()
    assert (ground == stands).all()


@kernel
def beside(ground, window, given, barred, value, from_turn):
    """Whether a robot may be where it is now, with an echo beside its front, coming from another heading."""
    one = GuardColumns(given, 0)
    put(ground, math.floor(0.7 * one.half_length / one.cell), math.ceil(one.half_width / one.cell), value)
    find_barred(ground, window, one, barred, 40, 0.05)
    return is_clear(
        ground, window, one, barred, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, math.cos(from_turn),
        math.sin(from_turn), one.least, 0.1, 0.05, 40, False, 0.0,
    )  # fmt: skip


def test_what_moves_may_not_come_nearer_on_any_part_of_a_way_and_what_stands_not_by_the_whole():
    """As on a way back and round: it may be there by then."""
    setting = course(1)
    given = np.array([given_rows(setting.robots[0], setting, 0, 0.05)]).T.copy()
    for others, value, turned, clear in (
        (0.2, 39, -0.1, False),  # its side comes nearer to what was seen just now
        (0.2, 39, 0.1, True),
        (0.2, 2, -0.1, True),  # seen long ago: it stands
        (0.0, 39, -0.1, True),  # nothing moves
    ):
        GuardColumns(given, 0).others = others
        ground, window = np.zeros((48, 48), dtype=np.int64), np.full(2, -24)
        assert beside(ground, window, given, np.zeros_like(ground), value, turned) == clear


@kernel
def goes_on(ground, window, given, barred, ahead, left, value, away):
    """Whether a robot may go 1 mm ahead, with an echo so many cells ``ahead`` of its front and ``left`` of its side."""
    one = GuardColumns(given, 0)
    reach = one.half_length / one.cell, one.half_width / one.cell
    put(ground, math.floor(reach[0] + ahead), math.floor(reach[1] + left), value)
    find_barred(ground, window, one, barred, 40, 0.05)
    x = 0.001
    return is_clear(
        ground, window, one, barred, x, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, one.least, 0.1, 0.05, 40,
        False, away * x,
    )  # fmt: skip


def test_beside_what_has_moved_and_may_touch_it_a_robot_creeps_or_drives_away():
    setting = course(1)
    given = np.array([given_rows(setting.robots[0], setting, 0, 0.05)]).T.copy()
    GuardColumns(given, 0).others = 0.2
    moved, stood = OF_MOVING - 2 * 40, 40
    behind = -2 * GuardColumns(given, 0).half_length / GuardColumns(given, 0).cell - 1
    for ahead, left, value, away, clear in (
        (-2.0, 0.5, moved, AWAY, False),  # along it
        (-2.0, 0.5, moved, 0.0, True),  # so slowly that it stands
        (-2.0, 0.5, stood, AWAY, True),  # it was always there
        (-2.0, 2.0, moved, AWAY, True),  # farther than it may touch
        (behind, -2.0, moved, AWAY, True),  # away from it
        (0.5, -2.0, moved, 0.0, False),  # into it
    ):
        ground, window = np.zeros((48, 48), dtype=np.int64), np.full(2, -24)
        assert goes_on(ground, window, given, np.zeros_like(ground), ahead, left, value, away) == clear


# Promises --------------------------------------------------------------------------------------------------------


@kernel
def gap_to(given, heard, x, y, heading, late):
    mine, other = GuardColumns(given, 0), GuardColumns(given, 1)
    body = mine.half_length, mine.half_width, mine.radius
    return apart(mine, other, HeardPosture(heard, 0, 0), x, y, heading, body, late, 1.0)


@pytest.mark.parametrize("turned", [0.0, 0.1])
def test_no_robot_that_keeps_its_promise_comes_nearer_than_is_foreseen(turned):
    robot = load_robot("pioneer-3dx").robot
    setting = replace(robotics.load_scenario("lyapunov-sine").setting, robots=(robot, robot))
    setting = replace(setting, sensing=setting.sensing * 2, sensors=setting.sensors * 2)
    rows = [given_rows(robot, setting, i, 0.3) for i in (0, 1)]
    given = np.array(rows).T.copy()
    GuardColumns(given).turned[1] = turned
    top, swiftest = OVERSHOOT * min(robot.v_max, robot.wheel_speed_limit), OVERSHOOT * robot.w_max
    rng, size = np.random.default_rng(5), footprints([robot])[:, 0]
    near = 0
    for _ in range(200):
        fastest, slowest, turn = rng.uniform(0, top), -rng.uniform(0, 0.3), rng.uniform(0, 5)
        x, y, heading = *rng.uniform(-1.2, 1.2, 2), rng.uniform(-np.pi, np.pi)
        age, late, grows = rng.uniform(0.05, 0.6), rng.uniform(0, 0.5), max(rng.uniform(-0.5, 2.5), 0.0)
        heard = np.array([age, 1.0, 0.0, 0.0, 0.0, fastest, slowest, turn, grows])[:, None, None]
        foreseen = gap_to(given, heard, x, y, heading, late)
        steps = 60
        step = (age + late) / steps
        for kind in ("random", "random", "round", "round", "there", "there"):  # ways that keep the promise
            side, to = rng.choice([-1.0, 1.0]), np.zeros(2)
            place = np.array([0.0, 0.0, turned * side])
            for n in range(steps):
                more = n * step * grows
                forwards, back = min(fastest + more * top, top), max(slowest - BACK_GROWS * more * top, -top)
                swift = min(turn + TURN_GROWS * more * swiftest, swiftest)
                if kind == "there":  # round, and straight at the body
                    bearing = np.arctan2(y - place[1], x - place[0]) - place[2]
                    bearing = np.arctan2(np.sin(bearing), np.cos(bearing))
                    v, w = forwards if abs(bearing) < np.pi / 2 else 0.0, np.clip(bearing / step, -swift, swift)
                elif kind == "round":
                    v, w = forwards, side * swift
                else:
                    if n == 0 or rng.random() < 0.1:
                        to = np.array([rng.uniform(0, 1), rng.choice([-1.0, 0.0, 1.0])])
                    v, w = back + to[0] * (forwards - back), to[1] * swift
                middle = place[2] + w * step / 2
                place += step * np.array([v * np.cos(middle), v * np.sin(middle), w])
            gap = rectangle_gap(place[0] - x, place[1] - y, heading, place[2], size, size)
            assert foreseen <= gap + 1e-9
            near += foreseen > -inf and gap - foreseen < 0.1
    assert near > 65  # it is no bound that forbids everything: of the rectangle alone 63, and 43


def test_who_is_far_from_all_others_starts_at_once():
    search = Search("etsro", "yes")
    script = np.array([[[[0.0, 0.0], [0.4, 0.0]]] * 2])
    simulation = Simulation(search.setting, Scripted(script=script, seconds=1.0), (0,))
    for k, _ in simulation.periods():
        if k == 25:
            break
    assert float(TruthColumns(simulation.lanes.body.truth).v.min()) > 0.3
    assert simulation.lanes.guard.acted.sum() == 0


def test_the_stated_delay_is_so_long_that_nearly_every_message_comes_within_it():
    assert radio_delay(Radio(), 0.05) == pytest.approx(0.1)
    stated = radio_delay(Radio(loss=0.2, latency=0.3), 0.05)
    assert 0.2 ** ((stated - 0.3 - 0.05) / 0.05 - 1) <= 1e-5
    assert stated < 0.9


# What is said, and how it is switched on ---------------------------------------------------------------------------


def test_a_scenario_or_a_law_switches_it_on_and_without_it_nothing_changes():
    scenario = next(s for n in robotics.scenario_names() if (s := robotics.load_scenario(n)).obstacles)
    for law in ("lyapunov", "pid", "fuzzy"):
        plain = record_run(scenario.setting, robotics.make_controller(law), (0,))
        off = replace(scenario, safety="passive").setting
        told = record_run(off, robotics.make_controller(f"{law}:safe=no"), (0,))
        assert plain.samples.tobytes() == told.samples.tobytes()
        on = record_run(off, robotics.make_controller(law), (0,))
        also = record_run(scenario.setting, robotics.make_controller(f"{law}:safe=yes"), (0,))
        assert on.samples.tobytes() == also.samples.tobytes()
        assert on.samples.tobytes() != plain.samples.tobytes()


OWN = """
from dataclasses import dataclass
import numpy as np
from robotics import Command, Law

@dataclass(frozen=True)
class Ahead(Law):
    def control(self, seen, memory, dt):
        v = np.full_like(seen.x, 0.8)
        return Command(v, 0 * v, v, 0 * v), memory
"""


def test_an_own_python_law_has_it_too(tmp_path):
    (tmp_path / "own.py").write_text(OWN)
    setting, found = course(10), {}
    for safe in ("no", "yes"):
        law = robotics.make_controller(f"{tmp_path / 'own.py'}:Ahead:safe={safe}")
        found[safe] = int(run_ensemble(ObstacleOutcome, setting, law, range(10)).caused.any(axis=1).sum())
    assert found["no"] > 0
    assert found["yes"] == 0


def test_a_law_of_torques_cannot_have_it():
    torque = next(n for n in robotics.CATALOGUE if robotics.make_controller(n).level == "torque")
    scenario = replace(robotics.load_scenario("lyapunov-sine"), safety="passive")
    with pytest.raises(ControllerError, match="commands torques"):
        robotics.simulate(scenario, torque)


def test_blind_spots_are_said_before_a_run():
    etsro, mir = load_robot("etsro"), load_robot("mir100")
    (behind,) = [span for span in blind_directions(etsro.robot, etsro.sensors) if span[1] - span[0] > 90]
    assert behind[0] < 180 < behind[1]
    assert blind_directions(mir.robot, mir.sensors) == []
    setting = course(1)
    assert covered_speed(etsro.robot, etsro.sensors, setting) == pytest.approx(0.825, abs=0.02)
    assert covered_speed(etsro.robot, {"left": etsro.sensors["left"]}, setting) == 0
    assert covered_speed(etsro.robot, etsro.sensors, setting, backwards=True) == 0
    assert covered_speed(mir.robot, mir.sensors, setting, backwards=True) == mir.robot.v_max
    (said,) = blind_spots(setting, RAGING)
    assert "no sensor looks at" in said
    assert "goes back" not in said
    (said,) = blind_spots(replace(setting, others_speed=0.2), RAGING)
    assert "among what moves it goes back at 0.02 m/s at most; nor does an end of its rear edge" in said
    slipping = replace(setting, robots=(setting.robots[0].changed(lateral_slip=0.02),))
    assert "and this robot has lateral_slip 0.02" in blind_spots(slipping, RAGING)[0]
    assert blind_spots(setting, replace(RAGING, safe="no")) == []
    scenario = next(s for n in robotics.scenario_names() if (s := robotics.load_scenario(n)).obstacles)
    findings = inspect_scenario(replace(scenario, safety="passive"), "fuzzy").findings
    assert any(f.kind == "blind spots" and f.severity == "note" for f in findings)


def test_a_disc_that_runs_into_a_standing_robot_is_not_caused_by_it():
    row = attack(DISC, "etsro", "raging", 60, 0, "yes")
    assert row["touched"] > 0
    assert row["caused"] == 0
