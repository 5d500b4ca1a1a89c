/* Samples of the tensions beside driven nodes, and what they change. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define SAME 1e-9 /* [s] */

static double next_of(const rs_clocks *c, int clock)
{
    return c->begin[clock] + c->ticks[clock] * c->period[clock];
}

double rs_next_tick(const rs_clocks *c)
{
    double next = INFINITY;
    for (int i = 0; i < c->clocks; i++)
        if (next_of(c, i) < next) next = next_of(c, i);
    return next;
}

static int is_due(const rs_clocks *c, int clock, double time)
{
    return fabs(next_of(c, clock) - time) <= SAME;
}

/* The decision of a member: its kernel's results. */
static void decide(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_clocks *c, int i)
{
    int form = c->form[i];
    double *to = c->work;
    *to++ = m->time;
    for (int j = 0; j < l->ns; j++) *to++ = l->shared[j] < l->np ? q->p[l->shared[j]] : q->u[l->shared[j] - l->np];
    memcpy(to, q->x + c->x[i], c->states[form] * sizeof(double)), to += c->states[form];
    memcpy(to, q->u + c->u[i], c->inputs[form] * sizeof(double)), to += c->inputs[form];
    memcpy(to, q->p + c->p[i], c->parameters[form] * sizeof(double)), to += c->parameters[form];
    memcpy(to, q->d + c->d[i], c->discrete[form] * sizeof(double)), to += c->discrete[form];
    for (int port = c->port_first[i]; port < c->port_first[i + 1]; port++, to += 3) {
        if (c->port_span[port] >= 0)
            rs_end_force(l, q, m, c->port_span[port], c->port_end[port], to);
        else
            to[0] = to[1] = to[2] = 0.0;
    }
    c->kernels[form](c->work, c->results + i * c->most);
}

/* Whether a member that wants to act may do so. */
static int is_granted(const rs_clocks *c, int i)
{
    const double *own = c->results + i * c->most;
    if (own[0] == 0.0) return 0;
    for (int n = c->rival_first[i]; n < c->rival_first[i + 1]; n++) {
        int j = c->rival[n];
        const double *other = c->results + j * c->most;
        if (other[0] == 0.0) continue;
        if (!c->by_need[n] || (i < j ? !(own[1] >= other[1]) : !(own[1] > other[1]))) return 0;
    }
    return 1;
}

/* Decisions of the clocks that tick now: in `changed` each member's new correction, NAN where it stays as it is. Returns
 * how many change, -1 where no clock ticks. */
int rs_sample(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_clocks *c, double time)
{
    int changes = 0, due = 0;
    for (int clock = 0; clock < c->clocks; clock++) {
        if (!is_due(c, clock, time)) continue;
        due = 1;
        for (int i = c->first[clock]; !c->effect[clock] && i < c->first[clock + 1]; i++) decide(l, q, m, c, i);
        for (int i = c->first[clock]; i < c->first[clock + 1]; i++) {
            double correction = NAN;
            c->changed[i] = NAN;
            if (c->effect[clock])
                correction = q->d[c->waiting[i]];
            else {
                int n = c->values[c->form[i]], granted = is_granted(c, i);
                double *results = c->results + i * c->most;
                if (!granted) memcpy(results + 2, results + 2 + n, n * sizeof(double));
                for (int j = 0; j < n; j++)
                    if (c->place[c->place_first[i] + j] == c->correction[i]) correction = results[2 + j];
            }
            if (isnan(correction) || correction == q->d[c->correction[i]]) continue;
            c->changed[i] = correction;
            changes++;
        }
    }
    return due ? changes : -1;
}

/* Takes over the decisions of `rs_sample`, and begins an epoch. */
void rs_act(rs_point *q, rs_motion *m, const rs_clocks *c, double time)
{
    for (int clock = 0; clock < c->clocks; clock++) {
        if (!is_due(c, clock, time)) continue;
        for (int i = c->first[clock]; i < c->first[clock + 1]; i++) {
            const double *results = c->results + i * c->most;
            for (int j = 0; !c->effect[clock] && j < c->values[c->form[i]]; j++)
                if (c->place[c->place_first[i] + j] != c->correction[i])
                    q->d[c->place[c->place_first[i] + j]] = results[2 + j];
            if (isnan(c->changed[i])) continue;
            q->d[c->correction[i]] = c->changed[i];
            m->response[m->responses].member = i;
            m->response[m->responses].record = m->written.records;
            m->response[m->responses++].value = c->changed[i];
        }
    }
    for (int clock = 0; clock < c->clocks; clock++) c->ticks[clock] += is_due(c, clock, time);
    m->epoch++;
    memcpy(m->epoch_ticks + m->epoch * c->clocks, c->ticks, c->clocks * sizeof(long long));
    for (int i = 0; i < m->keeps; i++) m->epoch_kept[m->epoch * m->keeps + i] = q->d[m->kept[i]];
}
