/* A carriage that moves between places: spans of a skyline and the shoes between them. Each place has its own equations
 * and margins: distances of the carriage from the transition to another place, or from the end of its path. The place
 * depends on the path of the states: the algebraic variables are solved follow_path it, place by place, from the last held
 * point. So every reachable state has a solution, also trial states of an importer beyond an event; accepted points are
 * held. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

#define CLOSE 1e-13 /* of the path: resolution of a transition */
#define TRIALS 1000
#define CHANGES 50 /* largest number of transitions within one solution */

void rw_start_place(rw_instance *m)
{
    m->s.held.t = m->s.now.t;
    memcpy(m->s.held.x, rw_x_start, RW_NX * sizeof(double));
    memcpy(m->s.held.z, rw_z_start, RW_NZ * sizeof(double));
    m->s.place = rw_place_of(m);
}

/* Logs a transition of the carriage. */
static void report(rw_instance *m, int from, int to)
{
    for (int row = rw_passage_first[from]; row < rw_passage_first[from + 1]; row++)
        if (rw_passage_to[row] == to) {
            rw_message(m, RW_OK, "logEvents", "t = %.9f s: carriage: %s", m->s.now.t, rw_passage_event[row]);
            return;
        }
}

/* Holds the present point, which is solved. */
void rw_hold(rw_instance *m)
{
    if (!RW_NPL) return;
    if (!m->co_simulation && m->s.mode > RW_INITIALIZATION && m->s.place != rw_place_of(m))
        report(m, m->s.place, rw_place_of(m));
    rw_copy_point(&m->s.held, &m->s.now);
    m->s.place = rw_place_of(m);
}

/* Solves at a fraction of the path, from the present algebraic variables, and evaluates the margins. */
static rw_status solve_at(rw_instance *m, const rw_point *from, const rw_point *to, double share)
{
    rw_point *q = &m->s.now;
    rw_status status;
    q->t = share == 1.0 ? to->t : from->t + share * (to->t - from->t);
    for (int i = 0; i < RW_NX; i++) q->x[i] = share == 1.0 ? to->x[i] : from->x[i] + share * (to->x[i] - from->x[i]);
    m->s.solved = m->s.rated = m->s.shown = 0;
    status = rw_solve_here(m);
    return status != RW_OK ? status : rw_margins(m) ? RW_DISCARD : RW_OK;
}

/* Number of the margin that became negative first since `before`; -1 if none did. */
static int violated_margin(const rw_instance *m, const double *before)
{
    int found = -1, place = rw_place_of(m);
    double first = INFINITY;
    for (int i = 0; i < rw_passage_first[place + 1] - rw_passage_first[place]; i++) {
        double share = before[i] <= RW_NEAR ? 0.0 : before[i] / (before[i] - m->margin[i]);
        if (m->margin[i] >= -RW_NEAR || share >= first) continue;
        found = i;
        first = share;
    }
    return found;
}

/* Transition to the place beyond margin i. */
static rw_status transition(rw_instance *m, int i, const rw_point *from, const rw_point *to, double share)
{
    int place = rw_place_of(m), row = rw_passage_first[place] + i, beyond = rw_passage_to[row];
    if (beyond < 0) {
        rw_message(m, RW_ERROR, "logStatusError", "At t = %.9g s: %s", m->s.now.t, rw_passage_event[row]);
        return RW_ERROR;
    }
    m->s.d[0] = beyond;
    for (int n = 0; n < RW_NZ; n++) m->s.now.z[n] += rw_passage_jump[row * RW_NZ + n];
    m->s.lu.valid = 0;
    if (m->co_simulation && to->t > from->t) report(m, place, beyond);
    return solve_at(m, from, to, share);
}

/* Continuation follow_path the path from the held point to the present one; existing factors are invalid. */
static rw_status follow_path(rw_instance *m, const rw_point *from, const rw_point *to)
{
    rw_point *q = &m->s.now;
    rw_log_function log = m->log;
    double *before = m->margin_before, *good = m->good_z, reached = 0.0, step = 0.5, beyond = 2.0, over = 0.0;
    int border = -1, inside = 0, changes = 0;
    rw_status status;
    memcpy(q->z, from->z, RW_NZ * sizeof(double));
    m->s.lu.valid = 0;
    status = solve_at(m, from, to, 0.0);
    for (int trial = 0; status == RW_OK && trial < TRIALS; trial++) {
        double next = fmin(reached + step, 1.0);
        int out;
        memcpy(before, m->margin, RW_NG * sizeof(double));
        memcpy(good, q->z, RW_NZ * sizeof(double));
        m->log = NULL; /* failures are repeated with smaller steps */
        status = solve_at(m, from, to, next);
        m->log = log;
        out = status == RW_OK ? violated_margin(m, before) : -1;
        if (status == RW_OK && out < 0) {
            reached = next;
            if (reached == 1.0) return RW_OK;
            step *= 2.0;
            over *= 0.5;
            inside++;
            if (reached >= beyond) border = -1; /* the margin belonged to another solution */
        } else {
            memcpy(q->z, good, RW_NZ * sizeof(double));
            m->s.lu.valid = 0;
            if (out >= 0) {
                border = out;
                beyond = next;
                over = m->margin[out];
                inside = 0;
            } else if ((step = 0.5 * (next - reached)) < 1e-9)
                break;
            memcpy(m->margin, before, RW_NG * sizeof(double));
            status = RW_OK;
        }
        if (border >= 0 && (m->margin[border] <= RW_NEAR || beyond - reached < CLOSE)) {
            status = solve_at(m, from, to, reached);
            if (status == RW_OK) status = ++changes > CHANGES ? RW_DISCARD : transition(m, border, from, to, reached);
            border = -1;
            beyond = 2.0;
            step = 1.0;
        } else if (border >= 0) {
            double share = trial % 3 == 2 ? 0.5 : m->margin[border] / (m->margin[border] - over);
            step = fmin(step, (beyond - reached) * (inside > 4 ? 1.0 : fmax(share, 0.1)));
        }
    }
    if (status != RW_ERROR) {
        status = RW_DISCARD;
        rw_message(m, status, "logStatusDiscard", "The carriage cannot be followed beyond t = %.9g s", q->t);
    }
    return status;
}

rw_status rw_follow(rw_instance *m)
{
    const rw_point *from = &m->path_from, *to = &m->path_to;
    rw_log_function log = m->log;
    rw_status status;
    rw_copy_point(&m->path_from, &m->s.held);
    rw_copy_point(&m->path_to, &m->s.now);
    if (rw_place_of(m) != m->s.place) { /* the last point was a rejected trial of the importer */
        m->s.d[0] = m->s.place;
        memcpy(m->s.now.z, from->z, RW_NZ * sizeof(double));
        m->s.lu.valid = 0;
    }
    m->log = NULL;
    status = solve_at(m, from, to, 1.0);
    m->log = log;
    if (status != RW_OK || violated_margin(m, m->no_margin) >= 0) status = follow_path(m, from, to);
    if (status == RW_OK) {
        if (m->s.mode != RW_CONTINUOUS) rw_hold(m);
        return RW_OK;
    }
    m->s.d[0] = m->s.place;
    rw_copy_point(&m->s.now, to);
    memcpy(m->s.now.z, from->z, RW_NZ * sizeof(double));
    m->s.solved = m->s.rated = m->s.shown = m->s.lu.valid = 0;
    return status;
}

/* One indicator for each transition between consecutive places: positive before it, negative beyond. */
rw_status rw_border_indicators(rw_instance *m, double *indicator)
{
    int place = rw_place_of(m);
    if (rw_margins(m)) return RW_DISCARD;
    for (int j = 0; j < RW_NB; j++) indicator[j] = place <= j ? 1.0 : -1.0;
    for (int row = rw_passage_first[place]; row < rw_passage_first[place + 1]; row++) {
        double left = fmax(m->margin[row - rw_passage_first[place]] + 2.0 * RW_NEAR, RW_NEAR);
        for (int j = place; j < rw_passage_to[row]; j++) indicator[j] = fmin(indicator[j], left);
        for (int j = rw_passage_to[row]; j >= 0 && j < place; j++) indicator[j] = fmax(indicator[j], -left);
    }
    return RW_OK;
}
