"""The solver: iterative linear-quadratic regulation with bounds of the commands and of their change.

The state of the problem is z = (x, y, ψ, v, ω) and the command before, p = (v_c, ω_c); the command u = (v_c, ω_c) of
a period is bounded by itself and by p (:mod:`robotics.plugins.predictive.allowed`). With the reference's place at the
end of period k, and the command u_r with which a robot would follow it,

    J = Σ_k ½ [ |(along, cross, 2 sin(ψ_e/2))|²_Q + |u − u_r|²_R + |u − p|²_D ]  +  ½ |terminal errors|²_P

and what it costs to be in the discs of :mod:`robotics.plugins.predictive.discs`, if there are some.

The step is that of control-limited differential dynamic programming [Tassa, Mansard & Todorov 2014]: backwards the
quadratic model of the cost to go, its least value within the bounds, and the feedback of what is not bounded; forwards
the plan with that feedback, its step halved until the cost falls by enough. A command at a bound of its change moves
with p one to one, which the feedback holds, and the cost to go with it. Hessians are those of Gauss and Newton, which
are safe; near the end, where a full step brings little, the curvature of the motion is added wherever the model stays
convex, so that the last steps converge quadratically.

A plan may be given in part: where its command is not-a-number, the robot is led by the Lyapunov law (2.30), (2.32) with
that law's gains. All is done in one row of numbers, ``work``; nothing is allocated.
"""

import numpy as np

from fuzzy.compiled.columns import Columns, column, several, within
from fuzzy.compiled.jit import compiled_only
from fuzzy.compiled.trigonometry import sincos
from robotics.plugins.predictive.allowed import STRIPS, best_change, bound, normal
from robotics.plugins.predictive.discs import AroundColumns, disc_of
from robotics.plugins.predictive.model import ResponseColumns, moved
from robotics.plugins.predictive.terminal import WeightColumns
from robotics.world.vehicle.plant import MotionColumns

TAIL = 16  # numbers of the terminal cost


class FixedColumns(Columns):
    """What does not change within a period."""

    after = within(ResponseColumns)
    weights = within(WeightColumns)
    half_axle = column("m")
    tops = several(STRIPS, "m/s, rad/s, m/s, m/s", "of the strips")
    rates = several(STRIPS, "m/s, rad/s, m/s, m/s", "of the strips, from one command to the next")


class PlanColumns(MotionColumns):
    """The state at the begin of a period, and what is done from there."""

    v_c = column("m/s", "the command")
    w_c = column("rad/s")
    distance = column("m", "driven")
    sin = column("1", "of the heading along which it was driven")
    cos = column("1")


class TargetColumns(Columns):
    """Where the reference is at the end of a period, and the command with which a robot follows it."""

    x = column("m")
    y = column("m")
    heading = column("rad")
    cos = column("1")
    sin = column("1")
    v = column("m/s")
    w = column("rad/s")


class PeriodColumns(Columns):
    """What belongs to a period."""

    to = within(TargetColumns)
    plan = within(PlanColumns)
    tried = within(PlanColumns)
    step_v = column("m/s", "of the plan's command")
    step_w = column("rad/s")
    feedback = several(14, "", "of v_c and of ω_c by (z, p)")


class SolverColumns(Columns):
    """All that a problem is solved in."""

    fixed = within(FixedColumns)
    before_v = column("m/s", "the command before the first")
    before_w = column("rad/s")
    state = within(MotionColumns)  # when the first command begins to act
    end_v = column("m/s", "of the reference, at the end")
    end_w = column("rad/s")
    tail = several(
        TAIL,
        "",
        "P: of (along, v, v_c) six numbers, of (cross, 2 sin(ψ_e/2), ω, ω_c) ten, the upper triangles by rows",
    )
    cost = column("1", "of the plan that was found")
    count = column("1", "of the iterations that it took")
    low = several(STRIPS, "m/s, rad/s, m/s, m/s", "the bounds of the strips")
    high = several(STRIPS, "m/s, rad/s, m/s, m/s")
    gradient = several(7, "", "of the cost to go, by (z, p)")
    around = within(AroundColumns)
    hessian = several(49, "", "(7, 7) of the cost to go")
    slopes = several(10, "", "the model's derivatives A and B: of x and of y by (ψ, v, ω, v_c, ω_c)")
    hessian_a = several(25, "", "H A (5, 5)")
    hessian_b = several(10, "", "H B (5, 2)")
    by_u = several(2, "", "the derivatives of the cost to go by u")
    by_uu = several(3)
    by_ux = several(14, "", "(2, 7): by u and by (z, p)")
    closed = several(14, "", "(2, 7): Quu K + Qux")
    exact = column("", "1: the curvature of the motion is added")
    nodes = several(0, "", "a PeriodColumns for each period, and one more for the end")


NODE = PeriodColumns.size
# The gains of robotics.laws.tracking.lyapunov.Lyapunov
_KX = 1.0  # 1/s
_KY = 10.0  # 1/m²
_KPSI = 5.0  # 1/m
_CATCH_UP = 0.3  # m/s
_MIDDLE = 1e-6  # m: nearer to a disc's middle no direction leads out
HALVINGS = 8  # of the step, before a plan is left as it is
_NEAR = 0.1  # of the cost: where a full step brings less, the next one is made with the exact Hessian
_CONVEX = 1e-6  # of the product of its diagonal: the least determinant of a Hessian that counts as convex
_ENOUGH = 1e-4  # of the fall that the quadratic model promises: what a step must bring (Armijo)


def working(horizon: int) -> int:
    """How many numbers a problem of ``horizon`` periods is solved in."""
    return SolverColumns.size + NODE * (horizon + 1)


@compiled_only(forceinline=True)
def node_of(work, k):  # type: ignore[no-untyped-def]
    """The ``k``-th period."""
    return PeriodColumns(work.nodes, NODE * k)


@compiled_only
def solve(work, horizon, iterations, tolerance):  # type: ignore[no-untyped-def]
    """Improve the plan in ``work``, whose commands need not be allowed or known, and leave its cost and count there.

    It ends after a number of ``iterations``, or where the quadratic model promises less than a ``tolerance`` of the
    cost, or no step brings any.
    """
    for k in range(horizon):
        node_of(work, k).plan.x = np.nan  # there is no plan to be near to
    cost = _roll(work, horizon, 0.0)
    _take(work, horizon)
    work.count, work.exact = 0.0, 0.0
    while work.count < iterations:
        promised = _backwards(work, horizon)
        if work.exact > 0 and not promised > 0:
            work.exact = 0.0
            promised = _backwards(work, horizon)
        if not promised > tolerance * cost:
            break
        work.count += 1
        step, tried = _search(work, horizon, cost, promised)
        if step > 0:
            _take(work, horizon)
        elif work.exact == 0:
            break
        # Near the end only: far from it the exact Hessian leads to worse plans.
        work.exact = 1.0 if step == 1 and cost - tried < _NEAR * cost else 0.0
        cost = tried
    work.cost = cost


@compiled_only
def _search(work, horizon, cost, promised):  # type: ignore[no-untyped-def]
    """Halve the step until the cost falls by enough; return it and the cost then, or 0 and the cost as it was."""
    step = 1.0
    for _ in range(HALVINGS):
        tried = _roll(work, horizon, step)
        if cost - tried > _ENOUGH * step * promised:
            return step, tried
        step *= 0.5
    return 0.0, cost


@compiled_only
def _take(work, horizon):  # type: ignore[no-untyped-def]
    """Make the plan of what was tried."""
    for k in range(horizon + 1):
        node = node_of(work, k)
        node.plan = node.tried


@compiled_only
def _roll(work, horizon, step):  # type: ignore[no-untyped-def]
    """Simulate the plan with a share ``step`` of its improvement and its feedback; return its cost.

    Where a node has no state to feed back, the command is the plan's, or the Lyapunov law's. It is the nearest allowed
    one in any case.
    """
    fixed, start, low, high = work.fixed, work.state, work.low, work.high
    weights, half, tops, rates = fixed.weights, fixed.half_axle, fixed.tops, fixed.rates
    x, y, heading, v, w = start.x, start.y, start.heading, start.v, start.w
    v_c, w_c = work.before_v, work.before_w
    cost = 0.0
    for k in range(horizon):
        node = node_of(work, k)
        to, tried = node.to, node.tried
        from_v, from_w = v_c, w_c
        v_c, w_c = _fed_back(work, k, step, x, y, heading, v, w, from_v, from_w)
        bound(low, high, tops, rates, half, from_v, from_w, from_v, from_w)
        g_v, g_w = from_v - v_c, half * half * (from_w - w_c)  # the nearest one by the speeds of the wheels
        change_v, change_w, _, _ = best_change(low, high, half, 1.0, 0.0, half * half, g_v, g_w)
        v_c, w_c = from_v + change_v, from_w + change_w
        tried.x, tried.y, tried.heading, tried.v, tried.w, tried.v_c, tried.w_c = x, y, heading, v, w, v_c, w_c
        x, y, heading, v, w, distance, sin, cos = moved(x, y, heading, v, w, v_c, w_c, fixed.after)
        tried.distance, tried.sin, tried.cos = distance, sin, cos
        off_v, off_w = v_c - to.v, w_c - to.w
        cost += 0.5 * (weights.deviation_v * off_v * off_v + weights.deviation_w * off_w * off_w)
        cost += 0.5 * (weights.change_v * change_v * change_v + weights.change_w * change_w * change_w)
        if k < horizon - 1:
            along, cross, turned, _ = _errors(to, x, y, heading)
            cost += 0.5 * (weights.along * along**2 + weights.cross * cross**2 + weights.turned * turned**2)
        cost += _within_discs(work.around, (k + 1) * (fixed.after.own + fixed.after.given), x, y)
    last = node_of(work, horizon).tried
    last.x, last.y, last.heading, last.v, last.w, last.v_c, last.w_c = x, y, heading, v, w, v_c, w_c
    return cost + _tail(work, horizon, last, False)


@compiled_only
def _fed_back(work, k, step, x, y, heading, v, w, from_v, from_w):  # type: ignore[no-untyped-def]
    """The command of the ``k``-th period: the plan's, a share of its improvement, and the feedback of the state."""
    node = node_of(work, k)
    plan, feedback = node.plan, node.feedback
    v_c, w_c = plan.v_c, plan.w_c
    if np.isnan(v_c):
        return _led(work.fixed.after, node.to, x, y, heading)
    if np.isnan(plan.x):
        return v_c, w_c
    p_v = node_of(work, k - 1).plan.v_c if k > 0 else work.before_v
    p_w = node_of(work, k - 1).plan.w_c if k > 0 else work.before_w
    off = (
        x - plan.x, y - plan.y, heading - plan.heading, v - plan.v, w - plan.w, from_v - p_v, from_w - p_w,
    )  # fmt: skip
    v_c += step * node.step_v
    w_c += step * node.step_w
    for n in range(7):
        v_c += feedback[n] * off[n]
        w_c += feedback[7 + n] * off[n]
    return v_c, w_c


@compiled_only
def _led(after, to, x, y, heading):  # type: ignore[no-untyped-def]
    """The command of the Lyapunov law towards the reference at the begin of a period, at whose end it is at ``to``."""
    v_r, w_r, period = to.v, to.w, after.own + after.given
    dx = to.x - period * v_r * to.cos - x
    dy = to.y - period * v_r * to.sin - y
    sin, cos = sincos(heading)
    sin_e, cos_e = sincos(to.heading - period * w_r - heading)
    v = v_r * cos_e + _KX * (cos * dx + sin * dy)
    speed = max(abs(v_r), min(abs(v), _CATCH_UP))
    return v, w_r + speed * (_KY * (cos * dy - sin * dx) + _KPSI * sin_e)


@compiled_only
def _errors(to, x, y, heading):  # type: ignore[no-untyped-def]
    """What a posture is off a target: along and across it [m], 2 sin(ψ_e/2), and that one's slope."""
    dx, dy = x - to.x, y - to.y
    half_sin, half_cos = sincos(0.5 * (heading - to.heading))
    return to.cos * dx + to.sin * dy, to.cos * dy - to.sin * dx, 2 * half_sin, half_cos


@compiled_only
def _tail(work, horizon, last, derive):  # type: ignore[no-untyped-def]
    """The terminal cost of the ``last`` plan's state; if ``derive``, its derivatives are written."""
    to, then = node_of(work, horizon - 1).to, node_of(work, horizon).to
    along, cross, turned, slope = _errors(to, last.x, last.y, last.heading)
    e_v, e_w = last.v - work.end_v, last.w - work.end_w
    e_vc, e_wc = last.v_c - then.v, last.w_c - then.w
    p = work.tail
    g_a = p[0] * along + p[1] * e_v + p[2] * e_vc
    g_v = p[1] * along + p[3] * e_v + p[4] * e_vc
    g_vc = p[2] * along + p[4] * e_v + p[5] * e_vc
    g_c = p[6] * cross + p[7] * turned + p[8] * e_w + p[9] * e_wc
    g_t = p[7] * cross + p[10] * turned + p[11] * e_w + p[12] * e_wc
    g_w = p[8] * cross + p[11] * turned + p[13] * e_w + p[14] * e_wc
    g_wc = p[9] * cross + p[12] * turned + p[14] * e_w + p[15] * e_wc
    if derive:
        cos, sin, g, h = to.cos, to.sin, work.gradient, work.hessian
        g[0], g[1], g[2] = cos * g_a - sin * g_c, sin * g_a + cos * g_c, slope * g_t
        g[3], g[4], g[5], g[6] = g_v, g_w, g_vc, g_wc
        # The rows of the upper triangle; of (x, y) they are those of (along, cross), turned
        h[0], h[1], h[8] = cos * cos * p[0] + sin * sin * p[6], cos * sin * (p[0] - p[6]), sin**2 * p[0] + cos**2 * p[6]
        h[2], h[3], h[4], h[5], h[6] = -sin * slope * p[7], cos * p[1], -sin * p[8], cos * p[2], -sin * p[9]
        h[9], h[10], h[11], h[12], h[13] = cos * slope * p[7], sin * p[1], cos * p[8], sin * p[2], cos * p[9]
        h[16], h[17], h[18], h[19], h[20] = slope * slope * p[10], 0.0, slope * p[11], 0.0, slope * p[12]
        h[24], h[25], h[26], h[27] = p[3], 0.0, p[4], 0.0
        h[32], h[33], h[34] = p[13], 0.0, p[14]
        h[40], h[41], h[48] = p[5], 0.0, p[15]
        _mirror(h)
    return 0.5 * (
        along * g_a + e_v * g_v + e_vc * g_vc + cross * g_c + turned * g_t + e_w * g_w + e_wc * g_wc
    )  # fmt: skip


@compiled_only
def _mirror(h):  # type: ignore[no-untyped-def]
    """Copy the upper triangle of a matrix (7, 7) to the lower one."""
    for i in range(1, 7):
        for j in range(i):
            h[7 * i + j] = h[7 * j + i]


@compiled_only
def _backwards(work, horizon):  # type: ignore[no-untyped-def]
    """Find the steps and the feedback of all nodes; return by how much the quadratic model says that the cost falls."""
    _tail(work, horizon, node_of(work, horizon).plan, True)
    promised = 0.0
    for k in range(horizon - 1, -1, -1):
        p_v = node_of(work, k - 1).plan.v_c if k > 0 else work.before_v
        p_w = node_of(work, k - 1).plan.w_c if k > 0 else work.before_w
        node, period = node_of(work, k), work.fixed.after.own + work.fixed.after.given
        if k < horizon - 1:
            _add_place(work, node.to, node_of(work, k + 1).plan)
        _add_discs(work, (k + 1) * period, node_of(work, k + 1).plan)
        _expand(work, node, p_v, p_w)
        promised += _improve(work, node, p_v, p_w)
    return promised


@compiled_only
def _add_place(work, to, after):  # type: ignore[no-untyped-def]
    """Add the cost of the place at the end of a period to the cost to go from there."""
    along, cross, turned, slope = _errors(to, after.x, after.y, after.heading)
    cos, sin, g, h, weights = to.cos, to.sin, work.gradient, work.hessian, work.fixed.weights
    q_a, q_c, q_t = weights.along, weights.cross, weights.turned
    g[0] += cos * q_a * along - sin * q_c * cross
    g[1] += sin * q_a * along + cos * q_c * cross
    g[2] += q_t * turned * slope
    h[0] += cos * cos * q_a + sin * sin * q_c
    h[1] += cos * sin * (q_a - q_c)
    h[7] = h[1]
    h[8] += sin * sin * q_a + cos * cos * q_c
    h[16] += q_t * slope * slope


@compiled_only
def _into(disc, time, x, y):  # type: ignore[no-untyped-def]
    """How far [m] a place is inside of a disc after a ``time`` [s], and the direction to it from the disc's middle."""
    dx, dy = x - disc.x - disc.v_x * time, y - disc.y - disc.v_y * time
    away = max(np.sqrt(dx * dx + dy * dy), _MIDDLE)
    return disc.radius - away, dx / away, dy / away


@compiled_only
def _within_discs(around, time, x, y):  # type: ignore[no-untyped-def]
    """What it costs to be at a place after a ``time`` [s]: ½ weight (r − d)² for each disc that it is in."""
    cost = 0.0
    for n in range(int(around.count)):
        deep, _, _ = _into(disc_of(around, n), time, x, y)
        if deep > 0:
            cost += 0.5 * around.weight * deep * deep
    return cost


@compiled_only
def _add_discs(work, time, after):  # type: ignore[no-untyped-def]
    """Add that to the cost to go, with the Hessian of Gauss and Newton."""
    g, h, around = work.gradient, work.hessian, work.around
    for n in range(int(around.count)):
        deep, n_x, n_y = _into(disc_of(around, n), time, after.x, after.y)
        if deep > 0:
            g[0] -= around.weight * deep * n_x
            g[1] -= around.weight * deep * n_y
            h[0] += around.weight * n_x * n_x
            h[1] += around.weight * n_x * n_y
            h[7] = h[1]
            h[8] += around.weight * n_y * n_y


@compiled_only
def _slopes(after, a, sin, cos, distance):  # type: ignore[no-untyped-def]
    """Write the derivatives of x and of y after a period by (ψ, v, ω, v_c, ω_c); the others are constants."""
    own, given, own_half, given_half = after.own, after.given, after.own_half, after.given_half
    a[0], a[1], a[2] = -distance * sin, own * cos, -distance * sin * own_half
    a[3], a[4] = given * cos, -distance * sin * given_half
    a[5], a[6], a[7] = distance * cos, own * sin, distance * cos * own_half
    a[8], a[9] = given * sin, distance * cos * given_half


@compiled_only
def _expand(work, node, p_v, p_w):  # type: ignore[no-untyped-def]
    """Carry the cost to go back over a period, as a quadratic function of z, p and u.

    Its parts by (z, p) replace the cost to go, gradient and Hessian.
    """
    plan, to, after, weights = node.plan, node.to, work.fixed.after, work.fixed.weights
    g, h, a, m, n = work.gradient, work.hessian, work.slopes, work.hessian_a, work.hessian_b
    qu, quu, qux = work.by_u, work.by_uu, work.by_ux
    sin, cos, distance = plan.sin, plan.cos, plan.distance
    decay, own, given, new = after.decay, after.own, after.given, 1 - after.decay
    _slopes(after, a, sin, cos, distance)
    for i in range(5):
        h0, h1, h2, h3, h4 = h[7 * i], h[7 * i + 1], h[7 * i + 2], h[7 * i + 3], h[7 * i + 4]
        m[5 * i], m[5 * i + 1], m[5 * i + 2] = h0, h1, h0 * a[0] + h1 * a[5] + h2
        m[5 * i + 3] = h0 * a[1] + h1 * a[6] + decay * h3
        m[5 * i + 4] = h0 * a[2] + h1 * a[7] + own * h2 + decay * h4
        n[2 * i] = h0 * a[3] + h1 * a[8] + new * h3 + h[7 * i + 5]
        n[2 * i + 1] = h0 * a[4] + h1 * a[9] + given * h2 + new * h4 + h[7 * i + 6]
    d_v, d_w = weights.change_v, weights.change_w
    u_v, u_w = plan.v_c, plan.w_c
    change_v, change_w = d_v * (u_v - p_v), d_w * (u_w - p_w)
    r_v, r_w = weights.deviation_v, weights.deviation_w
    qu[0] = g[0] * a[3] + g[1] * a[8] + new * g[3] + g[5] + change_v + r_v * (u_v - to.v)
    qu[1] = g[0] * a[4] + g[1] * a[9] + given * g[2] + new * g[4] + g[6] + change_w + r_w * (u_w - to.w)
    # B'(H_zz B + H_zp) + H_pz B + H_pp, and what the command itself costs
    quu[0] = a[3] * (n[0] + h[5]) + a[8] * (n[2] + h[12]) + new * (n[6] + h[26]) + h[40] + r_v + d_v
    quu[1] = a[3] * n[1] + a[8] * n[3] + new * n[7] + h[5] * a[4] + h[12] * a[9] + given * h[19] + new * h[33] + h[41]
    quu[2] = (
        a[4] * (n[1] + h[6]) + a[9] * (n[3] + h[13]) + given * (n[5] + h[20]) + new * (n[9] + h[34]) + h[48] + r_w + d_w
    )
    for j in range(2):
        n0, n1 = n[j], n[2 + j]
        row = 7 * j
        qux[row], qux[row + 1], qux[row + 2] = n0, n1, n0 * a[0] + n1 * a[5] + n[4 + j]
        qux[row + 3] = n0 * a[1] + n1 * a[6] + decay * n[6 + j]
        qux[row + 4] = n0 * a[2] + n1 * a[7] + own * n[4 + j] + decay * n[8 + j]
        qux[row + 5] = -d_v if j == 0 else 0.0
        qux[row + 6] = -d_w if j == 1 else 0.0
    pull, aside = _bend(work, cos, sin, distance) if work.exact > 0 else (0.0, 0.0)
    # A' g and A' H A; neither depends on p but for the change of the command
    g[4] = g[0] * a[2] + g[1] * a[7] + own * g[2] + decay * g[4]
    g[3] = g[0] * a[1] + g[1] * a[6] + decay * g[3]
    g[2] = g[0] * a[0] + g[1] * a[5] + g[2]
    g[5], g[6] = -change_v, -change_w
    for j in range(5):
        m0, m1, m2 = m[j], m[5 + j], m[10 + j]
        h[j], h[7 + j], h[14 + j] = m0, m1, m0 * a[0] + m1 * a[5] + m2
        h[21 + j] = m0 * a[1] + m1 * a[6] + decay * m[15 + j]
        h[28 + j] = m0 * a[2] + m1 * a[7] + own * m2 + decay * m[20 + j]
    half = after.own_half
    h[16] -= pull
    h[17] += aside * own
    h[18] -= pull * half
    h[25] += aside * own * half
    h[32] -= pull * half * half
    h[23], h[30], h[31] = h[17], h[18], h[25]
    for i in range(5):
        h[7 * i + 5], h[7 * i + 6] = 0.0, 0.0
    h[40], h[41], h[48] = d_v, 0.0, d_w


@compiled_only
def _bend(work, cos, sin, distance):  # type: ignore[no-untyped-def]
    """Add the curvature of the motion to the model in u, if that stays convex; return its two numbers, or 0 and 0.

    It is (x, y)'' = distance (cos, sin)(heading at half time)'' with the two being linear in z and u.
    """
    after, quu, qux = work.fixed.after, work.by_uu, work.by_ux
    g_x, g_y = work.gradient[0], work.gradient[1]
    pull, aside = distance * (g_x * cos + g_y * sin), g_y * cos - g_x * sin
    own, given, half, given_half = after.own, after.given, after.own_half, after.given_half
    b = quu[1] + aside * given * given_half
    c = quu[2] - pull * given_half * given_half
    if not (c > 0 and quu[0] * c - b * b > _CONVEX * quu[0] * c):
        return 0.0, 0.0
    quu[1], quu[2] = b, c
    qux[2] += aside * given
    qux[4] += aside * given * half
    qux[9] -= pull * given_half
    qux[10] += aside * own * given_half
    qux[11] -= pull * given_half * half
    return pull, aside


@compiled_only
def _improve(work, node, p_v, p_w):  # type: ignore[no-untyped-def]
    """Find the step and the feedback of a node, and the cost to go before it; return by how much that falls.

    It is not-a-number where the model in u is not convex, as the exact Hessians of later nodes may make it.
    """
    fixed, low, high, feedback, qux = work.fixed, work.low, work.high, node.feedback, work.by_ux
    half, u_v, u_w = fixed.half_axle, node.plan.v_c, node.plan.w_c
    bound(low, high, fixed.tops, fixed.rates, half, u_v, u_w, p_v, p_w)
    a, b, c = work.by_uu[0], work.by_uu[1], work.by_uu[2]
    g_v, g_w = work.by_u[0], work.by_u[1]
    if not (a > 0 and a * c - b * b > 0):
        return np.nan
    v, w, first, second = best_change(low, high, half, a, b, c, g_v, g_w)
    node.step_v, node.step_w = v, w
    if first < 0:
        det = a * c - b * b
        for n in range(7):
            feedback[n] = (b * qux[7 + n] - c * qux[n]) / det
            feedback[7 + n] = (b * qux[n] - a * qux[7 + n]) / det
    elif second < 0:
        _feed_edge(feedback, qux, a, b, c, half, first // 2, _moves(fixed, first, p_v, p_w))
    else:
        moves = _moves(fixed, first, p_v, p_w), _moves(fixed, second, p_v, p_w)
        _feed_corner(feedback, half, first // 2, second // 2, moves[0], moves[1])
    _close(work, feedback, v, w)
    return -(g_v * v + g_w * w + 0.5 * (a * v * v + 2 * b * v * w + c * w * w))


@compiled_only
def _moves(fixed, side, p_v, p_w):  # type: ignore[no-untyped-def]
    """1 where a bound is one of the change from the command before, and moves with it; 0 where it is a limit itself."""
    strip = side // 2
    n_v, n_w = normal(strip, fixed.half_axle)
    before, top, rate = n_v * p_v + n_w * p_w, fixed.tops[strip], fixed.rates[strip]
    if side % 2 == 0:
        return 1.0 if before - rate > -top else 0.0
    return 1.0 if before + rate < top else 0.0


@compiled_only
def _feed_edge(feedback, qux, a, b, c, half, strip, moves):  # type: ignore[no-untyped-def]
    """The feedback of a command on an edge: along it the best one, across it as the edge moves with p."""
    n_v, n_w = normal(strip, half)
    size = n_v * n_v + n_w * n_w
    t_v, t_w = -n_w, n_v
    curvature = a * t_v * t_v + 2 * b * t_v * t_w + c * t_w * t_w
    bent = (t_v * (a * n_v + b * n_w) + t_w * (b * n_v + c * n_w)) / size
    for n in range(7):
        across = moves * (n_v if n == 5 else n_w if n == 6 else 0.0)
        s = -(t_v * qux[n] + t_w * qux[7 + n] + bent * across) / curvature
        feedback[n] = n_v / size * across + s * t_v
        feedback[7 + n] = n_w / size * across + s * t_w


@compiled_only
def _feed_corner(feedback, half, strip, other, moves, other_moves):  # type: ignore[no-untyped-def]
    """The feedback of a command in a corner, which moves with p as its two edges do."""
    n_v, n_w = normal(strip, half)
    m_v, m_w = normal(other, half)
    det = n_v * m_w - n_w * m_v
    for n in range(5):
        feedback[n], feedback[7 + n] = 0.0, 0.0
    for n in range(2):
        first = moves * (n_v if n == 0 else n_w)
        second = other_moves * (m_v if n == 0 else m_w)
        feedback[5 + n] = (first * m_w - second * n_w) / det
        feedback[12 + n] = (n_v * second - m_v * first) / det


@compiled_only
def _close(work, feedback, v, w):  # type: ignore[no-untyped-def]
    """Put the step (v, ω) and the feedback into the cost to go, which then is one of (z, p) alone."""
    g, h, k, qu, quu, qux = work.gradient, work.hessian, work.closed, work.by_u, work.by_uu, work.by_ux
    a, b, c = quu[0], quu[1], quu[2]
    left_v, left_w = qu[0] + a * v + b * w, qu[1] + b * v + c * w  # 0 where nothing is bounded
    for n in range(7):
        f_v, f_w = feedback[n], feedback[7 + n]
        g[n] += f_v * left_v + f_w * left_w + qux[n] * v + qux[7 + n] * w
        k[n], k[7 + n] = a * f_v + b * f_w + qux[n], b * f_v + c * f_w + qux[7 + n]
    for i in range(7):
        for j in range(i, 7):
            h[7 * i + j] += (
                feedback[i] * k[j] + feedback[7 + i] * k[7 + j] + qux[i] * feedback[j] + qux[7 + i] * feedback[7 + j]
            )
    _mirror(h)
