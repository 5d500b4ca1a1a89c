/* Calls of kernels, and changes that go through them. */
#include <string.h>
#include "calls.h"

void rn_call(const rn_calls *c, double *values)
{
    double *v = values + c->values;
    const int *from = c->input;
    for (int k = 0; k < c->calls; k++) {
        for (int i = 0; from < c->input + c->inputs_end[k]; i++) v[i] = values[*from++];
        c->kernels[k](v, values + c->result[k]);
    }
}

/* Changes of the results of all calls, as rn_sweep. */
void rn_change(const rn_calls *c, const rn_kernel *tangents, double *values, double *changes)
{
    double *v = values + c->values;
    for (int k = 0, i = 0; k < c->calls; k++) {
        int first = i, n = c->inputs_end[k] - first;
        for (; i < c->inputs_end[k]; i++) {
            v[i - first] = values[c->input[i]];
            v[i - first + n] = changes[c->input[i]];
        }
        tangents[k](v, changes + c->result[k]);
    }
}

/* Changes of the results of all calls, where `values` are those of the calls, and the changes of all else stand in
 * `changes`. */
void rn_sweep(const rn_calls *c, const rn_derivatives *d, const double *values, double *changes)
{
    for (int k = 0, e = 0; k < c->calls; k++) {
        const double *own = values + d->first[k] - e;
        memset(changes + c->result[k], 0, (d->first[k] - c->result[k]) * sizeof(double));
        for (; e < d->end[k]; e++) changes[d->row[e]] += own[e] * changes[d->by[e]];
    }
}
