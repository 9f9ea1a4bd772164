/* The functions that a system in floating point may call, with REAL for double or float; each calls only those above
 * it. Two blank lines part them: what stands between is written as a whole, or not at all. */


static REAL least(REAL a, REAL b) { return b < a ? b : a; }


static REAL limited(REAL z) { return z < 0.0 ? 0.0 : (z > 1.0 ? 1.0 : z); }


/* 0 at a distance of 0 or less, 1 from a distance of the width on. */
static REAL ramp(REAL distance, REAL width) { return limited(distance / width); }


/* Two parabolas in place of the straight line. */
static REAL spline(REAL distance, REAL width) {
    const REAL z = limited(distance / width);
    return z < 0.5 ? 2.0 * (z * z) : 1.0 - 2.0 * ((1.0 - z) * (1.0 - z));
}


static REAL log_gauss(REAL distance, REAL sigma) {
    const REAL z = distance / sigma;
    return -0.5 * (z * z);
}


/* A Gaussian below the left end, a Gaussian above the right end. */
static REAL log_shoulders(REAL from_left, REAL s1, REAL from_right, REAL s2) {
    return log_gauss(from_left < 0.0 ? from_left : 0.0, s1) + log_gauss(from_right > 0.0 ? from_right : 0.0, s2);
}


/* The logarithm of 1 / (1 + e^-z), in a form that does not overflow. */
static REAL log_sigmoid(REAL z) { return -((z < 0.0 ? -z : 0.0) + log1p(exp(-fabs(z)))); }


/* The logarithm of 1 / (1 + |z|^2b). */
static REAL log_bell(REAL distance, REAL a, REAL b) {
    const REAL z = fabs(distance / a);
    return log_sigmoid(z > 0.0 ? -2.0 * b * log(z) : (b > 0.0 ? INFINITY : (b < 0.0 ? -INFINITY : 0.0)));
}


static REAL difference(REAL z1, REAL z2) { return limited(exp(log_sigmoid(z1)) - exp(log_sigmoid(z2))); }


/* 0 up to a, 1 from b on, straight between; a = b is a step that is 1 at its edge. */
static REAL rise(REAL x, REAL a, REAL b) { return b > a ? ramp(x - a, b - a) : (x >= b ? 1.0 : 0.0); }


static REAL trimf(REAL x, REAL a, REAL b, REAL c) { return least(rise(x, a, b), rise(-x, -c, -b)); }


static REAL trapmf(REAL x, REAL a, REAL b, REAL c, REAL d) { return least(rise(x, a, b), rise(-x, -d, -c)); }


static REAL linsmf(REAL x, REAL a, REAL b) { return rise(x, a, b); }


static REAL linzmf(REAL x, REAL a, REAL b) { return 1.0 - rise(x, a, b); }


/* From 0 at a to 1 at b; a >= b is a step in the middle. */
static REAL smf(REAL x, REAL a, REAL b) { return b > a ? spline(x - a, b - a) : (x >= (a + b) / 2.0 ? 1.0 : 0.0); }


static REAL zmf(REAL x, REAL a, REAL b) { return smf(-x, -b, -a); }


static REAL pimf(REAL x, REAL a, REAL b, REAL c, REAL d) { return smf(x, a, b) * smf(-x, -d, -c); }


static REAL dsigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) { return difference(a1 * (x - c1), a2 * (x - c2)); }


static REAL log_gaussmf(REAL x, REAL sigma, REAL c) { return log_gauss(x - c, sigma); }


static REAL log_gauss2mf(REAL x, REAL s1, REAL c1, REAL s2, REAL c2) { return log_shoulders(x - c1, s1, x - c2, s2); }


static REAL log_gbellmf(REAL x, REAL a, REAL b, REAL c) { return log_bell(x - c, a, b); }


static REAL log_sigmf(REAL x, REAL a, REAL c) { return log_sigmoid(a * (x - c)); }


static REAL log_psigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) {
    return log_sigmf(x, a1, c1) + log_sigmf(x, a2, c2);
}


static REAL gaussmf(REAL x, REAL sigma, REAL c) { return exp(log_gaussmf(x, sigma, c)); }


static REAL gauss2mf(REAL x, REAL s1, REAL c1, REAL s2, REAL c2) { return exp(log_gauss2mf(x, s1, c1, s2, c2)); }


static REAL gbellmf(REAL x, REAL a, REAL b, REAL c) { return exp(log_gbellmf(x, a, b, c)); }


static REAL sigmf(REAL x, REAL a, REAL c) { return exp(log_sigmf(x, a, c)); }


static REAL psigmf(REAL x, REAL a1, REAL c1, REAL a2, REAL c2) { return exp(log_psigmf(x, a1, c1, a2, c2)); }


static REAL both(REAL a, REAL b) { return a + b - a * b; }


static REAL most(REAL a, REAL b) { return b > a ? b : a; }


/* A degree after a hedge, whose power is not 1. */
static REAL hedged(REAL degree, REAL power) { return degree > 0.0 ? pow(degree, power) : degree; }


/* A lower degree of type-2 from the upper one: 0 up to the lag, and above it straight. */
static REAL lowered(REAL degree, REAL lag, REAL slope) { return degree > lag ? (degree - lag) * slope : 0.0; }


/* An end of the type-reduced set of rules with proposals p, on the way from between: w has their least strengths, and
 * then their greatest. Each step takes the greatest of those that are on the side of the end, and comes nearer to it. */
static REAL reduced(const REAL *p, const REAL *w, int rules, REAL between, int upwards) {
    for (;;) {
        REAL said = 0.0, total = 0.0;
        for (int r = 0; r < rules; r++) {
            const REAL off = p[r] - between;
            const REAL share = w[(upwards ? off > 0.0 : off < 0.0) ? rules + r : r];
            said += off * share;
            total += share;
        }
        const REAL next = between + (total > 0.0 ? said / total : 0.0);
        if (!(upwards ? next > between : next < between)) return between;
        between = next;
    }
}
