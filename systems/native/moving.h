/* A line whose drives follow known trajectories, from crossing to crossing. */
#ifndef MOVING_H
#define MOVING_H

#include "sections.h"

/* Why rs_move returns: the last stop is reached; a crossing that takes more than to pass; a load has crossed before the
 * time that rates predict; the list of loads ends; no room for records; Newton's method has failed; a rope is slack or
 * used up at a stop; a load has crossed, where it is to stop then. */
enum { RS_REACHED, RS_CROSSING, RS_UNFORESEEN, RS_LOADS, RS_FULL, RS_FAILED, RS_SLACK, RS_PASSED };

typedef struct {
    int run, support, load, forward, record; /* of what crosses; the record that it leads to */
} rs_event;

typedef struct {
    double time, begin, h; /* now; the window of the drives' trajectories */
    const double *stop;    /* times at which all sections are solved, and written down where `grid` */
    int stops, reached, grid;
    int strict, single, failure; /* single: stop after each crossing */
    const double *window;       /* (RS_NODES, nx) states at its Chebyshev points */
    const double *window_rates; /* their rates */
    double crossed;             /* time of the last crossing */
    double short_step, least_step;
    /* loads: of each run the first in the lists; places on the rope; (supports,) how many have passed; rope at each
     * support at zero travel, and mean span of each run */
    const long long *load_first;
    const double *place, *mass, *drag, *rope, *scale;
    long long *passed;
    const double *pull; /* (spans, 3): what each metre of rope adds to its tension vector [N/m] */
    const double *wind; /* (2,): what each square metre of a load's drag area adds to it [N/m2] */
    /* records and events */
    int records, most, events;
    int *record_grid;
    double *record_time, *record_x, *record_z;
    long long *record_passed;
    rs_event *event;
    rs_event coming; /* the crossing that is left */
    double *room;    /* 2 nz + 2 supports doubles */
} rs_motion;

RS_API int rs_move(const rs_line *line, rs_point *q, rs_motion *m);

#endif
