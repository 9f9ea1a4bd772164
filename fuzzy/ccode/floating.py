"""The functions of C that a system in double or float is made of: each is written only if the system needs it."""

from fuzzy.ccode.numbertype import Floating

# In the order in which they are written: name, the others that it needs, text.
_PIECES: tuple[tuple[str, tuple[str, ...], str], ...] = (
    ("least", (), """
static REAL least(REAL a, REAL b) { return b < a ? b : a; }
"""),
    ("limited", (), """
static REAL limited(REAL z) { return z < 0.0 ? 0.0 : (z > 1.0 ? 1.0 : z); }
"""),
    ("rise", ("limited",), """
/* 0 up to a, 1 from b on, straight between; a = b is a step that is 1 at its edge. */
static REAL rise(REAL x, REAL a, REAL b) {
    if (b > a) return limited((x - a) / (b - a));
    return x >= b ? 1.0 : 0.0;
}
"""),
    ("trimf", ("rise", "least"), """
static REAL trimf(REAL x, REAL a, REAL b, REAL c) { return least(rise(x, a, b), rise(-x, -c, -b)); }
"""),
    ("trapmf", ("rise", "least"), """
static REAL trapmf(REAL x, REAL a, REAL b, REAL c, REAL d) { return least(rise(x, a, b), rise(-x, -d, -c)); }
"""),
    ("linsmf", ("rise",), """
static REAL linsmf(REAL x, REAL a, REAL b) { return rise(x, a, b); }
"""),
    ("linzmf", ("rise",), """
static REAL linzmf(REAL x, REAL a, REAL b) { return 1.0 - rise(x, a, b); }
"""),
    ("smf", ("limited",), """
/* Two parabolas, from 0 at a to 1 at b; a >= b is a step in the middle. */
static REAL smf(REAL x, REAL a, REAL b) {
    if (b > a) {
        const REAL z = limited((x - a) / (b - a));
        return z < 0.5 ? 2.0 * (z * z) : 1.0 - 2.0 * ((1.0 - z) * (1.0 - z));
    }
    return x >= (a + b) / 2.0 ? 1.0 : 0.0;
}
"""),
    ("zmf", ("smf",), """
static REAL zmf(REAL x, REAL a, REAL b) { return smf(-x, -b, -a); }
"""),
    ("pimf", ("smf",), """
static REAL pimf(REAL x, REAL a, REAL b, REAL c, REAL d) { return smf(x, a, b) * smf(-x, -d, -c); }
"""),
    ("possible", (), """
/* A logarithm, or what stands for that of 0. */
static REAL possible(REAL logarithm) { return logarithm < NEVER ? NEVER : logarithm; }
"""),
    ("log_gaussmf", ("possible",), """
static REAL log_gaussmf(REAL x, REAL sigma, REAL c) {
    const REAL z = (x - c) / sigma;
    return possible(-0.5 * (z * z));
}
"""),
    ("log_gauss2mf", ("possible",), """
static REAL log_gauss2mf(REAL x, REAL s1, REAL c1, REAL s2, REAL c2) {
    const REAL left = (x > c1 ? 0.0 : x - c1) / s1, right = (x < c2 ? 0.0 : x - c2) / s2;
    return possible(-0.5 * (left * left) + -0.5 * (right * right));
}
"""),
    ("log_gbellmf", ("possible",), """
/* The logarithm of 1 / (1 + |z|^2b), in a form that does not overflow. */
static REAL log_gbellmf(REAL x, REAL a, REAL b, REAL c) {
    const REAL z = fabs((x - c) / a);
    const REAL e = z > 0.0 ? 2.0 * b * log(z) : (b > 0.0 ? -INFINITY : (b < 0.0 ? INFINITY : 0.0));
    return possible(-((e > 0.0 ? e : 0.0) + log1p(exp(-fabs(e)))));
}
"""),
    ("log_sigmf", ("possible",), """
/* The logarithm of 1 / (1 + e^(-a (x - c))), in a form that does not overflow. */
static REAL log_sigmf(REAL x, REAL a, REAL c) {
    const REAL z = a * (x - c);
    return possible(-((z < 0.0 ? -z : 0.0) + log1p(exp(-fabs(z)))));
}
"""),
    ("log_psigmf", ("log_sigmf",), """
static REAL log_psigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) {
    return log_sigmf(x, a1, c1) + log_sigmf(x, a2, c2);
}
"""),
    ("gaussmf", ("log_gaussmf",), """
static REAL gaussmf(REAL x, REAL sigma, REAL c) { return exp(log_gaussmf(x, sigma, c)); }
"""),
    ("gauss2mf", ("log_gauss2mf",), """
static REAL gauss2mf(REAL x, REAL s1, REAL c1, REAL s2, REAL c2) { return exp(log_gauss2mf(x, s1, c1, s2, c2)); }
"""),
    ("gbellmf", ("log_gbellmf",), """
static REAL gbellmf(REAL x, REAL a, REAL b, REAL c) { return exp(log_gbellmf(x, a, b, c)); }
"""),
    ("sigmf", ("log_sigmf",), """
static REAL sigmf(REAL x, REAL a, REAL c) { return exp(log_sigmf(x, a, c)); }
"""),
    ("psigmf", ("log_psigmf",), """
static REAL psigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) { return exp(log_psigmf(x, a1, c1, a2, c2)); }
"""),
    ("dsigmf", ("limited", "log_sigmf"), """
static REAL dsigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) {
    return limited(exp(log_sigmf(x, a1, c1)) - exp(log_sigmf(x, a2, c2)));
}
"""),
    ("ramp", ("limited",), """
/* 0 at a distance of 0 or less, 1 from a distance of the width on. */
static REAL ramp(REAL distance, REAL width) { return limited(distance / width); }
"""),
    ("spline", ("limited",), """
/* Two parabolas in place of the straight line. */
static REAL spline(REAL distance, REAL width) {
    const REAL z = limited(distance / width);
    return z < 0.5 ? 2.0 * (z * z) : 1.0 - 2.0 * ((1.0 - z) * (1.0 - z));
}
"""),
    ("log_gauss", ("possible",), """
static REAL log_gauss(REAL distance, REAL sigma) {
    const REAL z = distance / sigma;
    return possible(-0.5 * (z * z));
}
"""),
    ("log_shoulders", ("log_gauss",), """
/* A Gaussian below the left end, a Gaussian above the right end. */
static REAL log_shoulders(REAL from_left, REAL s1, REAL from_right, REAL s2) {
    return log_gauss(from_left < 0.0 ? from_left : 0.0, s1) + log_gauss(from_right > 0.0 ? from_right : 0.0, s2);
}
"""),
    ("log_sigmoid", ("possible",), """
/* The logarithm of 1 / (1 + e^-z), in a form that does not overflow. */
static REAL log_sigmoid(REAL z) { return possible(-((z < 0.0 ? -z : 0.0) + log1p(exp(-fabs(z))))); }
"""),
    ("log_bell", ("log_sigmoid",), """
/* The logarithm of 1 / (1 + |z|^2b). */
static REAL log_bell(REAL distance, REAL a, REAL b) {
    const REAL z = fabs(distance / a);
    return log_sigmoid(z > 0.0 ? -2.0 * b * log(z) : (b > 0.0 ? INFINITY : (b < 0.0 ? -INFINITY : 0.0)));
}
"""),
    ("difference", ("limited", "log_sigmoid"), """
static REAL difference(REAL z1, REAL z2) { return limited(exp(log_sigmoid(z1)) - exp(log_sigmoid(z2))); }
"""),
    ("both", (), """
static REAL both(REAL a, REAL b) { return a + b - a * b; }
"""),
    ("most", (), """
static REAL most(REAL a, REAL b) { return b > a ? b : a; }
"""),
    ("hedged", (), """
/* A degree after a hedge, whose power is not 1. */
static REAL hedged(REAL degree, REAL power) { return degree > 0.0 ? pow(degree, power) : degree; }
"""),
)  # fmt: skip


def pieces(needed: set[str], number: Floating) -> str:
    """The functions that are ``needed``, with all that these need, in the order in which C wants them."""
    wanted = set(needed)
    for name, others, _ in reversed(_PIECES):
        if name in wanted:
            wanted.update(others)
    assert wanted <= {name for name, _, _ in _PIECES}, wanted
    text = "".join(body.lstrip("\n") for name, _, body in _PIECES if name in wanted)
    return number.typed(text).replace("NEVER", number.constant(number.never))
