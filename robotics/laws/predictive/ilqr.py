"""The solver: iterative linear-quadratic regulation with bounds of the commands and of their change.

The state of the problem is z = (x, y, ψ, v, ω) and the command before, p = (v_c, ω_c); the command u = (v_c, ω_c) of
a period is bounded by itself and by p (:mod:`robotics.laws.predictive.allowed`). With the reference's place at the end
of period k, and the command u_r with which a robot would follow it,

    J = Σ_k ½ [ |(along, cross, 2 sin(ψ_e/2))|²_Q + |u − u_r|²_R + |u − p|²_D ]  +  ½ |terminal errors|²_P

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

from fuzzy.compiled.jit import inner
from fuzzy.compiled.trigonometry import sincos
from robotics.laws.predictive.allowed import STRIPS, best_change, bound, normal
from robotics.laws.predictive.model import moved

# Places in work. First what does not change within a period, which a law gives in this order:
DECAY, OWN, GIVEN, OWN_HALF, GIVEN_HALF = range(5)  # as of robotics.laws.predictive.model.Response
ALONG, CROSS, TURNED, DEVIATION_V, DEVIATION_W, CHANGE_V, CHANGE_W = range(5, 12)  # the diagonals of Q, R, D
HALF_AXLE = 12
TOPS, RATES = 13, 17  # of the strips, (4,) each: m/s, rad/s, m/s, m/s
FIXED = 21
FROM_V, FROM_W = 21, 22  # the command before the first
STATE = 23  # (5,) when the first command begins to act
AT_END_V, AT_END_W = 28, 29  # the reference's velocities at the end: m/s, rad/s
TAIL = 30  # (16,) P: of (along, v, v_c) six numbers, of (cross, 2 sin(ψ_e/2), ω, ω_c) ten, the upper triangles by rows
TAIL_NUMBERS = 16
COST, COUNT = 46, 47  # what was found: the cost, and the number of iterations
_LOW, _HIGH = 48, 52  # the bounds of the strips
GRADIENT, _H = 56, 63  # the cost to go: its gradient (7,) by (z, p), its Hessian (7, 7)
_A = 112  # the model's derivatives: of (x, y) by (ψ, v, ω, v_c, ω_c) two rows of five
_M, _N = 122, 147  # H A (5, 5), H B (5, 2)
_QU, _QUU, _QUX, _W = 157, 159, 162, 176  # of u: (2,), (3,), by (z, p) (2, 7); Quu K + Qux (2, 7)
_NEW = 190  # (7, 7)
_EXACT = 239
NODES = 240
# What belongs to a period, one row after the other: where the reference is at its end, and the command with which a
# robot follows it; the plan and the state at its begin; those that are tried; and the feedback
TO_X, TO_Y, TO_HEADING, TO_COS, TO_SIN, TO_V, TO_W = range(7)
PLAN, _TRIED = 7, 17
_X, _Y, _HEADING, _V, _WW, V_C, W_C, _DISTANCE, _SIN, _COS = range(10)  # places in PLAN and in _TRIED
_STEP, _FEEDBACK = 27, 29  # (2,), (2, 7)
NODE = 43
_KX, _KY, _KPSI, _CATCH_UP = 1.0, 10.0, 5.0, 0.3  # 1/s, 1/m², 1/m, m/s: as robotics.laws.tracking.lyapunov.Lyapunov
HALVINGS = 8  # of the step, before a plan is left as it is
_NEAR = 0.1  # of the cost: where a full step brings less, the next one is made with the exact Hessian
_CONVEX = 1e-6  # of the product of its diagonal: the least determinant of a Hessian that counts as convex
_ENOUGH = 1e-4  # of the fall that the quadratic model promises: what a step must bring (Armijo)


def working(horizon: int) -> int:
    """How many numbers a problem of ``horizon`` periods is solved in."""
    return NODES + NODE * (horizon + 1)


@inner
def solve(work, horizon, iterations, tolerance):  # type: ignore[no-untyped-def]
    """Improve the plan in ``work``, whose commands need not be allowed or known, and leave it, COST and COUNT there.

    It ends after a number of ``iterations``, or where the quadratic model promises less than a ``tolerance`` of the
    cost, or no step brings any.
    """
    for k in range(horizon):
        plan = NODES + NODE * k + PLAN
        work[plan + _X] = np.nan  # there is no plan to be near to
    cost = _roll(work, horizon, 0.0)
    _take(work, horizon)
    work[COUNT], work[_EXACT] = 0.0, 0.0
    while work[COUNT] < iterations:
        promised = _backwards(work, horizon)
        if work[_EXACT] > 0 and not promised > 0:
            work[_EXACT] = 0.0
            promised = _backwards(work, horizon)
        if not promised > tolerance * cost:
            break
        work[COUNT] += 1
        step, tried = _search(work, horizon, cost, promised)
        if step > 0:
            _take(work, horizon)
        elif work[_EXACT] == 0:
            break
        # Near the end only: far from it the exact Hessian leads to worse plans.
        work[_EXACT] = 1.0 if step == 1 and cost - tried < _NEAR * cost else 0.0
        cost = tried
    work[COST] = cost


@inner
def _search(work, horizon, cost, promised):  # type: ignore[no-untyped-def]
    """Halve the step until the cost falls by enough; return it and the cost then, or 0 and the cost as it was."""
    step = 1.0
    for _ in range(HALVINGS):
        tried = _roll(work, horizon, step)
        if cost - tried > _ENOUGH * step * promised:
            return step, tried
        step *= 0.5
    return 0.0, cost


@inner
def _take(work, horizon):  # type: ignore[no-untyped-def]
    """Make the plan of what was tried."""
    for k in range(horizon + 1):
        at = NODES + NODE * k
        for n in range(_TRIED - PLAN):
            work[at + PLAN + n] = work[at + _TRIED + n]


@inner
def _roll(work, horizon, step):  # type: ignore[no-untyped-def]
    """Simulate the plan with a share ``step`` of its improvement and its feedback; return its cost.

    Where a node has no state to feed back, the command is the plan's, or the Lyapunov law's. It is the nearest allowed
    one in any case.
    """
    x, y, heading, v, w = work[STATE], work[STATE + 1], work[STATE + 2], work[STATE + 3], work[STATE + 4]
    v_c, w_c = work[FROM_V], work[FROM_W]
    half, tops, rates = work[HALF_AXLE], work[TOPS : TOPS + STRIPS], work[RATES : RATES + STRIPS]
    low, high = work[_LOW : _LOW + STRIPS], work[_HIGH : _HIGH + STRIPS]
    cost = 0.0
    for k in range(horizon):
        at = NODES + NODE * k
        from_v, from_w = v_c, w_c
        v_c, w_c = _fed_back(work, at, step, x, y, heading, v, w, from_v, from_w)
        bound(low, high, tops, rates, half, from_v, from_w, from_v, from_w)
        g_v, g_w = from_v - v_c, half * half * (from_w - w_c)  # the nearest one by the speeds of the wheels
        change_v, change_w, _, _ = best_change(low, high, half, 1.0, 0.0, half * half, g_v, g_w)
        v_c, w_c = from_v + change_v, from_w + change_w
        tried = at + _TRIED
        work[tried + _X], work[tried + _Y], work[tried + _HEADING] = x, y, heading
        work[tried + _V], work[tried + _WW], work[tried + V_C], work[tried + W_C] = v, w, v_c, w_c
        x, y, heading, v, w, distance, sin, cos = moved(
            x, y, heading, v, w, v_c, w_c, work[DECAY], work[OWN], work[GIVEN], work[OWN_HALF], work[GIVEN_HALF]
        )
        work[tried + _DISTANCE], work[tried + _SIN], work[tried + _COS] = distance, sin, cos
        off_v, off_w = v_c - work[at + TO_V], w_c - work[at + TO_W]
        cost += 0.5 * (work[DEVIATION_V] * off_v * off_v + work[DEVIATION_W] * off_w * off_w)
        cost += 0.5 * (work[CHANGE_V] * change_v * change_v + work[CHANGE_W] * change_w * change_w)
        if k < horizon - 1:
            along, cross, turned, _ = _errors(work, at, x, y, heading)
            cost += 0.5 * (work[ALONG] * along**2 + work[CROSS] * cross**2 + work[TURNED] * turned**2)
    last = NODES + NODE * horizon + _TRIED
    work[last + _X], work[last + _Y], work[last + _HEADING] = x, y, heading
    work[last + _V], work[last + _WW], work[last + V_C], work[last + W_C] = v, w, v_c, w_c
    return cost + _tail(work, horizon, _TRIED, False)


@inner
def _fed_back(work, at, step, x, y, heading, v, w, from_v, from_w):  # type: ignore[no-untyped-def]
    """The command of the node ``at``: the plan's, a share of its improvement, and the feedback of where a robot is."""
    plan, feedback = at + PLAN, at + _FEEDBACK
    v_c, w_c = work[plan + V_C], work[plan + W_C]
    if np.isnan(v_c):
        return _led(work, at, x, y, heading)
    if np.isnan(work[plan + _X]):
        return v_c, w_c
    before = plan - NODE  # of the first node the rows before it hold no plan
    p_v = work[before + V_C] if at > NODES else work[FROM_V]
    p_w = work[before + W_C] if at > NODES else work[FROM_W]
    off = (
        x - work[plan + _X], y - work[plan + _Y], heading - work[plan + _HEADING],
        v - work[plan + _V], w - work[plan + _WW], from_v - p_v, from_w - p_w,
    )  # fmt: skip
    v_c += step * work[at + _STEP]
    w_c += step * work[at + _STEP + 1]
    for n in range(7):
        v_c += work[feedback + n] * off[n]
        w_c += work[feedback + 7 + n] * off[n]
    return v_c, w_c


@inner
def _led(work, at, x, y, heading):  # type: ignore[no-untyped-def]
    """The command of the Lyapunov law towards the reference at the begin of the period of the node ``at``."""
    v_r, w_r, period = work[at + TO_V], work[at + TO_W], work[OWN] + work[GIVEN]
    dx = work[at + TO_X] - period * v_r * work[at + TO_COS] - x
    dy = work[at + TO_Y] - period * v_r * work[at + TO_SIN] - y
    sin, cos = sincos(heading)
    sin_e, cos_e = sincos(work[at + TO_HEADING] - period * w_r - heading)
    v = v_r * cos_e + _KX * (cos * dx + sin * dy)
    speed = max(abs(v_r), min(abs(v), _CATCH_UP))
    return v, w_r + speed * (_KY * (cos * dy - sin * dx) + _KPSI * sin_e)


@inner
def _errors(work, at, x, y, heading):  # type: ignore[no-untyped-def]
    """What a posture is off the reference of a node: along and across it [m], 2 sin(ψ_e/2), and that one's slope."""
    dx, dy = x - work[at + TO_X], y - work[at + TO_Y]
    cos, sin = work[at + TO_COS], work[at + TO_SIN]
    half_sin, half_cos = sincos(0.5 * (heading - work[at + TO_HEADING]))
    return cos * dx + sin * dy, cos * dy - sin * dx, 2 * half_sin, half_cos


@inner
def _tail(work, horizon, of, derive):  # type: ignore[no-untyped-def]
    """The terminal cost of what is in the rows ``of`` of the last node; if ``derive``, its derivatives are written."""
    node, last = NODES + NODE * horizon, NODES + NODE * horizon + of
    at = node - NODE
    along, cross, turned, slope = _errors(work, at, work[last + _X], work[last + _Y], work[last + _HEADING])
    e_v, e_w = work[last + _V] - work[AT_END_V], work[last + _WW] - work[AT_END_W]
    e_vc, e_wc = work[last + V_C] - work[node + TO_V], work[last + W_C] - work[node + TO_W]
    p = work[TAIL : TAIL + TAIL_NUMBERS]
    g_a = p[0] * along + p[1] * e_v + p[2] * e_vc
    g_v = p[1] * along + p[3] * e_v + p[4] * e_vc
    g_vc = p[2] * along + p[4] * e_v + p[5] * e_vc
    g_c = p[6] * cross + p[7] * turned + p[8] * e_w + p[9] * e_wc
    g_t = p[7] * cross + p[10] * turned + p[11] * e_w + p[12] * e_wc
    g_w = p[8] * cross + p[11] * turned + p[13] * e_w + p[14] * e_wc
    g_wc = p[9] * cross + p[12] * turned + p[14] * e_w + p[15] * e_wc
    if derive:
        cos, sin = work[at + TO_COS], work[at + TO_SIN]
        g, h = work[GRADIENT : GRADIENT + 7], work[_H : _H + 49]
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


@inner
def _mirror(h):  # type: ignore[no-untyped-def]
    """Copy the upper triangle of a matrix (7, 7) to the lower one."""
    for i in range(1, 7):
        for j in range(i):
            h[7 * i + j] = h[7 * j + i]


@inner
def _backwards(work, horizon):  # type: ignore[no-untyped-def]
    """Find the steps and the feedback of all nodes; return by how much the quadratic model says that the cost falls."""
    _tail(work, horizon, PLAN, True)
    promised = 0.0
    for k in range(horizon - 1, -1, -1):
        at = NODES + NODE * k
        before = at + PLAN - NODE
        p_v = work[before + V_C] if k > 0 else work[FROM_V]
        p_w = work[before + W_C] if k > 0 else work[FROM_W]
        if k < horizon - 1:
            _add_place(work, at)
        _expand(work, at, p_v, p_w)
        promised += _improve(work, at, p_v, p_w)
    return promised


@inner
def _add_place(work, at):  # type: ignore[no-untyped-def]
    """Add the cost of the place at the end of a period to the cost to go from there."""
    after = at + NODE + PLAN
    along, cross, turned, slope = _errors(work, at, work[after + _X], work[after + _Y], work[after + _HEADING])
    cos, sin = work[at + TO_COS], work[at + TO_SIN]
    q_a, q_c, q_t = work[ALONG], work[CROSS], work[TURNED]
    work[GRADIENT] += cos * q_a * along - sin * q_c * cross
    work[GRADIENT + 1] += sin * q_a * along + cos * q_c * cross
    work[GRADIENT + 2] += q_t * turned * slope
    work[_H] += cos * cos * q_a + sin * sin * q_c
    work[_H + 1] += cos * sin * (q_a - q_c)
    work[_H + 7] = work[_H + 1]
    work[_H + 8] += sin * sin * q_a + cos * cos * q_c
    work[_H + 16] += q_t * slope * slope


@inner
def _slopes(work, a, sin, cos, distance):  # type: ignore[no-untyped-def]
    """Write the derivatives of x and of y after a period by (ψ, v, ω, v_c, ω_c); the others are constants."""
    own_half, given_half = work[OWN_HALF], work[GIVEN_HALF]
    a[0], a[1], a[2] = -distance * sin, work[OWN] * cos, -distance * sin * own_half
    a[3], a[4] = work[GIVEN] * cos, -distance * sin * given_half
    a[5], a[6], a[7] = distance * cos, work[OWN] * sin, distance * cos * own_half
    a[8], a[9] = work[GIVEN] * sin, distance * cos * given_half


@inner
def _expand(work, at, p_v, p_w):  # type: ignore[no-untyped-def]
    """Carry the cost to go back over a period, as a quadratic function of z, p and u.

    Its parts by (z, p) replace the cost to go: the gradient at GRADIENT, the Hessian at _H.
    """
    plan = at + PLAN
    g, h, a, m, n = (
        work[GRADIENT : GRADIENT + 7],
        work[_H : _H + 49],
        work[_A : _A + 10],
        work[_M : _M + 25],
        work[_N : _N + 10],
    )
    qu, quu, qux = work[_QU : _QU + 2], work[_QUU : _QUU + 3], work[_QUX : _QUX + 14]
    sin, cos, distance = work[plan + _SIN], work[plan + _COS], work[plan + _DISTANCE]
    decay, own, given, new = work[DECAY], work[OWN], work[GIVEN], 1 - work[DECAY]
    _slopes(work, a, sin, cos, distance)
    for i in range(5):
        h0, h1, h2, h3, h4 = h[7 * i], h[7 * i + 1], h[7 * i + 2], h[7 * i + 3], h[7 * i + 4]
        m[5 * i], m[5 * i + 1], m[5 * i + 2] = h0, h1, h0 * a[0] + h1 * a[5] + h2
        m[5 * i + 3] = h0 * a[1] + h1 * a[6] + decay * h3
        m[5 * i + 4] = h0 * a[2] + h1 * a[7] + own * h2 + decay * h4
        n[2 * i] = h0 * a[3] + h1 * a[8] + new * h3 + h[7 * i + 5]
        n[2 * i + 1] = h0 * a[4] + h1 * a[9] + given * h2 + new * h4 + h[7 * i + 6]
    d_v, d_w = work[CHANGE_V], work[CHANGE_W]
    u_v, u_w = work[plan + V_C], work[plan + W_C]
    change_v, change_w = d_v * (u_v - p_v), d_w * (u_w - p_w)
    r_v, r_w = work[DEVIATION_V], work[DEVIATION_W]
    qu[0] = g[0] * a[3] + g[1] * a[8] + new * g[3] + g[5] + change_v + r_v * (u_v - work[at + TO_V])
    qu[1] = g[0] * a[4] + g[1] * a[9] + given * g[2] + new * g[4] + g[6] + change_w + r_w * (u_w - work[at + TO_W])
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
    pull, aside = _bend(work, cos, sin, distance) if work[_EXACT] > 0 else (0.0, 0.0)
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
    half = work[OWN_HALF]
    h[16] -= pull
    h[17] += aside * own
    h[18] -= pull * half
    h[25] += aside * own * half
    h[32] -= pull * half * half
    h[23], h[30], h[31] = h[17], h[18], h[25]
    for i in range(5):
        h[7 * i + 5], h[7 * i + 6] = 0.0, 0.0
    h[40], h[41], h[48] = d_v, 0.0, d_w


@inner
def _bend(work, cos, sin, distance):  # type: ignore[no-untyped-def]
    """Add the curvature of the motion to the model in u, if that stays convex; return its two numbers, or 0 and 0.

    It is (x, y)'' = distance (cos, sin)(heading at half time)'' with the two being linear in z and u.
    """
    g_x, g_y = work[GRADIENT], work[GRADIENT + 1]
    pull, aside = distance * (g_x * cos + g_y * sin), g_y * cos - g_x * sin
    own, given, half, given_half = work[OWN], work[GIVEN], work[OWN_HALF], work[GIVEN_HALF]
    b = work[_QUU + 1] + aside * given * given_half
    c = work[_QUU + 2] - pull * given_half * given_half
    if not (c > 0 and work[_QUU] * c - b * b > _CONVEX * work[_QUU] * c):
        return 0.0, 0.0
    work[_QUU + 1], work[_QUU + 2] = b, c
    work[_QUX + 2] += aside * given
    work[_QUX + 4] += aside * given * half
    work[_QUX + 9] -= pull * given_half
    work[_QUX + 10] += aside * own * given_half
    work[_QUX + 11] -= pull * given_half * half
    return pull, aside


@inner
def _improve(work, at, p_v, p_w):  # type: ignore[no-untyped-def]
    """Find the step and the feedback of a node, and the cost to go before it; return by how much that falls.

    It is not-a-number where the model in u is not convex, as the exact Hessians of later nodes may make it.
    """
    plan, half = at + PLAN, work[HALF_AXLE]
    low, high, rates = work[_LOW : _LOW + STRIPS], work[_HIGH : _HIGH + STRIPS], work[RATES : RATES + STRIPS]
    u_v, u_w = work[plan + V_C], work[plan + W_C]
    bound(low, high, work[TOPS : TOPS + STRIPS], rates, half, u_v, u_w, p_v, p_w)
    a, b, c = work[_QUU], work[_QUU + 1], work[_QUU + 2]
    g_v, g_w = work[_QU], work[_QU + 1]
    if not (a > 0 and a * c - b * b > 0):
        return np.nan
    v, w, first, second = best_change(low, high, half, a, b, c, g_v, g_w)
    work[at + _STEP], work[at + _STEP + 1] = v, w
    feedback, qux = work[at + _FEEDBACK : at + _FEEDBACK + 14], work[_QUX : _QUX + 14]
    if first < 0:
        det = a * c - b * b
        for n in range(7):
            feedback[n] = (b * qux[7 + n] - c * qux[n]) / det
            feedback[7 + n] = (b * qux[n] - a * qux[7 + n]) / det
    elif second < 0:
        _feed_edge(feedback, qux, a, b, c, half, first // 2, _moves(work, first, u_v, u_w, p_v, p_w))
    else:
        moves = _moves(work, first, u_v, u_w, p_v, p_w), _moves(work, second, u_v, u_w, p_v, p_w)
        _feed_corner(feedback, half, first // 2, second // 2, moves[0], moves[1])
    _close(work, feedback, v, w)
    return -(g_v * v + g_w * w + 0.5 * (a * v * v + 2 * b * v * w + c * w * w))


@inner
def _moves(work, side, u_v, u_w, p_v, p_w):  # type: ignore[no-untyped-def]
    """1 where a bound is one of the change from the command before, and moves with it; 0 where it is a limit itself."""
    strip = side // 2
    n_v, n_w = normal(strip, work[HALF_AXLE])
    before, top, rate = n_v * p_v + n_w * p_w, work[TOPS + strip], work[RATES + strip]
    if side % 2 == 0:
        return 1.0 if before - rate > -top else 0.0
    return 1.0 if before + rate < top else 0.0


@inner
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


@inner
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


@inner
def _close(work, feedback, v, w):  # type: ignore[no-untyped-def]
    """Put the step (v, ω) and the feedback into the cost to go, which then is one of (z, p) alone."""
    g, h, k, qux = work[GRADIENT : GRADIENT + 7], work[_H : _H + 49], work[_W : _W + 14], work[_QUX : _QUX + 14]
    a, b, c = work[_QUU], work[_QUU + 1], work[_QUU + 2]
    left_v, left_w = work[_QU] + a * v + b * w, work[_QU + 1] + b * v + c * w  # 0 where nothing is bounded
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
