/* See NAME_control.h. Made of the system and its loop: change those. */
#include "NAME_control.h"

/* What the rules give, scaled: u, and the rate du. */
static int asked(REAL error, REAL rate, REAL total OPERATING, REAL *u, REAL *du) {
    REAL x[UPPER_INPUTS], y[UPPER_OUTPUTS];
    int told;
INPUTS
    told = NAME_infer(x, y);
    *u = OUTPUT_U;
    *du = OUTPUT_DU;
    (void)error, (void)rate, (void)total;
    return told;
}

void NAME_begin(NAME_controller *c) {
    static const NAME_controller fresh = {0, 0, 0, 0, 0, 0, 0};
    *c = fresh;
}

REAL NAME_control(NAME_controller *c, REAL reference, REAL measured OPERATING) {
    const REAL error = reference - measured;
    REAL rate = c->rate, total = c->total + error * PERIOD, integrated, wanted, control, u, du;
    if (c->begun) rate = KEEP * rate + TAKE * (error - c->error) / PERIOD;
    c->told = asked(error, rate, total SCHEDULED, &u, &du);
    wanted = u + c->integrated + du * PERIOD;
    if ((wanted > HIGH || wanted < LOW) && total != c->total) {
        /* Clamping: the sum stays if with it the actuator would be driven further into its limit. */
        REAL other, rising, less;
        asked(error, rate, c->total SCHEDULED, &other, &rising);
        less = other + c->integrated + rising * PERIOD;
        if ((wanted > HIGH && less <= wanted) || (wanted < LOW && less >= wanted)) {
            total = c->total;
            u = other;
            du = rising;
        }
    }
    integrated = c->integrated + du * PERIOD;
    if (u + integrated > HIGH && du > 0) {
        const REAL room = HIGH - u, least = room < integrated ? room : integrated;
        integrated = least > c->integrated ? least : c->integrated;
    } else if (u + integrated < LOW && du < 0) {
        const REAL room = LOW - u, most = room > integrated ? room : integrated;
        integrated = most < c->integrated ? most : c->integrated;
    }
    control = u + integrated;
    if (control != control) return c->control; /* not-a-number */
    control = control > LOW ? control : LOW;
    control = control < HIGH ? control : HIGH;
    c->begun = 1;
    c->error = error;
    c->rate = rate;
    c->total = total;
    c->integrated = integrated;
    c->control = control;
    return control;
}
