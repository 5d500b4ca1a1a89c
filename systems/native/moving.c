/* Loads that cross supports: a load at place c on the rope stands on support k exactly when the rope there is c. A
 * crossing that takes more than to pass, as one of a load that is pushed back, is left to the caller. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define NEAR 1e-9      /* part of a mean span within which a load is on a support */
#define FOLLOWED 0.02  /* part of a nominal by which an idler's travel may be elsewhere than its rate leads to */
#define SLACK 1.02     /* rope over chord beyond which a rope on idlers can have several stable places */
#define MOST 64        /* crossings at one time, and sections that they touch */
#define PI 3.14159265358979323846

typedef struct {
    double time, gap;
    int k, forward;
} coming_load;

static double rope_at(const rs_line *l, const rs_point *q, const rs_motion *m, int k)
{
    return m->rope[k] - rs_travel(l, q, k);
}

static double rate_at(const rs_line *l, const rs_point *q, int k)
{
    return l->state[k] >= 0 ? q->x_rate[l->state[k]] : l->travel[k] >= 0 ? q->z_rate[l->travel[k]] : 0.0;
}

static int is_last(const rs_line *l, int k)
{
    return k + 1 == l->run_first[l->run_of[k] + 1];
}

/* How far the rope over a support is from the next load forward and backward. */
static void gaps(const rs_line *l, const rs_point *q, const rs_motion *m, int k, double *ahead, double *behind)
{
    int run = l->run_of[k];
    const double *place = m->place + m->load_first[run];
    long long count = m->load_first[run + 1] - m->load_first[run], beyond = m->passed[k];
    double rope = rope_at(l, q, m, k);
    *ahead = beyond < count ? rope - place[beyond] : INFINITY;
    *behind = beyond > 0 ? place[beyond - 1] - rope : INFINITY;
    if (l->around[run] && is_last(l, k)) *ahead = *behind = INFINITY;
}

static int next_load(const rs_line *l, const rs_point *q, const rs_motion *m, coming_load *found)
{
    found->time = INFINITY;
    for (int k = 0; k < l->supports; k++) {
        double ahead, behind, rate = rate_at(l, q, k), time;
        if (fabs(rate) <= 1e-12) continue;
        gaps(l, q, m, k, &ahead, &behind);
        time = rate > 0.0 ? ahead / rate : behind / -rate;
        if (time < found->time) {
            found->time = time;
            found->gap = rate > 0.0 ? ahead : behind;
            found->k = k;
            found->forward = rate > 0.0;
        }
    }
    return isfinite(found->time);
}

/* The same load from here. */
static void look_again(const rs_line *l, const rs_point *q, const rs_motion *m, coming_load *load)
{
    double ahead, behind, rate = rate_at(l, q, load->k);
    gaps(l, q, m, load->k, &ahead, &behind);
    load->gap = load->forward ? ahead : behind;
    if (!load->forward) rate = -rate;
    load->time = rate > 1e-12 ? load->gap / rate : INFINITY;
}

/* States and their rates at a time, by the polynomials through the points of the window. */
static void drive(const rs_line *l, rs_point *q, const rs_motion *m, double time)
{
    double weight[RS_NODES], sum = 0.0, *rate = (double *)q->x_rate;
    for (int j = 0; j < RS_NODES; j++) {
        double away = (time - m->begin) / m->h - (1.0 - cos(PI * j / (RS_NODES - 1))) / 2.0;
        if (fabs(away) < 1e-14) {
            memcpy(q->x, m->window + j * l->nx, l->nx * sizeof(double));
            memcpy(rate, m->window_rates + j * l->nx, l->nx * sizeof(double));
            return;
        }
        weight[j] = (j % 2 ? -1.0 : 1.0) * (j == 0 || j == RS_NODES - 1 ? 0.5 : 1.0) / away;
        sum += weight[j];
    }
    for (int i = 0; i < l->nx; i++) {
        double x = 0.0, v = 0.0;
        for (int j = 0; j < RS_NODES; j++) {
            x += weight[j] * m->window[j * l->nx + i];
            v += weight[j] * m->window_rates[j * l->nx + i];
        }
        q->x[i] = x / sum;
        rate[i] = v / sum;
    }
}

/* Inputs are linear in time too: u_rate is theirs. */
static void follow(const rs_line *l, rs_point *q, rs_motion *m, double time)
{
    double h = time - m->time;
    drive(l, q, m, time);
    for (int i = 0; i < l->nz; i++) q->z[i] += h * q->z_rate[i];
    for (int i = 0; i < l->nu; i++) q->u[i] += h * q->u_rate[i];
    m->time = time;
}

/* Solves sections, which must be where their rates have led them. */
static int correct(const rs_line *l, rs_point *q, rs_motion *m, const int *sections, int count, double *led)
{
    memcpy(led, q->z, l->nz * sizeof(double));
    for (int i = 0; i < count; i++)
        if ((m->failure = rs_solve(l, q, sections[i], 1)) != RS_OK) return RS_FAILED;
    for (int i = 0; i < count; i++)
        for (int k = l->first[sections[i]]; k <= l->last[sections[i]]; k++) {
            int z = l->travel[k];
            if (z < 0 || fabs(q->z[z] - led[z]) <= FOLLOWED * l->z_nominal[z]) continue;
            q->worst = l->balance[k];
            m->failure = RS_AWAY;
            return RS_FAILED;
        }
    return RS_REACHED;
}

/* The sections on both sides of a support, among `sections`. */
static int beside(const rs_line *l, int k, int *sections, int count)
{
    int run = l->run_of[k], ends[3] = {-1, -1, -1};
    if (k > l->run_first[run]) ends[0] = l->section_of[k - run - 1];
    if (!is_last(l, k)) ends[1] = l->section_of[k - run];
    if (k == l->run_first[run] && l->around[run]) ends[2] = l->section_of[l->run_first[run + 1] - run - 2];
    for (int e = 0; e < 3; e++) {
        int known = ends[e] < 0;
        for (int i = 0; i < count && !known; i++) known = sections[i] == ends[e];
        if (!known && count < MOST) sections[count++] = ends[e];
    }
    return count;
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

/* Whether the load that stands on a support goes on beyond it (see load_crossings.py). */
static int passes(const rs_line *l, const rs_point *q, const rs_motion *m, int k, int forward)
{
    int run = l->run_of[k], span = k - run;
    long long first = m->load_first[run], load = first + m->passed[k] - (forward ? 0 : 1);
    const double *going;
    double coming[3], one[3], length, ratio;
    if (l->held[k] < 0 || k == l->run_first[run] || is_last(l, k)) return 1;
    going = q->z + l->force[span];
    length = rope_at(l, q, m, k) - rope_at(l, q, m, k - 1);
    for (int i = 0; i < 3; i++) coming[i] = q->z[l->force[span - 1] + i] + length * m->pull[3 * (span - 1) + i];
    for (long long n = first + m->passed[k]; n < first + m->passed[k - 1]; n++) {
        pull_of(q, m, n, one);
        for (int i = 0; i < 3; i++) coming[i] += one[i];
    }
    pull_of(q, m, load, one);
    ratio = length_of(going, one, 0.0) / length_of(coming, one, 0.0);
    if (forward) /* it hangs at the end of the span before */
        return length_of(going, one, -1.0) >= (1.0 - 1e-9) * ratio * length_of(coming, one, -1.0);
    return ratio * length_of(coming, one, 1.0) >= (1.0 - 1e-9) * length_of(going, one, 1.0);
}

/* Slots of a span from the loads passed; 0 where there are too few. */
static int write_slots(const rs_line *l, rs_point *q, const rs_motion *m, int span)
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
    if (k > l->run_first[run] && !write_slots(l, q, m, k - run - 1)) return 0;
    return is_last(l, k) || write_slots(l, q, m, k - run);
}

/* Writes the present point down; on the grid all sections are solved. */
static void record(const rs_line *l, const rs_point *q, rs_motion *m, int grid)
{
    int n = m->records++;
    m->record_time[n] = m->time;
    m->record_grid[n] = grid;
    memcpy(m->record_x + n * l->nx, q->x, l->nx * sizeof(double));
    memcpy(m->record_z + n * l->nz, q->z, l->nz * sizeof(double));
    memcpy(m->record_passed + n * l->supports, m->passed, l->supports * sizeof(long long));
}

/* Whether a jump has thrown a load of the touched sections past a support; at the ends of a run that have just been
 * crossed loads may lie beyond. */
static int thrown(const rs_line *l, const rs_point *q, const rs_motion *m, const coming_load *due, int crossings,
                  const int *sections, int count)
{
    for (int i = 0; i < count; i++)
        for (int k = l->first[sections[i]]; k <= l->last[sections[i]]; k++) {
            double ahead, behind, near = NEAR * m->scale[l->run_of[k]];
            int just = 0;
            gaps(l, q, m, k, &ahead, &behind);
            for (int j = 0; j < crossings; j++) just |= due[j].k == k;
            if (just && (is_last(l, k) || k == l->run_first[l->run_of[k]])) continue;
            if (ahead < -near || behind < -near) return 1;
        }
    return 0;
}

/* All that cross now, the first one among them. */
static int due_now(const rs_line *l, const rs_point *q, const rs_motion *m, const coming_load *first, coming_load *due)
{
    int count = 1;
    due[0] = *first;
    for (int k = 0; k < l->supports && count < MOST; k++) {
        double ahead, behind, rate = rate_at(l, q, k), near = NEAR * m->scale[l->run_of[k]];
        if (k == first->k) continue;
        gaps(l, q, m, k, &ahead, &behind);
        if ((fabs(ahead) <= near && rate > 0.0) || (fabs(behind) <= near && rate < 0.0)) {
            due[count].k = k;
            due[count++].forward = rate > 0.0;
        }
    }
    return count;
}

static void leave(const rs_line *l, rs_motion *m, const coming_load *load)
{
    m->coming.run = l->run_of[load->k];
    m->coming.support = load->k - l->run_first[m->coming.run];
    m->coming.forward = load->forward;
    m->coming.load = (int)(m->passed[load->k] - (load->forward ? 0 : 1));
}

/* Loads cross; both sides are recorded. RS_CROSSING, and nothing done, where the caller must see to it. */
static int cross(const rs_line *l, rs_point *q, rs_motion *m, const coming_load *first)
{
    coming_load due[MOST];
    int sections[MOST], count = 0, crossings = due_now(l, q, m, first, due);
    int records = m->records, events = m->events;
    double *z = m->room, *rate = z + l->nz;
    long long *passed = (long long *)(rate + l->nz);
    leave(l, m, first);
    for (int i = 0; i < crossings; i++) {
        int k = due[i].k, last = is_last(l, k), end = last || k == l->run_first[l->run_of[k]];
        if (end && l->free_end[k] && !l->around[l->run_of[k]] && due[i].forward == !last) return RS_CROSSING;
        if (!passes(l, q, m, k, due[i].forward)) return RS_CROSSING;
        count = beside(l, k, sections, count);
    }
    if (crossings == MOST || count == MOST) return RS_CROSSING;
    record(l, q, m, 0); /* the sections of the crossing are solved on both sides, others are where rates lead them */
    memcpy(z, q->z, l->nz * sizeof(double));
    memcpy(rate, q->z_rate, l->nz * sizeof(double));
    memcpy(passed, m->passed, l->supports * sizeof(long long));
    int room = 1;
    for (int i = 0; i < crossings; i++) {
        rs_event *e = m->event + m->events++;
        int k = due[i].k, run = l->run_of[k], last = l->run_first[run + 1] - 1;
        leave(l, m, due + i);
        *e = m->coming;
        e->record = m->records;
        m->passed[k] += due[i].forward ? 1 : -1;
        room = room && write_beside(l, q, m, k);
        if (l->around[run] && k == l->run_first[run]) {
            m->passed[last] += due[i].forward ? 1 : -1;
            room = room && write_beside(l, q, m, last);
        }
    }
    for (int i = 0; room && i < count; i++)
        if (rs_solve(l, q, sections[i], 1) != RS_OK) room = 0;
    if (!room || thrown(l, q, m, due, crossings, sections, count)) {
        memcpy(q->z, z, l->nz * sizeof(double));
        memcpy(q->z_rate, rate, l->nz * sizeof(double));
        memcpy(m->passed, passed, l->supports * sizeof(long long));
        for (int i = 0; i < crossings; i++) {
            write_beside(l, q, m, due[i].k);
            if (l->around[l->run_of[due[i].k]]) write_beside(l, q, m, l->run_first[l->run_of[due[i].k] + 1] - 1);
        }
        m->records = records;
        m->events = events;
        leave(l, m, first);
        return RS_CROSSING;
    }
    record(l, q, m, 0);
    return RS_REACHED;
}

static int short_of_loads(const rs_line *l, const rs_motion *m)
{
    for (int run = 0; run < l->runs; run++) {
        int a = l->run_first[run], b = l->run_first[run + 1] - 1;
        if (l->fed[run] && m->passed[a] >= m->load_first[run + 1] - m->load_first[run] - 1) return 1;
        if (l->around[run] && m->passed[b] < 1) return 1;
    }
    return 0;
}

/* Whether each span has rope left, and none that could lie otherwise too. */
static int taut(const rs_line *l, const rs_point *q, const rs_motion *m)
{
    for (int i = 0; i < l->spans; i++) {
        int k = l->start[i];
        const int *a = l->point + 3 * k, *b = a + 3;
        double x = q->p[b[0]] - q->p[a[0]], y = q->p[b[1]] - q->p[a[1]], z = q->p[b[2]] - q->p[a[2]];
        double length = rope_at(l, q, m, k + 1) - rope_at(l, q, m, k);
        if (length <= 0.0 || (l->on_idlers[i] && length > SLACK * sqrt(x * x + y * y + z * z))) return 0;
    }
    return 1;
}

/* A stop: all sections solved, loads where rates have led them. */
static int at_stop(const rs_line *l, rs_point *q, rs_motion *m)
{
    follow(l, q, m, m->stop[m->reached]);
    for (int s = 0; s < l->sections; s++) {
        int failed = correct(l, q, m, &s, 1, m->room);
        if (failed) return failed;
    }
    for (int k = 0; m->strict && k < l->supports; k++) {
        double ahead, behind, near = NEAR * m->scale[l->run_of[k]];
        gaps(l, q, m, k, &ahead, &behind);
        if (ahead < -near || behind < -near) return RS_UNFORESEEN;
    }
    if (!m->grid) return RS_REACHED;
    if (!taut(l, q, m)) return RS_SLACK;
    record(l, q, m, 1);
    return RS_REACHED;
}

int rs_move(const rs_line *l, rs_point *q, rs_motion *m)
{
    coming_load next;
    while (m->reached < m->stops) {
        int sections[3], count, failed;
        double left = m->stop[m->reached] - m->time;
        if (short_of_loads(l, m)) return RS_LOADS;
        if (m->records + 3 > m->most || m->events + MOST > 4 * m->most) return RS_FULL;
        if (!next_load(l, q, m, &next) || next.time > left) {
            failed = at_stop(l, q, m);
            if (failed) return failed;
            m->reached++;
            continue;
        }
        follow(l, q, m, m->time + next.time);
        count = beside(l, next.k, sections, 0);
        failed = correct(l, q, m, sections, count, m->room);
        if (failed) return failed;
        look_again(l, q, m, &next);
        double near = NEAR * m->scale[l->run_of[next.k]];
        if (fabs(next.gap) > near && next.time > m->stop[m->reached] - m->time) continue;
        double h = next.time;
        if (isfinite(h)) follow(l, q, m, m->time + h);
        if (fabs(next.gap) > near && fabs(h) > m->short_step) {
            failed = correct(l, q, m, sections, count, m->room);
            if (failed) return failed;
            look_again(l, q, m, &next);
            if (fabs(next.gap) > near) continue;
        }
        if (m->strict && m->time < m->crossed - m->least_step) return RS_UNFORESEEN;
        m->crossed = m->time;
        failed = cross(l, q, m, &next);
        if (failed) return failed;
        if (m->single) return RS_PASSED;
    }
    return RS_REACHED;
}
