/* A host without Python: loads an FMI 2.0 FMU for Co-Simulation, runs two instances side by side and prints a
 * variable after each step. host LIBRARY GUID REFERENCE INPUT STEPS SIZE */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include "fmi2FunctionTypes.h"
#ifdef _WIN32
#include <windows.h>
#define dlopen(path, mode) LoadLibraryA(path)
#define dlsym(library, name) (void *)GetProcAddress(library, name)
typedef HMODULE library_handle;
#else
#include <dlfcn.h>
typedef void *library_handle;
#endif

static void log_message(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status, fmi2String category, fmi2String text, ...)
{
    va_list list;
    va_start(list, text);
    fprintf(stderr, "%s %s: ", name, category);
    vfprintf(stderr, text, list);
    fputc('\n', stderr);
    va_end(list);
}

int main(int count, char **arguments)
{
    fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
    library_handle library = dlopen(arguments[1], RTLD_NOW);
    fmi2ValueReference output = (fmi2ValueReference)atoi(arguments[3]), input = (fmi2ValueReference)atoi(arguments[4]);
    int steps = atoi(arguments[5]);
    double size = atof(arguments[6]), faster = 1.05;
    fmi2Component one[2];
    if (count != 7 || !library) return 2;
    fmi2InstantiateTYPE *instantiate = (fmi2InstantiateTYPE *)dlsym(library, "fmi2Instantiate");
    fmi2SetupExperimentTYPE *setup = (fmi2SetupExperimentTYPE *)dlsym(library, "fmi2SetupExperiment");
    fmi2EnterInitializationModeTYPE *enter = (fmi2EnterInitializationModeTYPE *)dlsym(library, "fmi2EnterInitializationMode");
    fmi2ExitInitializationModeTYPE *leave = (fmi2ExitInitializationModeTYPE *)dlsym(library, "fmi2ExitInitializationMode");
    fmi2SetRealTYPE *set = (fmi2SetRealTYPE *)dlsym(library, "fmi2SetReal");
    fmi2GetRealTYPE *get = (fmi2GetRealTYPE *)dlsym(library, "fmi2GetReal");
    fmi2DoStepTYPE *step = (fmi2DoStepTYPE *)dlsym(library, "fmi2DoStep");
    fmi2FreeInstanceTYPE *release = (fmi2FreeInstanceTYPE *)dlsym(library, "fmi2FreeInstance");
    for (int i = 0; i < 2; i++) {
        one[i] = instantiate(i ? "two" : "one", fmi2CoSimulation, arguments[2], "", &callbacks, fmi2False, fmi2False);
        if (!one[i] || setup(one[i], fmi2False, 0.0, 0.0, fmi2False, 0.0) || enter(one[i]) || leave(one[i])) return 3;
    }
    if (set(one[1], &input, 1, &faster)) return 4;
    for (int k = 0; k < steps; k++) {
        double value[2];
        for (int i = 0; i < 2; i++)
            if (step(one[i], k * size, size, fmi2True) || get(one[i], &output, 1, &value[i])) return 5;
        printf("%.17g %.17g\n", value[0], value[1]);
    }
    release(one[0]);
    release(one[1]);
    return 0;
}
