/* An instance: creation, variables, initialisation, saved states. Value references are consecutive: time, states, rates,
 * algebraic variables, inputs, parameters, masses, outputs, event indicators, limits (Boolean), loads passed
 * (integer), switches and the emergency stop (Boolean inputs). */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "ropeway.h"

enum {
    X = 1,
    DX = X + RW_NX,
    Z = DX + RW_NX,
    U = Z + RW_NZ,
    P = U + RW_NU,
    MASS = P + RW_NP,
    Y = MASS + RW_NM,
    EI = Y + RW_NY,
    LIMIT = EI + RW_NK + RW_NL + RW_NB,
    PASSED = LIMIT + RW_NL,
    SWITCH = PASSED + RW_NK,
    STOP = SWITCH + RW_NSW,
    END = STOP + (RW_NE > 0)
};

enum { HIDDEN, READ, PARAMETER, INPUT, STATE };

/* Name of a variable for messages. */
static const char *name_of(unsigned vr)
{
    return vr < END && rw_variable_name[vr][0] ? rw_variable_name[vr] : "without a name";
}

/* What the importer says of its run. */
void rw_experiment(rw_instance *m, int tolerance_defined, double tolerance, int stop_defined, double stop)
{
    m->tolerance = tolerance_defined && tolerance > 0.0 ? fmin(fmax(tolerance, 1e-10), 1e-2) : RW_TOLERANCE;
    m->stop_time = stop_defined ? stop : INFINITY;
}

void rw_reset(rw_instance *m)
{
    rw_state *s = &m->s;
    rw_experiment(m, 0, 0.0, 0, 0.0);
    memset(s, 0, sizeof *s);
    s->mode = RW_INSTANTIATED;
    s->now.t = m->start_time;
    memcpy(s->now.x, rw_x_start, RW_NX * sizeof(double));
    memcpy(s->now.z, rw_z_start, RW_NZ * sizeof(double));
    memcpy(s->u, rw_u_start, RW_NU * sizeof(double));
    memcpy(s->p, rw_p_start, RW_NP * sizeof(double));
    memcpy(s->d, rw_d_start, RW_ND * sizeof(double));
    memcpy(s->mass, rw_mass_start, RW_NM * sizeof(double));
    memcpy(s->passed, rw_passed_start, RW_NK * sizeof(int));
    for (int i = 0; i < RW_NSW; i++) s->on[i] = s->d[rw_switch[i]] > 0.0;
    s->h = RW_INERTIAL ? 0.01 : 1e9;
    rw_place_loads(m);
    rw_start_place(m);
}

rw_instance *rw_new(rw_log_function log, void *context, int co_simulation)
{
    rw_instance *m = calloc(1, sizeof *m);
    if (!m) return NULL;
    m->log = log;
    m->context = context;
    m->co_simulation = co_simulation;
    rw_reset(m);
    return m;
}

/* Solves the line for parameters, masses or states other than those of the equilibrium at export: in one step, or by
 * continuation from the equilibrium. Loads are then moved into the spans that the rope has carried them to. */
static rw_status apply_start_values(rw_instance *m)
{
    rw_state *s = &m->s;
    double p[RW_NP + 1], mass[RW_NM + 1], x[RW_NX + 1], done = 0.0, share = 1.0;
    rw_status status;
    if (s->known) return RW_OK;
    memcpy(s->passed, rw_passed_start, RW_NK * sizeof(int));
    memcpy(s->d, rw_d_start, RW_ND * sizeof(double));
    for (int i = 0; i < RW_NSW; i++) s->d[rw_switch[i]] = s->on[i];
    memcpy(s->now.z, rw_z_start, RW_NZ * sizeof(double));
    rw_start_place(m);
    memcpy(p, s->p, sizeof p);
    memcpy(mass, s->mass, sizeof mass);
    memcpy(x, s->now.x, sizeof x);
    s->lu.valid = 0;
    while (done < 1.0) {
        double to = fmin(done + share, 1.0);
        rw_point from = s->now;
        for (int i = 0; i < RW_NP; i++) s->p[i] = to == 1.0 ? p[i] : rw_p_start[i] + to * (p[i] - rw_p_start[i]);
        for (int i = 0; i < RW_NM; i++) s->mass[i] = to == 1.0 ? mass[i] : rw_mass_start[i] + to * (mass[i] - rw_mass_start[i]);
        for (int i = 0; i < RW_NX; i++) s->now.x[i] = to == 1.0 ? x[i] : rw_x_start[i] + to * (x[i] - rw_x_start[i]);
        rw_write_slots(m);
        status = rw_overrun_settle(m);
        if (status == RW_OK) {
            done = to;
            continue;
        }
        share /= 2.0;
        memcpy(s->now.z, from.z, sizeof from.z);
        if (status == RW_ERROR || share < 1e-2) {
            memcpy(s->p, p, sizeof p);
            memcpy(s->mass, mass, sizeof mass);
            memcpy(s->now.x, x, sizeof x);
            s->solved = s->rated = s->shown = 0;
            rw_message(m, RW_ERROR, "logStatusError", "No equilibrium was found for these parameters and states");
            return RW_ERROR;
        }
    }
    s->known = 1;
    return RW_OK;
}

rw_status rw_initialize(rw_instance *m)
{
    rw_status status = apply_start_values(m);
    rw_start_clocks(m);
    return status == RW_OK ? rw_limits(m) : status;
}

/* During initialisation the variables of an instance follow from its parameters. */
rw_status rw_up_to_date(rw_instance *m)
{
    if (m->s.mode <= RW_INITIALIZATION) {
        rw_status status = apply_start_values(m);
        if (status != RW_OK) return status;
    } else {
        rw_status status = rw_look_ahead(m);
        if (status != RW_OK) return status;
    }
    return rw_solve(m);
}

rw_status rw_set_time(rw_instance *m, double t)
{
    if (!isfinite(t)) {
        rw_message(m, RW_ERROR, "logStatusError", "The time is not finite");
        return RW_ERROR;
    }
    if (t != m->s.now.t) m->s.solved = m->s.rated = m->s.shown = 0;
    m->s.now.t = t;
    return RW_OK;
}

static rw_status unknown(rw_instance *m, unsigned vr)
{
    rw_message(m, RW_ERROR, "logStatusError", "Unknown value reference %u", vr);
    return RW_ERROR;
}

static rw_status not_now(rw_instance *m, unsigned vr)
{
    rw_message(m, RW_ERROR, "logStatusError", "The variable %s cannot be set now", name_of(vr));
    return RW_ERROR;
}

rw_status rw_get_real(rw_instance *m, unsigned vr, double *value)
{
    rw_status status;
    if (vr >= LIMIT || rw_access[vr] == HIDDEN) return unknown(m, vr);
    if (vr == 0) *value = m->s.now.t;
    else if (vr < DX) *value = m->s.now.x[vr - X];
    else if (vr >= U && vr < P) {
        rw_inputs_at(m, m->s.now.t, m->us);
        *value = m->us[vr - U];
    } else if (vr >= P && vr < MASS) *value = m->s.p[vr - P];
    else if (vr >= MASS && vr < Y) *value = m->s.mass[vr - MASS];
    else {
        status = rw_up_to_date(m);
        if (status != RW_OK) return status;
        if (vr < Z) *value = m->s.rate[vr - DX];
        else if (vr < U) *value = m->s.now.z[vr - Z];
        else if (vr < EI) {
            status = rw_show(m);
            if (status != RW_OK) return status;
            *value = m->s.y[vr - Y];
        } else {
            double indicator[RW_NK + RW_NL + RW_NB + 1];
            status = rw_event_indicators(m, indicator);
            if (status != RW_OK) return status;
            *value = indicator[vr - EI];
        }
    }
    return RW_OK;
}

/* Whether a value of a parameter is valid; masses of loads are not negative. */
static int in_range(rw_instance *m, unsigned vr, double value)
{
    int known = vr < MASS, above = known && rw_above[vr - P];
    double least = known ? rw_least[vr - P] : 0.0, most = known ? rw_most[vr - P] : INFINITY;
    const char *wanted = value > most ? "be at most" : above ? "be above" : "not be below";
    if (value > least || (!above && value == least)) if (value <= most) return 1;
    rw_message(m, RW_ERROR, "logStatusError", "The value for %s must %s %g", name_of(vr), wanted, value > most ? most : least);
    return 0;
}

rw_status rw_set_real(rw_instance *m, unsigned vr, double value)
{
    int access = vr < LIMIT ? rw_access[vr] : HIDDEN, initialising = m->s.mode <= RW_INITIALIZATION;
    if (access == HIDDEN) return unknown(m, vr);
    if (!isfinite(value)) {
        rw_message(m, RW_ERROR, "logStatusError", "The value for %s is not finite", name_of(vr));
        return RW_ERROR;
    }
    if (access == PARAMETER && !in_range(m, vr, value)) return RW_ERROR;
    if (access == INPUT) {
        if (m->s.u[vr - U] == value) return RW_OK;
        m->s.u[vr - U] = value;
        m->s.ahead.kept = 0;
        m->s.ahead.stale = 1;
    } else if (access == PARAMETER && initialising) {
        *(vr < MASS ? &m->s.p[vr - P] : &m->s.mass[vr - MASS]) = value;
        m->s.known = 0;
    } else if (access == PARAMETER && rw_tunable[vr - P] && (m->s.mode == RW_EVENT || m->s.mode == RW_STEP)) {
        *(vr < MASS ? &m->s.p[vr - P] : &m->s.mass[vr - MASS]) = value;
        m->s.lu.valid = 0;
        if (vr >= MASS) rw_write_slots(m);
    } else if (access == STATE && (initialising || m->s.mode == RW_EVENT || m->s.mode == RW_CONTINUOUS)) {
        m->s.now.x[vr - X] = value;
        if (initialising) m->s.known = 0;
    } else
        return not_now(m, vr);
    m->s.solved = m->s.rated = m->s.shown = 0;
    return RW_OK;
}

/* Rate of an input within the next step of Co-Simulation. */
rw_status rw_set_input_rate(rw_instance *m, unsigned vr, double rate)
{
    if (vr >= LIMIT || rw_access[vr] != INPUT) return unknown(m, vr);
    if (!isfinite(rate)) {
        rw_message(m, RW_ERROR, "logStatusError", "The rate for value reference %u is not finite", vr);
        return RW_ERROR;
    }
    m->s.slope[vr - U] = rate;
    m->s.slope_from = m->s.now.t;
    m->s.rated = 0;
    return RW_OK;
}

/* Inputs go linearly to `end` within the next step of Co-Simulation. */
void rw_inputs_reach(rw_instance *m, const double *end, double size)
{
    m->s.slope_from = m->s.now.t;
    for (int i = 0; i < RW_NU; i++) m->s.slope[i] = (end[i] - m->s.u[i]) / size;
}

rw_status rw_get_boolean(rw_instance *m, unsigned vr, int *value)
{
    rw_status status = RW_OK;
    if (vr >= STOP && vr < END) {
        *value = m->s.stopping;
        return RW_OK;
    }
    if (vr >= SWITCH && vr < STOP && rw_switch_shown[vr - SWITCH]) {
        *value = m->s.on[vr - SWITCH];
        return RW_OK;
    }
    if (vr < LIMIT || vr >= PASSED) return unknown(m, vr);
    if (m->s.mode == RW_INITIALIZATION) status = rw_initialize(m);
    if (status <= RW_WARNING) *value = m->s.broken[vr - LIMIT];
    return status;
}

/* Begins an emergency stop: all commanded speeds go to zero from their present values, responses end. Or ends it: the
 * inputs count again. */
static void emergency_stop(rw_instance *m, int on)
{
    if (on) rw_inputs_at(m, m->s.now.t, m->us);
    for (int i = 0; on && i < RW_NE; i++) {
        int correction = rw_stop_correction[i];
        m->s.stop_speed[i] = m->us[rw_stop_input[i]] + (correction < 0 ? 0.0 : m->s.d[correction]);
        if (correction >= 0) m->s.d[correction] = 0.0;
    }
    if (!on) rw_start_clocks(m);
    m->s.stop_time = m->s.now.t;
    m->s.stopping = on;
    m->s.solved = m->s.rated = m->s.shown = 0;
}

/* Sets a switch; the line continues from its present state. */
rw_status rw_set_boolean(rw_instance *m, unsigned vr, int value)
{
    if (vr >= LIMIT && vr < PASSED) return not_now(m, vr);
    if (vr >= STOP && vr < END) {
        if (m->s.stopping == (value != 0)) return RW_OK;
        if (m->s.mode <= RW_INITIALIZATION || m->s.mode == RW_CONTINUOUS) return not_now(m, vr);
        emergency_stop(m, value != 0);
        return RW_OK;
    }
    if (vr < SWITCH || vr >= STOP || !rw_switch_shown[vr - SWITCH]) return unknown(m, vr);
    if (m->s.on[vr - SWITCH] == (value != 0)) return RW_OK;
    if (m->s.mode == RW_CONTINUOUS) return not_now(m, vr);
    m->s.on[vr - SWITCH] = value != 0;
    m->s.d[rw_switch[vr - SWITCH]] = value != 0;
    if (m->s.mode <= RW_INITIALIZATION) m->s.known = 0;
    m->s.solved = m->s.rated = m->s.shown = 0;
    return RW_OK;
}

rw_status rw_get_integer(rw_instance *m, unsigned vr, int *value)
{
    rw_status status = RW_OK;
    if (vr < PASSED || vr >= SWITCH) return unknown(m, vr);
    if (m->s.mode == RW_INITIALIZATION) status = apply_start_values(m);
    if (status <= RW_WARNING) *value = m->s.passed[vr - PASSED];
    return status;
}

void rw_clear_seeds(rw_instance *m)
{
    m->dt = 0.0;
    memset(m->dx, 0, sizeof m->dx);
    memset(m->du, 0, sizeof m->du);
    memset(m->dp, 0, sizeof m->dp);
    memset(m->dm, 0, sizeof m->dm);
}

/* Seed of a known variable: an input, a state, a parameter, or time. */
rw_status rw_seed(rw_instance *m, unsigned vr, double seed)
{
    int access = vr < LIMIT ? rw_access[vr] : HIDDEN;
    if (access == STATE) m->dx[vr - X] = seed;
    else if (access == INPUT) m->du[vr - U] = seed;
    else if (access == PARAMETER) *(vr < MASS ? &m->dp[vr - P] : &m->dm[vr - MASS]) = seed;
    else if (vr == 0) {
        m->dt = seed;
        rw_input_rates(m, m->s.now.t, seed, m->du);
    } else {
        rw_message(m, RW_ERROR, "logStatusError", "The variable %s (value reference %u) is not an input, a state or a parameter", name_of(vr), vr);
        return RW_ERROR;
    }
    return RW_OK;
}

/* Change of an unknown variable, after rw_tangent_of; a state that is an output changes by its own seed. */
rw_status rw_sensitivity(rw_instance *m, unsigned vr, double *value)
{
    if (vr >= X && vr < DX) *value = m->dx[vr - X];
    else if (vr >= DX && vr < Z) *value = m->df[vr - DX];
    else if (vr >= Z && vr < U) *value = m->dz[vr - Z];
    else if (vr >= Y && vr < EI) *value = m->dy[vr - Y];
    else {
        rw_message(m, RW_ERROR, "logStatusError", "The variable %s (value reference %u) has no derivatives", name_of(vr), vr);
        return RW_ERROR;
    }
    return RW_OK;
}

/* FNV-1a of 64 bits: a state with another checksum is damaged. */
static uint64_t checksum(const unsigned char *bytes, size_t size)
{
    uint64_t sum = 14695981039346656037u;
    for (size_t i = 0; i < size; i++) sum = (sum ^ bytes[i]) * 1099511628211u;
    return sum;
}

size_t rw_serialized_size(void)
{
    return sizeof(rw_fingerprint) + sizeof(uint64_t) + RW_STATE_SIZE;
}

rw_status rw_serialize(rw_instance *m, const rw_state *state, unsigned char *bytes, size_t size)
{
    uint64_t sum = checksum((const unsigned char *)state, RW_STATE_SIZE);
    if (size < rw_serialized_size()) {
        rw_message(m, RW_ERROR, "logStatusError", "A state requires %lu bytes", (unsigned long)rw_serialized_size());
        return RW_ERROR;
    }
    memcpy(bytes, rw_fingerprint, sizeof rw_fingerprint);
    memcpy(bytes + sizeof rw_fingerprint, &sum, sizeof sum);
    memcpy(bytes + sizeof rw_fingerprint + sizeof sum, state, RW_STATE_SIZE);
    return RW_OK;
}

rw_status rw_deserialize(rw_instance *m, const unsigned char *bytes, size_t size, rw_state **state)
{
    uint64_t sum;
    const unsigned char *kept = bytes + sizeof rw_fingerprint + sizeof sum;
    if (size != rw_serialized_size() || memcmp(bytes, rw_fingerprint, sizeof rw_fingerprint) != 0) {
        rw_message(m, RW_ERROR, "logStatusError", "These bytes are not a state of this FMU");
        return RW_ERROR;
    }
    memcpy(&sum, bytes + sizeof rw_fingerprint, sizeof sum);
    if (sum != checksum(kept, RW_STATE_SIZE)) {
        rw_message(m, RW_ERROR, "logStatusError", "These bytes of a state are damaged: their checksum differs");
        return RW_ERROR;
    }
    if (!*state) *state = malloc(RW_STATE_SIZE);
    if (!*state) return RW_ERROR;
    memcpy(*state, kept, RW_STATE_SIZE);
    return RW_OK;
}
