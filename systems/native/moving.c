/* A line whose drives follow known trajectories, from crossing to crossing. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define NEAR 1e-9     /* part of a mean span within which a load is on a support */
#define SWINGING 1e-6 /* [s]: step of a section that is linear beside a drive at a limit */
#define FOLLOWED 0.02 /* part of a nominal by which an idler's travel may be elsewhere than its rate leads to */

/* States and their rates at a time, by the polynomials through the points of the window. */
static void drive(const rs_line *l, rs_point *q, const rs_motion *m, double time)
{
    double weight[RS_NODES], sum = 0.0;
    for (int j = 0; j < RS_NODES; j++) {
        double away = (time - m->begin) / m->h - m->nodes[j];
        if (fabs(away) < 1e-14) {
            memcpy(q->x, m->window + j * l->nx, l->nx * sizeof(double));
            memcpy(q->x_rate, m->window_rates + j * l->nx, l->nx * sizeof(double));
            return;
        }
        weight[j] = m->weights[j] / away;
        sum += weight[j];
    }
    memset(q->x, 0, l->nx * sizeof(double));
    memset(q->x_rate, 0, l->nx * sizeof(double));
    for (int j = 0; j < RS_NODES; j++) /* by rows: sums of many states side by side */
        for (int i = 0; i < l->nx; i++) {
            q->x[i] += weight[j] * m->window[j * l->nx + i];
            q->x_rate[i] += weight[j] * m->window_rates[j * l->nx + i];
        }
    for (int i = 0; i < l->nx; i++) q->x[i] /= sum, q->x_rate[i] /= sum;
}

/* Moves along the trajectories to a time; sections and inputs follow their rates. */
void rs_follow(const rs_line *l, rs_point *q, rs_motion *m, double time)
{
    double h = time - m->time;
    if (l->nx) drive(l, q, m, time);
    for (int i = 0; i < l->nz; i++) q->z[i] += h * q->z_rate[i];
    for (int i = 0; i < l->nu; i++) q->u[i] += h * q->u_rate[i];
    m->time = time;
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
        rs_follow(l, q, m, m->time + next.time);
        count = rs_beside(l, next.k, sections, 0, RS_MOST);
        if ((failed = correct(l, q, m, sections, count))) return failed;
        rs_look_again(l, q, m, &next);
        double near = NEAR * m->scale[l->run_of[next.k]], h = next.time;
        double linear = drives && rs_limited(l, drives, sections, count) ? SWINGING : m->short_step;
        if (fabs(next.gap) > near && h > stop - m->time) continue;
        if (isfinite(h)) rs_follow(l, q, m, m->time + h);
        if (fabs(next.gap) > near && fabs(h) > linear) {
            if ((failed = correct(l, q, m, sections, count))) return failed;
            rs_look_again(l, q, m, &next);
            if (fabs(next.gap) > near) continue;
        }
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
