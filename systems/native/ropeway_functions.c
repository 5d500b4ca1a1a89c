/* Values of the generated functions at a point, and inputs in time. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

void rw_point_arguments(rw_instance *m, const double *t, const double *x, const double *z, const double *u)
{
    m->arg[0] = t;
    m->arg[1] = x;
    m->arg[2] = z;
    m->arg[3] = u;
    m->arg[4] = m->s.p;
    m->arg[5] = m->s.d;
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
    rw_point_arguments(m, &t, x, z, u);
    m->res[0] = m->f;
    m->res[1] = m->g;
    return rw_dae(m->arg, m->res, m->iw, m->cw, 0) || !rw_all_finite(m->f, RW_NX) || !rw_all_finite(m->g, RW_NZ);
}

int rw_rate_function(rw_instance *m, double t, const double *x, const double *z, const double *u, double *rate)
{
    if (RW_SECTIONS) {
        rw_point_arguments(m, &t, x, z, u);
        m->res[0] = rate;
        return rw_rates_alone[0](m->arg, m->res, m->iw, m->cw, 0) || !rw_all_finite(rate, RW_NX);
    }
    if (rw_equations(m, t, x, z, u)) return 1;
    memcpy(rate, m->f, RW_NX * sizeof(double));
    return 0;
}

/* New values of a clock at the present point, in m->sample. */
int rw_sample(rw_instance *m, int clock)
{
    int n = rw_clock_first[clock + 1] - rw_clock_first[clock];
    rw_inputs_at(m, m->s.now.t, m->us);
    rw_point_arguments(m, &m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    m->res[0] = m->sample;
    return rw_clock_update[clock](m->arg, m->res, m->iw, m->cw, 0) || !rw_all_finite(m->sample, n);
}

/* Derivatives of the rates of the drives of a line by states and algebraic variables, in m->coupling. */
int rw_couplings(rw_instance *m)
{
    rw_inputs_at(m, m->s.now.t, m->us);
    rw_point_arguments(m, &m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    m->res[0] = m->coupling;
    return rw_coupling[0](m->arg, m->res, m->iw, m->cw, 0) || !rw_all_finite(m->coupling, RW_NCP);
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
