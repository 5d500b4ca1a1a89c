/* A line solved by its sections (see sections.h), each by itself. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

static const char *const failures[] = {"", "The equations are singular", "Newton's method stalled",
                                       "Newton's method did not converge"};

/* The present point, with `x_rate` as the rates of its states; inputs are those in m->us. Loads are counted where
 * they are put into their slots. */
static rs_point point_of(rw_instance *m, double *x_rate, double *z_rate)
{
    rs_point q = {0};
    q.x = m->s.now.x, q.z = m->s.now.z, q.u = m->us, q.p = m->s.p, q.d = m->s.d;
    q.used = m->used, q.x_rate = x_rate, q.u_rate = m->us_rate, q.z_rate = z_rate, q.work = m->line_work;
    return q;
}

/* Inputs and their rates now. */
static void put_inputs(rw_instance *m)
{
    rw_inputs_at(m, m->s.now.t, m->us);
    memcpy(m->us_rate, m->s.slope, RW_NU * sizeof(double));
    rw_input_rates(m, m->s.now.t, 1.0, m->us_rate);
}

static rw_status solve_section(rw_instance *m, int section, int rates)
{
    rs_point q = point_of(m, m->s.rate, m->s.zrate);
    int failed;
    failed = rs_solve(&rw_line, &q, section, rates);
    if (!failed) return RW_OK;
    rw_message(m, RW_DISCARD, "logStatusDiscard", "%s at t = %.9g s (worst: %s)", failures[failed], m->s.now.t,
               rw_equation_name[RW_NX + q.worst]);
    return RW_DISCARD;
}

/* Solves some sections at the present point, with the rates of their variables for the rates of the states. */
rw_status rw_solve_sections(rw_instance *m, const int *sections, int count)
{
    put_inputs(m);
    for (int i = 0; i < count; i++) {
        rw_status status = solve_section(m, sections[i], 1);
        if (status != RW_OK) return status;
    }
    return RW_OK;
}

/* Solves all sections; after a failure the algebraic variables are unchanged. */
rw_status rw_solve_all_sections(rw_instance *m, int rates)
{
    double *before = m->before_z;
    put_inputs(m);
    memcpy(before, m->s.now.z, RW_NZ * sizeof(double));
    for (int i = 0; i < rw_line.sections; i++) {
        rw_status status = solve_section(m, i, rates);
        if (status == RW_OK) continue;
        memcpy(m->s.now.z, before, RW_NZ * sizeof(double));
        return status;
    }
    return RW_OK;
}

/* Solves the line at the present point, and the rates of its states. */
rw_status rw_solve_line(rw_instance *m)
{
    rw_point *q = &m->s.now;
    rw_status status = RW_OK;
    m->s.rated = m->s.shown = 0;
    for (int pass = 0; pass < 2; pass++) { /* rates that depend on the line follow from its solution */
        if (pass == !RW_COUPLED) {
            status = rw_solve_all_sections(m, !RW_COUPLED);
            if (status != RW_OK) return status;
            continue;
        }
        rw_inputs_at(m, q->t, m->us);
        if (!rw_rate_function(m, q->t, q->x, q->z, m->us, m->s.rate)) continue;
        rw_message(m, RW_DISCARD, "logStatusDiscard", "The rates are not finite at t = %.9g s", q->t);
        return RW_DISCARD;
    }
    m->s.solved = 1;
    m->s.rated = !RW_COUPLED;
    return status;
}

/* Rates of the algebraic variables of a solved line, in m->s.zrate. */
rw_status rw_line_rates(rw_instance *m)
{
    rs_point q = point_of(m, m->s.rate, m->s.zrate);
    put_inputs(m);
    for (int i = 0; i < rw_line.sections; i++) {
        rs_linearise(&rw_line, &q, i);
        rs_section_rates(&rw_line, &q, i);
    }
    if (!rw_all_finite(m->s.zrate, RW_NZ)) {
        rw_message(m, RW_DISCARD, "logStatusDiscard", "The equations are singular at t = %.9g s", m->s.now.t);
        return RW_DISCARD;
    }
    m->s.rated = 1;
    return RW_OK;
}

/* Adds to the matrix of the drives, `values` in the pattern rw_drives, what a state changes in their rates through the
 * line: `by_z` are the derivatives of the rates by the algebraic variables, times `factor`. */
void rw_through_line(rw_instance *m, const double *coupling, double factor, double *values)
{
    rs_point q = point_of(m, m->dx, m->dz);
    put_inputs(m);
    memset(m->us_rate, 0, RW_NU * sizeof(double));
    memset(m->dx, 0, RW_NX * sizeof(double));
    for (int i = 0; i < rw_line.sections; i++) rs_linearise(&rw_line, &q, i);
    for (int j = 0; j < RW_NX; j++) {
        m->dx[j] = 1.0;
        memset(m->df, 0, RW_NX * sizeof(double));
        for (int s = rw_state_section_first[j]; s < rw_state_section_first[j + 1]; s++) {
            int section = rw_state_section[s], a = rw_line.first[section], span = rw_line.first_span[section];
            rs_section_rates(&rw_line, &q, section);
            for (int k = a; k <= rw_line.last[section]; k++) {
                int places[4], count = 0;
                for (int i = 0; k < rw_line.last[section] && i < 3; i++) places[count++] = rw_line.force[span + k - a] + i;
                if (rw_line.travel[k] >= 0) places[count++] = rw_line.travel[k];
                for (int i = 0; i < count; i++)
                    for (int p = rw_coupling_colind[RW_NX + places[i]]; p < rw_coupling_colind[RW_NX + places[i] + 1]; p++)
                        m->df[rw_coupling_row[p]] += coupling[p] * m->dz[places[i]];
            }
        }
        for (int p = rw_drives_colind[j]; p < rw_drives_colind[j + 1]; p++)
            values[p] += factor * m->df[rw_drives.row[p]] * rw_x_nominal[j] / rw_x_nominal[rw_drives.row[p]];
        m->dx[j] = 0.0;
    }
}

/* Tension vector of a span's rope at its end b, at the present point. */
void rw_span_end(rw_instance *m, int span, double *force)
{
    rs_point q = point_of(m, m->s.rate, m->s.zrate);
    double result[RS_SPAN];
    rw_inputs_at(m, m->s.now.t, m->us);
    rs_span(&rw_line, &q, span, result);
    for (int i = 0; i < 3; i++) force[i] = -result[3 + i]; /* the kernel has the force on the support */
}

/* Residual of the tension law of an idler with `share` of a load added to the forces of both ropes; no load holds it. */
double rw_line_law(rw_instance *m, int k, const double *load, double share)
{
    rs_point q = point_of(m, m->s.rate, m->s.zrate);
    int span = k - rw_run_of[k];
    double coming[3], going[3], result[RS_SUPPORT], held = m->s.d[rw_held[k]];
    rw_span_end(m, span - 1, coming);
    for (int i = 0; i < 3; i++) {
        coming[i] = -(coming[i] + share * load[i]);
        going[i] = m->s.now.z[rw_line.force[span] + i] + share * load[i];
    }
    m->s.d[rw_held[k]] = 0.0;
    rs_support(&rw_line, &q, k, coming, going, result);
    m->s.d[rw_held[k]] = held;
    return result[0];
}
