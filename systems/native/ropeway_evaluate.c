/* Outputs, rates and derivatives at a solved point. */
#include <string.h>
#include "ropeway.h"

/* Solves the algebraic variables at the present point. */
rw_status rw_solve(rw_instance *m)
{
    if (m->s.solved) return RW_OK;
    return RW_NPL ? rw_follow(m) : rw_solve_here(m);
}

/* Solves, and computes the outputs. */
rw_status rw_show(rw_instance *m)
{
    rw_status status = rw_solve(m);
    if (status != RW_OK || m->s.shown) return status;
    rw_inputs_at(m, m->s.now.t, m->us);
    rw_point_arguments(m, &m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    m->res[0] = m->s.y;
    if (rw_outputs(m->arg, m->res, m->iw, m->cw, 0) || !rw_all_finite(m->s.y, RW_NY)) {
        rw_message(m, RW_DISCARD, "logStatusDiscard", "The outputs are not finite at t = %.9g s", m->s.now.t);
        return RW_DISCARD;
    }
    m->s.shown = 1;
    return RW_OK;
}

/* Values of the limits' outputs at the present solution, in m->limit. */
rw_status rw_limit_values(rw_instance *m)
{
    rw_status status = RW_SECTIONS ? rw_solve(m) : rw_show(m);
    if (status != RW_OK) return status;
    if (!RW_SECTIONS || m->s.shown) {
        for (int i = 0; i < RW_NL; i++) m->limit[i] = m->s.y[rw_limit_output[i]];
        return RW_OK;
    }
    rw_inputs_at(m, m->s.now.t, m->us);
    rw_point_arguments(m, &m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    m->res[0] = m->limit;
    if (!rw_limits_alone[0](m->arg, m->res, m->iw, m->cw, 0) && rw_all_finite(m->limit, RW_NL)) return RW_OK;
    rw_message(m, RW_DISCARD, "logStatusDiscard", "The limits are not finite at t = %.9g s", m->s.now.t);
    return RW_DISCARD;
}

/* Factors of the matrix at the present solution. */
static rw_status exact(rw_instance *m)
{
    rw_status status = rw_solve(m);
    if (status != RW_OK) return status;
    if (m->s.lu.valid && m->s.lu.exact && m->s.lu.hg == 0.0) return RW_OK;
    rw_inputs_at(m, m->s.now.t, m->us);
    if (rw_matrix(m, m->s.now.t, m->s.now.x, m->s.now.z, m->us) || rw_factor_matrix(m, 0.0)) {
        memset(m->residual, 0, sizeof m->residual);
        return rw_fail(m, "The equations are singular", m->s.now.t);
    }
    m->s.lu.exact = 1;
    return RW_OK;
}

/* Rates of the algebraic variables, in m->s.zrate, for prediction. Where rates depend on inputs only, existing factors
 * are accurate enough; otherwise the matrix is evaluated again, as the steps start from it. */
rw_status rw_rates(rw_instance *m)
{
    rw_status status = rw_solve(m);
    if (status != RW_OK || m->s.rated) return status;
    if (RW_SECTIONS) return rw_line_rates(m);
    if (RW_INERTIAL && rw_core_solve(m)) return RW_OK;
    if (RW_COUPLED || !m->s.lu.valid || m->s.lu.hg != 0.0) {
        m->s.lu.exact = 0;
        status = exact(m);
        if (status != RW_OK) return status;
    }
    memset(m->increment, 0, sizeof m->increment);
    for (int j = 0; j < RW_NX; j++)
        for (int p = rw_colind[j]; p < rw_colind[j + 1]; p++)
            if (rw_row[p] >= RW_NX) m->increment[rw_row[p]] -= m->s.lu.jac[p] * m->s.rate[j] / rw_r_nominal[rw_row[p] - RW_NX];
    rw_back(&rw_whole, &m->s.lu, m->increment, m->work);
    for (int i = 0; i < RW_NZ; i++) m->s.zrate[i] = m->increment[RW_NX + i] * rw_z_nominal[i];
    m->s.rated = 1;
    return RW_OK;
}

/* Changes of rates (m->df), algebraic variables (m->dz) and outputs (m->dy) with the seeds dt, dx, du, dp. */
rw_status rw_tangent_of(rw_instance *m)
{
    rw_status status = exact(m);
    if (status != RW_OK) return status;
    memset(m->dz, 0, sizeof m->dz);
    rw_slot_seeds(m);
    for (int pass = 0; pass < 2; pass++) {
        rw_inputs_at(m, m->s.now.t, m->us);
        rw_point_arguments(m, &m->s.now.t, m->s.now.x, m->s.now.z, m->us);
        m->arg[6] = &m->dt;
        m->arg[7] = m->dx;
        m->arg[8] = m->dz;
        m->arg[9] = m->du;
        m->arg[10] = m->dp;
        m->arg[11] = m->dd;
        m->res[0] = m->df;
        m->res[1] = m->dg;
        m->res[2] = m->dy;
        if (rw_tangent(m->arg, m->res, m->iw, m->cw, 0)) return RW_DISCARD;
        if (pass == 0) {
            memset(m->increment, 0, sizeof m->increment);
            for (int i = 0; i < RW_NZ; i++) m->increment[RW_NX + i] = -m->dg[i] / rw_r_nominal[i];
            rw_back(&rw_whole, &m->s.lu, m->increment, m->work);
            for (int i = 0; i < RW_NZ; i++) m->dz[i] = m->increment[RW_NX + i] * rw_z_nominal[i];
        }
    }
    if (!rw_all_finite(m->df, RW_NX) || !rw_all_finite(m->dz, RW_NZ) || !rw_all_finite(m->dy, RW_NY)) {
        rw_message(m, RW_DISCARD, "logStatusDiscard", "The derivatives are not finite at t = %.9g s", m->s.now.t);
        return RW_DISCARD;
    }
    return RW_OK;
}
