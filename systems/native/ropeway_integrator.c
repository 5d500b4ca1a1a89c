/* One step of the states, with its error.
 *
 * The integrator is ARK3(2)4L[2]SA-ESDIRK (Kennedy and Carpenter 2003): four stages, stiffly accurate: a
 * restart at a communication point costs nothing, and the end point satisfies the algebraic equations. Where
 * rates depend on inputs only (commanded speeds) they are integrated exactly. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

#define GAMMA (1767732205903.0 / 4055673282236.0)
#define STAGE_TOLERANCE 1e-12 /* of the step of Newton's method, scaled */
#define STAGE_ITERATIONS 30

static const double stage_time[4] = {0.0, 2.0 * GAMMA, 0.6, 1.0};
static const double stage_weight[4][3] = {
    {0.0, 0.0, 0.0},
    {GAMMA, 0.0, 0.0},
    {2746238789719.0 / 10658868560708.0, -640167445237.0 / 6845629431997.0, 0.0},
    {1471266399579.0 / 7840856788654.0, -4482444167858.0 / 7529755066697.0, 11266239266428.0 / 11593286722821.0},
};
static const double lower_order[4] = {
    2756255671327.0 / 12835298489170.0,
    -10771552573575.0 / 22201958757719.0,
    9247589265047.0 / 10645013368117.0,
    2193209047091.0 / 5459859503100.0,
};

/* A step of states whose rates depend on inputs only. */
static rw_status driven_step(rw_instance *m, const rw_point *from, double h, int alone)
{
    rw_point *q = &m->s.now;
    double *rate = m->stage[0];
    rw_status status;
    memcpy(rate, m->s.rate, RW_NX * sizeof(double));
    q->t = from->t + h;
    for (int i = 0; i < RW_NX; i++) q->x[i] = from->x[i] + h * rate[i];
    for (int i = 0; i < RW_NZ; i++) q->z[i] = from->z[i] + h * m->s.zrate[i];
    m->s.solved = m->s.rated = m->s.shown = 0;
    if (RW_SECTIONS) {
        rw_inputs_at(m, q->t, m->us);
        if (rw_rate_function(m, q->t, q->x, q->z, m->us, m->s.rate)) return RW_DISCARD;
    } else {
        status = rw_solve(m);
        if (status != RW_OK || memcmp(rate, m->s.rate, RW_NX * sizeof(double)) == 0) return status;
    }
    for (int i = 0; i < RW_NX; i++) q->x[i] = from->x[i] + h / 2.0 * (rate[i] + m->s.rate[i]);
    m->s.solved = m->s.rated = m->s.shown = 0;
    return alone ? RW_OK : rw_solve(m);
}

/* The matrix of the drives of a line, factorised: alone, or with what the line adds. */
static int drive_matrix(rw_instance *m, double hg, int alone)
{
    double *values = m->values;
    if (rw_couplings(m)) return 1;
    for (int j = 0; j < RW_NX; j++) {
        memset(m->df, 0, RW_NX * sizeof(double));
        for (int p = rw_coupling_colind[j]; p < rw_coupling_colind[j + 1]; p++) m->df[rw_coupling_row[p]] = m->coupling[p];
        for (int p = rw_drives_colind[j]; p < rw_drives_colind[j + 1]; p++) {
            int i = rw_drives.row[p];
            values[p] = (i == j ? 1.0 : 0.0) - hg * m->df[i] * rw_x_nominal[j] / rw_x_nominal[i];
        }
    }
    if (!alone) rw_through_line(m, m->coupling, -hg, values);
    m->drives.known = 0; /* a step depends on nothing before */
    m->drives_valid = rn_factor(&m->drives, &rw_drives, values) == RN_OK;
    return !m->drives_valid;
}

/* A stage of the drives of a line: solves x - base - hg f = 0 by Newton's method, with the line in each iteration unless
 * they are alone. */
static rw_status drive_stage(rw_instance *m, double hg, int alone)
{
    rw_point *q = &m->s.now;
    double last = INFINITY;
    for (int it = 0; it < STAGE_ITERATIONS; it++) {
        double size = 0.0, rate;
        rw_status status = alone ? RW_OK : rw_solve_all_sections(m, 0);
        if (status != RW_OK) return status;
        rw_inputs_at(m, q->t, m->us);
        if (rw_rate_function(m, q->t, q->x, q->z, m->us, m->f)) return RW_DISCARD;
        if (!m->drives_valid && drive_matrix(m, hg, alone)) return RW_DISCARD;
        for (int i = 0; i < RW_NX; i++) m->increment[i] = (q->x[i] - m->base[i] - hg * m->f[i]) / rw_x_nominal[i];
        rn_back(&m->drives, &rw_drives, m->increment);
        for (int i = 0; i < RW_NX; i++) {
            q->x[i] -= m->increment[i] * rw_x_nominal[i];
            if (!(fabs(m->increment[i]) <= size)) size = fabs(m->increment[i]);
        }
        if (!isfinite(size)) return RW_DISCARD;
        rate = size / last; /* 0 in the first iteration */
        if (size <= STAGE_TOLERANCE || (isfinite(last) && rate < 0.5 && size * rate <= STAGE_TOLERANCE)) return RW_OK;
        if (last < 1e-9 && rate > 0.5) return RW_OK; /* at the level of rounding errors */
        if (rate > 0.3) m->drives_valid = 0;
        last = size;
    }
    return RW_DISCARD;
}

static rw_status coupled_step(rw_instance *m, const rw_point *from, double h, int alone, double *error)
{
    rw_point *q = &m->s.now;
    double hg = h * GAMMA;
    rw_status status;
    memcpy(m->stage[0], m->s.rate, RW_NX * sizeof(double));
    m->drives_valid = 0;
    if (!RW_SECTIONS && rw_factor_matrix(m, hg)) return RW_DISCARD;
    for (int i = 1; i < 4; i++) {
        double part = i == 1 ? stage_time[1] : i == 2 ? 0.6 - stage_time[1] : 0.4;
        q->t = from->t + stage_time[i] * h;
        rw_inputs_at(m, q->t, m->us);
        for (int n = 0; n < RW_NX; n++) {
            m->base[n] = from->x[n];
            for (int j = 0; j < i; j++) m->base[n] += h * stage_weight[i][j] * m->stage[j][n];
            q->x[n] = m->base[n] + hg * m->stage[i - 1][n];
        }
        for (int n = 0; n < RW_NZ; n++) q->z[n] += part * h * m->s.zrate[n];
        status = RW_SECTIONS ? drive_stage(m, hg, alone) : rw_newton(m, q->t, q->x, q->z, m->us, m->base, hg);
        if (status != RW_OK) return status;
        for (int n = 0; n < RW_NX; n++) m->stage[i][n] = (q->x[n] - m->base[n]) / hg;
    }
    *error = 0.0;
    for (int n = 0; n < RW_NX; n++) {
        double e = 0.0, allowed = m->tolerance * (rw_x_nominal[n] + fmax(fabs(from->x[n]), fabs(q->x[n])));
        for (int i = 0; i < 4; i++) e += h * ((i < 3 ? stage_weight[3][i] : GAMMA) - lower_order[i]) * m->stage[i][n];
        if (!(fabs(e) / allowed <= *error)) *error = fabs(e) / allowed;
    }
    m->s.solved = m->s.rated = m->s.shown = 0;
    if (!alone) return rw_solve(m);
    rw_inputs_at(m, q->t, m->us);
    return rw_rate_function(m, q->t, q->x, q->z, m->us, m->s.rate) ? RW_DISCARD : RW_OK;
}

/* One step of h from `from`, the present point, whose rates are known; `error` is relative to the tolerance. `alone`: of
 * the drives of a line only, with their rates at the end; the line is not solved. */
rw_status rw_one_step(rw_instance *m, const rw_point *from, double h, int alone, double *error)
{
    *error = 0.0;
    return RW_COUPLED ? coupled_step(m, from, h, alone, error) : driven_step(m, from, h, alone);
}
