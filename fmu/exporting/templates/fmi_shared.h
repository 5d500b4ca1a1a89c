/* Code that FMI 2.0 and 3.0 share. Included by fmi2.c and fmi3.c, which define FMI(name), a name of the standard with
 * its prefix, and one name each where the versions differ by more. An instance begins with its rw_instance. */

#define CORE ((rw_instance *)c)
#define MODE (CORE->s.mode)
#define NEEDS(condition, call)                                                                   \
    do {                                                                                         \
        if (!c) return FMI(Error);                                                               \
        if (!(condition)) {                                                                      \
            rw_message(CORE, RW_ERROR, "logStatusError", call " is not allowed in this state");  \
            return FMI(Error);                                                                   \
        }                                                                                        \
    } while (0)
#define WORST(status, other)                                       \
    do {                                                           \
        rw_status now_ = (other);                                  \
        if (now_ > (status)) (status) = now_;                      \
        if ((status) > RW_WARNING) return (FMI(Status))(status);   \
    } while (0)

FMI(Status) FMI(SetDebugLogging)(void *c, FMI(Boolean) on, size_t n, const FMI(String) categories[])
{
    NEEDS(1, "SetDebugLogging");
    CORE->log_events = CORE->log_all = 0;
    if (on && n == 0) CORE->log_all = 1;
    for (size_t i = 0; on && i < n; i++) {
        if (strcmp(categories[i], "logEvents") == 0) CORE->log_events = 1;
        if (strcmp(categories[i], "logAll") == 0) CORE->log_all = 1;
    }
    return FMI(OK);
}

FMI(Status) FMI(ExitInitializationMode)(void *c)
{
    rw_status status;
    NEEDS(MODE == RW_INITIALIZATION, "ExitInitializationMode");
    status = rw_initialize(CORE);
    if (status > RW_WARNING) return FMI(Error);
    MODE = CORE->co_simulation && !CORE->has_event_mode ? RW_STEP : RW_EVENT;
    return (FMI(Status))status;
}

FMI(Status) FMI(Terminate)(void *c)
{
    NEEDS(1, "Terminate");
    MODE = RW_TERMINATED;
    return FMI(OK);
}

FMI(Status) FMI(Reset)(void *c)
{
    NEEDS(1, "Reset");
    CORE->start_time = 0.0;
    rw_reset(CORE);
    return FMI(OK);
}

/* The state: plain memory */

FMI(Status) FMI_GET_STATE(void *c, void **state)
{
    NEEDS(state, "GetFMUstate");
    if (!*state) *state = malloc(rw_saved_size(CORE));
    if (!*state) return FMI(Error);
    rw_save(CORE, *state);
    return FMI(OK);
}

FMI(Status) FMI_SET_STATE(void *c, void *state)
{
    NEEDS(state, "SetFMUstate");
    rw_take_state(CORE, state);
    return FMI(OK);
}

FMI(Status) FMI_FREE_STATE(void *c, void **state)
{
    NEEDS(1, "FreeFMUstate");
    if (state) {
        free(*state);
        *state = NULL;
    }
    return FMI(OK);
}

FMI(Status) FMI_SERIALIZED_SIZE(void *c, void *state, size_t *size)
{
    (void)state;
    NEEDS(size, "SerializedFMUstateSize");
    *size = rw_serialized_size(CORE);
    return FMI(OK);
}

FMI(Status) FMI_SERIALIZE(void *c, void *state, FMI(Byte) bytes[], size_t size)
{
    NEEDS(state && bytes, "SerializeFMUstate");
    return (FMI(Status))rw_serialize(CORE, state, (unsigned char *)bytes, size);
}

FMI(Status) FMI_DESERIALIZE(void *c, const FMI(Byte) bytes[], size_t size, void **state)
{
    NEEDS(state && bytes, "DeSerializeFMUstate");
    return (FMI(Status))rw_deserialize(CORE, (const unsigned char *)bytes, size, (unsigned char **)state);
}

static FMI(Status) directional(void *c, const FMI(ValueReference) unknown[], size_t nu, const FMI(ValueReference) known[],
                               size_t nk, const double seed[], double sensitivity[])
{
    rw_status status = RW_OK;
    WORST(status, rw_up_to_date(CORE));
    rw_clear_seeds(CORE);
    for (size_t i = 0; i < nk; i++) WORST(status, rw_seed(CORE, known[i], seed[i]));
    WORST(status, rw_tangent_of(CORE));
    for (size_t i = 0; i < nu; i++) WORST(status, rw_sensitivity(CORE, unknown[i], &sensitivity[i]));
    return (FMI(Status))status;
}

/* Model Exchange */

FMI(Status) FMI(EnterEventMode)(void *c)
{
    NEEDS(CORE->co_simulation ? MODE == RW_STEP && CORE->has_event_mode : MODE == RW_CONTINUOUS || MODE == RW_EVENT, "EnterEventMode");
    rw_leave_trial(CORE);
    MODE = RW_EVENT;
    return FMI(OK);
}

/* Events at the present time; returns the next time event, INFINITY if there is none. */
static FMI(Status) update(void *c, double *next)
{
    rw_status status = rw_event_update(CORE);
    if (status > RW_WARNING) return FMI(Error);
    *next = rw_next_time_event(CORE);
    return (FMI(Status))status;
}

FMI(Status) FMI(EnterContinuousTimeMode)(void *c)
{
    rw_status status;
    NEEDS(MODE == RW_EVENT && !CORE->co_simulation, "EnterContinuousTimeMode");
    status = rw_solve(CORE);
    if (status == RW_OK) status = rw_accept_point(CORE);
    if (status != RW_OK) return (FMI(Status))status;
    MODE = RW_CONTINUOUS;
    return FMI(OK);
}

FMI(Status) FMI(CompletedIntegratorStep)(void *c, FMI(Boolean) final, FMI(Boolean) *enterEvent, FMI(Boolean) *terminate)
{
    rw_status status;
    (void)final;
    NEEDS(MODE == RW_CONTINUOUS && enterEvent && terminate, "CompletedIntegratorStep");
    *enterEvent = *terminate = 0;
    rw_leave_trial(CORE);
    status = rw_solve(CORE);
    if (status == RW_OK) rw_hold(CORE);
    if (status == RW_OK) status = rw_accept_point(CORE);
    return (FMI(Status))(status == RW_OK ? rw_lengths(CORE) : status);
}

FMI(Status) FMI(SetTime)(void *c, double time)
{
    NEEDS(!CORE->co_simulation, "SetTime");
    return (FMI(Status))rw_set_time(CORE, time);
}

FMI(Status) FMI(SetContinuousStates)(void *c, const double x[], size_t n)
{
    rw_status status = RW_OK;
    NEEDS(n == (size_t)RW_NX && !CORE->co_simulation, "SetContinuousStates");
    for (size_t i = 0; i < n; i++) WORST(status, rw_set_real(CORE, (unsigned)(1 + i), x[i]));
    return FMI(OK);
}

FMI(Status) FMI(GetContinuousStates)(void *c, double x[], size_t n)
{
    NEEDS(n == (size_t)RW_NX && !CORE->co_simulation, "GetContinuousStates");
    memcpy(x, CORE->s.now.x, n * sizeof *x);
    return FMI(OK);
}

FMI(Status) FMI(GetNominalsOfContinuousStates)(void *c, double nominal[], size_t n)
{
    NEEDS(n == (size_t)RW_NX && !CORE->co_simulation, "GetNominalsOfContinuousStates");
    memcpy(nominal, rw_x_nominal, n * sizeof *nominal);
    return FMI(OK);
}

FMI(Status) FMI_GET_RATES(void *c, double rate[], size_t n)
{
    rw_status status = RW_OK;
    NEEDS(n == (size_t)RW_NX && !CORE->co_simulation, "GetDerivatives");
    WORST(status, rw_up_to_date(CORE));
    memcpy(rate, CORE->s.rate, n * sizeof *rate);
    return FMI(OK);
}

FMI(Status) FMI(GetEventIndicators)(void *c, double indicator[], size_t n)
{
    NEEDS(n == (size_t)(RW_NK + RW_NL + RW_NB) && !CORE->co_simulation, "GetEventIndicators");
    return (FMI(Status))rw_event_indicators(CORE, indicator);
}

/* Co-Simulation */

static FMI(Status) do_step(void *c, double time, double size)
{
    if (!(size > 0.0) || !isfinite(size) || !isfinite(time) || fabs(time - CORE->s.now.t) > 1e-6 * (1.0 + fabs(time))) {
        rw_message(CORE, RW_ERROR, "logStatusError", "A step of %g s from %.9g s was requested at %.9g s", size, time, CORE->s.now.t);
        return FMI(Error);
    }
    if (time + size > CORE->stop_time + 1e-9 * (1.0 + fabs(CORE->stop_time))) {
        rw_message(CORE, RW_ERROR, "logStatusError", "A step to %.9g s was requested, beyond the stop time %.9g s", time + size, CORE->stop_time);
        return FMI(Error);
    }
    return (FMI(Status))rw_do_step(CORE, time + size);
}
