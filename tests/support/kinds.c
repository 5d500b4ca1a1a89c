/* A small FMU with variables of all kinds; compile it with -DFMI=2 or -DFMI=3.
 *
 *   der(x) = brake ? 0 : u + gain d       limit = x >= level
 *
 * u is a continuous input, d a discrete one, gain a tunable parameter; brake, counts, texts and enumerations are inputs
 * with an output each that repeats them. It ends the run at `stop_at`, discards steps beyond `discard_at` and fails in
 * those beyond `error_at`. Calls that FMI forbids in a mode are errors. Of FMI 3.0: all types, arrays, a clock. */
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TIME, U, X, DX, D, D_OUT, GAIN, LEVEL, STOP_AT, DISCARD_AT, ERROR_AT, START_TOLD, STOP_TOLD, REALS };
enum { COUNT = 20, BRAKE = 30, BRAKE_OUT, LIMIT, TEXT = 40, ENUM = 50, F32 = 60, BINARY = 76, SIZE = 80, V, W, M, TRACE, FLAGS, FLAGS_OUT, ALL = 100 };
enum { INSTANTIATED = 1, INITIALISING = 2, EVENT = 4, CONTINUOUS = 8, STEPPING = 16, CONFIGURING = 32, TERMINATED = 64 };

#if FMI == 2
#include "fmi2FunctionTypes.h"
typedef fmi2Status status;
typedef fmi2Boolean boolean;
enum { OK = fmi2OK, WARNING = fmi2Warning, DISCARD = fmi2Discard, ERROR = fmi2Error };
#else
#include "fmi3FunctionTypes.h"
typedef fmi3Status status;
typedef fmi3Boolean boolean;
enum { OK = fmi3OK, WARNING = fmi3Warning, DISCARD = fmi3Discard, ERROR = fmi3Error };
#endif

typedef struct {
    double r[REALS], v[8], m[4];
    int64_t z[ALL];
    char text[64], binary[64];
    size_t bytes;
    boolean flags[2];
    int limit, ended, mode;
} state;

typedef struct {
    state s;
    int exchange;
    const void *log, *environment;
} instance;

static status say(instance *i, status how, const char *text)
{
#if FMI == 2
    ((fmi2CallbackLogger)i->log)((void *)i->environment, "kinds", how, "log", text);
#else
    ((fmi3LogMessageCallback)i->log)((void *)i->environment, how, "log", text);
#endif
    return how;
}

#define NEED(modes) do { if (!(i->s.mode & (modes))) return say(i, ERROR, __func__); } while (0)
#define DISCRETE (INSTANTIATED | INITIALISING | EVENT | STEPPING)

static void equations(state *s)
{
    s->r[DX] = s->z[BRAKE] ? 0.0 : s->r[U] + s->r[GAIN] * s->r[D];
    s->r[D_OUT] = s->r[D];
    if (s->mode != CONTINUOUS) s->limit = s->r[X] >= s->r[LEVEL];
}

static instance *create(int exchange, const void *log, const void *environment)
{
    instance *i = calloc(1, sizeof *i);
    i->exchange = exchange;
    i->log = log;
    i->environment = environment;
    i->s.mode = INSTANTIATED;
    i->s.r[LEVEL] = i->s.r[STOP_AT] = i->s.r[DISCARD_AT] = i->s.r[ERROR_AT] = 1e9;
    i->s.r[STOP_TOLD] = -1.0;
    i->s.z[ENUM] = 1;
    i->s.z[SIZE] = 3;
    strcpy(i->s.text, "none");
    return i;
}

static status get_real(instance *i, unsigned vr, double *value)
{
    NEED(~INSTANTIATED & ~CONFIGURING);
    if (vr >= REALS) return say(i, ERROR, "no such real variable");
    equations(&i->s);
    *value = i->s.r[vr];
    return OK;
}

static status set_real(instance *i, unsigned vr, double value)
{
    if (vr == U || vr == X) /* CasADi sets states like inputs */
        NEED(DISCRETE | CONTINUOUS);
    else if (vr == D || vr == GAIN)
        NEED(DISCRETE);
    else
        NEED(INSTANTIATED | INITIALISING);
    i->s.r[vr] = value;
    return OK;
}

static status set_whole(instance *i, unsigned vr, int64_t value)
{
    NEED(vr == SIZE ? CONFIGURING : DISCRETE);
    if (vr == ENUM && (value < 1 || value > 3)) return say(i, ERROR, "no such item");
    i->s.z[vr] = value;
    return OK;
}

static status get_whole(instance *i, unsigned vr, int64_t *value)
{
    equations(&i->s);
    *value = vr == LIMIT ? i->s.limit : i->s.z[vr == BRAKE_OUT ? BRAKE : vr == SIZE ? vr : vr & ~1u];
    return OK;
}

/* One step of Co-Simulation up to `goal`; where it ends. */
static status move(instance *i, double time, double size, double *reached)
{
    state *s = &i->s;
    double goal = time + size;
    NEED(STEPPING);
    if (s->r[STOP_TOLD] >= 0.0 && goal > s->r[STOP_TOLD] + 1e-12) return say(i, ERROR, "beyond the stop time");
    if (goal > s->r[ERROR_AT]) return say(i, ERROR, "it has failed");
    if (goal > s->r[DISCARD_AT]) return say(i, DISCARD, "no step from there");
    if (goal >= s->r[STOP_AT]) {
        goal = s->r[STOP_AT];
        s->ended = 1;
    }
    equations(s);
    s->r[X] += (goal - time) * s->r[DX];
    s->r[TIME] = *reached = goal;
    return OK;
}

static status update(instance *i, boolean *needed, boolean *end, boolean *nominals, boolean *states, boolean *defined, double *next)
{
    NEED(EVENT);
    equations(&i->s);
    *needed = *nominals = *states = 0;
    *end = i->s.r[TIME] >= i->s.r[STOP_AT];
    *defined = i->s.r[STOP_AT] < 1e9;
    *next = i->s.r[STOP_AT];
    return OK;
}

static status change_mode(instance *i, int from, int to)
{
    NEED(from);
    i->s.mode = to;
    return OK;
}

static status enter(instance *i, double start, int ends, double stop)
{
    i->s.r[TIME] = i->s.r[START_TOLD] = start;
    if (ends) i->s.r[STOP_TOLD] = stop;
    return OK;
}

#define MODE(name, from, to) status name(void *c) { return change_mode(c, from, to); }
#define MISSING(name) status name(void) { return ERROR; }
#define EACH(c) instance *i = c; for (size_t k = 0; k < n; k++)

static status rates(instance *i, double *rate, size_t n)
{
    if (i->s.r[TIME] > i->s.r[ERROR_AT]) return say(i, ERROR, "it has failed");
    equations(&i->s);
    if (n) rate[0] = i->s.r[DX];
    return OK;
}

static status set_time(instance *i, double time)
{
    NEED(EVENT | CONTINUOUS);
    i->s.r[TIME] = time;
    return OK;
}

static status set_states(instance *i, const double x[], size_t n)
{
    NEED(CONTINUOUS);
    if (n) i->s.r[X] = x[0];
    return OK;
}

static status keep(instance *i, void **kept)
{
    if (!*kept) *kept = malloc(sizeof(state));
    memcpy(*kept, &i->s, sizeof(state));
    return OK;
}

static status bring_back(instance *i, void *kept)
{
    memcpy(&i->s, kept, sizeof(state));
    return OK;
}

static status release(void **kept)
{
    free(*kept);
    *kept = NULL;
    return OK;
}

static status terminate(instance *i)
{
    NEED(EVENT | CONTINUOUS | STEPPING);
    i->s.mode = TERMINATED;
    return say(i, WARNING, "terminated");
}

#if FMI == 2
#include "kinds2.h"
#else
#include "kinds3.h"
#endif
