/* A small FMU that misbehaves; FMI 2.0, Co-Simulation.
 *
 *   y1 ... y10 = u1 ... u10,  t = time
 *
 * At the first step beyond `when` it does what `deed` says. Instantiated by the name of a deed it does it at once. */
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "fmi2FunctionTypes.h"

enum { NOTHING, SEGFAULT, EXIT, ABORT, HANG, BUS, MOVE, OVERFLOW, TRASH, NOISE, FATAL };
static const char *const deeds[] = {"nothing", "segfault", "exit", "abort", "hang", "bus", "move", "overflow", "trash", "noise", "fatal"};

typedef struct {
    double u[10], when, time;
    int deed;
    const fmi2CallbackFunctions *callbacks;
} instance;

#ifdef MOVES_AT_LOAD
__attribute__((constructor)) static void at_load(void) { if (chdir("/")) abort(); }
#endif

static int deep(volatile char *before)
{
    volatile char here[65536];
    here[0] = before[0];
    return deep(here) + here[1];
}

static void act(int deed)
{
    switch (deed) {
    case SEGFAULT: *(volatile int *)8 = 1; break;
    case EXIT: exit(3);
    case ABORT: abort();
    case HANG: for (;;) usleep(10000);
    case BUS: raise(SIGBUS); break;
    case MOVE: if (chdir("/")) abort(); break;
    case OVERFLOW: deep("x"); break;
    case TRASH: memset((void *)deeds, 0xff, 1 << 20); break;
    }
}

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }
const char *fmi2GetVersion(void) { return "2.0"; }

void *fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging)
{
    instance *i;
    for (int k = 1; k < (int)(sizeof deeds / sizeof *deeds); k++)
        if (strcmp(name, deeds[k]) == 0) act(k);
    if (strcmp(name, "refused") == 0) return NULL;
    i = calloc(1, sizeof *i);
    i->callbacks = callbacks;
    i->when = 1e9;
    return i;
}

void fmi2FreeInstance(void *c) { free(c); }
fmi2Status fmi2SetupExperiment(void *c, fmi2Boolean has, double tolerance, double start, fmi2Boolean ends, double stop) { return fmi2OK; }
fmi2Status fmi2EnterInitializationMode(void *c) { return fmi2OK; }
fmi2Status fmi2ExitInitializationMode(void *c) { return fmi2OK; }
fmi2Status fmi2Terminate(void *c) { return fmi2OK; }
fmi2Status fmi2Reset(void *c) { return fmi2OK; }
fmi2Status fmi2SetDebugLogging(void *c, fmi2Boolean on, size_t n, const fmi2String categories[]) { return fmi2OK; }

fmi2Status fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[])
{
    instance *i = c;
    for (size_t k = 0; k < n; k++) value[k] = vr[k] == 20 ? i->time : vr[k] == 21 ? i->when : i->u[vr[k] % 10];
    return fmi2OK;
}
fmi2Status fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[])
{
    instance *i = c;
    for (size_t k = 0; k < n; k++) *(vr[k] == 21 ? &i->when : &i->u[vr[k] % 10]) = value[k];
    return fmi2OK;
}
fmi2Status fmi2GetInteger(void *c, const unsigned vr[], size_t n, int value[]) { if (n) *value = ((instance *)c)->deed; return fmi2OK; }
fmi2Status fmi2SetInteger(void *c, const unsigned vr[], size_t n, const int value[]) { if (n) ((instance *)c)->deed = *value; return fmi2OK; }

fmi2Status fmi2DoStep(void *c, double time, double size, fmi2Boolean noSetPrior)
{
    instance *i = c;
    i->time = time + size;
    if (i->deed == NOISE)
        i->callbacks->logger(i->callbacks->componentEnvironment, "hostile", fmi2Warning, "noise", "noise");
    if (i->time <= i->when) return fmi2OK;
    if (i->deed == FATAL) return fmi2Fatal;
    act(i->deed);
    return fmi2OK;
}

#define MISSING(name) fmi2Status name(void) { return fmi2Error; }
MISSING(fmi2GetBoolean) MISSING(fmi2SetBoolean) MISSING(fmi2GetString) MISSING(fmi2SetString)
MISSING(fmi2GetFMUstate) MISSING(fmi2SetFMUstate) MISSING(fmi2FreeFMUstate) MISSING(fmi2SerializedFMUstateSize)
MISSING(fmi2SerializeFMUstate) MISSING(fmi2DeSerializeFMUstate) MISSING(fmi2GetDirectionalDerivative)
MISSING(fmi2SetRealInputDerivatives) MISSING(fmi2GetRealOutputDerivatives)
MISSING(fmi2GetStatus) MISSING(fmi2GetRealStatus) MISSING(fmi2GetIntegerStatus) MISSING(fmi2GetBooleanStatus) MISSING(fmi2GetStringStatus)
#ifndef LACKS_A_FUNCTION
MISSING(fmi2CancelStep)
#endif
