/* A line in time, from crossing to crossing and from one stop to the next. */
#ifndef MOVING_H
#define MOVING_H

#include "calls.h"
#include "clocks.h"
#include "drives.h"
#include "sections.h"

#define RS_MOST 64 /* crossings at one time, and sections that they touch */

/* Why rs_move and rs_run return: the last stop is reached; a crossing that takes more than to pass; a load has crossed
 * before the time that rates predict; the list of loads ends; no room for records; Newton's method has failed; a rope is
 * used up or unstable at a stop; a load has crossed, where it is to stop then, or drives move otherwise from then on; a
 * limit of a drive is active that moves by itself; the motion of a drive is not found. */
enum {
    RS_REACHED,
    RS_CROSSING,
    RS_UNFORESEEN,
    RS_LOADS,
    RS_FULL,
    RS_FAILED,
    RS_SLACK,
    RS_PASSED,
    RS_COUPLED,
    RS_ASTRAY
};

typedef struct {
    int run, support, load, forward, record; /* of what crosses; the record that it leads to */
} rs_event;

typedef struct {
    int member, record; /* of the clocks; the record that it leads to */
    double value;
} rs_response;

/* What is written down: records, those that are whole, and sections and their variables in the others; how many of these
 * follow the last whole one. */
typedef struct {
    int records, wholes, sections, numbers, behind;
} rs_written;

typedef struct {
    double time, begin, h; /* now; the window of the drives' trajectories */
    const double *stop;    /* times of the grid: all sections are solved, and written down */
    int stops, grids, reached; /* the last stop may be beyond the grid: nothing is written down there */
    int strict, single, failure; /* single: stop after each crossing */
    const double *window;       /* (RS_NODES, nx) states at its Chebyshev points */
    const double *window_rates; /* their rates */
    const double *nodes, *weights;
    double crossed; /* time of the last crossing */
    double short_step, least_step, longest_step;
    /* loads: of each run the first in the lists; places on the rope; (supports,) how many have passed; rope at each
     * support at zero travel, and mean span of each run */
    const long long *load_first;
    const double *place, *mass, *drag, *rope, *scale;
    long long *passed;
    const double *pull; /* (spans, 3): what each metre of rope adds to its tension vector [N/m] */
    const double *wind; /* (2,): what each square metre of a load's drag area adds to it [N/m2] */
    const int *sign;    /* (supports,): 1 where more travel of a stable line lowers the residual of its balance, else -1 */
    /* records and events; an epoch lasts from one tick of a clock to the next. A crossing writes down the sections beside
     * it only, `record_sections` of them, where fewer than `chain` such records follow a whole one, which has
     * `whole_z` and `whole_passed` */
    rs_written written;
    int most, most_wholes, most_numbers, chain, events, responses, epoch;
    int *record_grid, *record_epoch, *record_sections, *part_section;
    double *record_time, *record_x, *record_u, *whole_z, *part_z;
    long long *whole_passed;
    rs_event *event;
    rs_response *response;
    rs_event coming; /* the crossing that is left */
    const int *kept; /* places of the discrete variables that do not follow from the loads */
    int keeps, epochs;
    double *epoch_kept;     /* (epochs, keeps) */
    long long *epoch_ticks; /* (epochs, clocks) */
    double *due;            /* (supports,): when the next load reaches each of them */
    double *room;           /* 2 nz + 2 supports doubles */
    /* for the guess at a stop: time of the last one, 0 in `curved` where there is none; (nz,) rates there, and their
     * change since the one before [per s2]; (sections,) whether a section has been solved since */
    double stopped;
    int curved;
    int *touched;
    double *old_rate, *curve;
} rs_motion;

/* Times at which inputs bend, their values there, and their rates before each of them and after the last. */
typedef struct {
    int bends, bent;
    const double *bend, *value, *slope;
    int discrete; /* number of discrete variables */
    double *saved; /* rs_saved_size doubles */
} rs_agenda;

/* Outputs by calls of kernels: the values are the `vectors` of a state with a zero behind them, the time, then others;
 * places of the outputs. */
typedef struct {
    rn_calls calls;
    int vectors, outputs;
    const int *row;
} rs_output_calls;

RS_API int rs_write_rows(const rs_line *line, rs_point *q, rs_motion *m, double *d, long long stride, long long *passed,
                         int states);
RS_API int rs_outputs(const rs_output_calls *calls, const double *rows, long long stride, const double *time, int states,
                      double *work, double *outputs, long long outputs_stride);
RS_API int rs_move(const rs_line *line, rs_point *q, rs_motion *m, double stop, const rs_drives *drives);
RS_API int rs_run(const rs_line *line, rs_point *q, rs_motion *m, rs_agenda *a, rs_drives *drives, rs_clocks *clocks);
RS_API int rs_window(const rs_line *line, rs_point *q, rs_motion *m, rs_drives *s, double end);
RS_API int rs_coupled(const rs_line *line, const rs_point *q, const rs_motion *m, const rs_drives *s, const int *sections,
                      int count);
RS_API int rs_rates(const rs_line *line, rs_point *q, const rs_motion *m, const rs_drives *s);
RS_API int rs_drives_size(const rs_line *line, const rs_drives *drives);
RS_API int rs_saved_size(const rs_line *line, int discrete);

/* crossings.c */
typedef struct {
    double time, gap;
    int k, forward;
} rs_coming;

double rs_rope(const rs_line *l, const rs_point *q, const rs_motion *m, int k);
void rs_end_force(const rs_line *l, const rs_point *q, const rs_motion *m, int span, int end, double *force);
double rs_travel_rate(const rs_line *l, const rs_point *q, int k);
void rs_foresee(const rs_line *l, const rs_point *q, const rs_motion *m, const int *sections, int count);
int rs_next(const rs_line *l, const rs_point *q, const rs_motion *m, rs_coming *found);
void rs_look_again(const rs_line *l, const rs_point *q, const rs_motion *m, rs_coming *load);
int rs_cross(const rs_line *l, rs_point *q, rs_motion *m, const rs_coming *first, int *sections, int *count);
int rs_write_slots(const rs_line *l, rs_point *q, const rs_motion *m, int span);
void rs_record(const rs_line *l, const rs_point *q, rs_motion *m, int grid);
int rs_is_full(const rs_line *l, const rs_motion *m);
int rs_in_order(const rs_line *l, const rs_point *q, const rs_motion *m);
int rs_short_of_loads(const rs_line *l, const rs_motion *m);

/* moving.c */
void rs_follow(const rs_line *l, rs_point *q, rs_motion *m, double time);
void rs_note_stop(const rs_line *l, const rs_point *q, rs_motion *m);

/* drives.c: room; the kernel of a drive `after` some time with its states `x`, and inputs that follow their rates; forces
 * at its ports; whether the rates that the kernel has given depend on them; the sections beside it, among `sections`.
 * Drives that move by themselves and have come to a limit here are `limited` from now on; whether any is, beside some
 * sections. */
rs_drive_room rs_room_of(const rs_line *l, const rs_drives *s);
void rs_drive(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r, int i,
              double after, const double *x);
void rs_pull(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r, int i);
int rs_feels(const rs_line *l, const rs_drives *s, const rs_drive_room *r, int i);
int rs_drive_sections(const rs_line *l, const rs_drives *s, int i, int *sections, int count);
void rs_note_limits(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s);
int rs_limited(const rs_line *l, const rs_drives *s, const int *sections, int count);

/* windows.c: the window of all drives from now to `end`, or shorter where one changes fast; those at a limit move with the
 * sections beside them */
int rs_drive_window(const rs_line *l, rs_point *q, rs_motion *m, rs_drives *s, double end);
int rs_swung(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const double *z,
             const double *rate);

/* clocks.c */
int rs_sample(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_clocks *c, double time);
void rs_act(rs_point *q, rs_motion *m, const rs_clocks *c, double time);
double rs_next_tick(const rs_clocks *c);

#endif
