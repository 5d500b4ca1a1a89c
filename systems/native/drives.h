/* Drives: while no limit is active, their motion does not depend on the tensions of the rope. */
#ifndef DRIVES_H
#define DRIVES_H

#include "sections.h"

#define RS_TERMS 60 /* of a power series in time */

/* Nodes with states, and how ropes pull at them: of each form one kernel, of (time, what all kernels read, states,
 * inputs, parameters, discrete variables, force at each port (3,)) -> rates of the states, their derivatives by the
 * states (by rows), by the inputs, by time and by the forces. */
typedef struct {
    int drives, most; /* most states of one */
    const int *form, *x, *u, *p, *d, *port_first;
    const int *port_span, *port_end; /* of each port: span, -1 for none, and which end of it, 0 or 1 */
    const int *states, *inputs, *parameters, *discrete, *ports; /* of each form */
    const int *tied;                 /* whether a limit can be active, so that rates depend on forces */
    const rs_kernel *kernels;
    const double *nominal;                     /* of the states of the line */
    const double *nodes, *weights, *derivative; /* Chebyshev points of a window on [0, 1], as in drive_trajectories.py */
    double *window, *rates;                    /* (RS_NODES, nx) */
    int *limited; /* whether each drive moves with the ropes beside it in this window */
    double last;  /* length of the last window with such a drive [s] */
    double *work;
} rs_drives;

/* Room for drives: a kernel's vector and results; forces at the ports of all drives, and the derivatives of those of one
 * drive by its states; what finds its trajectory; points of the line in a window. */
typedef struct {
    double *v, *result, *force, *by_state, *series, *matrix, *right;
    double *z, *z_rate, *x_rate, *u, *u_rate; /* z: (RS_NODES, nz) */
} rs_drive_room;

#endif
