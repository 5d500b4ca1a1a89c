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

/* Outputs of states: each state's row and its time are copied to `work`, then the calls are made. */
int rs_outputs(const rs_output_calls *c, const double *rows, long long stride, const double *time, int states, double *work,
               double *outputs, long long outputs_stride)
{
    for (int i = 0; i < states; i++, outputs += outputs_stride) {
        memcpy(work, rows + i * stride, c->vectors * sizeof(double));
        work[c->vectors] = time[i];
        rn_call(&c->calls, work);
        for (int j = 0; j < c->outputs; j++) outputs[j] = work[c->row[j]];
    }
    return states;
}
