"""The closed loop of a robot, its law and its reference, in numbers, and a candidate for its Lyapunov function."""

from fuzzy.compiled.columns import Columns, column, several
from robotics.laws.rules.of_reference import INPUTS, OUTPUTS

ASKED = ("x_err", "y_err", "heading_err", "target_v", "target_w")  # what rules may ask for
GROUPS = 8  # of commands, by their age, at most


class LevelColumns(Columns):
    """V = a X² + b Y² + (ψ + m Y)² of posture errors in the reference's frame, and what is claimed of it."""

    a = column("1/m²")
    b = column("1/m²")
    m = column("1/m")
    outer = column("", "V of all that is known of the past: w at most")
    inner = column("", "w at least")
    share = column("1", "ν: V now over w, at most")
    fall = column("1", "μ: V falls by it each period, at least")


class LoopColumns(Columns):
    """The closed loop in numbers."""

    formula = column("", "1: the Lyapunov law in place of a rule base")
    catch_up = column("m/s")
    kx = column("1/s")
    ky = column("1/m²")
    kpsi = column("1/m")
    span = column("s", "how far from the present a reference's velocity counts")
    period = column("s")
    memory = column("", "how many periods back commands are bounded one by one")
    prompt = column("", "commands, beside the newest, that bound v and ω at any time of a period")
    turning = column("", "how many periods back a reversal of a wheel still counts")
    smooth = column("s", "the time constant of the low-pass behind the law; 0: there is none")
    fresh = column("1", "the share of a new correction in the smoothed one, 1 − exp(−period/smooth)")
    forgotten = column("", "periods, of which older corrections count as anything between the robot's limits")
    groups = column("", "of commands, by their age")
    last = several(GROUPS, "", "the greatest age in each, in periods")
    v_weight = several(GROUPS, "", "of each in the mean speed of a period")
    w_weight = several(GROUPS, "", "of each in the mean turn rate")
    share = column("1", "of the width of the hull of all in memory, by which the mean may differ")
    v_error = column("m/s", "by which it may differ, too")
    w_error = column("rad/s")
    v_reversal = column("m/s", "by which it may differ, too, where a wheel may turn round")
    w_reversal = column("rad/s")
    slow = column("m/s", "of a wheel's rim, below which it may turn round")
    overshoot = column("1", "of that width, by which v and ω may leave the hull within a period")
    v_ripple = column("m/s", "by which they may leave it, too")
    w_ripple = column("rad/s")
    v_rate = column("m/s²", "of the reference")
    w_rate = column("rad/s²", "of the reference")
    speed_low = column("m/s")
    speed_high = column("m/s")
    curvature = column("1/m", "of the reference, at most")
    position_noise = column("m")
    heading_noise = column("rad")
    v_max = column("m/s")
    w_max = column("rad/s")
    half_axle = column("m")
    wheel_limit = column("m/s", "of the rim, short of which the wheels were measured")
    count = column("", "of inputs")
    places = several(INPUTS, "", "of the inputs in ASKED")
    given = several(len(OUTPUTS), "", "where the rule base gives each of OUTPUTS; -1: it does not")
