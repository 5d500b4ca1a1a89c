/* Trial states of an importer in Model Exchange, also far beyond the next crossing, where the loads of a span would be
 * beyond its end. Where its equations have no solution there, the algebraic variables and outputs keep their values from
 * the crossing, and travels go on at their rates: rates stay finite, and event indicators change their signs. An accepted
 * point is always solved. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

#define HALVINGS 20

/* The last accepted point, which is solved, and the time of its next crossing. */
rw_status rw_accept_point(rw_instance *m)
{
    rw_ahead *a = &m->s.ahead;
    rw_crossing coming;
    rw_status status;
    if (RW_NPL || RW_NK == 0) return RW_OK;
    status = rw_rates(m);
    if (status != RW_OK) return status;
    rw_copy_point(&m->s.held, &m->s.now);
    memcpy(a->zrate, m->s.zrate, RW_NZ * sizeof(double));
    a->near = a->unsolved = INFINITY;
    if (rw_next_crossing(m, &coming)) a->near = fmax(coming.time, 0.0);
    a->kept = a->stale = 0;
    return RW_OK;
}

/* Before the present point is accepted or has an event it is solved as it is. */
void rw_leave_trial(rw_instance *m)
{
    if (!m->s.ahead.beyond) return;
    memcpy(m->s.now.z, m->s.held.z, RW_NZ * sizeof(double));
    m->s.solved = m->s.rated = m->s.shown = m->s.lu.valid = m->s.ahead.beyond = 0;
}

/* Solution and outputs at a share of the path from the accepted point; the share is halved until it succeeds. */
static rw_status keep(rw_instance *m, const rw_point *to, double share)
{
    const rw_point *from = &m->s.held;
    rw_point *q = &m->s.now;
    rw_status status = RW_DISCARD;
    for (int trial = 0; trial < HALVINGS && status != RW_OK; trial++, share *= 0.5) {
        double time = share * (to->t - from->t);
        q->t = from->t + time;
        for (int i = 0; i < RW_NX; i++) q->x[i] = from->x[i] + share * (to->x[i] - from->x[i]);
        for (int i = 0; i < RW_NZ; i++) q->z[i] = from->z[i] + time * m->s.ahead.zrate[i];
        m->s.solved = m->s.rated = m->s.shown = m->s.lu.valid = 0;
        status = rw_solve_here(m);
        if (status == RW_OK) status = rw_show(m);
    }
    if (status != RW_OK) return status;
    memcpy(m->s.ahead.z, q->z, RW_NZ * sizeof(double));
    m->s.ahead.t = q->t;
    m->s.ahead.kept = 1;
    return RW_OK;
}

/* A state beyond the crossing. */
static rw_status beyond(rw_instance *m, const rw_point *to)
{
    rw_ahead *a = &m->s.ahead;
    rw_point *q = &m->s.now;
    double ahead = to->t - m->s.held.t;
    rw_status status = a->kept ? RW_OK : keep(m, to, ahead > a->near ? a->near / ahead : 0.5);
    if (status != RW_OK) return status;
    rw_copy_point(q, to);
    memcpy(q->z, a->z, RW_NZ * sizeof(double));
    for (int k = 0; k < RW_NK; k++)
        if (rw_travel[k] >= RW_NX) q->z[rw_travel[k] - RW_NX] = a->z[rw_travel[k] - RW_NX] + (to->t - a->t) * a->zrate[rw_travel[k] - RW_NX];
    rw_inputs_at(m, q->t, m->us);
    if (rw_rate_function(m, q->t, q->x, q->z, m->us, m->s.rate)) return RW_DISCARD;
    m->s.solved = m->s.shown = a->beyond = 1;
    m->s.rated = m->s.lu.valid = 0;
    return RW_OK;
}

/* Solves a trial state. */
rw_status rw_look_ahead(rw_instance *m)
{
    rw_ahead *a = &m->s.ahead;
    const rw_point *to = &m->trial;
    rw_log_function log = m->log;
    rw_status status = RW_DISCARD;
    if (m->s.mode != RW_CONTINUOUS || RW_NPL || RW_NK == 0 || m->s.solved) return RW_OK;
    rw_copy_point(&m->trial, &m->s.now);
    if (a->beyond) memcpy(m->s.now.z, m->s.held.z, RW_NZ * sizeof(double));
    a->beyond = 0;
    m->log = NULL; /* failures are repeated */
    if (to->t - m->s.held.t < a->unsolved) {
        status = rw_solve_here(m);
        if (status != RW_OK && to->t - m->s.held.t > a->near) a->unsolved = to->t - m->s.held.t;
    }
    if (status == RW_OK && a->stale && to->t == m->s.held.t) status = rw_accept_point(m); /* inputs have changed */
    if (status != RW_OK) status = beyond(m, to);
    m->log = log;
    if (status == RW_OK) return RW_OK;
    rw_copy_point(&m->s.now, to);
    memcpy(m->s.now.z, m->s.held.z, RW_NZ * sizeof(double));
    m->s.solved = m->s.rated = m->s.shown = m->s.lu.valid = 0;
    rw_message(m, RW_DISCARD, "logStatusDiscard", "The line has no solution at the trial state at t = %.9g s", to->t);
    return RW_DISCARD;
}
