/* Sparse LU, column by column (Gilbert and Peierls). The first matrix of a solve chooses the pivots, near the diagonal
 * that the tables prefer; later ones keep them and the pattern as long as they are good. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "sparse_lu.h"

#define PREFERRED 0.1 /* of the largest entry of a column: from here the preferred row is taken */
#define KEPT 1e-3     /* of the largest entry: a smaller kept pivot is chosen again */

int rn_new_factors(rn_factors *f, int n)
{
    memset(f, 0, sizeof *f);
    f->n = n;
    f->size_l = f->size_u = 16 * n + 16;
    f->lower_end = calloc(7 * (size_t)n + 1, sizeof(int));
    f->lower = malloc(f->size_l * sizeof(int));
    f->upper = malloc(f->size_u * sizeof(int));
    f->l = malloc(f->size_l * sizeof(double));
    f->u = malloc(f->size_u * sizeof(double));
    f->work = malloc((n + 1) * sizeof(double));
    if (!f->lower_end || !f->lower || !f->upper || !f->l || !f->u || !f->work) return 1;
    f->upper_end = f->lower_end + n;
    f->step_of = f->upper_end + n;
    f->mark = f->step_of + n;
    f->stack = f->mark + n;
    f->place = f->stack + n;
    f->reached = f->place + n;
    return 0;
}

void rn_free_factors(rn_factors *f)
{
    free(f->lower_end), free(f->lower), free(f->upper), free(f->l), free(f->u), free(f->work);
}

/* Room for n more entries of a column in both factors. */
static int room(rn_factors *f, int l, int u)
{
    if (l + f->n > f->size_l) {
        f->size_l = 2 * f->size_l + f->n;
        int *at = realloc(f->lower, f->size_l * sizeof(int));
        if (at) f->lower = at;
        double *value = realloc(f->l, f->size_l * sizeof(double));
        if (value) f->l = value;
        if (!at || !value) return 1;
    }
    if (u + f->n > f->size_u) {
        f->size_u = 2 * f->size_u + f->n;
        int *at = realloc(f->upper, f->size_u * sizeof(int));
        if (at) f->upper = at;
        double *value = realloc(f->u, f->size_u * sizeof(double));
        if (value) f->u = value;
        if (!at || !value) return 1;
    }
    return 0;
}

static int begin(const int *end, int k)
{
    return k ? end[k - 1] : 0;
}

/* Rows that a column reaches through those eliminated before, in the order of elimination from f->reached[top]. */
static int reach(rn_factors *f, const rn_pattern *a, int column, int stamp)
{
    int top = f->n;
    for (int p = begin(a->column_end, column); p < a->column_end[column]; p++) {
        int depth = 0;
        if (f->mark[a->row[p]] == stamp) continue;
        f->stack[0] = a->row[p];
        f->mark[a->row[p]] = stamp;
        f->place[0] = -1;
        while (depth >= 0) {
            int i = f->stack[depth], j = f->step_of[i], next = -1;
            if (j >= 0) {
                int q = f->place[depth] < 0 ? begin(f->lower_end, j) : f->place[depth];
                for (; q < f->lower_end[j] && next < 0; q++)
                    if (f->mark[f->lower[q]] != stamp) next = f->lower[q];
                f->place[depth] = q;
            }
            if (next >= 0) {
                f->mark[next] = stamp;
                f->stack[++depth] = next;
                f->place[depth] = -1;
            } else {
                f->reached[--top] = i;
                depth--;
            }
        }
    }
    return top;
}

static void eliminate(const rn_factors *f, int j, double value)
{
    for (int q = begin(f->lower_end, j); q < f->lower_end[j]; q++) f->work[f->lower[q]] -= f->l[q] * value;
}

/* The row that column k takes of those reached; -1 where there is none that is finite and not zero. */
static int pivot_of(const rn_factors *f, const rn_pattern *a, int k, int top)
{
    int wanted = a->diagonal[k], inner = k < a->inner, pivot = -1;
    double largest = 0.0;
    for (int s = top; s < f->n; s++) {
        int i = f->reached[s];
        if (f->step_of[i] >= 0 || (inner && i >= a->inner)) continue;
        if (!isfinite(f->work[i])) return -1;
        if (fabs(f->work[i]) > largest) largest = fabs(f->work[i]), pivot = i;
    }
    if (f->mark[wanted] == k && f->step_of[wanted] < 0 && fabs(f->work[wanted]) > f->least)
        if (!inner || fabs(f->work[wanted]) >= PREFERRED * largest) return wanted;
    return inner && largest > f->least ? pivot : -1;
}

/* Factors with new pivots. */
static int choose(rn_factors *f, const rn_pattern *a, const double *entries)
{
    int l = 0, u = 0;
    f->steps = 0;
    for (int i = 0; i < f->n; i++) f->step_of[i] = f->mark[i] = -1, f->work[i] = 0.0;
    for (int k = 0; k < f->n; k++) {
        int column = a->order[k], top = reach(f, a, column, k), pivot;
        if (room(f, l, u)) return RN_MEMORY;
        for (int p = begin(a->column_end, column); p < a->column_end[column]; p++) f->work[a->row[p]] = entries[p];
        for (int s = top; s < f->n; s++) {
            int i = f->reached[s], j = f->step_of[i];
            if (j >= 0) {
                double value = f->work[i];
                eliminate(f, j, value);
                f->upper[u] = i; /* rows of the matrix: steps are found by step_of */
                f->u[u++] = value;
                f->work[i] = 0.0;
            }
        }
        pivot = pivot_of(f, a, k, top);
        if (pivot < 0) return RN_SINGULAR;
        double value = f->work[pivot];
        f->step_of[pivot] = k;
        f->upper[u] = pivot; /* the diagonal is the last of its column */
        f->u[u++] = value;
        for (int s = top; s < f->n; s++) {
            int i = f->reached[s];
            if (f->step_of[i] < 0) {
                f->lower[l] = i;
                f->l[l++] = f->work[i] / value;
            }
            f->work[i] = 0.0;
        }
        f->lower_end[k] = l;
        f->upper_end[k] = u;
        f->steps = k + 1;
    }
    return RN_OK;
}

/* Factors with the pivots of an earlier matrix; 1 where one is too small. */
static int again(rn_factors *f, const rn_pattern *a, const double *entries)
{
    for (int k = 0; k < f->n; k++) {
        int column = a->order[k], last = f->upper_end[k] - 1;
        double largest;
        for (int p = begin(a->column_end, column); p < a->column_end[column]; p++) f->work[a->row[p]] = entries[p];
        for (int q = begin(f->upper_end, k); q < last; q++) {
            f->u[q] = f->work[f->upper[q]];
            eliminate(f, f->step_of[f->upper[q]], f->u[q]);
            f->work[f->upper[q]] = 0.0;
        }
        double value = f->u[last] = f->work[f->upper[last]];
        largest = fabs(value);
        f->work[f->upper[last]] = 0.0;
        for (int q = begin(f->lower_end, k); q < f->lower_end[k]; q++) {
            double below = f->work[f->lower[q]];
            f->work[f->lower[q]] = 0.0;
            f->l[q] = below / value;
            if (!(fabs(below) <= largest)) largest = fabs(below);
        }
        if (!(fabs(value) >= KEPT * largest && value != 0.0)) {
            memset(f->work, 0, f->n * sizeof(double));
            return 1;
        }
    }
    return 0;
}

/* Factors of a matrix; RN_SINGULAR where it has none. */
int rn_factor(rn_factors *f, const rn_pattern *a, const double *entries)
{
    if (f->known && !again(f, a, entries)) return RN_OK;
    int failed = choose(f, a, entries);
    f->known = !failed;
    return failed;
}

/* The pivots of the columns behind the inner ones, in their order, for a matrix whose entries are taken from others; zero
 * from the first that is zero. */
int rn_pivots(const rn_pattern *a, const double *from, const int *take, double *pivots)
{
    rn_factors f;
    int count = a->n ? a->column_end[a->n - 1] : 0, failed = rn_new_factors(&f, a->n);
    double *entries = malloc((count + 1) * sizeof(double));
    for (int k = a->inner; k < a->n; k++) pivots[k - a->inner] = 0.0;
    if (failed || !entries)
        failed = RN_MEMORY;
    else {
        for (int p = 0; p < count; p++) entries[p] = from[take[p]];
        failed = choose(&f, a, entries);
        for (int k = a->inner; k < f.steps; k++) pivots[k - a->inner] = f.u[f.upper_end[k] - 1];
        if (failed == RN_SINGULAR && f.steps >= a->inner) failed = RN_OK;
    }
    rn_free_factors(&f);
    free(entries);
    return failed;
}

/* Solves in place. */
void rn_back(const rn_factors *f, const rn_pattern *a, double *b)
{
    double *x = f->work;
    memset(x, 0, f->n * sizeof(double));
    for (int k = 0; k < f->n; k++) {
        int row = f->upper[f->upper_end[k] - 1];
        double value = b[row];
        x[k] = value;
        for (int q = begin(f->lower_end, k); q < f->lower_end[k]; q++) b[f->lower[q]] -= f->l[q] * value;
    }
    for (int k = f->n - 1; k >= 0; k--) {
        double value = x[k] /= f->u[f->upper_end[k] - 1];
        for (int q = begin(f->upper_end, k); q < f->upper_end[k] - 1; q++) x[f->step_of[f->upper[q]]] -= f->u[q] * value;
    }
    for (int k = 0; k < f->n; k++) b[a->order[k]] = x[k];
}
