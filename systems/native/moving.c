/* A line whose drives follow known trajectories, from crossing to crossing. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define NEAR 1e-9     /* part of a mean span within which a load is on a support */
#define SWINGING 1e-6 /* [s]: step of a section that is linear beside a drive at a limit */
#define FOLLOWED 0.02 /* part of a nominal by which an idler's travel may be elsewhere than its rate leads to */

/* Weights of the points of the window at a time, and their sum; the point itself where the time is there, else -1. */
typedef struct {
    double weight[RS_NODES], sum;
    int node;
} weights;

static weights weigh(const rs_motion *m, double time)
{
    weights w = {{0.0}, 0.0, -1};
    for (int j = 0; j < RS_NODES; j++) {
        double away = (time - m->begin) / m->h - m->nodes[j];
        if (fabs(away) < 1e-14) {
            w.node = j;
            return w;
        }
        w.weight[j] = m->weights[j] / away;
        w.sum += w.weight[j];
    }
    return w;
}

/* `count` states from `i` on and their rates, by the polynomials through the points of the window. */
static void drive(const rs_line *l, rs_point *q, const rs_motion *m, const weights *w, int i, int count)
{
    double *x = q->x + i, *rate = q->x_rate + i;
    const double *at = m->window + i, *rate_at = m->window_rates + i;
    size_t size = count * sizeof(double);
    if (w->node >= 0) {
        memcpy(x, at + w->node * l->nx, size);
        memcpy(rate, rate_at + w->node * l->nx, size);
        return;
    }
    memset(x, 0, size);
    memset(rate, 0, size);
    for (int j = 0; j < RS_NODES; j++)
        for (int k = 0; k < count; k++) {
            x[k] += w->weight[j] * at[j * l->nx + k];
            rate[k] += w->weight[j] * rate_at[j * l->nx + k];
        }
    for (int k = 0; k < count; k++) x[k] /= w->sum, rate[k] /= w->sum;
}

/* Inputs follow their rates to a time, which is then. */
static void turn(const rs_line *l, rs_point *q, rs_motion *m, double time)
{
    for (int i = 0; i < l->nu; i++) q->u[i] += (time - m->time) * q->u_rate[i];
    m->time = time;
}

/* Moves along the trajectories to a time; sections and inputs follow their rates. */
void rs_follow(const rs_line *l, rs_point *q, rs_motion *m, double time)
{
    weights w = weigh(m, time);
    if (l->nx) drive(l, q, m, &w, 0, l->nx);
    for (int i = 0; i < l->nz; i++) q->z[i] += (time - m->time) * q->z_rate[i];
    turn(l, q, m, time);
}

/* The same for some sections, with the states that they read: the others stay behind. */
static void follow_beside(const rs_line *l, rs_point *q, rs_motion *m, double time, const int *sections, int count)
{
    weights w = weigh(m, time);
    double h = time - m->time;
    for (int i = 0; i < count; i++)
        for (int k = l->first[sections[i]], span = l->first_span[sections[i]]; k <= l->last[sections[i]]; k++, span++) {
            int force = k < l->last[sections[i]] ? l->force[span] : 0, travel = l->travel[k], speed = l->speed[k];
            for (int z = force; k < l->last[sections[i]] && z < force + 3; z++) q->z[z] += h * q->z_rate[z];
            if (travel >= 0) q->z[travel] += h * q->z_rate[travel];
            if (l->state[k] >= 0) drive(l, q, m, &w, l->state[k], 1);
            if (speed >= 0 && speed < l->nx) drive(l, q, m, &w, speed, 1);
        }
    turn(l, q, m, time);
}

/* Moves the sections that have stayed behind since a time, and all states. */
static void catch_up(const rs_line *l, rs_point *q, rs_motion *m, double since, const int *sections, int count)
{
    weights w = weigh(m, m->time);
    if (l->nx) drive(l, q, m, &w, 0, l->nx);
    for (int i = 0; i < count; i++) rs_keep(l, sections[i], q->z, m->room);
    for (int i = 0; i < l->nz; i++) q->z[i] += (m->time - since) * q->z_rate[i];
    for (int i = 0; i < count; i++) rs_keep(l, sections[i], m->room, q->z);
}

/* Solves some sections, or all, which must be where their rates have led them. */
static int correct(const rs_line *l, rs_point *q, rs_motion *m, const int *sections, int count)
{
    double *led = m->room;
    for (int i = 0; i < count; i++) rs_keep(l, sections ? sections[i] : i, q->z, led);
    for (int i = 0; sections && i < count; i++) m->touched[sections[i]] = 1;
    for (int i = 0; i < count; i++)
        if ((m->failure = rs_solve(l, q, sections ? sections[i] : i, 1)) != RS_OK) return RS_FAILED;
    for (int i = 0; i < count; i++) {
        int s = sections ? sections[i] : i;
        for (int k = l->first[s]; k <= l->last[s]; k++) {
            int z = l->travel[k];
            if (z < 0 || fabs(q->z[z] - led[z]) <= FOLLOWED * l->z_nominal[z]) continue;
            q->worst = l->balance[k];
            m->failure = RS_AWAY;
            return RS_FAILED;
        }
    }
    rs_foresee(l, q, m, sections, sections ? count : 0);
    return RS_REACHED;
}

/* Adds the second order to the guess of sections that have not been solved since the last stop. */
static void bend(const rs_line *l, rs_point *q, const rs_motion *m)
{
    double half = 0.5 * (m->time - m->stopped) * (m->time - m->stopped);
    for (int s = 0; s < l->sections; s++) {
        if (m->touched[s]) continue;
        for (int k = l->first[s], span = l->first_span[s]; k <= l->last[s]; k++, span++) {
            int force = l->force[k < l->last[s] ? span : span - 1], travel = l->travel[k];
            for (int i = force; k < l->last[s] && i < force + 3; i++) q->z[i] += half * m->curve[i];
            if (travel >= 0) q->z[travel] += half * m->curve[travel];
        }
    }
}

/* Notes the change of rates since the last stop, for the next one. */
void rs_note_stop(const rs_line *l, const rs_point *q, rs_motion *m)
{
    double h = m->time - m->stopped;
    for (int i = 0; i < l->nz; i++) m->curve[i] = m->curved && h > 0.0 ? (q->z_rate[i] - m->old_rate[i]) / h : 0.0;
    for (int s = 0; s < l->sections; s++) {
        if (!m->touched[s]) continue;
        m->touched[s] = 0;
        for (int k = l->first[s], span = l->first_span[s]; k <= l->last[s]; k++, span++) {
            if (k < l->last[s]) memset(m->curve + l->force[span], 0, 3 * sizeof(double));
            if (l->travel[k] >= 0) m->curve[l->travel[k]] = 0.0;
        }
    }
    memcpy(m->old_rate, q->z_rate, l->nz * sizeof(double));
    m->stopped = m->time;
    m->curved = 1;
}

/* Moves the sections beside a support to the time at which a load stands on it; RS_PASSED: after the stop. */
static int locate(const rs_line *l, rs_point *q, rs_motion *m, rs_coming *next, double stop, double linear,
                  const int *sections, int count)
{
    double near = NEAR * m->scale[l->run_of[next->k]], h;
    int failed;
    follow_beside(l, q, m, m->time + next->time, sections, count);
    if ((failed = correct(l, q, m, sections, count))) return failed;
    rs_look_again(l, q, m, next);
    h = next->time;
    if (fabs(next->gap) > near && h > stop - m->time) return RS_PASSED;
    if (isfinite(h)) follow_beside(l, q, m, m->time + h, sections, count);
    if (!(fabs(next->gap) > near && fabs(h) > linear)) return RS_REACHED;
    if ((failed = correct(l, q, m, sections, count))) return failed;
    rs_look_again(l, q, m, next);
    return fabs(next->gap) > near ? RS_PASSED : RS_REACHED;
}

/* Moves a line along its window to a stop, where all sections are solved. With `drives`, those that move by themselves may
 * not have come to a limit when a load crosses; where the ropes move a drive then, its window ends. */
int rs_move(const rs_line *l, rs_point *q, rs_motion *m, double stop, const rs_drives *drives)
{
    rs_coming next;
    int sections[RS_MOST], count, failed;
    rs_foresee(l, q, m, 0, 0);
    for (;;) {
        if (rs_short_of_loads(l, m)) return RS_LOADS;
        if (rs_is_full(l, m)) return RS_FULL;
        if (!rs_next(l, q, m, &next) || next.time > stop - m->time) break;
        double since = m->time;
        count = rs_beside(l, next.k, sections, 0, RS_MOST);
        int code = locate(l, q, m, &next, stop, drives && rs_limited(l, drives, sections, count) ? SWINGING : m->short_step,
                          sections, count);
        catch_up(l, q, m, since, sections, count);
        if (code == RS_PASSED) continue;
        if (code) return code;
        if (m->strict && m->time < m->crossed - m->least_step) return RS_UNFORESEEN;
        m->crossed = m->time;
        if (drives && rs_coupled(l, q, m, drives, sections, count)) return RS_COUPLED;
        if ((failed = rs_cross(l, q, m, &next, sections, &count))) return failed;
        if (m->single) return RS_PASSED;
        rs_foresee(l, q, m, sections, count);
        if (!drives || m->time >= stop) continue;
        if (rs_limited(l, drives, sections, count) || rs_coupled(l, q, m, drives, sections, count)) return RS_PASSED;
    }
    rs_follow(l, q, m, stop);
    if (m->curved) bend(l, q, m);
    if ((failed = correct(l, q, m, 0, l->sections))) return failed;
    return m->strict && !rs_in_order(l, q, m) ? RS_UNFORESEEN : RS_REACHED;
}
