/* Loads of a system with inertia near supports. Within the zone of a support a load is tied: it moves with the rope, and
 * crosses the support tied; beyond the zone it is free again, at the place and with the velocity of its station on the
 * rope. The same rule as support_zones.py, whose distances are RW_ZONE_... . */
#include <math.h>
#include <string.h>
#include "ropeway.h"

#define APART 1e-4    /* time over which velocities are differences of places [s] */
#define SHORTEST 1e-9 /* step [s] */
#define NEAR 2e-4     /* how far past an event the line may stop [m] */
#define BEHIND 1e-4   /* travel after which an event is due that was due before but for the direction of the rope [m] */

static const char *const failures[] = {"", "The equations are singular", "Newton's method stalled",
                                       "Newton's method did not converge", "The steps become too short"};

/* Free loads come to the zone of end a or b; tied ones cross forward or backward, or leave backward or forward. */
enum { TIE_A, TIE_B, CROSS_FORWARD, CROSS_BACKWARD, LEAVE_BACKWARD, LEAVE_FORWARD, KINDS };

static int is_leave(const rw_threshold *t)
{
    return t->kind >= LEAVE_BACKWARD;
}

static int is_cross(const rw_threshold *t)
{
    return t->kind == CROSS_FORWARD || t->kind == CROSS_BACKWARD;
}

/* Whether the rope over a support has inertia: loads near it are tied. */
static int ties(int k)
{
    return rw_travel[k] >= 0 && rw_travel[k] < RW_NX;
}

static double rope_at(const rw_instance *m, int k)
{
    return m->rope[k] - rw_support_travel(m, k);
}

/* Span in which load i of a run hangs. */
static int span_of(const rw_instance *m, int run, int i)
{
    int k = rw_run_first[run];
    while (m->s.passed[k + 1] > i) k++;
    return k;
}

static double *discrete(rw_instance *m, const int *first, int place, int slot)
{
    return m->s.d + first[place] + slot;
}

/* Where load i of a run is: in span k, or -1 support where it waits at an end, and the support it is tied to, or -1. */
typedef struct {
    int i, k, tied, inside;
    double place;
} standing;

static standing stand(const rw_instance *m, int run, int i)
{
    int k = span_of(m, run, i), slot = m->s.passed[k] - 1 - i;
    int a = m->s.d[rw_slot_tied[2 * k] + slot] > 0.0, b = m->s.d[rw_slot_tied[2 * k + 1] + slot] > 0.0;
    return (standing){i, k, a ? k : b ? k + 1 : -1, 1, rw_load_position(m, run, i)};
}

/* By how much an event in span k may be earlier: loads that leave one end of a short span late must not be beyond the
 * other end by then. */
static double early_in(const rw_instance *m, int k)
{
    double room = (fabs(rope_at(m, k + 1) - rope_at(m, k)) - 2.0 * RW_ZONE_BEYOND * RW_ZONE) / 2.0;
    return fmin(fmax(room, 0.0), RW_ZONE_EARLY * RW_ZONE);
}

/* The event of a kind that a load comes to; 0 where there is none. */
static int threshold(const rw_instance *m, int kind, const standing *l, double early, rw_threshold *t)
{
    int free = l->tied < 0, before = !free && l->k < l->tied, behind = !free && !before;
    int end = kind == TIE_B, k = free ? l->k + end : l->tied;
    double past = l->place - rope_at(m, k), reach = RW_ZONE_BEYOND * RW_ZONE + early;
    *t = (rw_threshold){.kind = kind, .k = k, .load = l->i};
    switch (kind) {
    case TIE_A:
    case TIE_B:
        t->side = end ? 1.0 : -1.0;
        t->gap = -t->side * past - RW_ZONE;
        t->early = early;
        return free && ties(k);
    case CROSS_FORWARD:
        t->side = 1.0;
        t->gap = RW_ZONE_PAST - past;
        return before;
    case CROSS_BACKWARD:
        t->side = -1.0;
        t->gap = RW_ZONE_PAST + past;
        return behind;
    default:
        t->side = kind == LEAVE_FORWARD ? 1.0 : -1.0;
        t->gap = reach - t->side * past;
        t->early = early;
        return l->inside && (kind == LEAVE_FORWARD ? behind : before);
    }
}

/* Adds what the loads of a run come to. */
static int thresholds_of(const rw_instance *m, int run, rw_threshold *found, int count)
{
    int a = rw_run_first[run], b = rw_run_first[run + 1] - 1, moves = 0;
    for (int k = a; k <= b; k++) moves |= ties(k);
    if (!moves || rw_load_count(run) == 0) return count;
    for (int kind = 0; kind < KINDS; kind++) {
        for (int i = m->s.passed[b]; i < m->s.passed[a]; i++) {
            standing l = stand(m, run, i);
            count += threshold(m, kind, &l, early_in(m, l.k), &found[count]);
        }
        if (rw_around[run]) continue;
        if (ties(a) && m->s.passed[a] < rw_load_count(run)) { /* the next load waits at the first support, the last one at the last */
            standing l = {m->s.passed[a], a - 1, a, 0, rw_load_position(m, run, m->s.passed[a])};
            count += threshold(m, kind, &l, early_in(m, a), &found[count]);
        }
        if (ties(b) && m->s.passed[b] > 0) {
            standing l = {m->s.passed[b] - 1, b, b, 0, rw_load_position(m, run, m->s.passed[b] - 1)};
            count += threshold(m, kind, &l, early_in(m, b - 1), &found[count]);
        }
    }
    return count;
}

/* All that loads come to, whichever way the rope moves. */
static int thresholds(const rw_instance *m, rw_threshold *found)
{
    int count = 0;
    for (int run = 0; rw_run_first[run] < RW_NK; run++) count = thresholds_of(m, run, found, count);
    return count;
}

/* The events that are due at the present rates, and all that are possible with them, one for each load. */
int rw_zones_due(const rw_instance *m, rw_threshold *due)
{
    rw_threshold all[RW_NTH];
    int count = 0, any = 0;
    for (int i = thresholds(m, all) - 1; i >= 0; i--) {
        int j = 0;
        if (!(all[i].side * rw_travel_rate(m, all[i].k) > 1e-9) || all[i].gap > RW_ZONE_NEAR + all[i].early) continue;
        any |= all[i].gap <= RW_ZONE_NEAR;
        while (j < count && (due[j].load != all[i].load || rw_run_of[due[j].k] != rw_run_of[all[i].k])) j++;
        due[j] = all[i];
        if (j == count) count++;
    }
    return any ? count : 0;
}

/* Joins free slots of span k that hang so near to the slot before that the rope between them is stiff. */
static void join(rw_instance *m, int k)
{
    int run = rw_run_of[k], count = m->s.passed[k] - m->s.passed[k + 1], before = 0;
    for (int j = 0; count > 1 && j < count; j++) {
        int i = m->s.passed[k] - 1 - j;
        int loose = *discrete(m, rw_slot_tied, 2 * k, j) + *discrete(m, rw_slot_tied, 2 * k + 1, j) == 0.0;
        int near = j > 0 && rw_load_position(m, run, i) - rw_load_position(m, run, i + 1) < RW_ZONE_JOINED;
        *discrete(m, rw_slot_joined, k, j) = loose && near && before;
        before = loose;
    }
}

/* Outputs at the present point, or APART later or earlier at the present rates. */
static rw_status outputs_at(rw_instance *m, int way, double *y)
{
    rw_point q = m->s.now;
    double h = way * APART;
    q.t += h;
    for (int i = 0; i < RW_NX; i++) q.x[i] += h * m->s.rate[i];
    for (int i = 0; i < RW_NZ; i++) q.z[i] += h * m->s.zrate[i];
    rw_inputs_at(m, m->s.now.t, m->us);
    rw_point_arguments(m, &q.t, q.x, q.z, m->us);
    m->res[0] = y;
    if (!rw_outputs(m->arg, m->res, m->iw, m->cw, 0) && rw_all_finite(y, RW_NY)) return RW_OK;
    rw_message(m, RW_DISCARD, "logStatusDiscard", "The outputs are not finite at t = %.9g s", m->s.now.t);
    return RW_DISCARD;
}

/* Frees loads: they take place and velocity of their stations. */
static rw_status leave(rw_instance *m, const rw_threshold *due, int count)
{
    double here[RW_NY + 1], later[RW_NY + 1], earlier[RW_NY + 1];
    rw_status status = outputs_at(m, 0, here);
    if (status == RW_OK) status = outputs_at(m, 1, later);
    if (status == RW_OK) status = outputs_at(m, -1, earlier);
    if (status != RW_OK) return status;
    for (int n = 0; n < count; n++) {
        int run = rw_run_of[due[n].k], k, slot;
        if (!is_leave(&due[n])) continue;
        k = span_of(m, run, due[n].load);
        slot = m->s.passed[k] - 1 - due[n].load;
        for (int axis = 0; axis < 3; axis++) {
            int station = rw_slot_station[3 * k + axis] + slot;
            double velocity = (later[station] - earlier[station]) / (2.0 * APART);
            m->s.now.x[rw_slot_velocity[3 * k + axis] + slot] = velocity;
            /* the rope sees the place a little ahead: there the tension does not jump */
            m->s.now.x[rw_slot_place[3 * k + axis] + slot] = here[station] - m->s.p[rw_damping[k]] * velocity;
        }
        *discrete(m, rw_slot_tied, 2 * k, slot) = *discrete(m, rw_slot_tied, 2 * k + 1, slot) = 0.0;
    }
    for (int n = 0; n < count; n++)
        if (is_leave(&due[n])) join(m, span_of(m, rw_run_of[due[n].k], due[n].load));
    return RW_OK;
}

/* A load within the zone hangs in balance from now on; the tension behind it starts there. */
static void tie(rw_instance *m, const rw_threshold *t)
{
    int k = span_of(m, rw_run_of[t->k], t->load), slot = m->s.passed[k] - 1 - t->load;
    double at[2] = {0.0, 0.0}, weight;
    *discrete(m, rw_slot_tied, 2 * k + (t->k != k), slot) = 1.0;
    *discrete(m, rw_slot_joined, k, slot) = 0.0;
    for (int i = 0; i < 2; i++)
        if (slot - i >= 0)
            at[i] = *discrete(m, rw_slot_at, k, slot - i) + *discrete(m, rw_slot_ride, k, slot - i) * rw_support_travel(m, k);
    weight = (m->s.p[rw_mass_per_length[k]] * (at[0] - at[1]) + *discrete(m, rw_slot_mass, k, slot)) * m->s.p[0];
    for (int axis = 0; axis < 3; axis++) {
        const int *pull = &rw_slot_pull[3 * k + axis];
        double before = m->s.now.z[slot ? *pull + slot - 1 : rw_force[k] + axis];
        m->s.now.z[*pull + slot] = before + (axis == 2 ? weight : 0.0);
    }
}

/* What a slot with a load has in a span. */
typedef struct {
    int load;
    double x[6], z[6], tied[2], joined, lost;
} moving_slot;

/* Of span k all slots with loads: place and velocity, pull and acceleration. */
static int take(const rw_instance *m, int k, moving_slot *found)
{
    int count = m->s.passed[k] - m->s.passed[k + 1];
    for (int j = 0; j < count; j++) {
        moving_slot *s = &found[j];
        s->load = m->s.passed[k] - 1 - j;
        for (int axis = 0; axis < 3; axis++) {
            s->x[axis] = m->s.now.x[rw_slot_place[3 * k + axis] + j];
            s->x[3 + axis] = m->s.now.x[rw_slot_velocity[3 * k + axis] + j];
            s->z[axis] = m->s.now.z[rw_slot_pull[3 * k + axis] + j];
            s->z[3 + axis] = m->s.now.z[rw_slot_acceleration[3 * k + axis] + j];
        }
        for (int end = 0; end < 2; end++) s->tied[end] = m->s.d[rw_slot_tied[2 * k + end] + j];
        s->joined = m->s.d[rw_slot_joined[k] + j];
        s->lost = m->s.d[rw_slot_lost[k] + j];
    }
    return count;
}

/* Writes the slots of span k, now that its loads have changed; empty ones are tied to its end b. */
static void put(rw_instance *m, int k, const moving_slot *known, int count)
{
    double behind[3];
    memcpy(behind, m->s.now.z + rw_force[k], sizeof behind);
    for (int j = 0; j < rw_slot_count[k]; j++) {
        int load = m->s.passed[k] - 1 - j;
        const moving_slot *s = NULL;
        for (int n = 0; n < count && load >= m->s.passed[k + 1]; n++)
            if (known[n].load == load) s = &known[n];
        *discrete(m, rw_slot_joined, k, j) = s ? s->joined : 0.0;
        *discrete(m, rw_slot_lost, k, j) = s ? s->lost : 0.0;
        for (int end = 0; end < 2; end++) *discrete(m, rw_slot_tied, 2 * k + end, j) = s ? s->tied[end] : end;
        if (s) memcpy(behind, s->z, sizeof behind);
        for (int axis = 0; axis < 3; axis++) {
            m->s.now.z[rw_slot_pull[3 * k + axis] + j] = behind[axis];
            if (!s) continue;
            m->s.now.x[rw_slot_place[3 * k + axis] + j] = s->x[axis];
            m->s.now.x[rw_slot_velocity[3 * k + axis] + j] = s->x[3 + axis];
            m->s.now.z[rw_slot_acceleration[3 * k + axis] + j] = s->z[3 + axis];
        }
    }
}

/* A load that comes into span k through one of its ends, tied to that end. */
static moving_slot coming_in(rw_instance *m, int k, const rw_threshold *t, int load, double lost, const moving_slot *own, int count)
{
    int forward = t->kind == CROSS_FORWARD;
    double weight = rw_load_mass(m, rw_run_of[k], load) * m->s.p[0], *force = m->s.now.z + rw_force[k];
    moving_slot s = {.load = load, .tied = {forward, !forward}, .lost = lost};
    memcpy(s.z, force, 3 * sizeof(double));
    for (int n = 0; !forward && n < count; n++)
        if (own[n].load == load + 1) memcpy(s.z, own[n].z, 3 * sizeof(double));
    if (forward) force[2] -= weight; /* the first piece, before the load, is pulled less steeply down */
    else s.z[2] += weight;
    return s;
}

/* Moves a tied load past its support to the other span, where it is tied to the same support. */
static rw_status cross(rw_instance *m, const rw_threshold *t)
{
    int run = rw_run_of[t->k], first = rw_run_first[run], last = rw_run_first[run + 1] - 1;
    int forward = t->kind == CROSS_FORWARD, joint = rw_around[run] && (t->k == first || t->k == last);
    int ends[2] = {joint ? first : t->k, last}, spans[4], counts[4], n = 0;
    moving_slot known[4][RW_SLOTS + 1];
    double lost = 0.0;
    for (int e = 0; e <= joint; e++)
        for (int k = ends[e] - 1; k <= ends[e]; k++) {
            int seen = k < first || k >= last;
            for (int i = 0; i < n; i++) seen |= spans[i] == k;
            if (seen) continue;
            spans[n] = k;
            counts[n] = take(m, k, known[n]);
            for (int j = 0; j < counts[n]; j++)
                if (known[n][j].load == t->load) lost = known[n][j].lost;
            n++;
        }
    for (int e = 0; e <= joint; e++) {
        int end = ends[e], load = m->s.passed[end] - (forward ? 0 : 1), into = forward ? end : end - 1;
        m->s.passed[end] += forward ? 1 : -1;
        for (int i = 0; i < n; i++) {
            if (spans[i] != into) continue;
            known[i][counts[i]] = coming_in(m, into, t, load, lost, known[i], counts[i]);
            counts[i]++;
        }
    }
    for (int e = 0; !forward && e <= joint; e++) /* the first load of the span has left it: the tension is that behind it */
        for (int i = 0; i < n; i++)
            for (int j = 0; spans[i] == ends[e] && j < counts[i]; j++)
                if (known[i][j].load == m->s.passed[ends[e]]) memcpy(m->s.now.z + rw_force[ends[e]], known[i][j].z, 3 * sizeof(double));
    rw_status status = rw_check_slots(m);
    if (status != RW_OK) return status;
    rw_write_slots(m);
    for (int i = 0; i < n; i++) put(m, spans[i], known[i], counts[i]);
    rw_tell_crossing(m, m->s.now.t, &(rw_crossing){.k = t->k, .load = t->load, .forward = forward}, 0);
    return RW_OK;
}

/* All events that are due at the present point, whose rates are known; the line is solved again. */
rw_status rw_pass_zones(rw_instance *m)
{
    rw_threshold due[RW_NTH];
    int count = rw_zones_due(m, due), leaving = 0;
    rw_status status = RW_OK;
    if (!count) return RW_OK;
    for (int n = 0; n < count; n++) leaving |= is_leave(&due[n]);
    if (leaving) status = leave(m, due, count);
    for (int n = 0; n < count; n++)
        if (due[n].kind <= TIE_B) tie(m, &due[n]);
    for (int n = 0; status == RW_OK && n < count; n++)
        if (is_cross(&due[n])) status = cross(m, &due[n]);
    m->s.solved = m->s.rated = m->s.shown = m->s.lu.valid = 0;
    return status == RW_OK ? rw_rates(m) : status;
}

/* Moves the line by at most h, to the first event that a load comes to; `stop` is where h may end. */
rw_status rw_move_with_inertia(rw_instance *m, double h, double stop)
{
    rw_threshold found[RW_NTH];
    double low[RW_NK + 1], high[RW_NK + 1], reached[RW_NU + 1];
    int watched[RW_NK + 1], place[RW_NK + 1], count = 0, events = thresholds(m, found), failed;
    ri_point *q = rw_core_point(m);
    ri_run run = {.stop = h, .h = m->s.h, .tolerance = m->tolerance, .shortest = SHORTEST, .near = NEAR};
    for (int k = 0; k < RW_NK; k++) {
        if (!ties(k)) continue;
        watched[count] = rw_travel[k], place[k] = count;
        low[count] = -INFINITY, high[count++] = INFINITY;
    }
    for (int i = 0; i < events; i++) {
        double gap = found[i].gap > RW_ZONE_NEAR ? found[i].gap : BEHIND, at = rw_support_travel(m, found[i].k);
        int n = place[found[i].k];
        if (found[i].side > 0.0) high[n] = fmin(high[n], at + gap);
        else low[n] = fmax(low[n], at - gap);
    }
    run.watches = count, run.watched = watched, run.low = low, run.high = high;
    failed = ri_move(&rw_core, q, &run);
    m->s.h = run.h;
    m->s.now.t = run.hit < 0 && m->s.now.t + h >= stop - SHORTEST ? stop : m->s.now.t + run.time;
    if (!rw_core_solved(m, failed)) {
        rw_message(m, RW_DISCARD, "logStatusDiscard", "%s at t = %.9g s (worst: %s)",
                   failed ? failures[failed] : "The rates are not finite", m->s.now.t, rw_equation_name[RW_NX + q->worst]);
        return RW_DISCARD;
    }
    memcpy(reached, m->us, RW_NU * sizeof(double));
    rw_inputs_at(m, m->s.now.t, m->us);
    for (int i = 0; i < RW_NU; i++) /* the rates of inputs jump here */
        if (fabs(m->us[i] - reached[i]) > 1e-12) m->s.solved = m->s.rated = 0;
    return rw_rates(m);
}

/* Travel of the rope over support k until the next event there, whichever way it moves, as a part of a mean span. */
double rw_zone_gap(const rw_instance *m, int k)
{
    rw_threshold all[RW_NTH];
    double gap = INFINITY;
    for (int i = thresholds(m, all) - 1; i >= 0; i--)
        if (all[i].k == k) gap = fmin(gap, all[i].gap - 0.5 * RW_ZONE_NEAR);
    return isfinite(gap) ? gap / rw_span_scale[rw_run_of[k]] : 1.0;
}

/* Solves the line where it starts: a load whose place is beyond a support would have to cross it first. */
rw_status rw_require_spans(rw_instance *m)
{
    rw_status status = rw_rates(m);
    for (int run = 0; status == RW_OK && rw_run_first[run] < RW_NK; run++)
        for (int i = m->s.passed[rw_run_first[run + 1] - 1]; i < m->s.passed[rw_run_first[run]]; i++) {
            int k = span_of(m, run, i);
            double place = rw_load_position(m, run, i), past = 2.0 * RW_ZONE_PAST;
            if (place >= rope_at(m, k) - past && place <= rope_at(m, k + 1) + past) continue;
            rw_message(m, RW_ERROR, "logStatusError", "With these lengths load %d hangs beyond the span after %s: export the line with them",
                       i + 1, rw_support_name[k]);
            return RW_ERROR;
        }
    return status == RW_OK ? rw_lengths(m) : status;
}
