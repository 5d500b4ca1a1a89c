/* Loads that cross supports: time of the next crossing, and its effect. At a hold-down sheave a load can be pushed back
 * from both sides; it then stands on the sheave, which carries it, until it is released to one side. */
#include <math.h>
#include <string.h>
#include "ropeway.h"

/* Travel of a support until the next load crosses it forward and backward [m]. */
void rw_gaps(const rw_instance *m, int k, double *ahead, double *behind)
{
    int run = rw_run_of[k], beyond = m->s.passed[k], around = rw_around[run];
    double rope = m->rope[k] - rw_support_travel(m, k);
    *ahead = *behind = INFINITY;
    if (around && rw_is_last(k)) return; /* its loads cross with those of the first support */
    if (beyond < rw_load_count(run)) *ahead = rope - rw_load_position(m, run, beyond);
    if (around || beyond > 0) *behind = rw_load_position(m, run, beyond - 1) - rope;
}

/* The first crossing at the present rates. */
int rw_next_crossing(const rw_instance *m, rw_crossing *found)
{
    found->time = INFINITY;
    for (int k = 0; k < RW_NK && !RW_INERTIAL; k++) {
        double ahead, behind, rate = rw_travel_rate(m, k), time;
        if (rw_load_count(rw_run_of[k]) == 0 || fabs(rate) <= 1e-12) continue;
        rw_gaps(m, k, &ahead, &behind);
        time = rate > 0.0 ? ahead / rate : behind / -rate;
        if (isfinite(time) && time < found->time) {
            found->time = time;
            found->gap = rate > 0.0 ? ahead : behind;
            found->k = k;
            found->forward = rate > 0.0;
            found->load = m->s.passed[k] - (rate > 0.0 ? 0 : 1);
        }
    }
    return isfinite(found->time);
}

/* Forces by which each side of an idler draws a load on it away [N]: with the load on the rope out, and on the rope in;
 * `size` is the tension they are compared with. */
typedef struct {
    double forward, backward, size;
} prevailing;

/* Tension of a rope with `share` of a load's weight and wind added to its tension vector. */
static double length_of(const double *v, const double *load, double share)
{
    double x = v[0] + share * load[0], y = v[1] + share * load[1], z = v[2] + share * load[2];
    return sqrt(x * x + y * y + z * z);
}

/* What a load adds to the tension vector of a rope behind it: its weight, and the wind on it. */
static void pull_of(rw_instance *m, int run, int load, double *pull)
{
    pull[0] = pull[1] = 0.0;
    pull[2] = rw_load_mass(m, run, load) * m->s.p[0];
    if (rw_wind[0] < 0) return;
    rw_inputs_at(m, m->s.now.t, m->us);
    double force = rw_drag_area(run, load) * m->us[rw_wind[0]];
    double angle = (m->us[rw_wind[1]] - m->s.p[rw_north[0]]) * 3.14159265358979323846 / 180.0;
    pull[0] = force * sin(angle);
    pull[1] = force * cos(angle);
}

/* Residual of an idler's tension law with `share` of a load added to the forces of both ropes; no load holds it. */
static rw_status law(rw_instance *m, int k, const double *load, double share, double *found)
{
    double *in = m->s.now.z + rw_force[k - 1], *out = m->s.now.z + rw_force[k], before[6], held = m->s.d[rw_held[k]];
    int failed;
    if (RW_SECTIONS) {
        *found = rw_line_law(m, k, load, share);
        return RW_OK;
    }
    rw_inputs_at(m, m->s.now.t, m->us);
    memcpy(before, in, 3 * sizeof(double));
    memcpy(before + 3, out, 3 * sizeof(double));
    for (int i = 0; i < 3; i++) { /* the force at the end follows that at the start */
        in[i] += share * load[i];
        out[i] += share * load[i];
    }
    m->s.d[rw_held[k]] = 0.0;
    failed = rw_equations(m, m->s.now.t, m->s.now.x, m->s.now.z, m->us);
    memcpy(in, before, 3 * sizeof(double));
    memcpy(out, before + 3, 3 * sizeof(double));
    m->s.d[rw_held[k]] = held;
    if (failed) return rw_fail(m, "The tension law is not finite", m->s.now.t);
    *found = m->g[rw_law[k]];
    return RW_OK;
}

/* The forces on the load at support k. */
static rw_status beside(rw_instance *m, int k, int load, prevailing *s)
{
    rw_status status = RW_SECTIONS ? rw_solve(m) : rw_show(m);
    double pull[3], coming[3], t_in, t_out, ahead = 0.0, behind = 1.0;
    const double *going = m->s.now.z + rw_force[k];
    if (status != RW_OK) return status;
    pull_of(m, rw_run_of[k], load, pull);
    if (RW_SECTIONS)
        rw_span_end(m, k - 1 - rw_run_of[k], coming);
    else {
        memcpy(coming, m->s.now.z + rw_force[k - 1], sizeof coming);
        if (rw_pull_b[k - 1] >= 0) memcpy(coming, m->s.y + rw_pull_b[k - 1], 2 * sizeof(double));
        coming[2] = m->s.y[rw_vertical_b[k - 1]];
    }
    if (load >= m->s.passed[k]) { /* it hangs at the end of the span before the support */
        ahead = -1.0;
        behind = 0.0;
    }
    t_in = s->size = length_of(coming, pull, 0.0);
    t_out = length_of(going, pull, 0.0);
    if (!rw_is_held(m, k) && fabs(t_out - t_in) <= 1e-9 * t_in) {
        s->forward = length_of(going, pull, ahead) - length_of(coming, pull, ahead);
        s->backward = length_of(coming, pull, behind) - length_of(going, pull, behind);
        return RW_OK;
    }
    status = law(m, k, pull, ahead, &s->forward);
    if (status != RW_OK) return status;
    status = law(m, k, pull, behind, &s->backward);
    s->backward = -s->backward;
    return status;
}

/* Moves the load across the support, or leaves it there. The line is not solved. */
rw_status rw_put_across(rw_instance *m, const rw_crossing *crossing)
{
    int k = crossing->k, load = crossing->load, forward = crossing->forward;
    int goes = 1;
    rw_status status;
    if (rw_held[k] >= 0 && !rw_is_last(k) && k > rw_run_first[rw_run_of[k]]) {
        prevailing s;
        status = beside(m, k, load, &s);
        if (status != RW_OK) return status;
        goes = (forward ? s.forward : s.backward) >= -1e-9 * s.size; /* a massless load passes */
    }
    if (goes) {
        m->s.passed[k] += forward ? 1 : -1;
        if (rw_around[rw_run_of[k]] && k == rw_run_first[rw_run_of[k]]) m->s.passed[rw_run_first[rw_run_of[k] + 1] - 1] += forward ? 1 : -1;
        status = rw_check_slots(m);
        if (status != RW_OK) return status;
        rw_write_slots(m);
    } else {
        m->s.d[rw_held[k]] = 1.0;
        m->s.d[rw_held_travel[k]] = m->rope[k] - rw_load_position(m, rw_run_of[k], load);
        m->s.solved = m->s.rated = m->s.shown = 0;
    }
    rw_tell_crossing(m, m->s.now.t, crossing, !goes);
    return RW_OK;
}

/* Loads that are beyond a support after a jump of the line cross it; not, at the ends of a rope, those that were just
 * put on or taken off there (`just`, by support). */
static rw_status overrun(rw_instance *m, unsigned char *just)
{
    if (RW_INERTIAL) return rw_require_spans(m);
    for (int pass = 0; pass < 50; pass++) {
        int moved = 0;
        rw_status status = rw_solve(m);
        unsigned char forward[RW_NK + 1], backward[RW_NK + 1];
        if (status != RW_OK) return status;
        for (int k = 0; k < RW_NK; k++) {
            double ahead, behind, near = RW_NEAR * rw_span_scale[rw_run_of[k]];
            int end = rw_is_last(k) || k == rw_run_first[rw_run_of[k]];
            rw_gaps(m, k, &ahead, &behind);
            forward[k] = backward[k] = 0;
            if (rw_travel[k] < 0 || (end && just[k])) continue;
            forward[k] = ahead < -near;
            backward[k] = behind < -near;
        }
        for (int k = 0; k < RW_NK; k++) {
            if (!forward[k] && !backward[k]) continue;
            if (rw_is_held(m, k)) continue;
            status = rw_put_across(m, &(rw_crossing){.k = k, .load = m->s.passed[k] - (forward[k] ? 0 : 1), .forward = forward[k]});
            if (status != RW_OK) return status;
            just[k] = 1;
            moved = 1;
        }
        if (!moved) return rw_lengths(m);
    }
    rw_message(m, RW_ERROR, "logStatusError", "Loads oscillate across a support at t = %.9g s", m->s.now.t);
    return RW_ERROR;
}

rw_status rw_overrun_settle(rw_instance *m)
{
    unsigned char just[RW_NK + 1] = {0};
    return overrun(m, just);
}

/* The same between events: after a jump of an input or switch, or after a rope that reversed within a step. Loads at
 * the ends of a rope may be beyond the end after a jump. */
rw_status rw_overrun_moving(rw_instance *m)
{
    unsigned char just[RW_NK + 1];
    rw_status status;
    memset(just, 1, sizeof just);
    status = overrun(m, just);
    return status == RW_OK ? rw_rates(m) : status;
}

/* Crosses the first load and all others that are on a support at this time; the line is then solved. Call it after
 * rw_rates. `first` may be NULL. */
rw_status rw_cross(rw_instance *m, const rw_crossing *first)
{
    unsigned char just[RW_NK + 1] = {0};
    rw_crossing due[RW_NK + 1];
    int count = 0;
    if (first) due[count++] = *first;
    for (int k = 0; k < RW_NK; k++) {
        double ahead, behind, near = RW_NEAR * rw_span_scale[rw_run_of[k]], rate = rw_travel_rate(m, k);
        rw_gaps(m, k, &ahead, &behind);
        if ((first && k == first->k) || rw_is_held(m, k)) continue;
        if ((rate > 0.0 && ahead <= near) || (rate < 0.0 && behind <= near)) {
            due[count].k = k;
            due[count].forward = rate > 0.0;
            due[count++].load = m->s.passed[k] - (rate > 0.0 ? 0 : 1);
        }
    }
    for (int i = 0; i < count; i++) {
        rw_status status = rw_put_across(m, &due[i]);
        if (status != RW_OK) return status;
        just[due[i].k] = 1;
    }
    return overrun(m, just);
}

int rw_standing(const rw_instance *m)
{
    for (int k = 0; k < RW_NK; k++)
        if (rw_is_held(m, k)) return 1;
    return 0;
}

static int load_on(const rw_instance *m, int k)
{
    double place = m->rope[k] - m->s.d[rw_held_travel[k]];
    int beyond = m->s.passed[k], run = rw_run_of[k];
    if (beyond == 0 && !rw_around[run]) return 0;
    if (beyond >= rw_load_count(run)) return beyond - 1;
    return fabs(rw_load_position(m, run, beyond) - place) <= fabs(rw_load_position(m, run, beyond - 1) - place) ? beyond : beyond - 1;
}

/* Force that pushes the load on support k off it [N]: positive when it leaves, in the direction of `found`. */
rw_status rw_release_of(rw_instance *m, int k, rw_crossing *found, double *ahead)
{
    prevailing s;
    rw_status status;
    found->k = k;
    found->load = load_on(m, k);
    status = beside(m, k, found->load, &s);
    if (status != RW_OK) return status;
    found->forward = s.forward >= s.backward;
    *ahead = fmax(s.forward, s.backward);
    return RW_OK;
}

/* The load on a sheave that is closest to its release; `ahead` is -INFINITY if there is none. */
rw_status rw_release(rw_instance *m, rw_crossing *found, double *ahead)
{
    *ahead = -INFINITY;
    for (int k = 0; k < RW_NK; k++) {
        rw_crossing one;
        double force;
        rw_status status;
        if (!rw_is_held(m, k)) continue;
        status = rw_release_of(m, k, &one, &force);
        if (status != RW_OK) return status;
        if (force > *ahead) {
            *ahead = force;
            *found = one;
        }
    }
    return RW_OK;
}

/* Releases a load from a sheave. */
rw_status rw_let_go(rw_instance *m, const rw_crossing *found)
{
    rw_status status;
    m->s.d[rw_held[found->k]] = 0.0;
    m->s.passed[found->k] = found->load + (found->forward ? 1 : 0);
    rw_message(m, RW_OK, "logEvents", "t = %.9f s: load %d released %s at %s", m->s.now.t, found->load + 1,
               found->forward ? "forward" : "backward", rw_support_name[found->k]);
    status = rw_check_slots(m);
    if (status != RW_OK) return status;
    rw_write_slots(m);
    return rw_solve(m);
}

/* Updates the violated limits: tension above the breaking load, lift-off and others. */
rw_status rw_limits(rw_instance *m)
{
    rw_status status = rw_limit_values(m);
    if (status != RW_OK) return status;
    for (int i = 0; i < RW_NL; i++) {
        double value = m->limit[i], slack = m->s.broken[i] ? rw_limit_slack[i] : 0.0;
        int broken = value >= rw_limit_high[i] - slack || value <= rw_limit_low[i] + slack;
        if (broken && !m->s.broken[i])
            rw_message(m, RW_WARNING, "logStatusWarning", "t = %.9f s: %s", m->s.now.t, rw_limit_name[i]);
        m->s.broken[i] = broken;
    }
    return RW_OK;
}
