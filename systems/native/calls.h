/* Calls of kernels, one after the other, on one array of values. */
#ifndef CALLS_H
#define CALLS_H

typedef void (*rn_kernel)(const double *v, double *r);

/* Places count in an array of `values`, behind which there is room for the most inputs of a kernel. Of each call: where
 * its result begins; the end of its inputs in `input`, the places that it reads. */
typedef struct {
    int calls, values;
    const int *result, *inputs_end, *input;
    const rn_kernel *kernels; /* of each call */
} rn_calls;

/* Derivatives of the results of calls by what they read: of each call the end of its entries, and the place of the first
 * among its results; of each entry the place of its result, and that of what it is by. */
typedef struct {
    const int *end, *first, *row, *by;
} rn_derivatives;

void rn_call(const rn_calls *calls, double *values);
/* Changes by kernels, of each call one: of its inputs, then of a change of each. */
void rn_change(const rn_calls *calls, const rn_kernel *tangents, double *values, double *changes);
void rn_sweep(const rn_calls *calls, const rn_derivatives *derivatives, const double *values, double *changes);

#endif
