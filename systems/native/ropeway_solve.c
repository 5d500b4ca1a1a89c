/* Solution of the equations by a damped Newton's method. A failure is a status and a message; values of a failed solve
 * are never returned. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

const rw_pattern rw_whole = {RW_NW, rw_colind, rw_row, rw_column_order};

#define TOLERANCE 1e-12 /* of the predicted next Newton step, scaled */

/* Scaled residuals of x - base - hg f = 0 and g = 0; their norm, INFINITY if they are not finite. */
static double residual(rw_instance *m, double t, const double *x, const double *z, const double *u, const double *base,
                       double hg)
{
    double sum = 0.0;
    if (rw_equations(m, t, x, z, u)) return INFINITY;
    for (int i = 0; i < RW_NX; i++) m->residual[i] = (x[i] - base[i] - hg * m->f[i]) / rw_x_nominal[i];
    for (int i = 0; i < RW_NZ; i++) m->residual[RW_NX + i] = m->g[i] / rw_r_nominal[i];
    for (int i = 0; i < RW_NW; i++) sum += m->residual[i] * m->residual[i];
    return isfinite(sum) ? sqrt(sum) : INFINITY;
}

/* Derivatives of f and g by x and z at a point, by changes in the directions of groups of these: no equation depends on
 * two of a group. */
static int by_groups(rw_instance *m)
{
    const double zero = 0.0;
    double *direction = m->work;
    for (int group = 0; group < RW_GROUPS; group++) {
        for (int j = 0; j < RW_NW; j++) direction[j] = rw_group[j] == group;
        m->arg[6] = &zero;
        m->arg[7] = direction;
        m->arg[8] = direction + RW_NX;
        m->arg[9] = m->arg[10] = m->arg[11] = m->none;
        m->res[0] = m->f;
        m->res[1] = m->g;
        m->res[2] = NULL;
        if (rw_tangent(m->arg, m->res, m->iw, m->cw, 0)) return 1;
        for (int j = 0; j < RW_NW; j++)
            for (int p = rw_colind[j]; rw_group[j] == group && p < rw_colind[j + 1]; p++)
                m->s.lu.jac[p] = rw_row[p] < RW_NX ? m->f[rw_row[p]] : m->g[rw_row[p] - RW_NX];
    }
    return 0;
}

/* Derivatives of f and g by x and z at a point, in m->s.lu.jac. */
int rw_matrix(rw_instance *m, double t, const double *x, const double *z, const double *u)
{
    rw_point_arguments(m, &t, x, z, u);
    m->res[0] = m->s.lu.jac;
    m->s.lu.valid = 0;
    if (RW_GROUPS ? by_groups(m) : rw_jacobian_of[0](m->arg, m->res, m->iw, m->cw, 0)) return 1;
    return !rw_all_finite(m->s.lu.jac, RW_NNZ);
}

/* Factors of the scaled matrix from m->s.lu.jac. */
int rw_factor_matrix(rw_instance *m, double hg)
{
    static const int nx = RW_NX;
    double values[RW_NNZ + 1];
    for (int j = 0; j < RW_NW; j++) {
        double scale = j < nx ? rw_x_nominal[j < nx ? j : 0] : rw_z_nominal[j - nx];
        for (int p = rw_colind[j]; p < rw_colind[j + 1]; p++) {
            int i = rw_row[p];
            if (i < nx)
                values[p] = (i == j ? 1.0 : 0.0) - hg * m->s.lu.jac[p] * scale / rw_x_nominal[i];
            else
                values[p] = m->s.lu.jac[p] * scale / rw_r_nominal[i - nx];
        }
    }
    m->s.lu.valid = rw_factor(m, &rw_whole, &m->s.lu, values) == 0;
    m->s.lu.hg = hg;
    m->s.lu.exact = 0;
    return !m->s.lu.valid;
}

rw_status rw_fail(rw_instance *m, const char *reason, double t)
{
    int worst = 0;
    for (int i = 1; i < RW_NW; i++)
        if (!(fabs(m->residual[i]) <= fabs(m->residual[worst]))) worst = i;
    m->s.lu.valid = 0;
    rw_message(m, RW_DISCARD, "logStatusDiscard", "%s at t = %.9g s (worst: %s)", reason, t, rw_equation_name[worst]);
    return RW_DISCARD;
}

static void advance(const double *from, const double *increment, double share, double *x, double *z)
{
    for (int i = 0; i < RW_NX; i++) x[i] = from[i] - share * increment[i] * rw_x_nominal[i];
    for (int i = 0; i < RW_NZ; i++) z[i] = from[RW_NX + i] - share * increment[RW_NX + i] * rw_z_nominal[i];
}

/* Solves x - base - hg f(x, z) = 0 and g(x, z) = 0 in place for given u. Factors are reused while the iteration
 * converges; a step that increases the residual is repeated with new factors, then damped. After a failure x and z are
 * unchanged. */
rw_status rw_newton(rw_instance *m, double t, double *x, double *z, const double *u, const double *base, double hg)
{
    double first[RW_NW + 1], *from = m->w, before = INFINITY, last = INFINITY;
    int fresh = 0, renew = !m->s.lu.valid || m->s.lu.hg != hg;
    rw_status status = RW_DISCARD;
    if (RW_NZ == 0 && hg == 0.0) return RW_OK;
    memcpy(first, x, RW_NX * sizeof(double));
    memcpy(first + RW_NX, z, RW_NZ * sizeof(double));
    memcpy(from, first, sizeof first);
    m->s.lu.exact = 0;
    for (int it = 0; it < 60; it++) {
        double norm = residual(m, t, x, z, u, base, hg), size = 0.0, rate;
        if (it == 0 && isinf(norm)) {
            memset(m->residual, 0, sizeof m->residual);
            rw_fail(m, "The equations are not finite", t);
            goto failed;
        }
        if (it > 0 && !(norm <= 0.9 * before || (last < 1e-6 && norm <= 1e-12))) {
            if (!fresh) { /* repeat with new factors */
                memcpy(x, from, RW_NX * sizeof(double));
                memcpy(z, from + RW_NX, RW_NZ * sizeof(double));
                norm = residual(m, t, x, z, u, base, hg);
                renew = 1;
            } else {
                double share = 0.5;
                for (;; share *= 0.5) {
                    if (share < 1e-7) {
                        rw_fail(m, "Newton's method stalled", t);
                        goto failed;
                    }
                    advance(from, m->increment, share, x, z);
                    norm = residual(m, t, x, z, u, base, hg);
                    if (norm <= (1.0 - 0.1 * share) * before) break;
                }
                renew = 1;
            }
            last = INFINITY;
        }
        fresh = 0;
        if (renew) {
            if (rw_matrix(m, t, x, z, u) || rw_factor_matrix(m, hg)) {
                rw_fail(m, "The equations are singular", t);
                goto failed;
            }
            renew = 0;
            fresh = 1;
        }
        memcpy(m->increment, m->residual, sizeof m->residual);
        rw_back(&rw_whole, &m->s.lu, m->increment, m->work);
        if (hg == 0.0) memset(m->increment, 0, RW_NX * sizeof(double)); /* x is given and stays unchanged */
        for (int i = 0; i < RW_NW; i++)
            if (!(fabs(m->increment[i]) <= size)) size = fabs(m->increment[i]);
        if (!isfinite(size)) {
            rw_fail(m, "The equations are singular", t);
            goto failed;
        }
        memcpy(from, x, RW_NX * sizeof(double));
        memcpy(from + RW_NX, z, RW_NZ * sizeof(double));
        advance(from, m->increment, 1.0, x, z);
        rate = size / last; /* 0 in the first iteration */
        if (norm <= 1e-15 * sqrt((double)RW_NW) || size <= 0.1 * TOLERANCE) return RW_OK;
        if (fresh ? (isinf(last) ? 10.0 * size * size <= TOLERANCE : size < 1e-3 && size * rate <= TOLERANCE)
                  : (isfinite(last) && rate < 0.5 && size * rate / (1.0 - rate) <= TOLERANCE))
            return RW_OK;
        if (isfinite(last) && last < 1e-9 && rate > 0.5) return RW_OK; /* at the level of rounding errors */
        if (!fresh && isfinite(last) && rate > 0.1) renew = 1;
        before = norm;
        last = size;
    }
    status = rw_fail(m, "Newton's method did not converge", t);
failed:
    memcpy(x, first, RW_NX * sizeof(double));
    memcpy(z, first + RW_NX, RW_NZ * sizeof(double));
    return status;
}

/* Solves the equations of the active place, or the sections of a line. */
rw_status rw_solve_here(rw_instance *m)
{
    rw_point *q = &m->s.now;
    rw_status status;
    m->s.lu.exact = 0;
    if (RW_SECTIONS) return rw_solve_line(m);
    if (RW_INERTIAL && rw_core_solve(m)) return RW_OK;
    rw_inputs_at(m, q->t, m->us);
    status = rw_newton(m, q->t, q->x, q->z, m->us, q->x, 0.0);
    if (status != RW_OK) return status;
    if (rw_rate_function(m, q->t, q->x, q->z, m->us, m->s.rate)) {
        memset(m->residual, 0, sizeof m->residual);
        return rw_fail(m, "The rates are not finite", q->t);
    }
    m->s.solved = 1;
    m->s.rated = m->s.shown = 0;
    return RW_OK;
}

/* Margins of the carriage's place at the present solution, in m->margin. */
rw_status rw_margins_of(rw_instance *m)
{
    rw_inputs_at(m, m->s.now.t, m->us);
    rw_point_arguments(m, &m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    m->res[0] = m->margin;
    return rw_margins[0](m->arg, m->res, m->iw, m->cw, 0) || !rw_all_finite(m->margin, RW_NG) ? RW_DISCARD : RW_OK;
}
