/* States as the rows of an array: loads written into the slots of their spans, and outputs by kernels of components. */
#include <string.h>
#include "moving.h"

/* Writes the slots of states whose discrete variables begin at `d`, `stride` doubles apart; `passed` (states, supports).
 * Returns how many could be written: a span of the next one has too few slots. */
int rs_write_rows(const rs_line *l, rs_point *q, rs_motion *m, double *d, long long stride, long long *passed, int states)
{
    for (int i = 0; i < states; i++) {
        q->d = d + i * stride;
        m->passed = passed + (long long)i * l->supports;
        for (int span = 0; span < l->spans; span++)
            if (!rs_write_slots(l, q, m, span)) return i;
    }
    return states;
}

/* Outputs of states, at the end of `work`: each state's row and its time are copied there, then the calls are made. */
int rs_outputs(const rs_calls *c, const double *rows, long long stride, const double *time, int states, double *work,
               double *outputs, long long outputs_stride)
{
    double *v = work + c->size, *r = v + c->most;
    for (int i = 0; i < states; i++) {
        memcpy(work, rows + i * stride, c->values * sizeof(double));
        work[c->values] = time[i];
        for (int k = 0, in = 0, out = 0; k < c->calls; k++) {
            for (int j = 0; in < c->input_end[k]; in++, j++) v[j] = work[c->input[in]];
            c->kernels[k](v, r);
            for (int j = 0; out < c->output_end[k]; out++, j++) work[c->output[out]] = r[j];
        }
        memcpy(outputs + i * outputs_stride, work + c->size - c->outputs, c->outputs * sizeof(double));
    }
    return states;
}
