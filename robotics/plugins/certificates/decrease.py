"""Whether V falls over boxes of posture errors, in compiled code and in intervals that are rounded outwards.

Errors (X, Y) in the frame of the reference and ψ of the heading; a = v − v_r and b = ω − ω_r are what the robot drives
beside its reference:

    X' = v_r (1 − cos ψ) − a cos ψ + ω_r Y,   Y' = (v_r + a) sin ψ − ω_r X,   ψ' = −b

The wheels are known by an assumption only: over a period v and ω are on average a weighted mean of the newest commands,
within a share of the width of the hull of older ones and a constant. Behind a low-pass these commands are a mean that
fades of what the law has asked for, enclosed from the oldest on. Where the robot was when those commands were given
follows from how fast it can have moved since. docs/explanation/certificate.md has the theorem, after Razumikhin
[Hale & Verduyn Lunel 1993].
"""

import math

import numpy as np

from fuzzy.compiled.intervals import (
    add,
    cosine,
    down,
    hull,
    mul,
    rule_base_range,
    scale,
    sine,
    square,
    sub,
    up,
    wider,
    work_size,
)
from fuzzy.compiled.jit import compiled_only, kernel
from robotics.laws.rules.of_reference import GIVEN
from robotics.plugins.certificates.loopcolumns import LevelColumns, LoopColumns

# What may be in the way: no rule fires; the heading error is π; V is too great; a limit is met
HOLE, WAY_TURNED, GROWS, LIMITED = 1, 2, 4, 8
_NEAR = 0.75  # of w, below which V may grow


@compiled_only
def level(form, x, y, psi):  # type: ignore[no-untyped-def]
    """Enclose V."""
    s = add(psi, scale(form.m, y))
    return add(add(scale(form.a, square(x)), scale(form.b, square(y))), square(s))


@compiled_only
def within(a, b):  # type: ignore[no-untyped-def]
    """What two intervals have in common; the nearer end of the second where that is nothing."""
    low, high = max(a[0], b[0]), min(a[1], b[1])
    return (low, high) if low <= high else (min(max(a[0], b[0]), b[1]), min(max(a[0], b[0]), b[1]))


@compiled_only
def meets_limit(loop, v, w):  # type: ignore[no-untyped-def]
    """Whether a command may meet a limit of the robot, short of which the wheels were measured."""
    fast, turning = max(abs(v[0]), abs(v[1])), max(abs(w[0]), abs(w[1]))
    return fast > loop.v_max or turning > loop.w_max or up(fast + up(loop.half_axle * turning)) > loop.wheel_limit


@compiled_only
def ask(loop, v_r, w_r, x, y, psi, rules, asked, out, work):  # type: ignore[no-untyped-def]
    """Enclose what the law asks for beside the reference's velocity, and what is wrong, over a box of errors."""
    x, y, psi = wider(x, loop.position_noise), wider(y, loop.position_noise), wider(psi, loop.heading_noise)
    if psi[0] < -3.14 or psi[1] > 3.14:
        return (0.0, 0.0), (0.0, 0.0), WAY_TURNED
    v_change, w_change = up(loop.v_rate * loop.span), up(loop.w_rate * loop.span)
    cos, sin = cosine(psi), sine(psi)
    x_err, y_err = sub(mul(cos, x), mul(sin, y)), add(mul(sin, x), mul(cos, y))
    target = within(wider(v_r, v_change), (loop.speed_low, loop.speed_high))
    back = mul(target, sub((1.0, 1.0), cos))  # v_r (1 − cos ψ), of what the law reads
    wrong = 0
    if loop.formula != 0:
        dv, dw = scale(loop.kx, x_err), (0.0, 0.0)
        bend = add(scale(loop.ky, y_err), scale(loop.kpsi, sin))
    else:
        for n in range(int(loop.count)):
            place = int(loop.places[n])
            if place == 0:
                known = x_err
            elif place == 1:
                known = y_err
            elif place == 2:
                known = psi
            elif place == 3:
                known = target
            else:
                known = wider(w_r, w_change)
            asked[0, n], asked[1, n] = known
        wrong = rule_base_range(rules, asked, out, work)
        dv, dw, bend = said(loop, out, GIVEN.dv), said(loop, out, GIVEN.dw), said(loop, out, GIVEN.bend)
    a = sub(dv, back)
    v = add(target, a)
    size = max(v[0], -v[1], 0.0), max(-v[0], v[1])
    speed = max(target[0], min(size[0], loop.catch_up)), max(target[1], min(size[1], loop.catch_up))
    b = add(dw, mul(speed, bend))
    a, b = wider(a, v_change), wider(b, w_change)
    if meets_limit(loop, add(v_r, a), add(w_r, b)):
        wrong |= LIMITED
    return a, b, wrong


@compiled_only
def said(loop, out, output):  # type: ignore[no-untyped-def]
    """What a rule base gives, or 0."""
    place = int(loop.given[output])
    return (out[0, place], out[1, place]) if place >= 0 else (0.0, 0.0)


@compiled_only
def reverses(loop, v_r, w_r, a, b):  # type: ignore[no-untyped-def]
    """1 where a wheel may turn round, or 0."""
    v, rim = add(v_r, a), scale(loop.half_axle, add(w_r, b))
    right, left = add(v, rim), sub(v, rim)
    slow = loop.slow
    if (right[0] <= slow and right[1] >= -slow) or (left[0] <= slow and left[1] >= -slow):
        return 1.0
    return 0.0


@compiled_only
def at_any_time(loop, back, a, b):  # type: ignore[no-untyped-def]
    """What the wheels do at any time, of the hull of all commands in memory."""
    return (
        wider(a, up(up(loop.overshoot * up(a[1] - a[0])) + up(loop.v_ripple + back * loop.v_reversal))),
        wider(b, up(up(loop.overshoot * up(b[1] - b[0])) + up(loop.w_ripple + back * loop.w_reversal))),
    )


@compiled_only
def on_average(loop, back, a, b, wide_a, wide_b):  # type: ignore[no-untyped-def]
    """What they do over a period, of the weighted mean of commands and the widths of the hulls of all in memory."""
    return (
        wider(a, up(up(loop.share * wide_a) + up(loop.v_error + back * loop.v_reversal))),
        wider(b, up(up(loop.share * wide_b) + up(loop.w_error + back * loop.w_reversal))),
    )


@compiled_only
def references(loop, v_r, curvature):  # type: ignore[no-untyped-def]
    """v_r and ω_r at any time that counts, of what they are now."""
    return wider(v_r, up(loop.v_rate * loop.span)), wider(mul(v_r, curvature), up(loop.w_rate * loop.span))


@compiled_only
def rates(v_r, w_r, a, x, y, psi):  # type: ignore[no-untyped-def]
    """X' and Y'."""
    cos, sin = cosine(psi), sine(psi)
    one = sub(mul(v_r, sub((1.0, 1.0), cos)), mul(a, cos))
    return add(one, mul(w_r, y)), sub(mul(add(v_r, a), sin), mul(w_r, x))


@compiled_only
def earlier(loop, v_r, w_r, inst, mean_b, x, y, psi, most, periods, form, c):  # type: ignore[no-untyped-def]
    """Where the errors were at the last samples, so many periods back, and never beyond ``most``.

    Of what was driven since: ``inst`` are a and b at any time, ``mean_b`` is b over whole periods.
    """
    a, b = inst
    span = (-up(periods * loop.period), 0.0)
    p = add(psi, mul(span, (-b[1], -b[0])))
    # Between samples the errors may be beyond it, by what they move in a period
    step = up(loop.period * up(2 * v_r[1] + max(abs(a[0]), abs(a[1]))))
    step = up(step + up(loop.period * max(abs(w_r[0]), abs(w_r[1]))) * up(most[0][1] + most[1][1] + step))
    u, w = wider(most[0], step), wider(most[1], step)
    dx, dy = rates(v_r, w_r, a, u, w, p)
    u, w = within(add(x, mul(span, dx)), u), within(add(y, mul(span, dy)), w)
    dx, dy = rates(v_r, w_r, a, u, w, p)
    u, w = add(x, mul(span, dx)), add(y, mul(span, dy))
    p = add(psi, mul(span, (-mean_b[1], -mean_b[0])))
    w = within(w, most[1])
    return (
        within(u, most[0]),
        w,
        within(within(p, most[2]), wider(scale(-form.m, w), up(math.sqrt(up(c)) * (1 + 1e-14)))),
    )


@compiled_only
def reach(form, c):  # type: ignore[no-untyped-def]
    """The box that holds V <= c."""
    x, y = up(math.sqrt(up(c / form.a))), up(math.sqrt(up(c / form.b)))
    psi = up(math.sqrt(up(c * up(1 + up(form.m * form.m / form.b)))) * (1 + 1e-14))
    return (-x, x), (-y, y), (-psi, psi)


@compiled_only
def piece(whole, k, parts):  # type: ignore[no-untyped-def]
    """One of equal parts."""
    width = (whole[1] - whole[0]) / parts
    return down(whole[0] + k * width), up(whole[0] + (k + 1) * width)


@kernel(nogil=True)
def tabulate(numbers, candidate, rules, cell, parts, levels, found):  # type: ignore[no-untyped-def]
    """What the law asks for all over V <= c, and by how much √V then grows in a period, for each c of ``levels``.

    ``found`` (levels, 5) has the ends of a and of b, and the growth. Returns what is wrong anywhere.
    """
    loop, form, wrong = LoopColumns(numbers), LevelColumns(candidate), 0
    asked, out, work = np.empty((2, max(1, int(loop.count)))), np.empty((2, 16)), np.empty(work_size(rules))
    v_r = cell[0, 0], cell[0, 1]
    v_r, w_r = references(loop, v_r, (cell[1, 0], cell[1, 1]))
    # What is forgotten was anything between the limits
    rest = 2 * (1 - loop.fresh) ** (loop.forgotten + 1) * (1 + 1e-9)
    for n in range(len(levels)):
        c = levels[n]
        most = reach(form, c)
        a, b = (np.inf, -np.inf), (np.inf, -np.inf)
        for i in range(parts[0]):
            x = piece(most[0], i, parts[0])
            for j in range(parts[1]):
                y = piece(most[1], j, parts[1])
                for k in range(parts[2]):
                    psi = piece(most[2], k, parts[2])
                    if level(form, x, y, psi)[0] <= c:
                        s, t, bad = ask(loop, v_r, w_r, x, y, psi, rules, asked, out, work)
                        a, b, wrong = hull(a, s), hull(b, t), wrong | bad
        a, b = wider(a, up(rest * loop.v_max)), wider(b, up(rest * loop.w_max))
        found[n, 0], found[n, 1], found[n, 2], found[n, 3] = a[0], a[1], b[0], b[1]
        inst = at_any_time(loop, reverses(loop, v_r, w_r, a, b), a, b)
        dx, dy, dpsi = moved(loop, v_r, w_r, inst[0], inst[1], inst, most[0], most[1], most[2])
        turn_x, turn_y = scale(loop.period, mul(w_r, most[1])), scale(-loop.period, mul(w_r, most[0]))
        found[n, 4] = up(math.sqrt(level(form, add(dx, turn_x), add(dy, turn_y), dpsi)[1]) * (1 + 1e-14))
    return wrong


@compiled_only
def bent(factor, b, any_b):  # type: ignore[no-untyped-def]
    """The mean over a period of a factor times ∫ b dt, over T/2.

    With b's mean known, ∫ b dt is on average b T/2 within T/8 of the width of b.
    """
    middle, radius = (factor[0] + factor[1]) / 2, up((factor[1] - factor[0]) / 2 * (1 + 1e-15) + 1e-300)
    return wider(scale(middle, wider(b, up((any_b[1] - any_b[0]) / 4))), up(radius * max(abs(any_b[0]), abs(any_b[1]))))


@compiled_only
def moved(loop, v_r, w_r, a, b, inst, x, y, psi):  # type: ignore[no-untyped-def]
    """By how much the errors change in a period, but for T ω_r (Y, −X); a and b are means, ``inst`` at any time."""
    t, half, one = loop.period, loop.period / 2, (1.0, 1.0)
    heading = add(psi, mul((0.0, t), (-inst[1][1], -inst[1][0])))
    cos, sin, speed = cosine(psi), sine(psi), add(v_r, inst[0])
    own_x, own_y = sub(mul(v_r, sub(one, cos)), mul(a, cos)), mul(add(v_r, a), sin)
    own_x = sub(own_x, scale(half, bent(mul(speed, sine(heading)), b, inst[1])))
    own_y = sub(own_y, scale(half, bent(mul(speed, cosine(heading)), b, inst[1])))
    size = max(abs(x[0]), abs(x[1])) + max(abs(y[0]), abs(y[1]))
    far = up((size + t * (2 * v_r[1] + max(abs(inst[0][0]), abs(inst[0][1])))) * (1 + 1e-14))
    dx, dy = rates(v_r, w_r, inst[0], (-far, far), (-far, far), heading)
    own_x, own_y = add(own_x, scale(half, mul(w_r, dy))), sub(own_y, scale(half, mul(w_r, dx)))
    return scale(t, own_x), scale(t, own_y), scale(-t, b)


@compiled_only
def smooth(loop, hulls, n):  # type: ignore[no-untyped-def]
    """Enclose the commands that are at most n periods old behind the low-pass, of those before it: columns 4 to 7."""
    s, older = loop.fresh, hulls[min(n + 1, len(hulls) - 1)]
    for i in range(0, 4, 2):
        new = scale(s, (hulls[n, i], hulls[n, i + 1]))
        hulls[n, i + 4], hulls[n, i + 5] = add(new, mul((down(1 - s), up(1 - s)), (older[i + 4], older[i + 5])))


@compiled_only
def told(hulls, n):  # type: ignore[no-untyped-def]
    """What the wheels were told to do, a and b, in the last n + 1 periods."""
    k = min(n, len(hulls) - 1)
    return (hulls[k, 4], hulls[k, 5]), (hulls[k, 6], hulls[k, 7])


@compiled_only
def weighted(loop, hulls, n):  # type: ignore[no-untyped-def]
    """The weighted mean of commands by which the wheels turn in any of the last n + 1 periods."""
    a, b = (0.0, 0.0), (0.0, 0.0)
    for g in range(int(loop.groups)):
        v, w = told(hulls, n + int(loop.last[g]))
        a, b = add(a, scale(loop.v_weight[g], v)), add(b, scale(loop.w_weight[g], w))
    return a, b


@compiled_only
def change(loop, form, v_r, w_r, box, c, table, rules, asked, out, work, hulls):  # type: ignore[no-untyped-def]
    """Enclose by how much V changes in a period over a box, with V <= c before; and what is wrong."""
    x, y, psi = (box[0, 0], box[0, 1]), (box[1, 0], box[1, 1]), (box[2, 0], box[2, 1])
    most = reach(form, c)
    any_a, any_b = (table[0], table[1]), (table[2], table[3])
    wide_a, wide_b = up(table[1] - table[0]), up(table[3] - table[2])
    # hulls[n]: of the commands that are at most n periods old; of older ones no more is known than that V was <= c
    steps, prompt, wrong = len(hulls) - 2, int(loop.prompt), 0
    for i in range(4):
        hulls[steps + 1, i] = hulls[steps + 1, i + 4] = table[i]
    turns = reverses(loop, v_r, w_r, any_a, any_b)
    mean_a, mean_b, inst = any_a, any_b, (any_a, any_b)
    for n in range(steps, -1, -1):
        before = hulls[n + 1]
        for i in range(8):
            hulls[n, i] = before[i]  # until it is known better
        p, q, r = x, y, psi
        if n > 0:
            mean_a, mean_b = weighted(loop, hulls, n)
            mean_a, mean_b = on_average(loop, turns, mean_a, mean_b, wide_a, wide_b)
            v, w = told(hulls, n + prompt)
            inst = at_any_time(loop, turns, v, w)
            p, q, r = earlier(loop, v_r, w_r, inst, mean_b, x, y, psi, most, n, form, c)
        a, b, bad = ask(loop, v_r, w_r, p, q, r, rules, asked, out, work)
        a, b, wrong = within(a, (before[0], before[1])), within(b, (before[2], before[3])), wrong | bad
        hulls[n, 0], hulls[n, 1], hulls[n, 2], hulls[n, 3] = a[0], a[1], b[0], b[1]
        smooth(loop, hulls, n)
    v, w = told(hulls, int(loop.turning))
    turns = reverses(loop, v_r, w_r, v, w)
    mean_a, mean_b = weighted(loop, hulls, 0)
    mean_a, mean_b = on_average(loop, turns, mean_a, mean_b, wide_a, wide_b)
    v, w = told(hulls, prompt)
    inst = at_any_time(loop, turns, v, w)
    dx, dy, dpsi = moved(loop, v_r, w_r, mean_a, mean_b, inst, x, y, psi)
    s, ds = add(psi, scale(form.m, y)), add(dpsi, scale(form.m, dy))
    first = add(add(scale(form.a, mul(x, dx)), scale(form.b, mul(y, dy))), mul(s, ds))
    d = form.a - form.b
    skew = sub(mul((down(d), up(d)), y), scale(form.m, s))  # the rotation by ω_r leaves most of V as it is
    first = add(first, scale(loop.period, mul(mul(w_r, x), skew)))
    turn_x, turn_y = scale(loop.period, mul(w_r, y)), scale(-loop.period, mul(w_r, x))
    second = level(form, add(dx, turn_x), add(dy, turn_y), dpsi)
    return add(scale(2.0, first), second), wrong


@compiled_only
def at_least(levels, w):  # type: ignore[no-untyped-def]
    """The number of the least of the falling ``levels`` that is not below w, or 0."""
    n = len(levels) - 1
    while n > 0 and levels[n] < w:
        n -= 1
    return n


@compiled_only
def falls(loop, form, v_r, w_r, box, v, levels, tables, rules, asked, out, work, hulls):  # type: ignore[no-untyped-def]
    """Whether V is at most μ ν w after a period, for all w and all of a box with V <= ν w: 0, or what is in the way."""
    goal, near = form.fall * form.share, max(min(v[1] / _NEAR, levels[0]), form.inner)
    n = at_least(levels, near)
    dv, wrong = change(loop, form, v_r, w_r, box, levels[n], tables[n], rules, asked, out, work, hulls)
    if wrong != 0:
        return wrong, dv[1]
    if dv[1] > -up(1 - form.fall) * v[1] and up(v[1] + dv[1]) > form.fall * max(v[0], form.share * form.inner):
        return GROWS, dv[1]
    # Where w is greater V may grow: from the greatest w down
    w = levels[0]
    while w > near:
        n = at_least(levels, w)
        w = levels[n + 1] if n + 1 < len(levels) else form.inner
        root = up(math.sqrt(v[1]) * (1 + 1e-14) + tables[n, 4])
        if up(root * root) > down(goal * w):
            dv, wrong = change(loop, form, v_r, w_r, box, levels[n], tables[n], rules, asked, out, work, hulls)
            least = up(up(v[1] + dv[1]) / goal)
            if wrong != 0 or least > max(w, near):
                return max(wrong, GROWS), dv[1]
            w = least
    return 0, 0.0


@kernel(nogil=True)
def prove(numbers, candidate, rules, levels, tables, stack, held, sizes, most, least, failed):  # type: ignore[no-untyped-def]
    """Branch and bound over errors, v_r and curvature, from the first ``held`` boxes (5, 2) in ``stack``.

    Returns how many boxes it took, or minus that; then ``failed`` (5, 2) is the box that failed, and its last row what
    was in the way, and by which part of V. ``sizes`` are the widths of v_r over v_r and of the curvature that count as
    much as the whole region.
    """
    loop, form = LoopColumns(numbers), LevelColumns(candidate)
    asked, out, work = np.empty((2, max(1, int(loop.count)))), np.empty((2, 16)), np.empty(work_size(rules))
    hulls, whole, count, box = np.empty((int(loop.memory) + 2, 8)), reach(form, form.outer), 0, np.empty((5, 2))
    rim = form.share * form.outer
    while held > 0:
        held -= 1
        box[:] = stack[held]
        x, y, psi = (box[0, 0], box[0, 1]), (box[1, 0], box[1, 1]), (box[2, 0], box[2, 1])
        v = level(form, x, y, psi)
        if v[0] > rim:
            continue
        count += 1
        v, v_r = (v[0], min(v[1], rim)), (box[3, 0], box[3, 1])
        v_r, w_r = references(loop, v_r, (box[4, 0], box[4, 1]))
        why, grown = falls(loop, form, v_r, w_r, box, v, levels, tables, rules, asked, out, work, hulls)
        if why == 0:
            continue
        # The side that is widest, beside the errors that have this V
        size = math.sqrt(max(v[1], form.share * form.inner) / form.outer)
        widest, width = 0, -1.0
        for i in range(5):
            side = box[i, 1] - box[i, 0]
            side /= size * whole[i][1] if i < 3 else sizes[0] * box[3, 1] if i == 3 else sizes[1]
            if side > width:
                widest, width = i, side
        if width < least or count >= most or held + 2 > len(stack):
            failed[:5] = box
            failed[5, 0], failed[5, 1] = why, grown / max(v[1], 1e-300)
            return -count
        middle = (box[widest, 0] + box[widest, 1]) / 2
        stack[held], stack[held + 1] = box, box
        stack[held, widest, 1], stack[held + 1, widest, 0] = middle, middle
        held += 2
    return count


@kernel(nogil=True)
def at_points(numbers, candidate, rules, cells, points, levels, tables, found):  # type: ignore[no-untyped-def]
    """By which part V changes at points (n, 3), each with its v_r and ω_r (n, 2); no proof, but the same sums."""
    loop, form = LoopColumns(numbers), LevelColumns(candidate)
    asked, out, work = np.empty((2, max(1, int(loop.count)))), np.empty((2, 16)), np.empty(work_size(rules))
    box, hulls = np.empty((3, 2)), np.empty((int(loop.memory) + 2, 8))
    for k in range(len(points)):
        v_r = cells[k, 0], cells[k, 0]
        v_r, w_r = references(loop, v_r, (cells[k, 1], cells[k, 1]))
        box[:, 0], box[:, 1] = points[k], points[k]
        v = level(form, (box[0, 0], box[0, 1]), (box[1, 0], box[1, 1]), (box[2, 0], box[2, 1]))
        n = at_least(levels, min(v[1] / _NEAR, levels[0]))
        dv, wrong = change(loop, form, v_r, w_r, box, levels[n], tables[k, n], rules, asked, out, work, hulls)
        found[k] = dv[1] / v[1] if wrong == 0 else np.inf
