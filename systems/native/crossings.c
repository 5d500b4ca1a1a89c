/* Loads that cross supports: a load at place c on the rope stands on support k exactly when the rope there is c. A
 * crossing that takes more than to pass, as one of a load that is pushed back, is left to the caller. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define NEAR 1e-9 /* part of a mean span within which a load is on a support */

double rs_rope(const rs_line *l, const rs_point *q, const rs_motion *m, int k)
{
    return m->rope[k] - rs_travel(l, q, k);
}

double rs_travel_rate(const rs_line *l, const rs_point *q, int k)
{
    return l->state[k] >= 0 ? q->x_rate[l->state[k]] : l->travel[k] >= 0 ? q->z_rate[l->travel[k]] : 0.0;
}

/* How far the rope over a support is from the next load forward and backward. */
static void gaps(const rs_line *l, const rs_point *q, const rs_motion *m, int k, double *ahead, double *behind)
{
    int run = l->run_of[k];
    const double *place = m->place + m->load_first[run];
    long long count = m->load_first[run + 1] - m->load_first[run], beyond = m->passed[k];
    double rope = rs_rope(l, q, m, k);
    *ahead = beyond < count ? rope - place[beyond] : INFINITY;
    *behind = beyond > 0 ? place[beyond - 1] - rope : INFINITY;
    if (l->around[run] && rs_is_last(l, k)) *ahead = *behind = INFINITY;
}

/* When the next load reaches a support at the present rates. */
static void foresee(const rs_line *l, const rs_point *q, const rs_motion *m, int k)
{
    double ahead, behind, rate = rs_travel_rate(l, q, k);
    m->due[k] = INFINITY;
    if (fabs(rate) <= 1e-12) return;
    gaps(l, q, m, k, &ahead, &behind);
    m->due[k] = m->time + (rate > 0.0 ? ahead / rate : behind / -rate);
}

/* The same for some sections, or all: their rates or loads have changed. */
void rs_foresee(const rs_line *l, const rs_point *q, const rs_motion *m, const int *sections, int count)
{
    for (int k = 0; !sections && k < l->supports; k++) foresee(l, q, m, k);
    for (int i = 0; i < count; i++)
        for (int k = l->first[sections[i]]; k <= l->last[sections[i]]; k++) foresee(l, q, m, k);
}

/* The load that crosses first at the present rates; those of idlers are as they were foreseen. */
int rs_next(const rs_line *l, const rs_point *q, const rs_motion *m, rs_coming *found)
{
    double time = INFINITY;
    for (int k = 0; k < l->supports; k++) {
        if (l->state[k] >= 0) foresee(l, q, m, k);
        if (m->due[k] < time) time = m->due[k], found->k = k;
    }
    if (!isfinite(time)) return 0;
    found->forward = rs_travel_rate(l, q, found->k) > 0.0;
    rs_look_again(l, q, m, found);
    return 1;
}

/* The same load from here. */
void rs_look_again(const rs_line *l, const rs_point *q, const rs_motion *m, rs_coming *load)
{
    double ahead, behind, rate = rs_travel_rate(l, q, load->k);
    gaps(l, q, m, load->k, &ahead, &behind);
    load->gap = load->forward ? ahead : behind;
    if (!load->forward) rate = -rate;
    load->time = rate > 1e-12 ? load->gap / rate : INFINITY;
}

/* Tension of a rope with `share` of a load added to its tension vector. */
static double length_of(const double *v, const double *load, double share)
{
    double x = v[0] + share * load[0], y = v[1] + share * load[1], z = v[2] + share * load[2];
    return sqrt(x * x + y * y + z * z);
}

/* What a load adds to the tension vector of a rope: its weight, and the wind on it. */
static void pull_of(const rs_point *q, const rs_motion *m, long long load, double *pull)
{
    pull[0] = m->drag[load] * m->wind[0];
    pull[1] = m->drag[load] * m->wind[1];
    pull[2] = m->mass[load] * q->p[0];
}

/* Tension vector of a span at its end b. */
static void tension_at_end(const rs_line *l, const rs_point *q, const rs_motion *m, int span, double *tension)
{
    int k = l->start[span];
    long long first = m->load_first[l->run_of[k]];
    double length = rs_rope(l, q, m, k + 1) - rs_rope(l, q, m, k), one[3];
    for (int i = 0; i < 3; i++) tension[i] = q->z[l->force[span] + i] + length * m->pull[3 * span + i];
    for (long long n = first + m->passed[k + 1]; n < first + m->passed[k]; n++) {
        pull_of(q, m, n, one);
        for (int i = 0; i < 3; i++) tension[i] += one[i];
    }
}

/* Force of a span on what its end a (0) or b (1) sits at. */
void rs_end_force(const rs_line *l, const rs_point *q, const rs_motion *m, int span, int end, double *force)
{
    if (end == 0) {
        memcpy(force, q->z + l->force[span], 3 * sizeof(double));
        return;
    }
    tension_at_end(l, q, m, span, force);
    for (int i = 0; i < 3; i++) force[i] = -force[i];
}

/* Whether the load that stands on a support goes on beyond it (see load_crossings.py). */
static int passes(const rs_line *l, const rs_point *q, const rs_motion *m, int k, int forward)
{
    int run = l->run_of[k], span = k - run;
    long long load = m->load_first[run] + m->passed[k] - (forward ? 0 : 1);
    const double *going;
    double coming[3], one[3], ratio;
    if (l->held[k] < 0 || k == l->run_first[run] || rs_is_last(l, k)) return 1;
    going = q->z + l->force[span];
    tension_at_end(l, q, m, span - 1, coming);
    pull_of(q, m, load, one);
    ratio = length_of(going, one, 0.0) / length_of(coming, one, 0.0);
    if (forward) /* it hangs at the end of the span before */
        return length_of(going, one, -1.0) >= (1.0 - 1e-9) * ratio * length_of(coming, one, -1.0);
    return ratio * length_of(coming, one, 1.0) >= (1.0 - 1e-9) * length_of(going, one, 1.0);
}

/* Slots of a span from the loads passed; 0 where there are too few. */
int rs_write_slots(const rs_line *l, rs_point *q, const rs_motion *m, int span)
{
    int k = l->start[span], run = l->run_of[k];
    long long used = m->passed[k] - m->passed[k + 1];
    const double *place = m->place + m->load_first[run], *mass = m->mass + m->load_first[run];
    const double *drag = m->drag + m->load_first[run];
    if (used < 0 || used > l->count[span] || used > l->slots) return 0;
    for (int slot = 0; slot < l->count[span]; slot++) {
        long long load = m->passed[k] - 1 - slot;
        int full = slot < used;
        q->d[l->mass[span] + slot] = full ? mass[load] : 0.0;
        q->d[l->at[span] + slot] = full ? place[load] - m->rope[k] : 0.0;
        q->d[l->ride[span] + slot] = full;
        q->d[l->empty[span] + slot] = !full;
        if (l->drag[span] >= 0) q->d[l->drag[span] + slot] = full ? drag[load] : 0.0;
    }
    q->used[span] = used;
    return 1;
}

static int write_beside(const rs_line *l, rs_point *q, const rs_motion *m, int k)
{
    int run = l->run_of[k];
    if (k > l->run_first[run] && !rs_write_slots(l, q, m, k - run - 1)) return 0;
    return rs_is_last(l, k) || rs_write_slots(l, q, m, k - run);
}

/* Moves a load past a support, or back; 0 where a span has too few slots. */
static int put_beyond(const rs_line *l, rs_point *q, rs_motion *m, int k, int loads)
{
    int run = l->run_of[k], room, last = l->run_first[run + 1] - 1;
    m->passed[k] += loads;
    room = write_beside(l, q, m, k);
    if (!l->around[run] || k != l->run_first[run]) return room;
    m->passed[last] += loads;
    return write_beside(l, q, m, last) && room;
}

static void begin_record(const rs_line *l, const rs_point *q, rs_motion *m, int grid, int sections)
{
    int n = m->written.records++;
    m->record_time[n] = m->time;
    m->record_grid[n] = grid;
    m->record_epoch[n] = m->epoch;
    m->record_sections[n] = sections;
    memcpy(m->record_x + n * l->nx, q->x, l->nx * sizeof(double));
    if (m->record_u) memcpy(m->record_u + n * l->nu, q->u, l->nu * sizeof(double));
}

/* Writes the present point down; on the grid all sections are solved. */
void rs_record(const rs_line *l, const rs_point *q, rs_motion *m, int grid)
{
    int n = m->written.wholes++;
    begin_record(l, q, m, grid, 0);
    memcpy(m->whole_z + n * l->nz, q->z, l->nz * sizeof(double));
    memcpy(m->whole_passed + n * l->supports, m->passed, l->supports * sizeof(long long));
    m->written.behind = 0;
}

/* The same where only some sections are solved. */
static void record_beside(const rs_line *l, const rs_point *q, rs_motion *m, const int *sections, int count)
{
    if (m->written.behind >= m->chain) {
        rs_record(l, q, m, 0);
        return;
    }
    begin_record(l, q, m, 0, count);
    m->written.behind++;
    for (int i = 0; i < count; i++) {
        double *to = m->part_z + m->written.numbers;
        m->part_section[m->written.sections++] = sections[i];
        for (int k = l->first[sections[i]], span = l->first_span[sections[i]]; k <= l->last[sections[i]]; k++, span++) {
            if (k < l->last[sections[i]]) memcpy(to, q->z + l->force[span], 3 * sizeof(double)), to += 3;
            if (l->travel[k] >= 0) *to++ = q->z[l->travel[k]];
        }
        m->written.numbers = (int)(to - m->part_z);
    }
}

/* Whether there is no room for a crossing with the records of a stop. */
int rs_is_full(const rs_line *l, const rs_motion *m)
{
    return m->written.records + 8 > m->most || m->written.wholes + 8 > m->most_wholes ||
           m->written.numbers + 2 * l->nz > m->most_numbers || m->events + RS_MOST > 4 * m->most;
}

/* Whether a jump has moved a load of the touched sections past a support; at the ends of a run that have just been
 * crossed loads may lie beyond, unless a drum draws the load back that has just been put on. */
static int overrun(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_coming *due, int crossings,
                   const int *sections, int count)
{
    for (int i = 0; i < count; i++)
        for (int k = l->first[sections[i]]; k <= l->last[sections[i]]; k++) {
            int run = l->run_of[k], first = k == l->run_first[run], just = 0;
            double ahead, behind, near = NEAR * m->scale[run];
            gaps(l, q, m, k, &ahead, &behind);
            for (int j = 0; j < crossings; j++)
                if (due[j].k == k) just = due[j].forward ? 1 : -1;
            if (just && (first || rs_is_last(l, k))) {
                if (!l->free_end[k] || l->around[run] || (just > 0) != first) continue;
                if (just > 0 ? -behind > near : -ahead > near) return 1;
                continue;
            }
            if (ahead < -near || behind < -near) return 1;
        }
    return 0;
}

/* Whether no load lies beyond the support that it comes to next. */
int rs_in_order(const rs_line *l, const rs_point *q, const rs_motion *m)
{
    for (int k = 0; k < l->supports; k++) {
        double ahead, behind, near = NEAR * m->scale[l->run_of[k]];
        gaps(l, q, m, k, &ahead, &behind);
        if (ahead < -near || behind < -near) return 0;
    }
    return 1;
}

/* All that cross now, the first one among them. */
static int due_now(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_coming *first, rs_coming *due)
{
    int count = 1;
    due[0] = *first;
    for (int k = 0; k < l->supports && count < RS_MOST; k++) {
        double ahead, behind, rate = rs_travel_rate(l, q, k), near = NEAR * m->scale[l->run_of[k]];
        if (k == first->k || fabs(m->due[k] - m->time) * fabs(rate) > 2.0 * near) continue;
        gaps(l, q, m, k, &ahead, &behind);
        if ((fabs(ahead) <= near && rate > 0.0) || (fabs(behind) <= near && rate < 0.0)) {
            due[count].k = k;
            due[count++].forward = rate > 0.0;
        }
    }
    return count;
}

static void leave(const rs_line *l, rs_motion *m, const rs_coming *load)
{
    m->coming.run = l->run_of[load->k];
    m->coming.support = load->k - l->run_first[m->coming.run];
    m->coming.forward = load->forward;
    m->coming.load = (int)(m->passed[load->k] - (load->forward ? 0 : 1));
}

/* Loads cross; both sides are recorded; `sections` beside are those of RS_MOST. RS_CROSSING, and nothing done, where the
 * caller must see to it. */
int rs_cross(const rs_line *l, rs_point *q, rs_motion *m, const rs_coming *first, int *sections, int *beside)
{
    rs_coming due[RS_MOST];
    int count = 0, crossings = due_now(l, q, m, first, due);
    int events = m->events, room = 1;
    rs_written written = m->written;
    double *z = m->room, *rate = z + l->nz;
    leave(l, m, first);
    for (int i = 0; i < crossings; i++) {
        if (!passes(l, q, m, due[i].k, due[i].forward)) return RS_CROSSING;
        count = rs_beside(l, due[i].k, sections, count, RS_MOST);
    }
    for (int i = 0; i < count; i++) m->touched[sections[i]] = 1;
    if (crossings == RS_MOST || count == RS_MOST) return RS_CROSSING;
    record_beside(l, q, m, sections, count); /* solved on both sides, others are where rates lead them */
    for (int i = 0; i < count; i++) rs_keep(l, sections[i], q->z, z), rs_keep(l, sections[i], q->z_rate, rate);
    for (int i = 0; i < crossings; i++) {
        leave(l, m, due + i);
        m->coming.record = m->written.records;
        m->event[m->events++] = m->coming;
        room = put_beyond(l, q, m, due[i].k, due[i].forward ? 1 : -1) && room;
    }
    for (int i = 0; room && i < count; i++)
        if (rs_solve(l, q, sections[i], 1) != RS_OK) room = 0;
    if (!room || overrun(l, q, m, due, crossings, sections, count)) {
        for (int i = 0; i < count; i++) rs_keep(l, sections[i], z, q->z), rs_keep(l, sections[i], rate, q->z_rate);
        for (int i = crossings - 1; i >= 0; i--) put_beyond(l, q, m, due[i].k, due[i].forward ? -1 : 1);
        m->written = written;
        m->events = events;
        leave(l, m, first);
        return RS_CROSSING;
    }
    record_beside(l, q, m, sections, count);
    *beside = count;
    return RS_REACHED;
}

int rs_short_of_loads(const rs_line *l, const rs_motion *m)
{
    for (int run = 0; run < l->runs; run++) {
        int a = l->run_first[run], b = l->run_first[run + 1] - 1;
        if (l->fed[run] && m->passed[a] >= m->load_first[run + 1] - m->load_first[run] - 1) return 1;
        if (l->around[run] && m->passed[b] < 1) return 1;
    }
    return 0;
}
