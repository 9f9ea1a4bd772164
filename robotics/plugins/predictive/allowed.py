"""Which commands a robot may be given after another, and the best of them.

A command (v, ω) is bounded in four directions n, each by a strip  low <= n·(v, ω) <= high:

    n = (1, 0): the speed,  (0, 1): the turn rate,  (1, L) and (1, −L): the right and the left wheel

In each of them n·(v, ω) is bounded by a limit of its own, and by how far it may be from that of the command before. In
wheel speeds the last two are a box; with a bound of v or of ω it is an octagon at most. A quadratic function of two
numbers has its least value in it inside, on an edge or at a corner: what the projected Newton step looks for [Tassa,
Mansard & Todorov 2014] is found by trying every edge that the free minimum violates.
"""

import math

from fuzzy.compiled.jit import compiled_only

STRIPS = 4
_ROUNDING = 1e-12  # m/s, rad/s


@compiled_only
def normal(strip, half_axle):  # type: ignore[no-untyped-def]
    """The direction n of a strip: its parts for v and for ω."""
    if strip == 0:
        return 1.0, 0.0
    if strip == 1:
        return 0.0, 1.0
    return 1.0, half_axle if strip == 2 else -half_axle


@compiled_only
def bound(low, high, tops, rates, half_axle, v, w, from_v, from_w):  # type: ignore[no-untyped-def]
    """Write the bounds of the strips (4,) for a change of the command (v, ω); the one before is (from_v, from_w).

    ``tops`` and ``rates`` (4,) are the limits of n·(v, ω) and of its change from the command before.
    """
    for n in range(STRIPS):
        n_v, n_w = normal(n, half_axle)
        here, before = n_v * v + n_w * w, n_v * from_v + n_w * from_w
        low[n] = max(-tops[n], before - rates[n]) - here
        high[n] = min(tops[n], before + rates[n]) - here


@compiled_only
def best_change(low, high, half_axle, a, b, c, g_v, g_w):  # type: ignore[no-untyped-def]
    """The least value of ½ (a v² + 2 b v ω + c ω²) + g_v v + g_w ω within the strips, and the bounds that it is at.

    Returns v, ω and two bounds, each 2 · strip, and 1 more for the high one; −1: none. Where rounding leaves nothing,
    as 0 is within the strips, it is 0.
    """
    det = a * c - b * b
    free_v, free_w = (b * g_w - c * g_v) / det, (b * g_v - a * g_w) / det
    least, v, w, first, second = math.inf, 0.0, 0.0, -1, -1
    is_free = True
    for n in range(STRIPS):
        n_v, n_w = normal(n, half_axle)
        there = n_v * free_v + n_w * free_w
        if low[n] <= there <= high[n]:
            continue
        is_free = False
        side = 1 if there > high[n] else 0
        to = (high[n] if side > 0 else low[n]) / (n_v * n_v + n_w * n_w)
        at_v, at_w = n_v * to, n_w * to
        s, corner = _along(low, high, half_axle, n, at_v, at_w, a, b, c, g_v, g_w)
        e_v, e_w = at_v - s * n_w, at_w + s * n_v
        value = 0.5 * (a * e_v * e_v + 2 * b * e_v * e_w + c * e_w * e_w) + g_v * e_v + g_w * e_w
        if value < least:
            least, v, w, first, second = value, e_v, e_w, 2 * n + side, corner
    if is_free:
        return free_v, free_w, -1, -1
    return v, w, first, second


@compiled_only
def _along(low, high, half_axle, strip, at_v, at_w, a, b, c, g_v, g_w):  # type: ignore[no-untyped-def]
    """The best place on the edge through (at_v, at_w) of a strip, and the bound where it is a corner, or −1.

    The place is a multiple of (−n_ω, n_v); it is not-a-number where nothing of the edge is within the other strips.
    """
    n_v, n_w = normal(strip, half_axle)
    slope = -n_w * (a * at_v + b * at_w + g_v) + n_v * (b * at_v + c * at_w + g_w)
    s = -slope / (a * n_w * n_w - 2 * b * n_v * n_w + c * n_v * n_v)
    least, most, at_least, at_most = -math.inf, math.inf, -1, -1
    for m in range(STRIPS):
        if m == strip:
            continue
        m_v, m_w = normal(m, half_axle)
        rate, here = m_w * n_v - m_v * n_w, m_v * at_v + m_w * at_w
        to_low, to_high = (low[m] - here) / rate, (high[m] - here) / rate
        begin, end = 2 * m, 2 * m + 1
        if rate < 0:
            to_low, to_high, begin, end = to_high, to_low, end, begin
        if to_low > least:
            least, at_least = to_low, begin
        if to_high < most:
            most, at_most = to_high, end
    if least > most:
        # Strips that meet in one corner may miss each other by rounding.
        return (most, at_most) if least - most < _ROUNDING else (math.nan, -1)
    if s < least:
        return least, at_least
    if s > most:
        return most, at_most
    return s, -1
