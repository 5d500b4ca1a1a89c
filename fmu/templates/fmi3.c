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
} instance_data;

#define CORE (&((instance_data *)instance)->core)
#define MODE (CORE->s.mode)
#define NEEDS(condition, call)                                                                   \
    do {                                                                                         \
        if (!instance) return fmi3Error;                                                         \
        if (!(condition)) {                                                                      \
            rw_message(CORE, RW_ERROR, "logStatusError", call " is not allowed in this state");  \
            return fmi3Error;                                                                    \
        }                                                                                        \
    } while (0)
#define WORST(status, other)                                    \
    do {                                                        \
        rw_status now_ = (other);                               \
        if (now_ > (status)) (status) = now_;                   \
        if ((status) > RW_WARNING) return (fmi3Status)(status); \
    } while (0)

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
    if (!i) return NULL;
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

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean on, size_t n, const fmi3String categories[])
{
    NEEDS(1, "fmi3SetDebugLogging");
    CORE->log_events = CORE->log_all = 0;
    if (on && n == 0) CORE->log_all = 1;
    for (size_t i = 0; on && i < n; i++) {
        if (strcmp(categories[i], "logEvents") == 0) CORE->log_events = 1;
        if (strcmp(categories[i], "logAll") == 0) CORE->log_all = 1;
    }
    return fmi3OK;
}

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
    (void)resources, (void)visible, (void)earlyReturnAllowed, (void)required, (void)nRequired, (void)update;
    if (eventModeUsed) {
        if (log) log(environment, fmi3Error, "logStatusError", "This FMU has no event mode in Co-Simulation");
        return NULL;
    }
    return instantiate(name, token, logging, environment, log, 1);
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

void fmi3FreeInstance(fmi3Instance instance) { free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined, fmi3Float64 tolerance,
                                       fmi3Float64 start, fmi3Boolean stopDefined, fmi3Float64 stop)
{
    (void)toleranceDefined, (void)tolerance, (void)stopDefined, (void)stop;
    NEEDS(MODE == RW_INSTANTIATED, "fmi3EnterInitializationMode");
    CORE->start_time = start;
    if (rw_set_time(CORE, start) != RW_OK) return fmi3Error;
    MODE = RW_INITIALIZATION;
    return fmi3OK;
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    rw_status status;
    NEEDS(MODE == RW_INITIALIZATION, "fmi3ExitInitializationMode");
    status = rw_initialize(CORE);
    if (status > RW_WARNING) return fmi3Error;
    MODE = CORE->co_simulation ? RW_STEP : RW_EVENT;
    return (fmi3Status)status;
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    NEEDS(1, "fmi3Terminate");
    MODE = RW_TERMINATED;
    return fmi3OK;
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    NEEDS(1, "fmi3Reset");
    CORE->start_time = 0.0;
    rw_reset(CORE);
    return fmi3OK;
}

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Float64 value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "fmi3GetFloat64");
    for (size_t i = 0; i < n; i++) WORST(status, rw_get_real(CORE, vr[i], &value[i]));
    return (fmi3Status)status;
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, const fmi3Float64 value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "fmi3SetFloat64");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, vr[i], value[i]));
    return (fmi3Status)status;
}

fmi3Status fmi3GetInt32(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Int32 value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "fmi3GetInt32");
    for (size_t i = 0; i < n; i++) {
        int v = 0;
        WORST(status, rw_get_integer(CORE, vr[i], &v));
        value[i] = v;
    }
    return (fmi3Status)status;
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, fmi3Boolean value[], size_t nValues)
{
    rw_status status = RW_OK;
    NEEDS(n == nValues, "fmi3GetBoolean");
    for (size_t i = 0; i < n; i++) {
        int v = 0;
        WORST(status, rw_get_boolean(CORE, vr[i], &v));
        value[i] = v != 0;
    }
    return (fmi3Status)status;
}

/* Types without a variable. */
#define NOT_THERE(call, ...)                                                             \
    fmi3Status call(fmi3Instance instance, const fmi3ValueReference vr[], size_t n, __VA_ARGS__) \
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
NOT_THERE(fmi3SetBoolean, const fmi3Boolean value[], size_t nValues)
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

/* What this FMU does not offer. */
#define NOT_OFFERED(call, ...)                     \
    fmi3Status call(fmi3Instance instance, __VA_ARGS__) \
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

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    NEEDS(0, "fmi3EnterConfigurationMode");
    return fmi3Error;
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    NEEDS(0, "fmi3ExitConfigurationMode");
    return fmi3Error;
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    NEEDS(MODE == RW_EVENT || MODE == RW_INITIALIZATION, "fmi3EvaluateDiscreteStates");
    return fmi3OK;
}

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    NEEDS(state, "fmi3GetFMUState");
    if (!*state) *state = malloc(sizeof(rw_state));
    if (!*state) return fmi3Error;
    memcpy(*state, &CORE->s, sizeof(rw_state));
    return fmi3OK;
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState state)
{
    NEEDS(state, "fmi3SetFMUState");
    memcpy(&CORE->s, state, sizeof(rw_state));
    return fmi3OK;
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *state)
{
    NEEDS(1, "fmi3FreeFMUState");
    if (state) {
        free(*state);
        *state = NULL;
    }
    return fmi3OK;
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState state, size_t *size)
{
    (void)state;
    NEEDS(size, "fmi3SerializedFMUStateSize");
    *size = rw_serialized_size();
    return fmi3OK;
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState state, fmi3Byte bytes[], size_t size)
{
    NEEDS(state && bytes, "fmi3SerializeFMUState");
    return (fmi3Status)rw_serialize(CORE, state, (unsigned char *)bytes, size);
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte bytes[], size_t size, fmi3FMUState *state)
{
    NEEDS(state && bytes, "fmi3DeserializeFMUState");
    return (fmi3Status)rw_deserialize(CORE, (const unsigned char *)bytes, size, (rw_state **)state);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknown[], size_t nu,
                                        const fmi3ValueReference known[], size_t nk, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity)
{
    rw_status status = RW_OK;
    NEEDS(MODE != RW_INSTANTIATED && nk == nSeed && nu == nSensitivity, "fmi3GetDirectionalDerivative");
    WORST(status, rw_up_to_date(CORE));
    rw_clear_seeds(CORE);
    for (size_t i = 0; i < nk; i++) WORST(status, rw_seed(CORE, known[i], seed[i]));
    WORST(status, rw_tangent_of(CORE));
    for (size_t i = 0; i < nu; i++) WORST(status, rw_sensitivity(CORE, unknown[i], &sensitivity[i]));
    return (fmi3Status)status;
}

/* Model Exchange */

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    NEEDS((MODE == RW_CONTINUOUS || MODE == RW_EVENT) && !CORE->co_simulation, "fmi3EnterEventMode");
    MODE = RW_EVENT;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *needUpdate, fmi3Boolean *terminate, fmi3Boolean *nominals,
                                    fmi3Boolean *values, fmi3Boolean *timeDefined, fmi3Float64 *time)
{
    rw_status status;
    double next;
    NEEDS(MODE == RW_EVENT, "fmi3UpdateDiscreteStates");
    status = rw_event_update(CORE);
    if (status > RW_WARNING) return fmi3Error;
    next = rw_next_time_event(CORE);
    *needUpdate = *terminate = *nominals = *values = fmi3False;
    *timeDefined = isfinite(next);
    *time = isfinite(next) ? next : 0.0;
    return (fmi3Status)status;
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    NEEDS(MODE == RW_EVENT, "fmi3EnterContinuousTimeMode");
    MODE = RW_CONTINUOUS;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance, fmi3Boolean final, fmi3Boolean *enterEvent, fmi3Boolean *terminate)
{
    rw_status status;
    (void)final;
    NEEDS(MODE == RW_CONTINUOUS, "fmi3CompletedIntegratorStep");
    *enterEvent = *terminate = fmi3False;
    status = rw_solve(CORE);
    return (fmi3Status)(status == RW_OK ? rw_lengths(CORE) : status);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    NEEDS(!CORE->co_simulation, "fmi3SetTime");
    return (fmi3Status)rw_set_time(CORE, time);
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 x[], size_t n)
{
    rw_status status = RW_OK;
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi3SetContinuousStates");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, (unsigned)(1 + i), x[i]));
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 x[], size_t n)
{
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi3GetContinuousStates");
    memcpy(x, CORE->s.now.x, n * sizeof *x);
    return fmi3OK;
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 rate[], size_t n)
{
    rw_status status = RW_OK;
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi3GetContinuousStateDerivatives");
    WORST(status, rw_up_to_date(CORE));
    memcpy(rate, CORE->s.rate, n * sizeof *rate);
    return fmi3OK;
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominal[], size_t n)
{
    NEEDS(n == RW_NX && !CORE->co_simulation, "fmi3GetNominalsOfContinuousStates");
    memcpy(nominal, rw_x_nominal, n * sizeof *nominal);
    return fmi3OK;
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 indicator[], size_t n)
{
    NEEDS(n == RW_NK + RW_NL && !CORE->co_simulation, "fmi3GetEventIndicators");
    return (fmi3Status)rw_event_indicators(CORE, indicator);
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *n)
{
    NEEDS(n, "fmi3GetNumberOfEventIndicators");
    *n = RW_NK + RW_NL;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *n)
{
    NEEDS(n, "fmi3GetNumberOfContinuousStates");
    *n = RW_NX;
    return fmi3OK;
}

/* Co-Simulation */

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    NEEDS(0, "fmi3EnterStepMode");
    return fmi3Error;
}

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 time, fmi3Float64 size, fmi3Boolean noSetPrior, fmi3Boolean *eventNeeded,
                      fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
{
    rw_status status;
    (void)noSetPrior;
    NEEDS(MODE == RW_STEP, "fmi3DoStep");
    *eventNeeded = *terminate = *early = fmi3False;
    *last = CORE->s.now.t;
    if (!(size > 0.0) || !isfinite(size) || !isfinite(time) || fabs(time - CORE->s.now.t) > 1e-6 * (1.0 + fabs(time))) {
        rw_message(CORE, RW_ERROR, "logStatusError", "A step of %g s from %.9g s is asked for at %.9g s", size, time, CORE->s.now.t);
        return fmi3Error;
    }
    status = rw_do_step(CORE, time + size);
    *last = CORE->s.now.t;
    return (fmi3Status)status;
}
