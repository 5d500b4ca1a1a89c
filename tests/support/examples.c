/* Four small FMUs for Model Exchange, FMI 2.0, chosen by MODEL: the van der Pol oscillator (stiff for a large mu), a
 * bouncing ball (a state event), a staircase (time events, no state; it ends the run) and Roberts' chemical reaction (stiff;
 * state events at levels of the first and third substance). Variables are x, der(x), y, parameters; see examples.py. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2FunctionTypes.h"

#define VANDERPOL 1
#define BALL 2
#define STAIR 3
#define ROBERTS 4

#if MODEL == VANDERPOL
enum { NX = 2, NY = 0, NP = 1, NZ = 0 };
static const double start[] = {2.0, 0.0, 1.0};
#elif MODEL == BALL
enum { NX = 2, NY = 1, NP = 3, NZ = 1 };
static const double start[] = {1.0, 0.0, 9.81, 0.7, 0.1};
#elif MODEL == STAIR
enum { NX = 0, NY = 1, NP = 2, NZ = 0 };
static const double start[] = {1.0, 10.0};
#else
enum { NX = 3, NY = 1, NP = 0, NZ = 2 };
static const double start[] = {1.0, 0.0, 0.0};
#endif

/* w: states, rates, outputs, parameters */
enum { DX = NX, Y = 2 * NX, P = Y + NY, N = P + NP };

typedef struct {
    double t, w[N + 1];
    int count, resting, above[2]; /* bounces or stairs so far; levels of Roberts' that were passed */
} instance;

static void equations(instance *s)
{
    double *w = s->w;
#if MODEL == VANDERPOL
    w[DX] = w[1];
    w[DX + 1] = w[P] * (1.0 - w[0] * w[0]) * w[1] - w[0];
#elif MODEL == BALL
    w[DX] = w[1];
    w[DX + 1] = s->resting ? 0.0 : -w[P];
    w[Y] = s->count;
#elif MODEL == STAIR
    w[Y] = 1.0 + s->count;
#else
    double fast = 3e7 * w[1] * w[1], back = 1e4 * w[1] * w[2], slow = 0.04 * w[0];
    w[DX] = back - slow;
    w[DX + 1] = slow - back - fast;
    w[DX + 2] = fast;
    w[Y] = s->above[0] + 2 * s->above[1];
#endif
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *callbacks,
                              fmi2Boolean visible, fmi2Boolean logging)
{
    instance *s = calloc(1, sizeof *s);
    memcpy(s->w, start, NX * sizeof(double));
    memcpy(s->w + P, start + NX, NP * sizeof(double));
    return s;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }

#define FINE(call, ...) fmi2Status call(fmi2Component c, ##__VA_ARGS__) { return fmi2OK; }
FINE(fmi2SetupExperiment, fmi2Boolean has, fmi2Real tolerance, fmi2Real begin, fmi2Boolean ends, fmi2Real stop)
FINE(fmi2EnterInitializationMode)
FINE(fmi2ExitInitializationMode)
FINE(fmi2EnterEventMode)
FINE(fmi2EnterContinuousTimeMode)
FINE(fmi2Terminate)
FINE(fmi2Reset)
FINE(fmi2SetDebugLogging, fmi2Boolean on, size_t n, const fmi2String categories[])
#define MISSING(call) fmi2Status call(void) { return fmi2Error; }
MISSING(fmi2GetInteger) MISSING(fmi2SetInteger) MISSING(fmi2GetBoolean) MISSING(fmi2SetBoolean) MISSING(fmi2GetString)
MISSING(fmi2SetString) MISSING(fmi2SerializedFMUstateSize) MISSING(fmi2SerializeFMUstate) MISSING(fmi2DeSerializeFMUstate)
MISSING(fmi2GetDirectionalDerivative)

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    instance *s = c;
    equations(s);
    for (size_t i = 0; i < n; i++) value[i] = s->w[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++) ((instance *)c)->w[vr[i]] = value[i];
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *kept)
{
    if (!*kept) *kept = malloc(sizeof(instance));
    memcpy(*kept, c, sizeof(instance));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate kept)
{
    memcpy(c, kept, sizeof(instance));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *kept)
{
    free(*kept);
    *kept = NULL;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ((instance *)c)->t = time;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    memcpy(((instance *)c)->w, x, n * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    memcpy(x, ((instance *)c)->w, n * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    for (size_t i = 0; i < n; i++) x[i] = 1.0;
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rate[], size_t n)
{
    equations(c);
    memcpy(rate, ((instance *)c)->w + DX, n * sizeof *rate);
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean final, fmi2Boolean *enter, fmi2Boolean *end)
{
    *enter = *end = fmi2False;
    return fmi2OK;
}

#define LEVEL_1 0.9
#define LEVEL_3 0.01

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n)
{
    const instance *s = c;
#if MODEL == BALL
    z[0] = s->resting || (s->w[0] == 0.0 && s->w[1] > 0.0) ? 1e-300 : s->w[0]; /* after a bounce it is above the ground */
#elif MODEL == ROBERTS
    z[0] = s->w[0] - LEVEL_1;
    z[1] = s->w[2] - LEVEL_3;
#else
    (void)s, (void)z;
#endif
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    instance *s = c;
    memset(info, 0, sizeof *info);
#if MODEL == BALL
    if (s->w[0] <= 0.0 && s->w[1] < 0.0) {
        s->w[0] = 0.0;
        s->w[1] *= -s->w[P + 1];
        s->count++;
        if (s->w[1] < s->w[P + 2]) {
            s->w[1] = 0.0;
            s->resting = 1;
        }
        info->valuesOfContinuousStatesChanged = fmi2True;
    }
#elif MODEL == STAIR
    while (s->t >= s->w[P] * (s->count + 1) - 1e-12) s->count++;
    info->terminateSimulation = s->count >= s->w[P + 1];
    info->nextEventTimeDefined = fmi2True;
    info->nextEventTime = s->w[P] * (s->count + 1);
#elif MODEL == ROBERTS
    s->above[0] = !(s->w[0] > LEVEL_1);
    s->above[1] = s->w[2] > LEVEL_3;
#else
    (void)s;
#endif
    return fmi2OK;
}
