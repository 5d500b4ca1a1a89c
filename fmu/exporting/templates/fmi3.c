/* FMI 3.0, Model Exchange and Co-Simulation. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "fmi3Functions.h"
#include "ropeway.h"

typedef struct {
    rw_instance core;
    fmi3InstanceEnvironment environment;
    fmi3LogMessageCallback log;
    fmi3IntermediateUpdateCallback update;
} instance_data;

#define FMI(name) fmi3##name
#define FMI_GET_STATE fmi3GetFMUState
#define FMI_SET_STATE fmi3SetFMUState
#define FMI_FREE_STATE fmi3FreeFMUState
#define FMI_SERIALIZED_SIZE fmi3SerializedFMUStateSize
#define FMI_SERIALIZE fmi3SerializeFMUState
#define FMI_DESERIALIZE fmi3DeserializeFMUState
#define FMI_GET_RATES fmi3GetContinuousStateDerivatives
#include "fmi_shared.h"

static void forward_message(void *context, rw_status status, const char *category, const char *message)
{
    instance_data *i = context;
    if (i->log) i->log(i->environment, (fmi3Status)status, category, message);
}

static fmi3Instance instantiate(fmi3String name, fmi3String token, fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                fmi3LogMessageCallback log, int co_simulation)
{
    instance_data *i;
    if (!name || !token || strcmp(token, rw_fingerprint) != 0) {
        if (log) log(environment, fmi3Error, "logStatusError", "The instantiation token is not that of this FMU");
        return NULL;
    }
    i = calloc(1, sizeof *i);
    if (!i || rw_take_memory(&i->core)) {
        free(i);
        return NULL;
    }
    i->environment = environment;
    i->log = log;
    i->core.log = forward_message;
    i->core.context = i;
    i->core.log_all = logging;
    i->core.co_simulation = co_simulation;
    rw_reset(&i->core);
    return i;
}

const char *fmi3GetVersion(void) { return fmi3Version; }

fmi3Instance fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                          fmi3Boolean logging, fmi3InstanceEnvironment environment, fmi3LogMessageCallback log)
{
    (void)resources, (void)visible;
    return instantiate(name, token, logging, environment, log, 0);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                         fmi3Boolean logging, fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference required[], size_t nRequired,
                                         fmi3InstanceEnvironment environment, fmi3LogMessageCallback log,
                                         fmi3IntermediateUpdateCallback update)
{
    instance_data *i = instantiate(name, token, logging, environment, log, 1);
    (void)resources, (void)visible, (void)required;
    if (!i) return NULL;
    if (nRequired) i->update = update;
    i->core.has_event_mode = eventModeUsed;
    i->core.stops_at_events = eventModeUsed && earlyReturnAllowed;
    return i;
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible,
                                               fmi3Boolean logging, fmi3InstanceEnvironment environment,
                                               fmi3LogMessageCallback log, fmi3ClockUpdateCallback clock,
                                               fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)clock, (void)lock, (void)unlock;
    if (log) log(environment, fmi3Error, "logStatusError", "This FMU has no Scheduled Execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance c)
{
    if (!c) return;
    rw_leave_memory(CORE);
    free(c);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stopDefined, fmi3Float64 stop)
{
    NEEDS(MODE == RW_INSTANTIATED, "EnterInitializationMode");
    rw_experiment(CORE, toleranceDefined, tolerance, stopDefined, stop);
    CORE->start_time = start;
    if (rw_set_time(CORE, start) != RW_OK) return fmi3Error;
    MODE = RW_INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "GetFloat64");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_real(CORE, vr[i], &value[i]));
    return (fmi3Status)status;
}

fmi3Status fmi3SetFloat64(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "SetFloat64");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, vr[i], value[i]));
    return (fmi3Status)status;
}

fmi3Status fmi3GetInt32(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Int32 value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "GetInt32");
    for (size_t i = 0; i < n; i++) {
        int v = 0;
        WORST(status, rw_get_integer(CORE, vr[i], &v));
        value[i] = v;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3GetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, fmi3Boolean value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "GetBoolean");
    for (size_t i = 0; i < n; i++) {
        int v = 0;
        WORST(status, rw_get_boolean(CORE, vr[i], &v));
        value[i] = v != 0;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3SetBoolean(fmi3Instance c, const fmi3ValueReference vr[], size_t n, const fmi3Boolean value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "SetBoolean");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_boolean(CORE, vr[i], value[i]));
    return (fmi3Status)status;
}

/* Types without variables. */
#define NOT_THERE(call, ...)                                                             \
    fmi3Status call(fmi3Instance c, const fmi3ValueReference vr[], size_t n, __VA_ARGS__) \
    {                                                                                    \
        (void)vr, (void)value;                                                           \
        NEEDS(n == 0, #call ": there is no such variable; it");                          \
        return fmi3OK;                                                                   \
    }
#define NO_TYPE(name)                                                                               \
    NOT_THERE(fmi3Get##name, fmi3##name value[], size_t nValues)                                    \
    NOT_THERE(fmi3Set##name, const fmi3##name value[], size_t nValues)
NO_TYPE(Float32)
NO_TYPE(Int8)
NO_TYPE(UInt8)
NO_TYPE(Int16)
NO_TYPE(UInt16)
NO_TYPE(UInt32)
NO_TYPE(Int64)
NO_TYPE(UInt64)
NO_TYPE(String)
NOT_THERE(fmi3SetInt32, const fmi3Int32 value[], size_t nValues)
NOT_THERE(fmi3GetBinary, size_t sizes[], fmi3Binary value[], size_t nValues)
NOT_THERE(fmi3SetBinary, const size_t sizes[], const fmi3Binary value[], size_t nValues)
NOT_THERE(fmi3GetClock, fmi3Clock value[])
NOT_THERE(fmi3SetClock, const fmi3Clock value[])
NOT_THERE(fmi3GetIntervalDecimal, fmi3Float64 value[], fmi3IntervalQualifier qualifiers[])
NOT_THERE(fmi3GetIntervalFraction, fmi3UInt64 value[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
NOT_THERE(fmi3GetShiftDecimal, fmi3Float64 value[])
NOT_THERE(fmi3GetShiftFraction, fmi3UInt64 value[], fmi3UInt64 resolutions[])
NOT_THERE(fmi3SetIntervalDecimal, const fmi3Float64 value[])
NOT_THERE(fmi3SetIntervalFraction, const fmi3UInt64 value[], const fmi3UInt64 resolutions[])
NOT_THERE(fmi3SetShiftDecimal, const fmi3Float64 value[])
NOT_THERE(fmi3SetShiftFraction, const fmi3UInt64 value[], const fmi3UInt64 resolutions[])

/* Functions that this FMU does not support. */
#define NOT_OFFERED(call, ...)                     \
    fmi3Status call(fmi3Instance c, __VA_ARGS__) \
    {                                              \
        NEEDS(0, #call);                           \
        return fmi3Error;                          \
    }
NOT_OFFERED(fmi3GetNumberOfVariableDependencies, fmi3ValueReference vr, size_t *n)
NOT_OFFERED(fmi3GetVariableDependencies, fmi3ValueReference vr, size_t of[], fmi3ValueReference independents[], size_t on[],
            fmi3DependencyKind kinds[], size_t n)
NOT_OFFERED(fmi3GetAdjointDerivative, const fmi3ValueReference unknowns[], size_t nUnknowns, const fmi3ValueReference knowns[],
            size_t nKnowns, const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
NOT_OFFERED(fmi3GetOutputDerivatives, const fmi3ValueReference vr[], size_t n, const fmi3Int32 orders[], fmi3Float64 values[],
            size_t nValues)
NOT_OFFERED(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)

fmi3Status fmi3EnterConfigurationMode(fmi3Instance c)
{
    NEEDS(0, "EnterConfigurationMode");
    return fmi3Error;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance c)
{
    NEEDS(0, "ExitConfigurationMode");
    return fmi3Error;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance c)
{
    NEEDS(MODE == RW_EVENT || MODE == RW_INITIALIZATION, "EvaluateDiscreteStates");
    return fmi3OK;
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance c, const fmi3ValueReference unknown[], size_t nu,
                                        const fmi3ValueReference known[], size_t nk, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity)
{
    NEEDS(MODE != RW_INSTANTIATED && nk == nSeed && nu == nSensitivity, "GetDirectionalDerivative");
    return directional(c, unknown, nu, known, nk, seed, sensitivity);
}

/* Model Exchange */

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *needUpdate, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *timeDefined, fmi3Float64 *time)
{
    fmi3Status status;
    NEEDS(MODE == RW_EVENT && needUpdate && terminate && nominals && values && timeDefined && time, "UpdateDiscreteStates");
    status = update(c, time);
    *needUpdate = *terminate = *nominals = fmi3False;
    *values = fmi3True; /* rates jump, and some importers restart their solver only then */
    *timeDefined = status <= fmi3Warning && isfinite(*time);
    return status;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance c, size_t *n)
{
    NEEDS(n, "GetNumberOfEventIndicators");
    *n = RW_NK + RW_NL + RW_NB;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance c, size_t *n)
{
    NEEDS(n, "GetNumberOfContinuousStates");
    *n = RW_NX;
    return fmi3OK;
}

/* Co-Simulation */

fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    NEEDS(MODE == RW_EVENT && CORE->co_simulation, "EnterStepMode");
    MODE = RW_STEP;
    return fmi3OK;
}

/* Asks for the inputs at the end of a step: within it they are linear. */
static void inputs_at_end(void *c, double end, double size)
{
    instance_data *i = c;
    double *begin = CORE->input_begin, *reached = CORE->input_end;
    fmi3Boolean early = fmi3False;
    fmi3Float64 until = end;
    memcpy(begin, CORE->s.u, RW_NU * sizeof(double));
    i->update(i->environment, end, fmi3True, fmi3False, fmi3False, fmi3False, &early, &until);
    memcpy(reached, CORE->s.u, RW_NU * sizeof(double));
    memcpy(CORE->s.u, begin, RW_NU * sizeof(double));
    rw_inputs_reach(CORE, reached, size);
    CORE->s.solved = CORE->s.rated = CORE->s.shown = 0;
}

fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 time, fmi3Float64 size, fmi3Boolean noSetPrior, fmi3Boolean *eventNeeded,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    fmi3Status status;
    (void)noSetPrior;
    NEEDS(MODE == RW_STEP, "DoStep");
    *eventNeeded = *terminate = *early = fmi3False;
    if (((instance_data *)c)->update && size > 0.0 && isfinite(size)) inputs_at_end(c, time + size, size);
    status = do_step(c, time, size);
    *last = CORE->s.now.t;
    *eventNeeded = status <= fmi3Warning && CORE->has_event_mode && CORE->event;
    *early = *eventNeeded && CORE->s.now.t < time + size;
    return status;
}
