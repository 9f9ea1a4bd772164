/* One robot over one run: the periods of robotics/simulation/steps.py and the ticks of tick_lanes in
 * robotics/world/vehicle/plant.py, around the functions of plant.h, which are translated from there. */
#include "plant.h"

enum {MOST = 64}; /* terms, rules, inputs of a rule base */

double aims[SAMPLES][5];                          /* the reference in each period: x, y, heading, v, w */
double ahead[SAMPLES][5];                         /* the same, look_ahead later */
double early[SAMPLES * STEPS + MOST_LATE + 1][2]; /* v and w in each step, for the laws that read them ahead */
double trace[SAMPLES][3];                         /* what comes of it: x, y, heading; not-a-number once it was stopped */
double orders[SAMPLES][2];
double rules[MOST_NUMBERS];                       /* a rule base, packed as fuzzy/compiled/packed.py says */
double parameters[PARAMETERS];                    /* of the robot: ParameterColumns */
static int late; /* steps of latency */

#define LIST(name, n) s[(int)s[AT_##name] + (n)]

/* Evaluate one point, as evaluate_packed does: rules joined by products, triangles and trapezoids, clipped inputs. */
static void infer(const double *x, double *y) {
    const double *s = rules;
    const int inputs = (int)s[AT_inputs], count = (int)s[AT_rules];
    double at[MOST], degree[MOST], firing[MOST], sum = 0.0;
    for (int i = 0; i < inputs; i++) {
        at[i] = x[i] < LIST(low, i) ? LIST(low, i) : x[i] > LIST(high, i) ? LIST(high, i) : x[i];
    }
    for (int g = 0, t = 0; g < (int)s[AT_segments]; g++) {
        const int three = LIST(segment_kind, g) == TRIANGLE;
        for (; t < (int)LIST(segment_end, g); t++) {
            const double b = LIST(b, t), c = LIST(c, t);
            degree[t] = at_trapezoid(at[(int)LIST(segment_input, g)], LIST(a, t), b, three ? b : c, three ? c : LIST(d, t));
        }
    }
    for (int r = 0, k = 0; r < count; r++) {
        double w = 1.0;
        for (; k < (int)LIST(rule_end, r); k++) {
            const double d = degree[(int)LIST(clause_term, k)];
            w *= LIST(clause_negated, k) != 0.0 ? 1.0 - d : d;
        }
        firing[r] = w * LIST(weight, r);
        sum += firing[r];
    }
    for (int o = 0; o < (int)s[AT_outputs]; o++) {
        double total = 0.0, said = 0.0;
        for (int r = 0; r < count; r++) {
            const int place = o * count + r;
            if (firing[r] == 0.0 || LIST(takes_part, place) == 0.0) continue;
            double proposed = LIST(constant, place);
            for (int i = 0; LIST(linear, o) != 0.0 && i < inputs; i++) proposed += LIST(slopes, place * inputs + i) * at[i];
            total += firing[r] / sum;
            said += firing[r] / sum * proposed;
        }
        y[o] = total > 0.0 ? (LIST(complete, o) != 0.0 ? said : said / total) : LIST(default, o);
    }
}

#include "laws.h"

static void tick(const double earlier[2], const double command[2]) {
    begin();
    for (int n = 0; n < STEPS; n++) {
        z[VOLT_R] = (n < late % STEPS ? earlier : command)[0];
        z[VOLT_L] = (n < late % STEPS ? earlier : command)[1];
        loops();
        for (int m = 0; m < SUBSTEPS; m++) move();
        odometry();
    }
}

/* Drive by a law of laws.h, under so many steps of latency, from a start at rest. */
void drive(int law, int steps, double x, double y, double heading) {
    const double none[2] = {0.0, 0.0};
    int stopped = 0;
    late = steps;
    for (int n = 0; n < Z; n++) z[n] = 0.0;
    for (int n = 0; n < PARAMETERS; n++) z[FIRST_PARAMETER + n] = parameters[n];
    z[X] = z[ODO_X] = x;
    z[Y] = z[ODO_Y] = y;
    z[HEADING] = z[ODO_HEADING] = heading;
    counts[0] = counts[1] = 0.0;
    start();
    for (int k = 0; k < SAMPLES; k++) {
        const double dx = z[X] - aims[k][0], dy = z[Y] - aims[k][1];
        double *order = orders[k];
        const int back = k - late / STEPS;
        for (int n = 0; n < 3; n++) trace[k][n] = stopped ? NAN : z[X + n];
        encoders_of();
        measure_of(k, k);
        step(law, k, order);
        if (!isfinite(order[0]) || !isfinite(order[1]) || !(dx * dx + dy * dy < DIVERGENCE * DIVERGENCE)) stopped = 1;
        if (stopped) order[0] = order[1] = 0.0;
        tick(back > 0 ? orders[back - 1] : none, back >= 0 ? orders[back] : none);
    }
}
