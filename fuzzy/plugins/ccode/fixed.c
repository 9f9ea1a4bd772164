/* The functions that a system in fixed point may call; each calls only those above it. Two blank lines part them: what
 * stands between is written as a whole, or not at all.
 *
 * Inputs, consequents and outputs are Q16.16. Degrees of membership are Q2.30, so that 1 is 1 << 30; logarithms have 20
 * binary places in 64 bits. What a term asks of an input is a straight line of it, whose slope has 31 significant bits
 * whatever its size, so that narrow terms lose nothing. A product of degrees is a number with an exponent of its own, so
 * that rules that fire faintly keep their ratio. */


#define ONE ((int32_t)1 << 30) /* the degree of membership 1 */


#define NEVER (-((int64_t)1 << 41)) /* the logarithm of a degree that is as good as 0 */


/* value / 2^bits, rounded to nearest. */
static int64_t shifted(int64_t value, int bits) {
    const int64_t half = bits > 0 ? (int64_t)1 << (bits - 1) : 0;
    return value >= 0 ? (value + half) >> bits : -((half - value) >> bits);
}


/* The straight line slope * x / 2^bits + offset. */
static int64_t line(int32_t x, int32_t slope, int bits, int64_t offset) {
    return shifted((int64_t)x * slope, bits) + offset;
}


/* Limited to the degrees 0 and 1. */
static int32_t limited(int64_t z) { return z < 0 ? 0 : (z > ONE ? ONE : (int32_t)z); }


static int32_t least(int32_t a, int32_t b) { return b < a ? b : a; }


static int32_t most(int32_t a, int32_t b) { return b > a ? b : a; }


/* The product of two degrees. */
static int32_t times(int32_t a, int32_t b) { return (int32_t)(((int64_t)a * b + (1 << 29)) >> 30); }


static int32_t both(int32_t a, int32_t b) { return a + (b - times(a, b)); }


/* Two parabolas, from 0 to 1 while z goes there. */
static int32_t spline(int64_t z) {
    const int32_t rising = limited(z), falling = ONE - rising;
    return rising < ONE / 2 ? 2 * times(rising, rising) : ONE - 2 * times(falling, falling);
}


/* A degree that may be faint: value / 2^(30 + halvings), with the value 0 or in [2^29, 2^30]. */
typedef struct {
    int32_t value;
    int halvings;
} strength_t;

static strength_t strength_of(int32_t value, int halvings) {
    strength_t found;
    while (value > 0 && value < ONE / 2) value *= 2, halvings++;
    found.value = value > 0 ? value : 0;
    found.halvings = value > 0 ? halvings : 0;
    return found;
}


/* A strength as a degree. */
static int32_t plain(strength_t s) { return s.halvings > 30 ? 0 : s.value >> s.halvings; }


/* e^v for v <= 0, exact to 1e-8 of itself: whole powers of 1/2, and the Taylor series of 2^-f for the rest. */
static strength_t decaying(int64_t v) {
    static const int32_t series[10] = {109, 1419, 16377, 165394, 1431680,
                                       10327387, 59597083, 257941248, 744261118, ONE};
    int64_t t, f, p;
    if (v < -((int64_t)745 << 20)) return strength_of(0, 0);
    if (v > 0) v = 0; /* by rounding */
    t = -v * 1549082005; /* times log2(e), of 30 places */
    f = (t >> 20) & (ONE - 1);
    p = series[0];
    for (int k = 1; k < 10; k++) p = series[k] - ((p * f) >> 30);
    return strength_of((int32_t)p, (int)(t >> 50));
}


static int32_t exponential(int64_t v) { return plain(decaying(v)); }


static strength_t product(strength_t a, strength_t b) {
    return strength_of((int32_t)(((int64_t)a.value * b.value + (1 << 29)) >> 30), a.halvings + b.halvings);
}


static strength_t lesser(strength_t a, strength_t b) {
    if (a.value == 0 || b.value == 0) return strength_of(0, 0);
    if (a.halvings != b.halvings) return a.halvings > b.halvings ? a : b;
    return b.value < a.value ? b : a;
}


/* -z^2 / 2 */
static int64_t log_gauss(int64_t z) {
    const int64_t size = z < 0 ? -z : z, kept = size > INT32_MAX ? INT32_MAX : size;
    return -((kept * kept) >> 21);
}


/* The logarithm of a number > 0 with 20 places: of its power of 2, and 2 artanh of the rest. */
static int64_t logarithm(int64_t z) {
    int64_t s, q, sum;
    int power = 0;
    while (z >= (int64_t)1 << 31) z >>= 1, power++;
    while (z < (int64_t)1 << 30) z <<= 1, power--;
    s = ((z - ((int64_t)1 << 30)) << 30) / (z + ((int64_t)1 << 30)); /* below 1/3 */
    q = (s * s) >> 30;
    sum = 97612893; /* 1/11, and so on down to 1 */
    sum = 119304647 + ((sum * q) >> 30);
    sum = 153391689 + ((sum * q) >> 30);
    sum = 214748365 + ((sum * q) >> 30);
    sum = 357913941 + ((sum * q) >> 30);
    sum = ((int64_t)1 << 30) + ((sum * q) >> 30);
    return (((s * sum) >> 29) + ((int64_t)(power + 10) * 744261118)) >> 10;
}


/* The logarithm of 1 / (1 + e^-z). */
static int64_t log_sigmoid(int64_t z) {
    const int64_t size = z < 0 ? -z : z;
    const int64_t rest = logarithm(((int64_t)1 << 20) + (exponential(-size) >> 10));
    const int64_t log = -rest + (z < 0 ? z : 0);
    return log < NEVER ? NEVER : log;
}


/* 1 / (1 + e^-z) */
static strength_t sigmoid(int64_t z) {
    const strength_t small = decaying(z < 0 ? z : -z);
    const int64_t whole = ONE + (int64_t)plain(small);
    if (z < 0) return strength_of((int32_t)(((int64_t)small.value << 30) / whole), small.halvings);
    return strength_of((int32_t)(((int64_t)ONE << 30) / whole), 0);
}


/* -2 b log |z|: the bell 1 / (1 + |z|^2b) is a sigmoid of it. `twice` is 2 b in Q16.16. */
static int64_t bell(int64_t z, int32_t twice) {
    const int64_t size = z < 0 ? -z : z;
    const int64_t log = size == 0 ? NEVER : -(int64_t)(((size > 0 ? logarithm(size) : 0) * twice) >> 16);
    return size == 0 ? (twice > 0 ? -NEVER : (twice < 0 ? NEVER : 0)) : log;
}


static strength_t difference(strength_t a, strength_t b) {
    const int halvings = b.value == 0 || (a.value > 0 && a.halvings < b.halvings) ? a.halvings : b.halvings;
    const int behind_a = a.halvings - halvings, behind_b = b.halvings - halvings;
    const int32_t value_a = behind_a > 30 ? 0 : a.value >> behind_a, value_b = behind_b > 30 ? 0 : b.value >> behind_b;
    return strength_of(value_a - value_b, halvings);
}


/* The square root. */
static strength_t root(strength_t s) {
    const int odd = s.halvings & 1;
    uint64_t rest = (uint64_t)s.value << (30 - odd), found = 0;
    for (uint64_t bit = (uint64_t)1 << 60; bit != 0; bit >>= 2) {
        if (rest >= found + bit) {
            rest -= found + bit;
            found = (found >> 1) + bit;
        } else {
            found >>= 1;
        }
    }
    return strength_of((int32_t)found, (s.halvings - odd) / 2);
}


/* A degree to a power in Q16.16. */
static strength_t hedged(strength_t s, int32_t power) {
    if (s.value == 0) return s;
    return decaying(((logarithm(s.value) - (10 + s.halvings) * (int64_t)726817) * power) >> 16);
}
