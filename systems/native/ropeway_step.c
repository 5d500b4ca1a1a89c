/* Time integration with crossings located within the step (Co-Simulation); event indicators and event update (Model
 * Exchange). */
#include <math.h>
#include <string.h>
#include "ropeway.h"

#define STANDING_STEP 0.02 /* s, while a load stands on a sheave */
#define LEAST_STEP 1e-11   /* s */
#define RELEASE_FORCE (30.0 * RW_FORCE_NEAR) /* N, force at which a load is released: well above rounding errors */
#define MOST_STEPS 200000          /* within one step of the importer */
#define CHECK_TRAVEL 0.01          /* of a mean span: largest travel of the rope between two checks of the limits */

/* Restores the point before a rejected step, with its rates. */
static rw_status restore(rw_instance *m, const rw_point *from)
{
    rw_status status;
    m->s.now = *from;
    m->s.solved = m->s.rated = m->s.shown = 0;
    m->s.lu.valid = 0;
    status = rw_solve(m);
    return status == RW_OK ? rw_rates(m) : status;
}

/* A step from `from` by at most *h, reduced until it succeeds; rates are known at its end. */
static rw_status step(rw_instance *m, const rw_point *from, double *h, double stop)
{
    for (;;) {
        double error;
        rw_status status = rw_one_step(m, from, *h, 0, &error);
        if (status == RW_OK && error <= 1.0) {
            double next = *h * fmin(5.0, 0.9 / cbrt(fmax(error, 1e-9)));
            if (from->t + *h >= stop - LEAST_STEP) m->s.now.t = stop;
            if (next > m->s.h || error > 0.3) m->s.h = next;
            return rw_rates(m);
        }
        if (status == RW_ERROR) return status;
        *h *= status == RW_OK && error < 1e9 ? fmax(0.2, 0.9 / cbrt(error)) : 0.25;
        m->s.h = *h;
        if (*h < LEAST_STEP) {
            rw_message(m, RW_DISCARD, "logStatusDiscard", "The step at t = %.9g s fails at the smallest step size", from->t);
            return RW_DISCARD;
        }
        status = restore(m, from);
        if (status != RW_OK) return status;
    }
}

static rw_status after_event(rw_instance *m, rw_status status)
{
    m->s.lu.valid = m->s.rated = 0;
    return status == RW_OK ? rw_rates(m) : status;
}

/* A step of at most h, reduced to the time of the first crossing or release within it. */
static rw_status step_to_event(rw_instance *m, double h, double stop)
{
    rw_point from = m->s.now;
    rw_crossing coming, leaving;
    double before = -INFINITY, ahead = -INFINITY;
    int standing = rw_standing(m);
    rw_status status = standing ? rw_release(m, &leaving, &before) : RW_OK;
    if (status != RW_OK) return status;
    if (before >= RELEASE_FORCE) return after_event(m, rw_let_go(m, &leaving));
    for (int trial = 0; trial < 40; trial++) {
        status = step(m, &from, &h, stop);
        if (status != RW_OK) return status;
        if (rw_next_crossing(m, &coming) && coming.gap < -RW_NEAR * rw_span_scale[rw_run_of[coming.k]]) {
            /* a crossing lies within the step */
            double less = h + coming.time;
            h = less > 0.0 && trial < 20 ? less : h / 2.0;
        } else {
            if (!standing) return RW_OK;
            status = rw_release(m, &leaving, &ahead);
            if (status != RW_OK || ahead <= RW_FORCE_NEAR) return status;
            if (ahead <= 1e3 * RW_FORCE_NEAR || h < 1e-6) return after_event(m, rw_let_go(m, &leaving));
            h *= trial < 20 ? (RELEASE_FORCE - before) / (ahead - before) : 0.5;
        }
        if (h < LEAST_STEP) break;
        status = restore(m, &from);
        if (status != RW_OK) return status;
    }
    rw_message(m, RW_DISCARD, "logStatusDiscard", "An event cannot be located after t = %.9g s", from.t);
    return RW_DISCARD;
}

static double next_tick(const rw_instance *m, int clock)
{
    return rw_clock_phase[clock] + m->s.ticks[clock] * rw_clock_period[clock];
}

/* Skips ticks before the present time. */
void rw_start_clocks(rw_instance *m)
{
    for (int i = 0; i < RW_NC; i++) {
        m->s.ticks[i] = (int)fmax(0.0, floor((m->s.now.t - rw_clock_phase[i]) / rw_clock_period[i]));
        while (next_tick(m, i) < m->s.now.t - 1e-9) m->s.ticks[i]++;
    }
}

/* Evaluates the clocks that tick now; corrections take effect after all of them. */
static rw_status tick(rw_instance *m)
{
    int any = 0;
    memset(m->changes, 0, sizeof m->changes);
    for (int i = 0; i < RW_NC; i++) {
        if (m->s.stopping || next_tick(m, i) > m->s.now.t + 1e-9) continue;
        rw_status status = rw_solve(m);
        if (status != RW_OK) return status;
        m->s.ticks[i]++;
        if (rw_sample(m, i)) {
            rw_message(m, RW_DISCARD, "logStatusDiscard", "A response is not finite at t = %.9g s", m->s.now.t);
            return RW_DISCARD;
        }
        for (int p = rw_clock_first[i]; p < rw_clock_first[i + 1]; p++) {
            int entry = rw_clock_entry[p];
            double value = m->sample[p - rw_clock_first[i]];
            if (!rw_clock_corrects[p])
                m->s.d[entry] = value;
            else if (value != m->s.d[entry]) {
                m->fresh[entry] = value;
                any = m->changes[entry] = 1;
            }
        }
    }
    if (!any) return RW_OK;
    for (int i = 0; i < RW_ND; i++)
        if (m->changes[i]) m->s.d[i] = m->fresh[i];
    m->s.solved = m->s.rated = m->s.shown = 0;
    return rw_overrun_moving(m);
}

static int tick_due(const rw_instance *m)
{
    for (int i = 0; i < RW_NC; i++)
        if (!m->s.stopping && next_tick(m, i) <= m->s.now.t + 1e-9) return 1;
    return 0;
}

/* Time to the next check of the limits at the present rates. With a carriage that moves between places the state is the
 * travel of its drum. */
static double next_limit_check(const rw_instance *m)
{
    double time = INFINITY;
    for (int k = 0; k < RW_NK; k++) time = fmin(time, CHECK_TRAVEL * rw_span_scale[rw_run_of[k]] / fabs(rw_travel_rate(m, k)));
    if (RW_NPL)
        for (int i = 0; i < RW_NX; i++) time = fmin(time, CHECK_TRAVEL * RW_MEAN_SPAN / fabs(m->s.rate[i]));
    return time;
}

typedef struct {
    int passed[RW_NK + 1], broken[RW_NL + 1], place;
} rw_changes;

/* Notes an event if a discrete variable has changed since `before`. */
static void note_changes(rw_instance *m, const rw_changes *before)
{
    if (memcmp(before->passed, m->s.passed, sizeof m->s.passed) || memcmp(before->broken, m->s.broken, sizeof m->s.broken) ||
        before->place != m->s.place)
        m->event = 1;
}

static rw_status advance(rw_instance *m, double end)
{
    const double begin = m->s.now.t;
    rw_status status = rw_overrun_moving(m);
    for (int trial = 0; status == RW_OK && trial < MOST_STEPS; trial++) {
        double t = m->s.now.t, stop = fmin(end, rw_next_time_event(m)), h = stop - t;
        rw_crossing coming;
        int some = rw_next_crossing(m, &coming), moved = 0;
        rw_changes before;
        rw_threshold due[RW_NTH];
        int crosses = RW_INERTIAL ? rw_zones_due(m, due) > 0 : some && coming.gap <= RW_NEAR * rw_span_scale[rw_run_of[coming.k]];
        if (crosses || tick_due(m)) m->event = 1;
        if (m->event && m->stops_at_events && t > begin) return rw_limits(m); /* the importer handles it */
        if (crosses) {
            status = RW_INERTIAL ? rw_pass_zones(m) : after_event(m, rw_cross(m, &coming));
            continue;
        }
        if (tick_due(m)) {
            status = after_event(m, tick(m));
            continue;
        }
        if (t >= end - LEAST_STEP) {
            m->s.now.t = end;
            return rw_limits(m);
        }
        if (RW_COUPLED && !RW_INERTIAL) h = fmin(h, m->s.h);
        if (RW_NL) h = fmin(h, next_limit_check(m));
        memcpy(before.passed, m->s.passed, sizeof before.passed);
        memcpy(before.broken, m->s.broken, sizeof before.broken);
        before.place = m->s.place;
        if (RW_SECTIONS && !rw_standing(m)) status = rw_move_along(m, h, stop, &moved);
        if (RW_INERTIAL) status = rw_move_with_inertia(m, h, stop);
        else if (status == RW_OK && !moved) {
            if (some) h = fmin(h, coming.time);
            if (rw_standing(m)) h = fmin(h, STANDING_STEP);
            status = step_to_event(m, h, stop);
        }
        if (status == RW_OK && !RW_INERTIAL) status = rw_overrun_moving(m);
        if (status == RW_OK && RW_NL) status = rw_limits(m);
        note_changes(m, &before);
    }
    if (status == RW_OK) {
        rw_message(m, RW_DISCARD, "logStatusDiscard", "The step to t = %.9g s needs more than %d steps of the solver; it reached t = %.9g s: take smaller steps",
                   end, MOST_STEPS, m->s.now.t);
        status = RW_DISCARD;
    }
    return status;
}

/* From the present time to `end`, or to an event before it; rates of inputs end there. After a failure the state is
 * unchanged. */
rw_status rw_do_step(rw_instance *m, double end)
{
    rw_status status;
    memcpy(&m->backup, &m->s, RW_STATE_SIZE);
    m->event = 0;
    if (RW_NF) m->s.solved = m->s.rated = m->s.shown = 0; /* the rates of inputs may have changed */
    status = advance(m, end);
    if (status > RW_WARNING) {
        rw_take_state(m, &m->backup);
        m->s.lu.valid = 0;
        return status;
    }
    for (int i = 0; i < RW_NU; i++) {
        m->s.u[i] += m->s.slope[i] * (m->s.now.t - m->s.slope_from);
        m->s.slope[i] = 0.0;
    }
    return status;
}

/* Time of the next vertex of a schedule or tick of a clock. */
double rw_next_time_event(const rw_instance *m)
{
    double next = INFINITY;
    for (int i = 0; i < rw_schedule_first[RW_NS]; i++)
        if (rw_schedule_time[i] > m->s.now.t + LEAST_STEP && rw_schedule_time[i] < next) next = rw_schedule_time[i];
    for (int i = 0; !m->s.stopping && i < RW_NC; i++) next = fmin(next, next_tick(m, i));
    for (int i = 0; m->s.stopping && i < RW_NE; i++)
        if (rw_stop_end(m, i) > m->s.now.t + LEAST_STEP) next = fmin(next, rw_stop_end(m, i));
    return next;
}

/* One for each support, then one for each limit; an event when it falls to zero. */
rw_status rw_event_indicators(rw_instance *m, double *indicator)
{
    rw_status status = rw_look_ahead(m);
    if (status == RW_OK) status = rw_limit_values(m);
    if (status != RW_OK) return status;
    for (int k = 0; k < RW_NK; k++) {
        double ahead, behind, gap;
        if (rw_is_held(m, k)) {
            rw_crossing found;
            double force;
            status = rw_release_of(m, k, &found, &force);
            if (status != RW_OK) return status;
            indicator[k] = (RW_FORCE_NEAR - force) / RW_FORCE_SCALE;
            continue;
        }
        if (RW_INERTIAL) {
            indicator[k] = rw_zone_gap(m, k);
            continue;
        }
        rw_gaps(m, k, &ahead, &behind);
        gap = fmin(ahead, behind) / rw_span_scale[rw_run_of[k]] + RW_NEAR;
        indicator[k] = rw_travel[k] < 0 || !isfinite(gap) ? 1.0 : gap;
    }
    for (int i = 0; i < RW_NL; i++) {
        double value = m->limit[i], slack = rw_limit_slack[i];
        double inside = fmin(rw_limit_high[i] - value, value - rw_limit_low[i]);
        indicator[RW_NK + i] = (m->s.broken[i] ? slack - inside : inside) / rw_limit_scale[i];
    }
    return RW_NB ? rw_border_indicators(m, indicator + RW_NK + RW_NL) : RW_OK;
}

/* All events at the present time. */
rw_status rw_event_update(rw_instance *m)
{
    rw_crossing leaving;
    double ahead;
    rw_status status = rw_rates(m);
    if (status == RW_OK) rw_hold(m);
    if (status == RW_OK) status = RW_INERTIAL ? rw_pass_zones(m) : rw_cross(m, NULL);
    if (status == RW_OK && tick_due(m)) status = after_event(m, tick(m));
    if (status == RW_OK && rw_standing(m)) {
        status = rw_release(m, &leaving, &ahead);
        if (status == RW_OK && ahead > 0.5 * RW_FORCE_NEAR) status = after_event(m, rw_let_go(m, &leaving));
    }
    return status == RW_OK ? rw_limits(m) : status;
}
