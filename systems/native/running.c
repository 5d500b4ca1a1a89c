/* A line through the stops of a run: its grid, the ticks of its clocks, and where its inputs bend. Before each of them
 * the state is saved; where one is not reached, it is where it was after the last one. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define SAME 1e-9        /* [s] */
#define LEAST_STEP 1e-2  /* [s] between two stops, before a step is left to the caller */
#define SLACK 1.02       /* rope over chord beyond which a rope on idlers can have several stable places */

/* What a step changes, besides the vectors of the point. */
typedef struct {
    double time, crossed;
    rs_written written;
    int events, responses, epoch, bent;
} mark;

static void copy(double **to, double *values, size_t count, int back)
{
    memcpy(back ? values : *to, back ? *to : values, count * sizeof(double));
    *to += count;
}

int rs_saved_size(const rs_line *l, int discrete)
{
    return 2 * (l->nx + l->nz + l->nu) + discrete + l->spans + l->supports;
}

/* Saves the point, or takes it back. */
static void keep(const rs_line *l, rs_point *q, rs_motion *m, const rs_agenda *a, int back)
{
    double *to = a->saved;
    copy(&to, q->x, l->nx, back);
    copy(&to, q->x_rate, l->nx, back);
    copy(&to, q->z, l->nz, back);
    copy(&to, q->z_rate, l->nz, back);
    copy(&to, q->u, l->nu, back);
    copy(&to, q->u_rate, l->nu, back);
    copy(&to, q->d, a->discrete, back);
    copy(&to, (double *)q->used, l->spans, back); /* of the same size */
    copy(&to, (double *)m->passed, l->supports, back);
}

/* Whether each span has rope left, and the ropes on idlers do not run into a span: where spans are slack, the pivots of
 * the sections, just solved, must all have the sign of a stable balance. */
static int holds(const rs_line *l, const rs_point *q, const rs_motion *m)
{
    int slack = 0;
    for (int i = 0; i < l->spans; i++) {
        int k = l->start[i];
        const int *a = l->point + 3 * k, *b = a + 3;
        double x = q->p[b[0]] - q->p[a[0]], y = q->p[b[1]] - q->p[a[1]], z = q->p[b[2]] - q->p[a[2]];
        double length = rs_rope(l, q, m, k + 1) - rs_rope(l, q, m, k);
        if (length <= 0.0) return 0;
        slack = slack || (l->on_idlers[i] && length > SLACK * sqrt(x * x + y * y + z * z));
    }
    return !slack || rs_stable(l, q, m->sign);
}

/* The next stop, and what happens there. */
typedef struct {
    double time;
    int bend, tick, grid;
} stop_at;

static stop_at next_stop(const rs_motion *m, const rs_agenda *a, const rs_clocks *c)
{
    stop_at s = {m->stop[m->reached], 0, 0, 0};
    double last = m->stops > m->grids ? m->stop[m->grids] - SAME : INFINITY; /* ticks there are the caller's */
    double tick = rs_next_tick(c), bend = a->bent < a->bends ? a->bend[a->bent] : INFINITY;
    if (tick >= last) tick = INFINITY;
    if (tick < s.time) s.time = tick;
    if (bend < s.time) s.time = bend;
    s.grid = s.time >= m->stop[m->reached];
    s.tick = fabs(tick - s.time) <= SAME;
    s.bend = bend <= s.time;
    return s;
}

/* A bend, ticks and an entry on the grid, in this order. */
static int arrive(const rs_line *l, rs_point *q, rs_motion *m, rs_agenda *a, const rs_drives *s, const rs_clocks *c,
                  const stop_at *at)
{
    int changes = -1, disturbed = at->bend, on_grid = at->grid && m->reached < m->grids;
    if (at->bend) {
        memcpy(q->u, a->value + a->bent * l->nu, l->nu * sizeof(double));
        rs_record(l, q, m, 0);
        memcpy(q->u_rate, a->slope + ++a->bent * l->nu, l->nu * sizeof(double));
    }
    if (at->tick && (changes = rs_sample(l, q, m, c, at->time)) >= 0) {
        if (changes > 0) rs_record(l, q, m, 0);
        rs_act(q, m, c, at->time);
        disturbed |= changes > 0;
    }
    if (disturbed) {
        rs_rates(l, q, m, s);
        if ((m->failure = rs_solve_all(l, q, 1)) != RS_OK) return RS_FAILED;
        m->curved = 0;
    }
    if (changes > 0 || (changes == 0 && !on_grid)) rs_record(l, q, m, 0);
    if (on_grid) rs_record(l, q, m, 1);
    m->reached += at->grid;
    return RS_REACHED;
}

/* One step, at most to a stop. */
static int advance(const rs_line *l, rs_point *q, rs_motion *m, rs_agenda *a, rs_drives *s, rs_clocks *c, int tied,
                   double most)
{
    stop_at at = next_stop(m, a, c);
    int code, whole = at.time - m->time <= most;
    if (m->epoch + 2 > m->epochs || m->responses + (c->clocks ? c->first[c->clocks] : 0) > 4 * m->most) return RS_FULL;
    if (at.time > m->time) {
        m->crossed = -INFINITY;
        if ((code = rs_drive_window(l, q, m, s, whole ? at.time : m->time + most))) return code;
        whole = whole && m->begin + m->h >= at.time;
        code = rs_move(l, q, m, whole ? at.time : m->begin + m->h, tied ? s : 0);
        if (code) return code == RS_PASSED ? RS_REACHED : code; /* another window from here */
        if (tied && rs_coupled(l, q, m, s, 0, 0)) return RS_COUPLED;
        if (tied && rs_swung(l, q, m, s, a->saved + 2 * l->nx, a->saved + 2 * l->nx + l->nz)) return RS_COUPLED;
        if (!holds(l, q, m)) return RS_SLACK;
        rs_note_stop(l, q, m);
    }
    return whole ? arrive(l, q, m, a, s, c, &at) : RS_REACHED;
}

static int count_limited(const rs_drives *s)
{
    int count = 0;
    for (int i = 0; i < s->drives; i++) count += s->limited[i];
    return count;
}

static int run(const rs_line *l, rs_point *q, rs_motion *m, rs_agenda *a, rs_drives *s, rs_clocks *c)
{
    double longest = INFINITY, most;
    for (int i = 0; i < s->drives; i++)
        if (s->tied[s->form[i]]) longest = m->longest_step;
    most = longest;
    m->curved = 0;
    memset(m->touched, 0, l->sections * sizeof(int));
    keep(l, q, m, a, 0);
    rs_rates(l, q, m, s);
    if ((m->failure = rs_solve_all(l, q, 1)) != RS_OK) {
        keep(l, q, m, a, 1);
        return RS_FAILED;
    }
    while (m->reached < m->stops) {
        mark before = {m->time, m->crossed, m->written, m->events, m->responses, m->epoch, a->bent};
        keep(l, q, m, a, 0);
        int limits = count_limited(s), code = advance(l, q, m, a, s, c, isfinite(longest), most);
        if (code == RS_REACHED) {
            memset(s->limited, 0, s->drives * sizeof(int));
            most = 2.0 * most < longest ? 2.0 * most : longest;
            continue;
        }
        double tried = m->h < most ? m->h : most;
        if (code == RS_COUPLED) rs_note_limits(l, q, m, s);
        keep(l, q, m, a, 1);
        m->curved = 0;
        memset(m->touched, 0, l->sections * sizeof(int));
        memcpy(c->ticks, m->epoch_ticks + before.epoch * c->clocks, c->clocks * sizeof(long long));
        m->time = before.time, m->crossed = before.crossed, m->epoch = before.epoch, a->bent = before.bent;
        m->written = before.written, m->events = before.events, m->responses = before.responses;
        if (code == RS_COUPLED && count_limited(s) > limits) continue; /* the same again, more drives with the ropes */
        if (!(code == RS_UNFORESEEN || code == RS_FAILED || (code == RS_FULL && m->written.records == 0))) return code;
        if (tried < LEAST_STEP) return code;
        most = 0.5 * tried;
    }
    return RS_REACHED;
}

/* Through the stops of the grid, as far as records have room. */
int rs_run(const rs_line *l, rs_point *q, rs_motion *m, rs_agenda *a, rs_drives *s, rs_clocks *c)
{
    s->last = INFINITY;
    memset(s->limited, 0, s->drives * sizeof(int));
    int code = run(l, q, m, a, s, c);
    memset(s->limited, 0, s->drives * sizeof(int));
    return code;
}
