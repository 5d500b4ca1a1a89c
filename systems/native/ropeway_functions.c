/* Values of the networks at a point, and inputs in time. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

/* Place of a carriage: the part of the tables that counts. */
int rw_place_of(const rw_instance *m)
{
    return RW_NPL ? (int)(m->s.d[0] + 0.5) : 0;
}

static double *put(double *to, const double *values, int count)
{
    memcpy(to, values, count * sizeof(double));
    return to + count;
}

/* Makes the calls of a network. */
static void call(rw_instance *m, const rw_network *net, double t, const double *x, const double *z, const double *u)
{
    double *to = m->value;
    *to++ = t;
    to = put(put(put(to, x, RW_NX), z, RW_NZ), u, RW_NU);
    put(put(to, m->s.p, RW_NP), m->s.d, RW_ND);
    rn_call(&net->calls, m->value);
}

/* The results of a network of which the first is `first`; not 0 where they are not finite. */
static int take(const rw_network *net, const double *from, int first, int count, double *to)
{
    for (int i = 0; i < count; i++) to[i] = from[net->row[first + i]];
    return !rw_all_finite(to, count);
}

/* The results from the first one, at a point with the inputs of the present time. */
static int evaluate(rw_instance *m, const rw_network *net, const rw_point *q, int first, double *rows)
{
    rw_inputs_at(m, m->s.now.t, m->us);
    call(m, net, q->t, q->x, q->z, m->us);
    return take(net, m->value, first, net->rows - first, rows);
}

int rw_all_finite(const double *v, int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(v[i])) return 0;
    return 1;
}

/* Time at which a speed reaches zero in an emergency stop. */
double rw_stop_end(const rw_instance *m, int i)
{
    return m->s.stop_time + fabs(m->s.stop_speed[i]) / RW_STOP_DECELERATION;
}

/* Inputs at a time: those of the FMU, piecewise linear schedules, the speeds of an emergency stop, and the rates of these
 * that are inputs too. */
void rw_inputs_at(rw_instance *m, double t, double *u)
{
    for (int i = 0; i < RW_NU; i++) u[i] = m->s.u[i] + m->s.slope[i] * (t - m->s.slope_from);
    for (int i = 0; i < RW_NS; i++) {
        const double *times = rw_schedule_time + rw_schedule_first[i], *values = rw_schedule_value + rw_schedule_first[i];
        int n = rw_schedule_first[i + 1] - rw_schedule_first[i], k = 0;
        while (k < n && times[k] <= t) k++;
        if (k == 0 || k == n)
            u[rw_schedule_input[i]] = values[k == 0 ? 0 : n - 1];
        else
            u[rw_schedule_input[i]] = values[k - 1] + (values[k] - values[k - 1]) * (t - times[k - 1]) / (times[k] - times[k - 1]);
        if (k == n && t > times[n - 1] + 1e-9 && !m->s.beyond_schedule) {
            m->s.beyond_schedule = 1;
            rw_message(m, RW_WARNING, "logStatusWarning", "The schedule of %s ended at %g s: its last value is kept",
                       rw_input_name[rw_schedule_input[i]], times[n - 1]);
        }
    }
    for (int i = 0; m->s.stopping && i < RW_NE; i++) {
        double end = rw_stop_end(m, i), passed = t - m->s.stop_time, speed = m->s.stop_speed[i];
        u[rw_stop_input[i]] = t >= end ? 0.0 : speed - copysign(RW_STOP_DECELERATION * passed, speed);
    }
    if (RW_NF) {
        double *rate = m->input_rate;
        memcpy(rate, m->s.slope, RW_NU * sizeof(double));
        rw_input_rates(m, t, 1.0, rate);
        for (int i = 0; i < RW_NF; i++) u[rw_followed_input[i]] = rate[rw_followed_source[i]];
    }
}

/* Rates of scheduled inputs and of an emergency stop, times a factor. */
void rw_input_rates(const rw_instance *m, double t, double factor, double *du)
{
    for (int i = 0; i < RW_NS; i++) {
        const double *times = rw_schedule_time + rw_schedule_first[i], *values = rw_schedule_value + rw_schedule_first[i];
        int n = rw_schedule_first[i + 1] - rw_schedule_first[i], k = 0;
        while (k < n && times[k] <= t) k++;
        if (k > 0 && k < n)
            du[rw_schedule_input[i]] = factor * (values[k] - values[k - 1]) / (times[k] - times[k - 1]);
    }
    for (int i = 0; m->s.stopping && i < RW_NE; i++)
        du[rw_stop_input[i]] = t >= rw_stop_end(m, i) ? 0.0 : -factor * copysign(RW_STOP_DECELERATION, m->s.stop_speed[i]);
}

/* Rates and residuals at a point, in m->f and m->g; not 0 where they are not finite. */
int rw_equations(rw_instance *m, double t, const double *x, const double *z, const double *u)
{
    const rw_network *net = &rw_net_equations[rw_place_of(m)];
    call(m, net, t, x, z, u);
    return take(net, m->value, 0, RW_NX, m->f) | take(net, m->value, RW_NX, RW_NZ, m->g);
}

int rw_rate_function(rw_instance *m, double t, const double *x, const double *z, const double *u, double *rate)
{
    call(m, rw_net_rates, t, x, z, u);
    return take(rw_net_rates, m->value, 0, RW_NX, rate);
}

/* Outputs at a point, with the inputs of the present time. */
int rw_outputs_at(rw_instance *m, const rw_point *q, double *y)
{
    return evaluate(m, &rw_net_all[rw_place_of(m)], q, RW_NW, y);
}

/* The outputs that have limits at the present point, in m->limit. */
int rw_limit_outputs(rw_instance *m)
{
    return evaluate(m, rw_net_limits, &m->s.now, 0, m->limit);
}

/* Margins of the carriage's place at the present point, in m->margin. */
int rw_margins(rw_instance *m)
{
    return evaluate(m, &rw_net_margins[rw_place_of(m)], &m->s.now, 0, m->margin);
}

/* New values of a clock at the present point, in m->sample. */
int rw_sample(rw_instance *m, int clock)
{
    return evaluate(m, &rw_net_clock[clock], &m->s.now, 0, m->sample);
}

/* Derivatives of the results of a network by x and z, the entries of a matrix by columns: by changes in the directions
 * of groups of these, no result depends on two of a group. */
static int matrix(rw_instance *m, const rw_network *net, int tangents, const int *colind, const int *row, double *entries)
{
    double *direction = m->change + 1;
    memset(m->change, 0, (1 + RW_NW + RW_NU + RW_NP + RW_ND) * sizeof(double));
    for (int group = 0; group < RW_GROUPS; group++) {
        for (int j = 0; j < RW_NW; j++) direction[j] = rw_group[j] == group;
        if (tangents) rn_change(&net->calls, net->tangents, m->value, m->change);
        else rn_sweep(&net->calls, &net->derivatives, m->value, m->change);
        for (int j = 0; j < RW_NW; j++)
            for (int p = colind[j]; rw_group[j] == group && p < colind[j + 1]; p++) entries[p] = m->change[net->row[row[p]]];
    }
    return !rw_all_finite(entries, colind[RW_NW]);
}

/* Derivatives of f and g by x and z at a point, in the pattern of rw_whole. */
int rw_derivatives(rw_instance *m, double t, const double *x, const double *z, const double *u, double *entries)
{
    const int seldom = RW_SECTIONS || RW_INERTIAL;
    const rw_network *net = seldom ? rw_net_all : &rw_net_matrix[rw_place_of(m)];
    call(m, net, t, x, z, u);
    return matrix(m, net, seldom, rw_whole_colind, rw_whole.row, entries);
}

/* Derivatives of the rates of the drives of a line by states and algebraic variables, in m->coupling. */
int rw_couplings(rw_instance *m)
{
    rw_inputs_at(m, m->s.now.t, m->us);
    call(m, rw_net_coupling, m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    return matrix(m, rw_net_coupling, 0, rw_coupling_colind, rw_coupling_row, m->coupling);
}

/* Makes the calls at the present point whose changes rw_changes gives. */
void rw_call_with_changes(rw_instance *m)
{
    rw_inputs_at(m, m->s.now.t, m->us);
    call(m, &rw_net_all[rw_place_of(m)], m->s.now.t, m->s.now.x, m->s.now.z, m->us);
}

/* Changes of f, g and y for those of all that they depend on. */
void rw_changes(rw_instance *m)
{
    const rw_network *net = &rw_net_all[rw_place_of(m)];
    double *to = m->change;
    *to++ = m->dt;
    to = put(put(put(to, m->dx, RW_NX), m->dz, RW_NZ), m->du, RW_NU);
    put(put(to, m->dp, RW_NP), m->dd, RW_ND);
    rn_change(&net->calls, net->tangents, m->value, m->change);
    take(net, m->change, 0, RW_NX, m->df);
    take(net, m->change, RW_NX, RW_NZ, m->dg);
    take(net, m->change, RW_NW, RW_NY, m->dy);
}

/* Whether the rates of the drives of a line do not depend on its tensions here: no limit of one is active. */
int rw_drives_alone(rw_instance *m)
{
    if (!RW_COUPLED) return 1;
    if (rw_couplings(m)) return 0;
    for (int j = 0; j < RW_NZ; j++)
        for (int p = rw_coupling_colind[RW_NX + j]; p < rw_coupling_colind[RW_NX + j + 1]; p++)
            if (fabs(m->coupling[p]) * rw_z_nominal[j] >= 1e-9) return 0;
    return 1;
}
