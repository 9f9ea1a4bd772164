/* The controller of a loop round NAME_infer: scale factors, the error's filtered rate and its sum, the integral of du,
 * the actuator's limits with clamping. As fuzzy.step_response simulates it.
 *
 * Use, once every PERIOD s:
 *     NAME_controller c;
 *     NAME_begin(&c);
 *     u = NAME_control(&c, reference, measured SCHEDULED);
 *
 * It allocates nothing. Each loop has a NAME_controller of its own. */
#ifndef UPPER_CONTROL_H
#define UPPER_CONTROL_H

#include "NAME.h"

#ifdef __cplusplus
extern "C" {
#endif

/* The sample time [s] that the controller was made for. */
#define UPPER_PERIOD PERIOD

typedef struct {
    REAL error;      /* of the last sample */
    REAL rate;       /* the error's, filtered */
    REAL total;      /* the error's sum */
    REAL integrated; /* of the output du */
    REAL control;    /* the last u */
    int begun;       /* has there been a sample? */
    int told;        /* what NAME_infer told of the last one; with UPPER_NO_RULE, u may be held */
} NAME_controller;

void NAME_begin(NAME_controller *c);

/* The control u for the next sample, within its limits. Where no rule fires and the rules give no number, the last u
 * is held and the state stays. */
REAL NAME_control(NAME_controller *c, REAL reference, REAL measured OPERATING);

#ifdef __cplusplus
}
#endif
#endif /* UPPER_CONTROL_H */
