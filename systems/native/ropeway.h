/* A cable system: solution of its equations, loads that move from span to span, time integration.
 *
 * The sizes RW_N... and all tables are in model_data.c, the kernels of components in files of their own; these are
 * generated. fmi2.c and fmi3.c are the FMI wrappers. */
#ifndef ROPEWAY_H
#define ROPEWAY_H

#include <stddef.h>
#include <stdint.h>
#include "model_data.h"

#define RW_NEAR 1e-9 /* of a mean span: a load this close to a support is on it; tolerance of margins */

typedef enum { RW_OK, RW_WARNING, RW_DISCARD, RW_ERROR } rw_status; /* numbered as in FMI 2 and 3 */

typedef enum { RW_INSTANTIATED, RW_INITIALIZATION, RW_EVENT, RW_CONTINUOUS, RW_STEP, RW_TERMINATED } rw_mode;

/* Variables that change within a step. */
typedef struct {
    double t;
    double *x, *z;
} rw_point;

/* The scaled matrix [I - hg df/dx, -hg df/dz; dg/dx, dg/dz], whose factors are in rw_instance.whole. */
typedef struct {
    double hg;
    int valid, exact; /* exact: evaluated at the present point */
    double *jac;      /* derivatives of f and g by x and z */
} rw_matrix_state;

/* Trial states beyond the next crossing (Model Exchange): times after the held point at which it is reached, and at which
 * the equations had no solution; time of the solution kept for later states, and this; rates at the held point. */
typedef struct {
    double near, unsolved, t;
    int kept, beyond, stale; /* stale: inputs have changed since the held point */
    double *zrate, *z;
} rw_ahead;

/* The complete state of an instance. Its arrays are in `memory`, one after the other (see ropeway_memory.c). */
typedef struct {
    rw_mode mode;
    int known, solved, rated, shown; /* parameters applied, z solved, its rates and outputs computed */
    int beyond_schedule;
    int place;                       /* place of the carriage at the held point */
    int stopping;                    /* emergency stop: the commanded speeds are ramped down to zero */
    double stop_time;
    double h;          /* next step of the error control */
    double slope_from; /* time from which `slope` counts */
    rw_point now, held; /* held: last accepted point of a carriage, or in Model Exchange */
    rw_ahead ahead;
    rw_matrix_state lu; /* the last: the compiled core uses it within a call only */
    int *passed;   /* loads that have passed each support */
    int *broken;   /* violated limits */
    int *ticks;    /* of each clock */
    int *on;       /* switches: brakes, losses of pressure */
    double *slope; /* rates of inputs within the next step of Co-Simulation */
    double *stop_speed;
    double *u, *p, *d, *mass;
    double *rate, *zrate, *y;
    unsigned char *memory;
} rw_state;

typedef void (*rw_log_function)(void *context, rw_status status, const char *category, const char *message);

/* A load that reaches support k; time [s] and gap [m] of travel until then, negative when overdue. */
typedef struct {
    double time, gap;
    int k, load, forward;
} rw_crossing;

/* What load `load` of a run with inertia comes to at support k, when the rope runs forwards (side 1) or backwards (-1):
 * `gap` [m] is the travel until then at the latest; it is possible `early` [m] before. */
typedef struct {
    int kind, k, load;
    double side, gap, early;
} rw_threshold;

/* What a slot with a load has in a span of a run with inertia. */
typedef struct {
    int load;
    double x[6], z[6], tied[2], joined, lost;
} rw_moving_slot;

typedef struct {
    rw_state s;
    size_t state_memory; /* bytes in s.memory */
    rw_log_function log;
    void *context;
    int log_events, log_all;
    int co_simulation;
    double start_time, stop_time, tolerance;
    int has_event_mode, stops_at_events; /* Co-Simulation of FMI 3.0: a step may end at an event, for the importer to handle */
    int event;                           /* the last step has an event at its end or, if it does not stop there, in it */
    /* workspace within a call */
    double *f, *g, *residual, *increment, *w, *first, *values;
    double *dx, *dz, *du, *dp, *dd, *dm, dt, *df, *dg, *dy;
    unsigned char *backup; /* a saved state */
    double *sample, *fresh, *margin, *margin_before, *no_margin, *limit, *indicator, *input_rate, *input_begin, *input_end;
    unsigned char *changes, *just, *forward, *backward;
    double *line_work, *rope, *us_rate;
    long long *used;   /* of each span: loads in it */
    rn_factors whole, drives; /* of the matrix of the state, and of the drives of a line */
    int drives_valid;
    double *coupling, *us, *stage[4], *base;
    rw_crossing *due;
    double *goal_p, *goal_mass, *goal_x;        /* values that a start leads to */
    rw_point from, path_from, path_to, trial;   /* copies of points */
    double *good_z, *before_z;                   /* copies of algebraic variables */
    int *passed_before, *broken_before;
    /* of a system with inertia */
    ri_point core;
    rw_threshold *thresholds, *zones_due;
    rw_moving_slot *known; /* four spans */
    double *y_here, *y_later, *y_earlier, *watch_low, *watch_high, *input_reached;
    int *watched, *watch_of;
    double *value, *change; /* of a network, and changes of these */
    /* of a step along the drives of a line */
    rw_point course_from, course_to;
    double *course_rate, *course_end_rate, *since;
    int *sections;
    double *start_x, *start_z, *start_d, *start_rate, *start_zrate;
    int *start_passed;
    unsigned char *memory; /* all of this */
} rw_instance;

/* ropeway_log.c */
void rw_message(rw_instance *m, rw_status status, const char *category, const char *format, ...);

/* ropeway_memory.c */
int rw_take_memory(rw_instance *m);
void rw_leave_memory(rw_instance *m);
size_t rw_saved_size(const rw_instance *m);
void rw_save(rw_instance *m, unsigned char *bytes);
void rw_restore(rw_instance *m, const unsigned char *bytes);
void rw_clear(rw_instance *m);
void rw_copy_point(rw_point *to, const rw_point *from);

/* ropeway_slots.c */
void rw_place_loads(rw_instance *m);
double rw_load_position(const rw_instance *m, int run, int i);
double rw_load_mass(const rw_instance *m, int run, int i);
double rw_drag_area(int run, int i);
int rw_load_count(int run);
double rw_support_travel(const rw_instance *m, int k);
double rw_travel_rate(const rw_instance *m, int k);
int rw_is_last(int k);
int rw_is_held(const rw_instance *m, int k);
void rw_tell_crossing(rw_instance *m, double time, const rw_crossing *crossing, int held);
void rw_write_slots(rw_instance *m);
void rw_slot_seeds(rw_instance *m);
rw_status rw_check_slots(rw_instance *m);
rw_status rw_lengths(rw_instance *m);

/* ropeway_functions.c */
int rw_place_of(const rw_instance *m);
int rw_all_finite(const double *v, int n);
void rw_inputs_at(rw_instance *m, double t, double *u);
void rw_input_rates(const rw_instance *m, double t, double factor, double *du);
double rw_stop_end(const rw_instance *m, int i);
int rw_equations(rw_instance *m, double t, const double *x, const double *z, const double *u);
int rw_rate_function(rw_instance *m, double t, const double *x, const double *z, const double *u, double *rate);
int rw_outputs_at(rw_instance *m, const rw_point *q, double *y);
int rw_limit_outputs(rw_instance *m);
int rw_margins(rw_instance *m);
int rw_sample(rw_instance *m, int clock);
int rw_derivatives(rw_instance *m, double t, const double *x, const double *z, const double *u, double *entries);
int rw_couplings(rw_instance *m);
void rw_call_with_changes(rw_instance *m);
void rw_changes(rw_instance *m);
int rw_drives_alone(rw_instance *m);

/* ropeway_lines.c */
rw_status rw_solve_sections(rw_instance *m, const int *sections, int count);
rw_status rw_solve_all_sections(rw_instance *m, int rates);
rw_status rw_solve_line(rw_instance *m);
rw_status rw_line_rates(rw_instance *m);
void rw_through_line(rw_instance *m, const double *coupling, double factor, double *values);
void rw_span_end(rw_instance *m, int span, double *force);
double rw_line_law(rw_instance *m, int k, const double *load, double share);

/* ropeway_inertial.c */
ri_point *rw_core_point(rw_instance *m);
int rw_core_solved(rw_instance *m, int failed);
int rw_core_solve(rw_instance *m);

/* ropeway_solve.c */
int rw_matrix(rw_instance *m, double t, const double *x, const double *z, const double *u);
int rw_factor_matrix(rw_instance *m, double hg);
void rw_take_state(rw_instance *m, const unsigned char *state);
rw_status rw_fail(rw_instance *m, const char *reason, double t);
rw_status rw_newton(rw_instance *m, double t, double *x, double *z, const double *u, const double *base, double hg);
rw_status rw_solve_here(rw_instance *m);

/* ropeway_places.c */
void rw_start_place(rw_instance *m);
void rw_hold(rw_instance *m);
rw_status rw_follow(rw_instance *m);
rw_status rw_border_indicators(rw_instance *m, double *indicator);

/* ropeway_evaluate.c */
rw_status rw_solve(rw_instance *m);
rw_status rw_show(rw_instance *m);
rw_status rw_rates(rw_instance *m);
rw_status rw_limit_values(rw_instance *m);
rw_status rw_tangent_of(rw_instance *m);

/* ropeway_integrator.c */
rw_status rw_one_step(rw_instance *m, const rw_point *from, double h, int alone, double *error);

/* ropeway_zones.c */
int rw_zones_due(const rw_instance *m, rw_threshold *due);
rw_status rw_pass_zones(rw_instance *m);
rw_status rw_move_with_inertia(rw_instance *m, double h, double stop);
void rw_zone_gaps(const rw_instance *m, double *gap);
rw_status rw_require_spans(rw_instance *m);

/* ropeway_loads.c */
void rw_gaps(const rw_instance *m, int k, double *ahead, double *behind);
int rw_next_crossing(const rw_instance *m, rw_crossing *found);
rw_status rw_overrun_settle(rw_instance *m);
rw_status rw_overrun_moving(rw_instance *m);
rw_status rw_put_across(rw_instance *m, const rw_crossing *crossing);
rw_status rw_cross(rw_instance *m, const rw_crossing *first);
int rw_standing(const rw_instance *m);
rw_status rw_release_of(rw_instance *m, int k, rw_crossing *found, double *ahead);
rw_status rw_release(rw_instance *m, rw_crossing *found, double *ahead);
rw_status rw_let_go(rw_instance *m, const rw_crossing *found);
rw_status rw_limits(rw_instance *m);

/* ropeway_trajectory.c */
rw_status rw_move_along(rw_instance *m, double h, double stop, int *moved);

/* ropeway_ahead.c */
rw_status rw_accept_point(rw_instance *m);
void rw_leave_trial(rw_instance *m);
rw_status rw_look_ahead(rw_instance *m);

/* ropeway_step.c */
void rw_start_clocks(rw_instance *m);
rw_status rw_do_step(rw_instance *m, double end);
double rw_next_time_event(const rw_instance *m);
rw_status rw_event_indicators(rw_instance *m, double *indicator);
rw_status rw_event_update(rw_instance *m);

/* ropeway_instance.c */
void rw_reset(rw_instance *m);
void rw_experiment(rw_instance *m, int tolerance_defined, double tolerance, int stop_defined, double stop);
rw_status rw_initialize(rw_instance *m);
rw_status rw_up_to_date(rw_instance *m);
rw_status rw_set_time(rw_instance *m, double t);
rw_status rw_get_real(rw_instance *m, unsigned vr, double *value);
rw_status rw_set_real(rw_instance *m, unsigned vr, double value);
rw_status rw_set_input_rate(rw_instance *m, unsigned vr, double rate);
void rw_inputs_reach(rw_instance *m, const double *end, double size);
rw_status rw_get_boolean(rw_instance *m, unsigned vr, int *value);
rw_status rw_set_boolean(rw_instance *m, unsigned vr, int value);
rw_status rw_get_integer(rw_instance *m, unsigned vr, int *value);
void rw_clear_seeds(rw_instance *m);
rw_status rw_seed(rw_instance *m, unsigned vr, double seed);
rw_status rw_sensitivity(rw_instance *m, unsigned vr, double *value);
size_t rw_serialized_size(const rw_instance *m);
rw_status rw_serialize(rw_instance *m, const unsigned char *state, unsigned char *bytes, size_t size);
rw_status rw_deserialize(rw_instance *m, const unsigned char *bytes, size_t size, unsigned char **state);

#endif
