/* FMI 2.0, Model Exchange and Co-Simulation. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"
#include "ropeway.h"

typedef struct {
    rw_instance core; /* first: an fmi2Component is an rw_instance too */
    const fmi2CallbackFunctions *callbacks;
    char *name;
} instance;

#define CORE (&((instance *)c)->core)
#define NEEDS(condition, call)                                                                   \
    do {                                                                                         \
        if (!c) return fmi2Error;                                                                \
        if (!(condition)) {                                                                      \
            rw_message(CORE, RW_ERROR, "logStatusError", call " is not allowed in this state");  \
            return fmi2Error;                                                                    \
        }                                                                                        \
    } while (0)
#define MODE (CORE->s.mode)

static void forward_message(void *context, rw_status status, const char *category, const char *message)
{
    /* Some importers show the format itself: the message is given as one, without conversions. */
    instance *i = context;
    char plain[512];
    size_t n = 0;
    for (; message[n] && n + 1 < sizeof plain; n++) plain[n] = message[n] == '%' ? ' ' : message[n];
    plain[n] = 0;
    if (i->callbacks && i->callbacks->logger)
        i->callbacks->logger(i->callbacks->componentEnvironment, i->name, (fmi2Status)status, category, plain);
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return fmi2Version; }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[])
{
    NEEDS(1, "fmi2SetDebugLogging");
    CORE->log_events = CORE->log_all = 0;
    if (on && n == 0) CORE->log_all = 1;
    for (size_t i = 0; on && i < n; i++) {
        if (strcmp(categories[i], "logEvents") == 0) CORE->log_events = 1;
        if (strcmp(categories[i], "logAll") == 0) CORE->log_all = 1;
    }
    return fmi2OK;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                              const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *i = NULL;
    rw_instance *core;
    (void)resources;
    (void)visible;
    if (!name || !guid || strcmp(guid, rw_fingerprint) != 0) {
        if (callbacks && callbacks->logger)
            callbacks->logger(callbacks->componentEnvironment, name ? name : "?", fmi2Error, "logStatusError",
                              "The GUID is not that of this FMU");
        return NULL;
    }
    i = calloc(1, sizeof *i);
    if (!i) return NULL;
    i->callbacks = callbacks;
    i->name = malloc(strlen(name) + 1);
    if (!i->name) {
        free(i);
        return NULL;
    }
    strcpy(i->name, name);
    core = &i->core;
    core->log = forward_message;
    core->context = i;
    core->log_all = logging;
    core->co_simulation = type == fmi2CoSimulation;
    rw_reset(core);
    return i;
}

void fmi2FreeInstance(fmi2Component c)
{
    if (!c) return;
    free(((instance *)c)->name);
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stopDefined, fmi2Real stop)
{
    (void)toleranceDefined, (void)tolerance, (void)stopDefined, (void)stop;
    NEEDS(MODE == RW_INSTANTIATED, "fmi2SetupExperiment");
    CORE->start_time = start;
    return (fmi2Status)rw_set_time(CORE, start);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    NEEDS(MODE == RW_INSTANTIATED, "fmi2EnterInitializationMode");
    MODE = RW_INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    rw_status status;
    NEEDS(MODE == RW_INITIALIZATION, "fmi2ExitInitializationMode");
    status = rw_initialize(CORE);
    if (status > RW_WARNING) return fmi2Error;
    MODE = CORE->co_simulation ? RW_STEP : RW_EVENT;
    return (fmi2Status)status;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    NEEDS(1, "fmi2Terminate");
    MODE = RW_TERMINATED;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    NEEDS(1, "fmi2Reset");
    CORE->start_time = 0.0;
    rw_reset(CORE);
    return fmi2OK;
}

#define WORST(status, other)                        \
    do {                                            \
        rw_status now_ = (other);                   \
        if (now_ > (status)) (status) = now_;       \
        if ((status) > RW_WARNING) return (fmi2Status)(status); \
    } while (0)

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "fmi2GetReal");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_real(CORE, vr[i], &value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "fmi2SetReal");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, vr[i], value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "fmi2GetInteger");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_integer(CORE, vr[i], &value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "fmi2GetBoolean");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_boolean(CORE, vr[i], &value[i]));
    return (fmi2Status)status;
}

#define NOT_THERE(type, call, parameters)                                                        \
    fmi2Status call parameters                                                                   \
    {                                                                                            \
        (void)vr, (void)value;                                                                   \
        NEEDS(1, #call);                                                                         \
        if (n == 0) return fmi2OK;                                                               \
        rw_message(CORE, RW_ERROR, "logStatusError", #call ": no such variable");                \
        return fmi2Error;                                                                        \
    }
NOT_THERE(String, fmi2GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]))
NOT_THERE(String, fmi2SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]))
NOT_THERE(Integer, fmi2SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]))
NOT_THERE(Boolean, fmi2SetBoolean, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[]))

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    NEEDS(state, "fmi2GetFMUstate");
    if (!*state) *state = malloc(sizeof(rw_state));
    if (!*state) return fmi2Error;
    memcpy(*state, &CORE->s, sizeof(rw_state));
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    NEEDS(state, "fmi2SetFMUstate");
    memcpy(&CORE->s, state, sizeof(rw_state));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    NEEDS(1, "fmi2FreeFMUstate");
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)state;
    NEEDS(size, "fmi2SerializedFMUstateSize");
    *size = rw_serialized_size();
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    NEEDS(state && bytes, "fmi2SerializeFMUstate");
    return (fmi2Status)rw_serialize(CORE, state, (unsigned char *)bytes, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state)
{
    NEEDS(state && bytes, "fmi2DeSerializeFMUstate");
    return (fmi2Status)rw_deserialize(CORE, (const unsigned char *)bytes, size, (rw_state **)state);
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nu,
                                        const fmi2ValueReference known[], size_t nk, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    rw_status status = RW_OK;
    NEEDS(MODE != RW_INSTANTIATED, "fmi2GetDirectionalDerivative");
    WORST(status, rw_up_to_date(CORE));
    rw_clear_seeds(CORE);
    for (size_t i = 0; i < nk; i++) WORST(status, rw_seed(CORE, known[i], seed[i]));
    WORST(status, rw_tangent_of(CORE));
    for (size_t i = 0; i < nu; i++) WORST(status, rw_sensitivity(CORE, unknown[i], &sensitivity[i]));
    return (fmi2Status)status;
}

/* Model Exchange */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    NEEDS(MODE == RW_CONTINUOUS || MODE == RW_EVENT, "fmi2EnterEventMode");
    MODE = RW_EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    rw_status status;
    double next;
    NEEDS(MODE == RW_EVENT && info, "fmi2NewDiscreteStates");
    status = rw_event_update(CORE);
    if (status > RW_WARNING) return fmi2Error;
    next = rw_next_time_event(CORE);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = fmi2False;
    info->nextEventTimeDefined = isfinite(next) ? fmi2True : fmi2False;
    info->nextEventTime = isfinite(next) ? next : 0.0;
    return (fmi2Status)status;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    NEEDS(MODE == RW_EVENT, "fmi2EnterContinuousTimeMode");
    MODE = RW_CONTINUOUS;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean final, fmi2Boolean *enterEvent, fmi2Boolean *terminate)
{
    rw_status status;
    (void)final;
    NEEDS(MODE == RW_CONTINUOUS && enterEvent && terminate, "fmi2CompletedIntegratorStep");
    *enterEvent = *terminate = fmi2False;
    status = rw_solve(CORE);
    return (fmi2Status)(status == RW_OK ? rw_lengths(CORE) : status);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time)
{
    NEEDS(!CORE->co_simulation, "fmi2SetTime");
    return (fmi2Status)rw_set_time(CORE, time);
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    rw_status status = RW_OK;
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi2SetContinuousStates");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, (unsigned)(1 + i), x[i]));
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi2GetContinuousStates");
    memcpy(x, CORE->s.now.x, n * sizeof *x);
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real nominal[], size_t n)
{
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi2GetNominalsOfContinuousStates");
    memcpy(nominal, rw_x_nominal, n * sizeof *nominal);
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rate[], size_t n)
{
    rw_status status = RW_OK;
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi2GetDerivatives");
    WORST(status, rw_up_to_date(CORE));
    memcpy(rate, CORE->s.rate, n * sizeof *rate);
    return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real indicator[], size_t n)
{
    NEEDS(n == RW_NK + RW_NL && !CORE->co_simulation, "fmi2GetEventIndicators");
    return (fmi2Status)rw_event_indicators(CORE, indicator);
}

/* Co-Simulation */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    NEEDS(0, "fmi2SetRealInputDerivatives");
    return fmi2Error;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    NEEDS(0, "fmi2GetRealOutputDerivatives");
    return fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean noSetPrior)
{
    (void)noSetPrior;
    NEEDS(MODE == RW_STEP, "fmi2DoStep");
    if (!(size > 0.0) || !isfinite(size) || !isfinite(time) || fabs(time - CORE->s.now.t) > 1e-6 * (1.0 + fabs(time))) {
        rw_message(CORE, RW_ERROR, "logStatusError", "A step of %g s from %.9g s is asked for at %.9g s", size, time, CORE->s.now.t);
        return fmi2Error;
    }
    return (fmi2Status)rw_do_step(CORE, time + size);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    NEEDS(0, "fmi2CancelStep");
    return fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    NEEDS(1, "fmi2GetStatus");
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    NEEDS(1, "fmi2GetRealStatus");
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = CORE->s.now.t;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    NEEDS(1, "fmi2GetIntegerStatus");
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    NEEDS(1, "fmi2GetBooleanStatus");
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    NEEDS(1, "fmi2GetStringStatus");
    return fmi2Discard;
}
