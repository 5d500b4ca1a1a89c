/* Loads in the slots of their spans. A load at place c on the rope stands on support k exactly when the support's
 * travel is X_k - c, X_k the rope at the support at zero travel. The supports of all ropes are numbered consecutively;
 * support k is the b end of span k - 1 and the a end of span k, the last support of a rope has no span of its own.
 * On an endless rope loads recur: numbers n and n + around are the same load, one rope length apart, and the last
 * support is the first. */
#include <string.h>
#include "ropeway.h"

/* What follows from lengths and loads passed: rope at each support at zero travel, in m->rope, and of a line by sections
 * the loads in each span, in m->used. */
void rw_place_loads(rw_instance *m)
{
    for (int k = 0; k < RW_NK; k++) {
        m->rope[k] = k == rw_run_first[rw_run_of[k]] ? 0.0 : m->rope[k - 1] + m->s.p[rw_length_start[k - 1]];
        if (!rw_is_last(k)) m->used[k - rw_run_of[k]] = m->s.passed[k] - m->s.passed[k + 1];
    }
}

/* Takes over a saved state. */
void rw_take_state(rw_instance *m, const rw_state *state)
{
    memcpy(&m->s, state, RW_STATE_SIZE);
    if (RW_SECTIONS || RW_INERTIAL) m->s.lu.valid = 0;
    rw_place_loads(m);
}

/* Revolution of load i on an endless rope, rounded down; 0 on a rope with ends. */
static int revolution_of(int run, int i)
{
    int around = rw_around[run];
    return around == 0 ? 0 : i >= 0 ? i / around : -((around - 1 - i) / around);
}

double rw_load_position(const rw_instance *m, int run, int i)
{
    int first = rw_load_first[run], n = rw_load_first[run + 1] - first, revolution = revolution_of(run, i);
    if (rw_around[run]) return rw_load_place[first + i - revolution * n] - revolution * m->rope[rw_run_first[run + 1] - 1];
    if (i < n) return rw_load_place[first + i];
    return rw_load_place[first + n - 1] - rw_feed_spacing[run] * (i - n + 1);
}

/* Index of a load's mass among the adjustable masses. */
static int mass_of(int run, int i)
{
    int first = rw_mass_first[run], n = rw_mass_first[run + 1] - first;
    return first + (i - revolution_of(run, i) * rw_around[run]) % n;
}

double rw_load_mass(const rw_instance *m, int run, int i)
{
    return m->s.mass[mass_of(run, i)];
}

/* Drag area of a load; loads of a feed that are not in the list have that of the last one. */
double rw_drag_area(int run, int i)
{
    int first = rw_load_first[run], n = rw_load_first[run + 1] - first, k = i - revolution_of(run, i) * n;
    return rw_load_drag[first + (k < n ? k : n - 1)];
}

/* Number of loads of a run; unlimited with a feed. */
int rw_load_count(int run)
{
    return rw_feed_spacing[run] > 0.0 ? 1 << 30 : rw_load_first[run + 1] - rw_load_first[run];
}

double rw_support_travel(const rw_instance *m, int k)
{
    int i = rw_travel[k];
    return i < 0 ? 0.0 : i < RW_NX ? m->s.now.x[i] : m->s.now.z[i - RW_NX];
}

/* Rate of a support's travel [m/s], after rw_rates. */
double rw_travel_rate(const rw_instance *m, int k)
{
    int i = rw_travel[k];
    return i < 0 ? 0.0 : i < RW_NX ? m->s.rate[i] : m->s.zrate[i - RW_NX];
}

int rw_is_last(int k)
{
    return k + 1 == rw_run_first[rw_run_of[k] + 1];
}

int rw_is_held(const rw_instance *m, int k)
{
    return rw_held[k] >= 0 && m->s.d[rw_held[k]] > 0.0;
}

/* Logs that a load has crossed a support, or is held there. */
void rw_tell_crossing(rw_instance *m, double time, const rw_crossing *crossing, int held)
{
    rw_message(m, RW_OK, "logEvents", "t = %.9f s: load %d %s %s", time, crossing->load + 1,
               held ? "held at" : crossing->forward ? "crosses forward" : "crosses backward", rw_support_name[crossing->k]);
}

/* Puts the loads into the slots of their spans. */
void rw_write_slots(rw_instance *m)
{
    rw_place_loads(m);
    for (int k = 0; k < RW_NK; k++) {
        int run = rw_run_of[k];
        if (rw_is_last(k)) continue;
        for (int j = 0; j < rw_slot_count[k]; j++) {
            int load = m->s.passed[k] - 1 - j, full = load >= m->s.passed[k + 1];
            m->s.d[rw_slot_mass[k] + j] = full ? rw_load_mass(m, run, load) : 0.0;
            m->s.d[rw_slot_at[k] + j] = full ? rw_load_position(m, run, load) - m->rope[k] : 0.0;
            m->s.d[rw_slot_ride[k] + j] = full;
            m->s.d[rw_slot_empty[k] + j] = !full;
            if (rw_slot_drag[k] >= 0) m->s.d[rw_slot_drag[k] + j] = full ? rw_drag_area(run, load) : 0.0;
        }
    }
    m->s.solved = m->s.rated = m->s.shown = 0;
}

/* Derivatives of the slots in the direction of the parameter seeds: masses, and distances, which decrease with the
 * length of rope before the span, and with the total length for each revolution. */
void rw_slot_seeds(rw_instance *m)
{
    double grown = 0.0, whole = 0.0;
    memset(m->dd, 0, sizeof m->dd);
    for (int k = 0; k < RW_NK; k++) {
        int run = rw_run_of[k];
        if (k == rw_run_first[run]) {
            grown = whole = 0.0;
            for (int i = k; !rw_is_last(i); i++) whole += m->dp[rw_length_start[i]];
        }
        if (rw_is_last(k)) continue;
        for (int j = 0; j < rw_slot_count[k]; j++)
            if (m->s.d[rw_slot_ride[k] + j] > 0.0) {
                int load = m->s.passed[k] - 1 - j;
                m->dd[rw_slot_at[k] + j] = -grown - revolution_of(run, load) * whole;
                m->dd[rw_slot_mass[k] + j] = m->dm[mass_of(run, load)];
            }
        grown += m->dp[rw_length_start[k]];
    }
}

/* More loads in a span than slots are an error. */
rw_status rw_check_slots(rw_instance *m)
{
    for (int k = 0; k < RW_NK; k++)
        if (!rw_is_last(k) && m->s.passed[k] - m->s.passed[k + 1] > rw_slot_count[k]) {
            rw_message(m, RW_ERROR, "logStatusError", "%d loads in the span after %s, which has %d slots: export with a larger spacing",
                       m->s.passed[k] - m->s.passed[k + 1], rw_support_name[k], rw_slot_count[k]);
            return RW_ERROR;
        }
    return RW_OK;
}

/* A span without rope ends the run. */
rw_status rw_lengths(rw_instance *m)
{
    for (int k = 0; k < RW_NK; k++)
        if (!rw_is_last(k) && !(m->s.p[rw_length_start[k]] + rw_support_travel(m, k) - rw_support_travel(m, k + 1) > 0.0)) {
            rw_message(m, RW_ERROR, "logStatusError", "No rope is left in the span after %s at t = %.9g s", rw_support_name[k], m->s.now.t);
            return RW_ERROR;
        }
    return RW_OK;
}
