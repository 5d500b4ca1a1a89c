/* Responses of driven nodes to the tensions beside them, sampled by clocks (see sampled_control.py). */
#ifndef CLOCKS_H
#define CLOCKS_H

#include "sections.h"

/* Of each clock: its period, its first tick, and how often it has ticked; its members are `first` to the next one.
 * Members of a clock with `effect` take their oldest waiting correction. The others decide by one kernel a form, of (time,
 * what all kernels read, states, inputs, parameters, discrete variables, force at each port) -> whether it wants to act,
 * its need, and its values if granted and if refused. A rival with need goes before by its need, others always. */
typedef struct {
    int clocks, most; /* most results of a kernel */
    const double *period, *begin;
    long long *ticks;
    const int *first, *effect;
    const int *form, *x, *u, *p, *d, *port_first, *port_span, *port_end; /* of each member */
    const int *states, *inputs, *parameters, *discrete, *ports, *values; /* of each form */
    const int *correction, *waiting; /* of each member: place of its correction, of the oldest one that waits */
    const int *place_first, *place;  /* of each member the places of its values */
    const int *rival_first, *rival, *by_need;
    const rs_kernel *kernels;
    double *results, *changed, *work; /* of all members; (members,) */
} rs_clocks;

#endif
