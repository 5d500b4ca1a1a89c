/* FMI 2.0, Model Exchange and Co-Simulation. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi2Functions.h"
#include "ropeway.h"

typedef struct {
    rw_instance core; /* first: an fmi2Component is also an rw_instance */
    const fmi2CallbackFunctions *callbacks;
    char *name;
} instance;

#define FMI(name) fmi2##name
#define FMI_GET_STATE fmi2GetFMUstate
#define FMI_SET_STATE fmi2SetFMUstate
#define FMI_FREE_STATE fmi2FreeFMUstate
#define FMI_SERIALIZED_SIZE fmi2SerializedFMUstateSize
#define FMI_SERIALIZE fmi2SerializeFMUstate
#define FMI_DESERIALIZE fmi2DeSerializeFMUstate
#define FMI_GET_RATES fmi2GetDerivatives
#include "fmi_shared.h"

static void forward_message(void *context, rw_status status, const char *category, const char *message)
{
    /* Some importers show the format string: the message is passed as the format, without conversions. */
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
    if (!i->name || rw_take_memory(&i->core)) {
        free(i->name);
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
    rw_leave_memory(CORE);
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance, fmi2Real start,
                               fmi2Boolean stopDefined, fmi2Real stop)
{
    NEEDS(MODE == RW_INSTANTIATED, "SetupExperiment");
    rw_experiment(CORE, toleranceDefined, tolerance, stopDefined, stop);
    CORE->start_time = start;
    return (fmi2Status)rw_set_time(CORE, start);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    NEEDS(MODE == RW_INSTANTIATED, "EnterInitializationMode");
    MODE = RW_INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "GetReal");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_real(CORE, vr[i], &value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Real value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "SetReal");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, vr[i], value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "GetInteger");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_integer(CORE, vr[i], &value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Boolean value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "GetBoolean");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_boolean(CORE, vr[i], &value[i]));
    return (fmi2Status)status;
}

fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Boolean value[])
{
    rw_status status = RW_OK;
    NEEDS(1, "SetBoolean");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_boolean(CORE, vr[i], value[i]));
    return (fmi2Status)status;
}

#define NOT_THERE(type, call, parameters)                                                        \
    fmi2Status call parameters                                                                   \
    {                                                                                            \
        (void)vr, (void)value;                                                                   \
        NEEDS(1, #call);                                                                         \
        if (n == 0) return fmi2OK;                                                               \
        rw_message(CORE, RW_ERROR, "logStatusError", #call ": unknown variable");                \
        return fmi2Error;                                                                        \
    }
NOT_THERE(String, fmi2GetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2String value[]))
NOT_THERE(String, fmi2SetString, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2String value[]))
NOT_THERE(Integer, fmi2SetInteger, (fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer value[]))

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[], size_t nu,
                                        const fmi2ValueReference known[], size_t nk, const fmi2Real seed[],
                                        fmi2Real sensitivity[])
{
    NEEDS(MODE != RW_INSTANTIATED, "GetDirectionalDerivative");
    return directional(c, unknown, nu, known, nk, seed, sensitivity);
}

/* Model Exchange */

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    fmi2Status status;
    NEEDS(MODE == RW_EVENT && info, "NewDiscreteStates");
    status = update(c, &info->nextEventTime);
    info->newDiscreteStatesNeeded = fmi2False;
    info->terminateSimulation = fmi2False;
    info->nominalsOfContinuousStatesChanged = fmi2False;
    info->valuesOfContinuousStatesChanged = fmi2True; /* rates jump, and some importers restart their solver only then */
    info->nextEventTimeDefined = status <= fmi2Warning && isfinite(info->nextEventTime) ? fmi2True : fmi2False;
    return status;
}

/* Co-Simulation */

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    rw_status status = RW_OK;
    NEEDS(MODE == RW_STEP, "SetRealInputDerivatives");
    for (size_t i = 0; i < n; i++) {
        NEEDS(order[i] == 1, "SetRealInputDerivatives of another order than 1");
        WORST(status, rw_set_input_rate(CORE, vr[i], value[i]));
    }
    return (fmi2Status)status;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n, const fmi2Integer order[],
                                        fmi2Real value[])
{
    (void)vr, (void)n, (void)order, (void)value;
    NEEDS(0, "GetRealOutputDerivatives");
    return fmi2Error;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real time, fmi2Real size, fmi2Boolean noSetPrior)
{
    (void)noSetPrior;
    NEEDS(MODE == RW_STEP, "DoStep");
    return do_step(c, time, size);
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    NEEDS(0, "CancelStep");
    return fmi2Error;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    (void)kind, (void)value;
    NEEDS(1, "GetStatus");
    return fmi2Discard;
}

fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    NEEDS(1, "GetRealStatus");
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = CORE->s.now.t;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value)
{
    (void)kind, (void)value;
    NEEDS(1, "GetIntegerStatus");
    return fmi2Discard;
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    NEEDS(1, "GetBooleanStatus");
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value)
{
    (void)kind, (void)value;
    NEEDS(1, "GetStringStatus");
    return fmi2Discard;
}
