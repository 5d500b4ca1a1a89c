/* FMI 3.0 functions of kinds.c. */
const char *fmi3GetVersion(void) { return "3.0"; }

void *fmi3InstantiateModelExchange(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, void *environment, fmi3LogMessageCallback log)
{
    return create(1, (const void *)log, environment);
}
void *fmi3InstantiateCoSimulation(fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging, fmi3Boolean events, fmi3Boolean early, const unsigned required[], size_t n, void *environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback update)
{
    return create(0, (const void *)log, environment);
}
void *fmi3InstantiateScheduledExecution(void) { return NULL; }
void fmi3FreeInstance(void *c) { free(c); }

status fmi3EnterInitializationMode(void *c, fmi3Boolean has, double tolerance, double start, fmi3Boolean ends, double stop)
{
    enter(c, start, ends, stop);
    return change_mode(c, INSTANTIATED, INITIALISING);
}
status fmi3ExitInitializationMode(void *c) { return change_mode(c, INITIALISING, ((instance *)c)->exchange ? EVENT : STEPPING); }
MODE(fmi3EnterEventMode, CONTINUOUS, EVENT)
MODE(fmi3EnterContinuousTimeMode, EVENT, CONTINUOUS)
MODE(fmi3EnterConfigurationMode, INSTANTIATED, CONFIGURING)
MODE(fmi3ExitConfigurationMode, CONFIGURING, INSTANTIATED)
status fmi3Terminate(void *c) { return terminate(c); }

static int is_array(unsigned vr) { return vr >= V && vr <= FLAGS_OUT && vr != TRACE; }

status fmi3GetFloat64(void *c, const unsigned vr[], size_t n, double value[], size_t total)
{
    double *end = value + total;
    EACH(c) {
        size_t count = vr[k] == V || vr[k] == W ? (size_t)i->s.z[SIZE] : vr[k] == M ? 4 : 1;
        if (value + count > end) return say(i, ERROR, "too few values");
        if (vr[k] == TRACE)
            *value = i->s.m[0] + i->s.m[3];
        else if (vr[k] == M)
            memcpy(value, i->s.m, sizeof i->s.m);
        else if (is_array(vr[k]))
            for (size_t j = 0; j < count; j++) value[j] = (vr[k] == W ? 2.0 : 1.0) * i->s.v[j];
        else if (get_real(i, vr[k], value))
            return ERROR;
        value += count;
    }
    return value == end ? OK : say(c, ERROR, "too many values");
}
status fmi3SetFloat64(void *c, const unsigned vr[], size_t n, const double value[], size_t total)
{
    const double *end = value + total;
    EACH(c) {
        size_t count = vr[k] == V ? (size_t)i->s.z[SIZE] : vr[k] == M ? 4 : 1;
        if (value + count > end) return say(i, ERROR, "too few values");
        if (is_array(vr[k]))
            memcpy(vr[k] == V ? i->s.v : i->s.m, value, count * sizeof *value);
        else if (set_real(i, vr[k], *value))
            return ERROR;
        value += count;
    }
    return value == end ? OK : say(c, ERROR, "too many values");
}

/* Numbers of other types: an input at an even reference, its output at the next one. */
#define WHOLE(type, number) \
    status fmi3Get##type(void *c, const unsigned vr[], size_t n, number value[], size_t total) \
    { \
        int64_t whole; \
        EACH(c) { \
            get_whole(i, vr[k], &whole); \
            value[k] = (number)whole; \
        } \
        return OK; \
    } \
    status fmi3Set##type(void *c, const unsigned vr[], size_t n, const number value[], size_t total) \
    { \
        EACH(c) if (set_whole(i, vr[k], (int64_t)value[k])) return ERROR; \
        return OK; \
    }
WHOLE(Float32, float) WHOLE(Int8, int8_t) WHOLE(UInt8, uint8_t) WHOLE(Int16, int16_t) WHOLE(UInt16, uint16_t) WHOLE(Int32, int32_t)
WHOLE(UInt32, uint32_t) WHOLE(Int64, int64_t) WHOLE(UInt64, uint64_t)

status fmi3GetBoolean(void *c, const unsigned vr[], size_t n, fmi3Boolean value[], size_t total)
{
    int64_t whole;
    EACH(c) {
        if (is_array(vr[k])) {
            *value++ = i->s.flags[0];
            *value++ = i->s.flags[1];
        } else {
            get_whole(i, vr[k], &whole);
            *value++ = whole != 0;
        }
    }
    return OK;
}
status fmi3SetBoolean(void *c, const unsigned vr[], size_t n, const fmi3Boolean value[], size_t total)
{
    EACH(c) {
        if (is_array(vr[k])) {
            NEED(DISCRETE);
            i->s.flags[0] = *value++;
            i->s.flags[1] = *value++;
        } else if (set_whole(i, vr[k], *value++))
            return ERROR;
    }
    return OK;
}
status fmi3GetString(void *c, const unsigned vr[], size_t n, fmi3String value[], size_t total) { EACH(c) value[k] = i->s.text; return OK; }
status fmi3SetString(void *c, const unsigned vr[], size_t n, const fmi3String value[], size_t total)
{
    EACH(c) {
        NEED(DISCRETE);
        strncpy(i->s.text, value[k], sizeof i->s.text - 1);
    }
    return OK;
}
status fmi3GetBinary(void *c, const unsigned vr[], size_t n, size_t size[], fmi3Binary value[], size_t total)
{
    EACH(c) {
        size[k] = i->s.bytes;
        value[k] = (fmi3Binary)i->s.binary;
    }
    return OK;
}
status fmi3SetBinary(void *c, const unsigned vr[], size_t n, const size_t size[], const fmi3Binary value[], size_t total)
{
    EACH(c) {
        NEED(DISCRETE);
        memcpy(i->s.binary, value[k], i->s.bytes = size[k]);
    }
    return OK;
}

status fmi3GetFMUState(void *c, void **kept) { return keep(c, kept); }
status fmi3SetFMUState(void *c, void *kept) { return bring_back(c, kept); }
status fmi3FreeFMUState(void *c, void **kept) { return release(kept); }

status fmi3DoStep(void *c, double time, double size, fmi3Boolean noSetPrior, fmi3Boolean *event, fmi3Boolean *end, fmi3Boolean *early, double *reached)
{
    status done = move(c, time, size, reached);
    *event = *early = 0;
    *end = ((instance *)c)->s.ended;
    return done;
}
status fmi3UpdateDiscreteStates(void *c, fmi3Boolean *needed, fmi3Boolean *end, fmi3Boolean *nominals, fmi3Boolean *states, fmi3Boolean *defined, double *next)
{
    return update(c, needed, end, nominals, states, defined, next);
}
status fmi3CompletedIntegratorStep(void *c, fmi3Boolean final, fmi3Boolean *event, fmi3Boolean *end)
{
    *event = *end = 0;
    return OK;
}
status fmi3SetTime(void *c, double time) { return set_time(c, time); }
status fmi3SetContinuousStates(void *c, const double x[], size_t n) { return set_states(c, x, n); }
status fmi3GetContinuousStates(void *c, double x[], size_t n) { return get_real(c, X, x); }
status fmi3GetNominalsOfContinuousStates(void *c, double x[], size_t n) { *x = 1.0; return OK; }
status fmi3GetContinuousStateDerivatives(void *c, double rate[], size_t n) { return rates(c, rate, n); }
status fmi3GetEventIndicators(void *c, double z[], size_t n) { *z = ((instance *)c)->s.r[X] - ((instance *)c)->s.r[LEVEL]; return OK; }
status fmi3GetNumberOfContinuousStates(void *c, size_t *n) { *n = 1; return OK; }
status fmi3GetNumberOfEventIndicators(void *c, size_t *n) { *n = 1; return OK; }

MISSING(fmi3SetDebugLogging) MISSING(fmi3Reset) MISSING(fmi3GetClock) MISSING(fmi3SetClock) MISSING(fmi3GetNumberOfVariableDependencies)
MISSING(fmi3GetVariableDependencies) MISSING(fmi3SerializedFMUStateSize) MISSING(fmi3SerializeFMUState) MISSING(fmi3DeserializeFMUState)
MISSING(fmi3GetDirectionalDerivative) MISSING(fmi3GetAdjointDerivative) MISSING(fmi3GetIntervalDecimal) MISSING(fmi3GetIntervalFraction)
MISSING(fmi3GetShiftDecimal) MISSING(fmi3GetShiftFraction) MISSING(fmi3SetIntervalDecimal) MISSING(fmi3SetIntervalFraction)
MISSING(fmi3SetShiftDecimal) MISSING(fmi3SetShiftFraction) MISSING(fmi3EvaluateDiscreteStates) MISSING(fmi3EnterStepMode)
MISSING(fmi3GetOutputDerivatives) MISSING(fmi3ActivateModelPartition)
