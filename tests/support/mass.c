/* A small FMU that owes nothing to the exported ones: a mass on a spring and a damper, coupled to another by a third.
 *
 *   der(x) = v;  mass der(v) = force - spring x - damper v - mass gravity - f
 *   f = stiffness (x - x_in) + cubic (x - x_in)^3 + damping (v - v_in), what it pulls the other one with
 *
 * It bounces from `floor` and is kicked at `kick_time`. Steps above `longest_step` are refused. FMI 2.0, Model Exchange
 * and Co-Simulation; the latter without bounces and kicks. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2FunctionTypes.h"

enum { X, V, DX, DV, F, FORCE, X_IN, V_IN, MASS, SPRING, DAMPER, STIFFNESS, CUBIC, DAMPING, GRAVITY, FLOOR, BOUNCE, KICK_TIME, KICK, LONGEST, N };

typedef struct {
    double value[N], rate[N], time; /* rate: of inputs, within a step */
    int kicked;
} state;

typedef struct {
    state s;
    const fmi2CallbackFunctions *callbacks;
} instance;

static void equations(double *w)
{
    double d = w[X] - w[X_IN];
    w[F] = w[STIFFNESS] * d + w[CUBIC] * d * d * d + w[DAMPING] * (w[V] - w[V_IN]);
    w[DX] = w[V];
    w[DV] = (w[FORCE] - w[SPRING] * w[X] - w[DAMPER] * w[V] - w[F]) / w[MASS] - w[GRAVITY];
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *callbacks,
                              fmi2Boolean visible, fmi2Boolean logging)
{
    instance *i = calloc(1, sizeof *i);
    i->callbacks = callbacks;
    i->s.value[MASS] = 1.0;
    i->s.value[FLOOR] = -1e9;
    i->s.value[KICK_TIME] = i->s.value[LONGEST] = 1e9;
    return i;
}

void fmi2FreeInstance(fmi2Component c) { free(c); }
fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends, fmi2Real stop) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return fmi2OK; }

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    double *w = ((instance *)c)->s.value;
    equations(w);
    for (size_t i = 0; i < n; i++) value[i] = w[vr[i]];
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    state *s = &((instance *)c)->s;
    for (size_t i = 0; i < n; i++) {
        s->value[vr[i]] = value[i];
        s->rate[vr[i]] = 0.0;
    }
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nu, const fmi2ValueReference known[],
                                        size_t nk, const fmi2Real seed[], fmi2Real sensitivity[])
{
    const double *w = ((instance *)c)->s.value;
    for (size_t i = 0; i < nu; i++) {
        sensitivity[i] = 0.0;
        for (size_t k = 0; k < nk; k++) {
            double d = w[X] - w[X_IN], df = 0.0, dv = known[k] == FORCE ? 1.0 : 0.0;
            if (known[k] == X_IN) df = -w[STIFFNESS] - 3.0 * w[CUBIC] * d * d;
            if (known[k] == V_IN) df = -w[DAMPING];
            if (unknown[i] == F) sensitivity[i] += seed[k] * df;
            if (unknown[i] == DV) sensitivity[i] += seed[k] * (dv - df) / w[MASS];
        }
    }
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *kept)
{
    if (!*kept) *kept = malloc(sizeof(state));
    memcpy(*kept, &((instance *)c)->s, sizeof(state));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate kept)
{
    memcpy(&((instance *)c)->s, kept, sizeof(state));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *kept)
{
    free(*kept);
    *kept = NULL;
    return fmi2OK;
}

#define MISSING(call) fmi2Status call(void) { return fmi2Error; }
MISSING(fmi2SetDebugLogging) MISSING(fmi2Terminate) MISSING(fmi2Reset) MISSING(fmi2CancelStep)
MISSING(fmi2GetInteger) MISSING(fmi2SetInteger) MISSING(fmi2GetBoolean) MISSING(fmi2SetBoolean) MISSING(fmi2GetString) MISSING(fmi2SetString)
MISSING(fmi2SerializedFMUstateSize) MISSING(fmi2SerializeFMUstate) MISSING(fmi2DeSerializeFMUstate) MISSING(fmi2GetRealOutputDerivatives)
MISSING(fmi2GetStatus) MISSING(fmi2GetRealStatus) MISSING(fmi2GetIntegerStatus) MISSING(fmi2GetBooleanStatus) MISSING(fmi2GetStringStatus)

/* Co-Simulation: Runge-Kutta's classical method */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[], const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++) ((instance *)c)->s.rate[vr[i]] = value[i];
    return fmi2OK;
}

static void slope(const state *s, double t, double x, double v, double *k)
{
    double w[N];
    for (int i = 0; i < N; i++) w[i] = s->value[i] + t * s->rate[i];
    w[X] = x;
    w[V] = v;
    equations(w);
    k[0] = w[DX];
    k[1] = w[DV];
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean noSetPrior)
{
    instance *i = c;
    state *s = &i->s;
    int steps = (int)ceil(size / 2e-3);
    double h = size / steps, x = s->value[X], v = s->value[V];
    if (size > s->value[LONGEST]) {
        i->callbacks->logger(i->callbacks->componentEnvironment, "mass", fmi2Discard, "logStatusDiscard", "the step is too long");
        return fmi2Discard;
    }
    for (int n = 0; n < steps; n++) {
        double k[4][2], t = n * h;
        slope(s, t, x, v, k[0]);
        slope(s, t + h / 2, x + h / 2 * k[0][0], v + h / 2 * k[0][1], k[1]);
        slope(s, t + h / 2, x + h / 2 * k[1][0], v + h / 2 * k[1][1], k[2]);
        slope(s, t + h, x + h * k[2][0], v + h * k[2][1], k[3]);
        x += h / 6 * (k[0][0] + 2 * k[1][0] + 2 * k[2][0] + k[3][0]);
        v += h / 6 * (k[0][1] + 2 * k[1][1] + 2 * k[2][1] + k[3][1]);
    }
    for (int n = FORCE; n <= V_IN; n++) s->value[n] += size * s->rate[n];
    s->value[X] = x;
    s->value[V] = v;
    return fmi2OK;
}

/* Model Exchange */

fmi2Status fmi2EnterEventMode(fmi2Component c) { return fmi2OK; }
fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return fmi2OK; }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    state *s = &((instance *)c)->s;
    memset(info, 0, sizeof *info);
    if (s->value[X] <= s->value[FLOOR] && s->value[V] < 0.0) {
        s->value[V] *= -s->value[BOUNCE];
        info->valuesOfContinuousStatesChanged = info->newDiscreteStatesNeeded = fmi2True;
    }
    if (s->time >= s->value[KICK_TIME] && !s->kicked) {
        s->value[V] += s->value[KICK];
        s->kicked = 1;
        info->valuesOfContinuousStatesChanged = info->newDiscreteStatesNeeded = fmi2True;
    }
    info->nextEventTimeDefined = !s->kicked;
    info->nextEventTime = s->value[KICK_TIME];
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean final, fmi2Boolean *enter, fmi2Boolean *end)
{
    *enter = *end = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    ((instance *)c)->s.time = time;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    memcpy(((instance *)c)->s.value, x, 2 * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    memcpy(x, ((instance *)c)->s.value, 2 * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    x[0] = x[1] = 1.0;
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rate[], size_t n)
{
    double *w = ((instance *)c)->s.value;
    equations(w);
    memcpy(rate, w + DX, 2 * sizeof *rate);
    return fmi2OK;
}

/* Below the floor and going down: positive again as soon as it bounces. */
fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicator[], size_t n)
{
    const double *w = ((instance *)c)->s.value;
    indicator[0] = w[X] > w[FLOOR] || w[V] >= 0.0 ? fabs(w[X] - w[FLOOR]) + 1e-12 : w[X] - w[FLOOR];
    return fmi2OK;
}
