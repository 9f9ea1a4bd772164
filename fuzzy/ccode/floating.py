"""The functions of C that a system in double or float is made of: each is written only if the system needs it."""

from fuzzy.ccode.numbertype import Floating
from fuzzy.ccode.phrases import Pieces, chosen

_PIECES: Pieces = (
    ("least", (), """
static REAL least(REAL a, REAL b) { return b < a ? b : a; }
"""),
    ("limited", (), """
static REAL limited(REAL z) { return z < 0.0 ? 0.0 : (z > 1.0 ? 1.0 : z); }
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
    ("log_gauss", (), """
static REAL log_gauss(REAL distance, REAL sigma) {
    const REAL z = distance / sigma;
    return -0.5 * (z * z);
}
"""),
    ("log_shoulders", ("log_gauss",), """
/* A Gaussian below the left end, a Gaussian above the right end. */
static REAL log_shoulders(REAL from_left, REAL s1, REAL from_right, REAL s2) {
    return log_gauss(from_left < 0.0 ? from_left : 0.0, s1) + log_gauss(from_right > 0.0 ? from_right : 0.0, s2);
}
"""),
    ("log_sigmoid", (), """
/* The logarithm of 1 / (1 + e^-z), in a form that does not overflow. */
static REAL log_sigmoid(REAL z) { return -((z < 0.0 ? -z : 0.0) + log1p(exp(-fabs(z)))); }
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
    ("rise", ("ramp",), """
/* 0 up to a, 1 from b on, straight between; a = b is a step that is 1 at its edge. */
static REAL rise(REAL x, REAL a, REAL b) { return b > a ? ramp(x - a, b - a) : (x >= b ? 1.0 : 0.0); }
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
    ("smf", ("spline",), """
/* From 0 at a to 1 at b; a >= b is a step in the middle. */
static REAL smf(REAL x, REAL a, REAL b) { return b > a ? spline(x - a, b - a) : (x >= (a + b) / 2.0 ? 1.0 : 0.0); }
"""),
    ("zmf", ("smf",), """
static REAL zmf(REAL x, REAL a, REAL b) { return smf(-x, -b, -a); }
"""),
    ("pimf", ("smf",), """
static REAL pimf(REAL x, REAL a, REAL b, REAL c, REAL d) { return smf(x, a, b) * smf(-x, -d, -c); }
"""),
    ("dsigmf", ("difference",), """
static REAL dsigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) { return difference(a1 * (x - c1), a2 * (x - c2)); }
"""),
    ("log_gaussmf", ("log_gauss",), """
static REAL log_gaussmf(REAL x, REAL sigma, REAL c) { return log_gauss(x - c, sigma); }
"""),
    ("log_gauss2mf", ("log_shoulders",), """
static REAL log_gauss2mf(REAL x, REAL s1, REAL c1, REAL s2, REAL c2) { return log_shoulders(x - c1, s1, x - c2, s2); }
"""),
    ("log_gbellmf", ("log_bell",), """
static REAL log_gbellmf(REAL x, REAL a, REAL b, REAL c) { return log_bell(x - c, a, b); }
"""),
    ("log_sigmf", ("log_sigmoid",), """
static REAL log_sigmf(REAL x, REAL a, REAL c) { return log_sigmoid(a * (x - c)); }
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
    """The functions that are ``needed``, and those that they need, in a type of numbers."""
    return number.typed(chosen(_PIECES, needed))
