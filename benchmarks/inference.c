/* The system of benchmarks/inference.py as a plain loop: 3 inputs, 8 rules with a Gaussian for each input,
 * first-order consequents, product and weighted average. The exponents of a rule are summed first, so that a
 * rule costs one exponential. Strict IEEE arithmetic, one thread, the C library's exp. */
#include <math.h>
#include <stddef.h>

enum { INPUTS = 3, RULES = 8 };

/* x (n, INPUTS), center and sigma (RULES, INPUTS), consequent (RULES, INPUTS + 1: slopes, constant), y (n) */
void infer(ptrdiff_t n, const double *restrict x, const double *restrict center, const double *restrict sigma,
           const double *restrict consequent, double *restrict y) {
    double factor[RULES * INPUTS];
    for (int k = 0; k < RULES * INPUTS; k++) factor[k] = 1 / (sigma[k] * sqrt(2.0));
    for (ptrdiff_t p = 0; p < n; p++) {
        const double *point = x + p * INPUTS;
        double numerator = 0, denominator = 0;
        for (int r = 0; r < RULES; r++) {
            double exponent = 0, proposal = consequent[r * (INPUTS + 1) + INPUTS];
            for (int i = 0; i < INPUTS; i++) {
                double z = (point[i] - center[r * INPUTS + i]) * factor[r * INPUTS + i];
                exponent -= z * z;
                proposal += consequent[r * (INPUTS + 1) + i] * point[i];
            }
            double firing = exp(exponent);
            numerator += firing * proposal;
            denominator += firing;
        }
        y[p] = numerator / denominator;
    }
}
