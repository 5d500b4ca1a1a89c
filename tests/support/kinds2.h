/* FMI 2.0 functions of kinds.c. */
const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    return create(type == fmi2ModelExchange, (const void *)callbacks->logger, callbacks->componentEnvironment);
}

void fmi2FreeInstance(void *c) { free(c); }
status fmi2SetupExperiment(void *c, fmi2Boolean has, double tolerance, double start, fmi2Boolean ends, double stop) { return enter(c, start, ends, stop); }
MODE(fmi2EnterInitializationMode, INSTANTIATED, INITIALISING)
status fmi2ExitInitializationMode(void *c) { return change_mode(c, INITIALISING, ((instance *)c)->exchange ? EVENT : STEPPING); }
MODE(fmi2EnterEventMode, CONTINUOUS, EVENT)
MODE(fmi2EnterContinuousTimeMode, EVENT, CONTINUOUS)
status fmi2Terminate(void *c) { return terminate(c); }

status fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[]) { EACH(c) if (get_real(i, vr[k], value + k)) return ERROR; return OK; }
status fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[]) { EACH(c) if (set_real(i, vr[k], value[k])) return ERROR; return OK; }
status fmi2GetInteger(void *c, const unsigned vr[], size_t n, int value[])
{
    int64_t whole;
    EACH(c) {
        get_whole(i, vr[k], &whole);
        value[k] = (int)whole;
    }
    return OK;
}
status fmi2SetInteger(void *c, const unsigned vr[], size_t n, const int value[]) { EACH(c) if (set_whole(i, vr[k], value[k])) return ERROR; return OK; }
status fmi2GetBoolean(void *c, const unsigned vr[], size_t n, int value[]) { return fmi2GetInteger(c, vr, n, value); }
status fmi2SetBoolean(void *c, const unsigned vr[], size_t n, const int value[]) { return fmi2SetInteger(c, vr, n, value); }
status fmi2GetString(void *c, const unsigned vr[], size_t n, fmi2String value[]) { EACH(c) value[k] = i->s.text; return OK; }
status fmi2SetString(void *c, const unsigned vr[], size_t n, const fmi2String value[])
{
    EACH(c) {
        NEED(DISCRETE);
        strncpy(i->s.text, value[k], sizeof i->s.text - 1);
    }
    return OK;
}

status fmi2GetFMUstate(void *c, void **kept) { return keep(c, kept); }
status fmi2SetFMUstate(void *c, void *kept) { return bring_back(c, kept); }
status fmi2FreeFMUstate(void *c, void **kept) { return release(kept); }

status fmi2DoStep(void *c, double time, double size, fmi2Boolean noSetPrior)
{
    double reached;
    status done = move(c, time, size, &reached);
    return done == OK && ((instance *)c)->s.ended ? DISCARD : done;
}
status fmi2GetBooleanStatus(void *c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    if (kind != fmi2Terminated) return ERROR;
    *value = ((instance *)c)->s.ended;
    return OK;
}
status fmi2GetRealStatus(void *c, const fmi2StatusKind kind, double *value)
{
    if (kind != fmi2LastSuccessfulTime) return ERROR;
    *value = ((instance *)c)->s.r[TIME];
    return OK;
}

status fmi2NewDiscreteStates(void *c, fmi2EventInfo *info)
{
    return update(c, &info->newDiscreteStatesNeeded, &info->terminateSimulation, &info->nominalsOfContinuousStatesChanged, &info->valuesOfContinuousStatesChanged, &info->nextEventTimeDefined, &info->nextEventTime);
}
status fmi2CompletedIntegratorStep(void *c, fmi2Boolean final, fmi2Boolean *event, fmi2Boolean *end)
{
    *event = *end = fmi2False;
    return OK;
}
status fmi2SetTime(void *c, double time) { return set_time(c, time); }
status fmi2SetContinuousStates(void *c, const double x[], size_t n) { return set_states(c, x, n); }
status fmi2GetContinuousStates(void *c, double x[], size_t n) { return get_real(c, X, x); }
status fmi2GetNominalsOfContinuousStates(void *c, double x[], size_t n) { *x = 1.0; return OK; }
status fmi2GetDerivatives(void *c, double rate[], size_t n) { return rates(c, rate, n); }
status fmi2GetEventIndicators(void *c, double z[], size_t n) { *z = ((instance *)c)->s.r[X] - ((instance *)c)->s.r[LEVEL]; return OK; }

MISSING(fmi2SetDebugLogging) MISSING(fmi2Reset) MISSING(fmi2CancelStep) MISSING(fmi2SerializedFMUstateSize) MISSING(fmi2SerializeFMUstate)
MISSING(fmi2DeSerializeFMUstate) MISSING(fmi2GetRealOutputDerivatives) MISSING(fmi2SetRealInputDerivatives) MISSING(fmi2GetStatus)
MISSING(fmi2GetIntegerStatus) MISSING(fmi2GetStringStatus) MISSING(fmi2GetDirectionalDerivative)
