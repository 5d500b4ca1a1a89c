/* Damped Newton's method on a network of kernels: the same steps and tests as damped_newton.py. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "network.h"

#define SMALL 1e-11 /* scaled residual of a root */
#define STAGNANT 20  /* iterations after which small steps at a root are taken for its rounding error */

static int begin(const int *end, int k)
{
    return k ? end[k - 1] : 0;
}

static void add_up(const rn_network *net, double *w, int first, int last)
{
    for (int s = first; s < last; s++) {
        double sum = 0.0;
        for (int k = begin(net->terms_end, s); k < net->terms_end[s]; k++) sum += w[net->factor[k]] * w[net->other[k]];
        w[net->sum[s]] = sum;
    }
}

/* All calls, one after the other. */
void rn_evaluate(const rn_network *net, double *w)
{
    rn_call(&net->calls, w);
}

/* Scaled residuals at v; their norm. */
static double evaluate(const rn_network *net, const rn_problem *q, const double *v, double *residual)
{
    double sum = 0.0, *w = q->values;
    for (int i = 0; i < net->pattern.n; i++) w[net->unknown[i]] = v[i] * q->scale[i];
    rn_evaluate(net, w);
    for (int i = 0; i < net->pattern.n; i++) residual[i] = (w[net->residual[i]] - q->target[i]) * q->weight[i];
    if (q->damping != 0.0)
        for (int b = 0; b < net->balances; b++) {
            int i = net->balance_unknown[b];
            residual[net->balance_residual[b]] -= q->damping * net->sign[b] * (v[i] - q->anchor[i]);
        }
    for (int i = 0; i < net->pattern.n; i++) sum += residual[i] * residual[i];
    return sqrt(sum);
}

/* The matrix where the kernels have been evaluated. */
static void matrix_here(const rn_network *net, const rn_problem *q, double *entries)
{
    double *w = q->values;
    add_up(net, w, 0, net->sums - net->drifts);
    for (int j = 0; j < net->pattern.n; j++)
        for (int p = begin(net->pattern.column_end, j); p < net->pattern.column_end[j]; p++)
            entries[p] = net->entry[p] < 0 ? 0.0 : w[net->entry[p]] * q->weight[net->pattern.row[p]] * q->scale[j];
    if (q->damping != 0.0)
        for (int b = 0; b < net->balances; b++) entries[net->balance_entry[b]] -= q->damping * net->sign[b];
}

void rn_matrix(const rn_network *net, const rn_problem *q, const double *v, double *entries)
{
    for (int i = 0; i < net->pattern.n; i++) q->values[net->unknown[i]] = v[i] * q->scale[i];
    rn_evaluate(net, q->values);
    matrix_here(net, q, entries);
}

static double largest(const double *v, int n)
{
    double found = 0.0;
    for (int i = 0; i < n; i++)
        if (!(fabs(v[i]) <= found)) found = fabs(v[i]);
    return found;
}

/* Room for one solve. */
typedef struct {
    rn_factors factors;
    double *entries, *move, *step, *trial, *residual, *least, *now;
} room;

static int new_room(room *r, const rn_network *net)
{
    int n = net->pattern.n, failed = rn_new_factors(&r->factors, n);
    r->entries = malloc((net->entries + 6 * (size_t)n + 1) * sizeof(double));
    r->move = r->entries + net->entries;
    r->step = r->move + n;
    r->trial = r->step + n;
    r->residual = r->trial + n;
    r->least = r->residual + n;
    r->now = r->least + n;
    return failed || !r->entries;
}

/* Whether the residuals `now` at v are within the rounding error of the unknowns. */
static int rounded(const rn_network *net, const rn_problem *q, const double *v, const double *now, room *r)
{
    int n = net->pattern.n;
    for (int i = 0; i < n; i++) r->least[i] = SMALL;
    for (int alternate = 0; alternate < 2; alternate++) {
        for (int i = 0; i < n; i++) r->trial[i] = v[i] * (1.0 + (alternate && i % 2 == 0 ? -4.0 : 4.0) * DBL_EPSILON);
        evaluate(net, q, r->trial, r->residual);
        for (int i = 0; i < n; i++) r->least[i] = fmax(r->least[i], 4.0 * fabs(r->residual[i] - now[i]));
    }
    for (int i = 0; i < n; i++)
        if (!(fabs(now[i]) <= r->least[i])) return 0;
    return 1;
}

/* Newton's step at v, where the kernels have been evaluated, in r->step. */
static int newton_step(const rn_network *net, const rn_problem *q, const double *residual, room *r)
{
    matrix_here(net, q, r->entries);
    int failed = rn_factor(&r->factors, &net->pattern, r->entries);
    if (failed) return failed;
    memcpy(r->step, residual, net->pattern.n * sizeof(double));
    rn_back(&r->factors, &net->pattern, r->step);
    return RN_OK;
}

/* Rates of the scaled unknowns by the factors as they are. */
static void rates_here(const rn_network *net, const rn_problem *q, double *rates, room *r)
{
    if (!q->rates) return;
    add_up(net, q->values, net->sums - net->drifts, net->sums);
    for (int i = 0; i < net->pattern.n; i++)
        rates[i] = net->drift[i] < 0 ? 0.0 : -q->values[net->drift[i]] * q->weight[i];
    rn_back(&r->factors, &net->pattern, rates);
}

static void move_by(double *v, const double *step, int n)
{
    for (int i = 0; i < n; i++) v[i] -= step[i];
}

static int solve(const rn_network *net, const rn_problem *q, double *v, double *residual, double *rates, room *r)
{
    int n = net->pattern.n, failed;
    double before = INFINITY, last = INFINITY, coming;
    for (int turn = 0; turn < q->iterations; turn++) {
        double norm = evaluate(net, q, v, r->residual), size;
        failed = newton_step(net, q, r->residual, r);
        if (failed) return failed;
        if (turn > 0 && !(norm <= 0.9 * before || (last < 1e-6 && norm <= 1e-12))) {
            if (fmin(last, largest(r->step, n)) < 1e-6) {
                /* After one long step down to the rounding error, the next step is small. */
                rates_here(net, q, rates, r);
                memcpy(r->now, r->residual, n * sizeof(double));
                if (rounded(net, q, v, r->now, r)) {
                    move_by(v, r->step, n);
                    return RN_OK;
                }
            }
            /* A half, a quarter, ... of the step that has led here, where the residual falls. */
            double share = 0.5;
            for (;; share *= 0.5) {
                if (!(share > q->shortest)) return RN_STUCK;
                for (int i = 0; i < n; i++) r->trial[i] = v[i] + (1.0 - share) * r->move[i];
                norm = evaluate(net, q, r->trial, r->residual);
                if (norm <= (1.0 - 0.1 * share) * before) break;
            }
            memcpy(v, r->trial, n * sizeof(double));
            last = INFINITY;
            failed = newton_step(net, q, r->residual, r);
            if (failed) return failed;
        }
        memcpy(residual, r->residual, n * sizeof(double));
        memcpy(r->move, r->step, n * sizeof(double));
        size = largest(r->step, n);
        if (!isfinite(size)) return RN_SINGULAR;
        rates_here(net, q, rates, r);
        if (turn >= STAGNANT && size <= 1e-6 && norm <= 1e-12) { /* stiff: unknowns are rounded coarsely */
            move_by(v, r->step, n);
            return RN_OK;
        }
        coming = isfinite(last) ? size * (size / last) * (size / last) : 100.0 * size * size;
        if (fmin(size, coming) <= 1e-12 || norm <= 1e-15 * sqrt((double)n)) {
            move_by(v, r->step, n);
            if (last < 1e-2 && size <= 1e-3 * last && norm <= 1e-6) return RN_OK;
            evaluate(net, q, v, r->now);
            if (largest(r->now, n) <= SMALL || rounded(net, q, v, r->now, r)) return RN_OK;
        } else
            move_by(v, r->step, n);
        before = norm;
        last = size;
    }
    return RN_SLOW;
}

/* Solves from v, scaled, in place. `residual` is the scaled one that a failure had; with q->rates, `rates` are those of the
 * scaled unknowns. */
int rn_solve(const rn_network *net, const rn_problem *q, double *v, double *residual, double *rates)
{
    room r;
    int result = new_room(&r, net) ? RN_MEMORY : solve(net, q, v, residual, rates, &r);
    rn_free_factors(&r.factors);
    free(r.entries);
    return result;
}
