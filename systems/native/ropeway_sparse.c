/* Sparse LU with partial pivoting, column by column (Gilbert and Peierls): the columns are ordered at
 * export, the rows are chosen here. The capacities are upper bounds for any choice of rows. */
#include <math.h>
#include "ropeway.h"

/* Rows that column `col` of the matrix reaches through the columns of L found so far, in the order in which
 * they must be eliminated, at m->order[top...]. */
static int reach(rw_instance *m, const rw_pattern *a, const rw_factors *lu, int col, int stamp)
{
    int top = a->n;
    for (int p = a->colind[col]; p < a->colind[col + 1]; p++) {
        int depth = 0;
        if (m->mark[a->row[p]] == stamp) continue;
        m->stack[0] = a->row[p];
        m->mark[a->row[p]] = stamp;
        m->place[0] = -1;
        while (depth >= 0) {
            int i = m->stack[depth], j = lu->pinv[i], next = -1;
            if (j >= 0) {
                int q = m->place[depth] < 0 ? lu->lp[j] : m->place[depth];
                for (; q < lu->lp[j + 1]; q++) {
                    if (m->mark[lu->li[q]] != stamp) {
                        next = lu->li[q++];
                        break;
                    }
                }
                m->place[depth] = q;
            }
            if (next >= 0) {
                m->mark[next] = stamp;
                m->stack[++depth] = next;
                m->place[depth] = -1;
            } else {
                m->order[--top] = i;
                depth--;
            }
        }
    }
    return top;
}

/* Factors of the matrix with these nonzero `values`; 1 when it is singular or not finite. */
int rw_factor(rw_instance *m, const rw_pattern *a, rw_factors *lu, const double *values)
{
    double *x = m->work;
    int nl = 0, nu = 0;
    lu->lp[0] = lu->up[0] = 0;
    for (int i = 0; i < a->n; i++) {
        lu->pinv[i] = -1;
        m->mark[i] = -1;
        x[i] = 0.0;
    }
    for (int k = 0; k < a->n; k++) {
        int col = a->order[k], top = reach(m, a, lu, col, k), pivot = -1;
        double largest = 0.0, value;
        for (int p = a->colind[col]; p < a->colind[col + 1]; p++) x[a->row[p]] = values[p];
        for (int s = top; s < a->n; s++) {
            int i = m->order[s], j = lu->pinv[i];
            if (j < 0) continue;
            for (int q = lu->lp[j]; q < lu->lp[j + 1]; q++) x[lu->li[q]] -= lu->lx[q] * x[i];
            if (nu >= RW_UCAP) return 1;
            lu->ui[nu] = j;
            lu->ux[nu++] = x[i];
            x[i] = 0.0;
        }
        for (int s = top; s < a->n; s++) {
            int i = m->order[s];
            if (lu->pinv[i] >= 0) continue;
            if (!isfinite(x[i])) return 1;
            if (fabs(x[i]) > largest) {
                largest = fabs(x[i]);
                pivot = i;
            }
        }
        if (pivot < 0 || largest < 1e-14 || nu >= RW_UCAP) return 1;
        value = x[pivot];
        lu->pinv[pivot] = k;
        lu->ui[nu] = k; /* the diagonal is the last of its column */
        lu->ux[nu++] = value;
        for (int s = top; s < a->n; s++) {
            int i = m->order[s];
            if (lu->pinv[i] < 0) {
                if (x[i] != 0.0) {
                    if (nl >= RW_LCAP) return 1;
                    lu->li[nl] = i;
                    lu->lx[nl++] = x[i] / value;
                }
            }
            x[i] = 0.0;
        }
        lu->lp[k + 1] = nl;
        lu->up[k + 1] = nu;
    }
    return 0;
}

/* Solves in place. */
void rw_back(const rw_pattern *a, const rw_factors *lu, double *b, double *work, int *row_of)
{
    /* L has original row numbers: work[k] is the unknown of the k-th pivot. */
    for (int i = 0; i < a->n; i++) row_of[lu->pinv[i]] = i;
    for (int k = 0; k < a->n; k++) {
        double v = b[row_of[k]];
        work[k] = v;
        if (v != 0.0)
            for (int q = lu->lp[k]; q < lu->lp[k + 1]; q++) b[lu->li[q]] -= lu->lx[q] * v;
    }
    for (int k = a->n - 1; k >= 0; k--) {
        double v = work[k] /= lu->ux[lu->up[k + 1] - 1];
        if (v != 0.0)
            for (int q = lu->up[k]; q < lu->up[k + 1] - 1; q++) work[lu->ui[q]] -= lu->ux[q] * v;
    }
    for (int k = 0; k < a->n; k++) b[a->order[k]] = work[k];
}
