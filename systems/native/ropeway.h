/* A cable system: solution of its equations, loads that move from span to span, time integration.
 *
 * The sizes RW_N... and all tables come from model_data.h and model_data.c, the equations rw_dae, rw_jacobian,
 * rw_outputs and rw_tangent from files of these names; all are generated. fmi2.c and fmi3.c
 * are the FMI wrappers. */
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
    double x[RW_NX + 1], z[RW_NZ + 1];
} rw_point;

/* A square sparse matrix by columns, and the order in which they are eliminated. */
typedef struct {
    int n;
    const int *colind, *row, *order;
} rw_pattern;

/* The factors of the scaled matrix [I - hg df/dx, -hg df/dz; dg/dx, dg/dz]. */
typedef struct {
    double hg;
    int valid, exact; /* exact: evaluated at the present point */
    int lp[RW_NW + 1], up[RW_NW + 1], pinv[RW_NW + 1];
    int li[RW_LCAP], ui[RW_UCAP];
    double lx[RW_LCAP], ux[RW_UCAP];
    double jac[RW_NNZ + 1]; /* derivatives of f and g by x and z */
} rw_factors;

/* Trial states beyond the next crossing (Model Exchange): times after the held point at which it is reached, and at which
 * the equations had no solution; rates there; the solution kept for later states, and its time. */
typedef struct {
    double near, unsolved, zrate[RW_NZ + 1], z[RW_NZ + 1], t;
    int kept, beyond, stale; /* stale: inputs have changed since the held point */
} rw_ahead;

/* The complete state of an instance: it is saved by a copy. */
typedef struct {
    rw_mode mode;
    int known, solved, rated, shown;   /* parameters applied, z solved, its rates and outputs computed */
    int passed[RW_NK + 1];             /* loads that have passed each support */
    int broken[RW_NL + 1];             /* violated limits */
    int ticks[RW_NC + 1];              /* of each clock */
    int beyond_schedule;
    int on[RW_NSW + 1];                /* switches: brakes, losses of pressure */
    double h;                          /* next step of the error control */
    rw_point now, held;                /* held: last accepted point of a carriage, or in Model Exchange */
    int place;                         /* place of the carriage at the held point */
    double slope[RW_NU + 1], slope_from; /* rates of inputs within the next step of Co-Simulation, from a time on */
    rw_ahead ahead;
    int stopping;                      /* emergency stop: the commanded speeds are ramped down to zero */
    double stop_time, stop_speed[RW_NE + 1];
    double u[RW_NU + 1], p[RW_NP + 1], d[RW_ND + 1], mass[RW_NM + 1];
    double rate[RW_NX + 1], zrate[RW_NZ + 1], y[RW_NY + 1];
    rw_factors lu; /* the last: the compiled core uses it within a call only */
} rw_state;

#define RW_STATE_SIZE (RW_SECTIONS || RW_INERTIAL ? offsetof(rw_state, lu) : sizeof(rw_state)) /* of what is saved */

typedef void (*rw_log_function)(void *context, rw_status status, const char *category, const char *message);

typedef struct {
    rw_state s;
    rw_log_function log;
    void *context;
    int log_events, log_all;
    int co_simulation;
    double start_time, stop_time, tolerance;
    int has_event_mode, stops_at_events; /* Co-Simulation of FMI 3.0: a step may end at an event, for the importer to handle */
    int event;                           /* the last step has an event at its end or, if it does not stop there, in it */
    /* workspace within a call */
    double f[RW_NX + 1], g[RW_NZ + 1];
    double residual[RW_NW + 1], increment[RW_NW + 1], w[RW_NW + 1], work[RW_NW + 1];
    double dx[RW_NX + 1], dz[RW_NZ + 1], du[RW_NU + 1], dp[RW_NP + 1], dd[RW_ND + 1], dm[RW_NM + 1], dt, df[RW_NX + 1], dg[RW_NZ + 1], dy[RW_NY + 1];
    rw_state backup;
    double sample[RW_NQ + 1], fresh[RW_ND + 1];
    unsigned char changes[RW_ND + 1];
    double margin[RW_NG + 1];
    double limit[RW_NL + 1];
    double none[RW_NU + RW_NP + RW_ND + 1]; /* zeros */
    double line_work[RW_LINE_WORK], rope[RW_NK + 1], us_rate[RW_NU + 1];
    long long used[RW_NK + 1]; /* of each span: loads in it */
    rw_factors drives;         /* of the drives of a line */
    double coupling[RW_NCP + 1];
    double us[RW_NU + 1], stage[4][RW_NX + 1], base[RW_NX + 1];
    ri_point core; /* of a system with inertia, and its room */
    double core_y[RW_CORE_Y], core_value[RW_CORE_VALUE], core_kernel[RW_CORE_KERNEL], core_dense[RW_CORE_DENSE];
    double core_band[RW_CORE_BAND], core_room[RW_CORE_ROOM];
    int core_pivot[RW_CORE_PIVOT];
    int mark[RW_NW + 1], stack[RW_NW + 1], place[RW_NW + 1], order[RW_NW + 1];
    const double *arg[RW_SZ_ARG];
    double *res[RW_SZ_RES];
    int iw[RW_SZ_IW];
    double cw[RW_SZ_W];
} rw_instance;

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

extern const rw_pattern rw_whole, rw_drives; /* the whole line, and its drives alone */

/* ropeway_sparse.c */
int rw_factor(rw_instance *m, const rw_pattern *a, rw_factors *lu, const double *values);
void rw_back(const rw_pattern *a, const rw_factors *lu, double *b, double *work);

/* ropeway_log.c */
void rw_message(rw_instance *m, rw_status status, const char *category, const char *format, ...);

/* ropeway_slots.c */
void rw_place_loads(rw_instance *m);
void rw_take_state(rw_instance *m, const rw_state *state);
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
void rw_point_arguments(rw_instance *m, const double *t, const double *x, const double *z, const double *u);
int rw_all_finite(const double *v, int n);
void rw_inputs_at(rw_instance *m, double t, double *u);
void rw_input_rates(const rw_instance *m, double t, double factor, double *du);
double rw_stop_end(const rw_instance *m, int i);
int rw_equations(rw_instance *m, double t, const double *x, const double *z, const double *u);
int rw_rate_function(rw_instance *m, double t, const double *x, const double *z, const double *u, double *rate);
int rw_sample(rw_instance *m, int clock);
int rw_couplings(rw_instance *m);
int rw_drives_alone(rw_instance *m);

/* ropeway_lines.c */
rw_status rw_solve_sections(rw_instance *m, const int *sections, int count);
rw_status rw_solve_all_sections(rw_instance *m, int rates);
rw_status rw_solve_line(rw_instance *m);
rw_status rw_line_rates(rw_instance *m);
void rw_through_line(rw_instance *m, const double *coupling, double factor, double *values);
void rw_span_end(rw_instance *m, int span, double *force);
double rw_line_law(rw_instance *m, int k, const double *load, double share);
int rw_sections_beside(int k, int *sections, int count);

/* ropeway_inertial.c */
ri_point *rw_core_point(rw_instance *m);
int rw_core_solved(rw_instance *m, int failed);
int rw_core_solve(rw_instance *m);

/* ropeway_solve.c */
int rw_matrix(rw_instance *m, double t, const double *x, const double *z, const double *u);
int rw_factor_matrix(rw_instance *m, double hg);
rw_status rw_fail(rw_instance *m, const char *reason, double t);
rw_status rw_newton(rw_instance *m, double t, double *x, double *z, const double *u, const double *base, double hg);
rw_status rw_solve_here(rw_instance *m);
rw_status rw_margins_of(rw_instance *m);

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
double rw_zone_gap(const rw_instance *m, int k);
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
rw_instance *rw_new(rw_log_function log, void *context, int co_simulation);
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
size_t rw_serialized_size(void);
rw_status rw_serialize(rw_instance *m, const rw_state *state, unsigned char *bytes, size_t size);
rw_status rw_deserialize(rw_instance *m, const unsigned char *bytes, size_t size, rw_state **state);

#endif
