/* A line whose drives move alone: their states are known over a step, and each section of the line follows them by
 * itself. It is solved where one of its loads reaches a support, and at the end of the step. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

#define TRIALS 20
#define MOST 64         /* crossings in one step */
#define SHORT 3e-6      /* s, of travel at a known rate that is as good as a solution */
#define LEAST_STEP 1e-11 /* s */

/* Both ends of a step of the states, which are m->course_..., and its length. */
typedef struct {
    const rw_point *from, *to;
    double h;
    const double *rate, *end_rate;
} trajectory;

/* Keeps all that a step changes, or takes it back. */
static void keep(rw_instance *m, int back)
{
    const struct {
        void *kept, *own;
        size_t size;
    } parts[] = {
        {m->start_x, m->s.now.x, RW_NX * sizeof(double)},       {m->start_z, m->s.now.z, RW_NZ * sizeof(double)},
        {m->start_passed, m->s.passed, RW_NK * sizeof(int)},    {m->start_d, m->s.d, RW_ND * sizeof(double)},
        {m->start_rate, m->s.rate, RW_NX * sizeof(double)},     {m->start_zrate, m->s.zrate, RW_NZ * sizeof(double)},
    };
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        memcpy(back ? parts[i].own : parts[i].kept, back ? parts[i].kept : parts[i].own, parts[i].size);
}

static void take_back(rw_instance *m, double time)
{
    keep(m, 1);
    m->s.now.t = time;
    m->s.solved = m->s.rated = 1;
    m->s.shown = 0;
    rw_place_loads(m);
}

/* The drives over at most `h`; the line stays at its point. */
static rw_status trace(rw_instance *m, double h, trajectory *c)
{
    rw_copy_point(&m->course_from, &m->s.now);
    memcpy(m->course_rate, m->s.rate, RW_NX * sizeof(double));
    *c = (trajectory){&m->course_from, &m->course_to, h, m->course_rate, m->course_end_rate};
    for (;;) {
        double error;
        rw_status status = rw_one_step(m, c->from, c->h, 1, &error);
        rw_copy_point(&m->course_to, &m->s.now);
        memcpy(m->course_end_rate, m->s.rate, RW_NX * sizeof(double));
        rw_copy_point(&m->s.now, c->from);
        memcpy(m->s.rate, c->rate, RW_NX * sizeof(double));
        if (status == RW_OK && error <= 1.0) {
            double next = c->h * fmin(5.0, 0.9 / cbrt(fmax(error, 1e-9)));
            if (next > m->s.h || error > 0.3) m->s.h = next;
            return RW_OK;
        }
        c->h *= status == RW_OK && error < 1e9 ? fmax(0.2, 0.9 / cbrt(error)) : 0.25;
        m->s.h = c->h;
        if (c->h < LEAST_STEP) return RW_DISCARD;
    }
}

/* States at a time, by the cubic through both ends with their rates; algebraic variables at their rates. */
static void follow(rw_instance *m, const trajectory *c, double time)
{
    rw_point *q = &m->s.now;
    double s = (time - c->from->t) / c->h, h = time - q->t;
    double a = s * s * (3.0 - 2.0 * s), b = s * (1.0 - s) * (1.0 - s) * c->h, e = s * s * (s - 1.0) * c->h;
    double da = 6.0 * s * (1.0 - s) / c->h, db = (1.0 - s) * (1.0 - 3.0 * s), de = s * (3.0 * s - 2.0);
    for (int i = 0; i < RW_NX; i++) {
        double way = c->to->x[i] - c->from->x[i];
        q->x[i] = s == 1.0 ? c->to->x[i] : c->from->x[i] + a * way + b * c->rate[i] + e * c->end_rate[i];
        m->s.rate[i] = da * way + db * c->rate[i] + de * c->end_rate[i];
    }
    for (int i = 0; i < RW_NZ; i++) q->z[i] += h * m->s.zrate[i];
    q->t = time;
}

static double near(int k)
{
    return RW_NEAR * rw_span_scale[rw_run_of[k]];
}

/* The same crossing from here. */
static void look_again(const rw_instance *m, rw_crossing *found)
{
    double ahead, behind, rate = rw_travel_rate(m, found->k);
    rw_gaps(m, found->k, &ahead, &behind);
    found->gap = found->forward ? ahead : behind;
    if (!found->forward) rate = -rate;
    found->time = rate > 1e-12 ? found->gap / rate : INFINITY;
}

static int is_driven(int k)
{
    return rw_travel[k] < RW_NX;
}

/* The run of a step: its end; time since which each section has been followed; sections in hand; crossings so far. */
typedef struct {
    const trajectory *c;
    double end, *since;
    int *sections, count;
    rw_crossing done[MOST];
    double time[MOST];
    int held[MOST], crossings;
} passage;

enum { REACHED, LATER, BLOCKED };

/* Leads the line to the time at which the load found reaches its support, and the sections beside it to their solution.
 * LATER: not within the step; BLOCKED: it cannot be located here. */
static int reach(rw_instance *m, passage *w, rw_crossing *found)
{
    w->count = rs_beside(&rw_line, found->k, w->sections, 0, RW_NSEC);
    for (int trial = 0; trial < TRIALS; trial++) {
        double time = m->s.now.t + found->time;
        int close = trial > 0 && fabs(found->time) <= SHORT;
        if (!(time <= w->end + LEAST_STEP)) return LATER;
        for (int i = 0; i < w->count; i++)
            if (time < w->since[w->sections[i]] - LEAST_STEP) return BLOCKED;
        follow(m, w->c, fmin(time, w->end));
        if (!close && !is_driven(found->k) && rw_solve_sections(m, w->sections, w->count) != RW_OK) return BLOCKED;
        look_again(m, found);
        if (fabs(found->gap) <= near(found->k)) return REACHED;
    }
    return BLOCKED;
}

/* Adds the loads that are on other supports of the sections in hand now, in `due`; idlers count where the sections are
 * solved. Returns how many are due, or 0. */
static int due_now(rw_instance *m, passage *w, rw_crossing *due, int solved)
{
    int count = 1;
    for (int i = 0; i < w->count; i++)
        for (int k = rw_line.first[w->sections[i]]; k <= rw_line.last[w->sections[i]]; k++) {
            double ahead, behind, rate = rw_travel_rate(m, k);
            int known = rw_is_last(k) && rw_around[rw_run_of[k]], more = w->count;
            for (int j = 0; j < count && !known; j++) known = due[j].k == k;
            if (known || (!solved && !is_driven(k))) continue;
            rw_gaps(m, k, &ahead, &behind);
            if (!((rate > 0.0 && ahead <= near(k)) || (rate < 0.0 && behind <= near(k)))) continue;
            if (count == MOST) return 0;
            due[count].k = k;
            due[count].forward = rate > 0.0;
            due[count++].load = m->s.passed[k] - (rate > 0.0 ? 0 : 1);
            w->count = rs_beside(&rw_line, k, w->sections, more, RW_NSEC);
            if (solved && rw_solve_sections(m, w->sections + more, w->count - more) != RW_OK) return 0;
        }
    return count;
}

/* Whether a load of the sections in hand is beyond a support after a jump; not at the ends of a rope that are `due`. */
static int overrun(const rw_instance *m, const passage *w, const rw_crossing *due, int count)
{
    for (int i = 0; i < w->count; i++)
        for (int k = rw_line.first[w->sections[i]]; k <= rw_line.last[w->sections[i]]; k++) {
            double ahead, behind;
            int just = 0;
            if (rw_travel[k] < 0) continue;
            if (rw_is_last(k) || k == rw_run_first[rw_run_of[k]])
                for (int j = 0; j < count; j++) just |= due[j].k == k;
            rw_gaps(m, k, &ahead, &behind);
            if (!just && (ahead < -near(k) || behind < -near(k))) return 1;
        }
    return 0;
}

/* Loads cross now, the one found among them; 0 where this takes more than to pass. */
static int cross(rw_instance *m, passage *w, const rw_crossing *found)
{
    rw_crossing due[MOST];
    int count;
    due[0] = *found;
    count = due_now(m, w, due, !is_driven(found->k));
    if (count == 0 || w->crossings + count > MOST) return 0;
    for (int i = 0; i < count; i++) {
        int k = due[i].k, n = w->crossings++;
        m->s.solved = 1; /* beside an idler, which is enough */
        if (rw_put_across(m, &due[i]) != RW_OK) return 0;
        w->done[n] = due[i];
        w->time[n] = m->s.now.t;
        w->held[n] = rw_is_held(m, k);
    }
    if (rw_solve_sections(m, w->sections, w->count) != RW_OK || overrun(m, w, due, count)) return 0;
    for (int i = 0; i < w->count; i++) w->since[w->sections[i]] = m->s.now.t;
    return rw_drives_alone(m);
}

/* Solves the whole line at the present time; 0 where its drives are not alone. */
static int solve_all(rw_instance *m)
{
    rw_point *q = &m->s.now;
    rw_inputs_at(m, q->t, m->us);
    if (rw_rate_function(m, q->t, q->x, q->z, m->us, m->s.rate) || rw_solve_all_sections(m, 1) != RW_OK) return 0;
    m->s.solved = m->s.rated = 1;
    m->s.shown = 0;
    return rw_drives_alone(m);
}

/* The run ends at the last crossing so far. */
static void end_early(passage *w)
{
    w->end = w->c->from->t;
    for (int i = 0; i < rw_line.sections; i++) w->end = fmax(w->end, w->since[i]);
}

/* Moves the line along its drives, or to where a load is held or many have crossed; 0 where that takes more than loads
 * that pass. */
static int run(rw_instance *m, passage *w)
{
    int solved = 0; /* at the end */
    w->end = w->c->to->t;
    for (int i = 0; i < rw_line.sections; i++) w->since[i] = w->c->from->t;
    for (int trial = 0; trial < 4 * MOST; trial++) {
        rw_crossing next;
        int result;
        if (!rw_next_crossing(m, &next) || m->s.now.t + next.time > w->end) {
            if (solved) return 1;
            follow(m, w->c, w->end);
            if (!solve_all(m)) return 0;
            solved = 1;
            continue;
        }
        solved = 0;
        result = reach(m, w, &next);
        if (result == BLOCKED) return 0;
        if (result == LATER) continue;
        if (m->stops_at_events) { /* at the first one */
            rw_crossing first;
            if (!solve_all(m)) return 0;
            if (!rw_next_crossing(m, &first) || first.gap >= -near(first.k)) return 1;
            continue;
        }
        if (!cross(m, w, &next)) return 0;
        if (rw_standing(m) || w->crossings > MOST / 2) end_early(w);
    }
    return 0;
}

/* Moves the line from its present point, which is solved, by at most h. Where its drives are not alone, or a load does
 * more than to pass a support, `moved` is 0 and the line is as before. */
rw_status rw_move_along(rw_instance *m, double h, double stop, int *moved)
{
    const double time = m->s.now.t;
    trajectory c;
    passage w = {.c = &c, .since = m->since, .sections = m->sections};
    rw_log_function log = m->log;
    *moved = 0;
    if (!rw_drives_alone(m)) return RW_OK;
    keep(m, 0);
    m->log = NULL; /* what fails is done again */
    if (trace(m, h, &c) == RW_OK) {
        if (c.to->t >= stop - LEAST_STEP) m->course_to.t = stop;
        *moved = run(m, &w);
    }
    m->log = log;
    if (!*moved) take_back(m, time);
    for (int i = 0; *moved && i < w.crossings; i++) {
        int first = 0; /* of sections beside each other the later one may have been found first */
        for (int j = 1; j < w.crossings; j++)
            if (w.time[j] < w.time[first]) first = j;
        rw_tell_crossing(m, w.time[first], &w.done[first], w.held[first]);
        w.time[first] = INFINITY;
    }
    return RW_OK;
}
