/* The equations of a system with inertia, and its linear system: (M / c - J) u = r with the step c, M one for states. For
 * c = 0 the states stay as they are. */
#include <math.h>
#include <string.h>
#include "inertial.h"

#define SAME 1e-5 /* by how much inputs may differ, relative */

/* Integers of the packed factors of a piece. */
#define PIVOTS(n) ((n) * (2 * (n) + 1) + 2)
/* The packed factors of piece i, of form f with n unknowns and m of nodes. */
#define PACKED(l, q, i, f, n, m) ((q)->dense + (l)->dense[i] + (n) * ((n) + (m)) + (l)->form_given[f] * (m))
/* Where a form's block begins. */
#define BLOCK(l, f, k) ((l)->block[(RI_BLOCKS + 1) * (f) + (k)])

void ri_load(const ri_line *l, ri_point *q)
{
    double *y = q->y;
    memcpy(y, q->x, l->nx * sizeof(double)), y += l->nx;
    memcpy(y, q->z, l->nz * sizeof(double)), y += l->nz;
    memcpy(y, q->u, l->nu * sizeof(double)), y += l->nu;
    memcpy(y, q->p, l->np * sizeof(double)), y += l->np;
    y[0] = 0.0, y[1] = 1.0;
    for (int i = 0; i < l->components; i++) {
        int f = l->form[i];
        double *v = q->kernel + l->input[i] + l->form_nx[f] + l->form_nz[f] + l->form_ports[f] + l->form_nu[f] + l->ns;
        memcpy(v, q->p + l->p[i], l->form_np[f] * sizeof(double)), v += l->form_np[f];
        memcpy(v, q->d + l->d[i], l->form_nd[f] * sizeof(double)), v += l->form_nd[f];
        *v = 0.0;
    }
}

void ri_evaluate(const ri_line *l, ri_point *q)
{
    for (int i = 0; i < l->components; i++) {
        int f = l->form[i], nx = l->form_nx[f], nz = l->form_nz[f];
        double *v = q->kernel + l->input[i], *r = q->kernel + l->result[i];
        memcpy(v, q->y + l->x[i], nx * sizeof(double)), v += nx;
        memcpy(v, q->y + l->nx + l->z[i], nz * sizeof(double)), v += nz;
        for (int k = l->port_at[i]; k < l->port_at[i + 1]; k++) {
            int piece = l->port_piece[k];
            *v++ = piece < 0 ? q->y[l->port_source[k]] : q->kernel[l->result[piece] + l->port_row[k]];
            if (i < l->pieces) v[-1] += q->y[l->port_aside[k]];
        }
        memcpy(v, q->y + l->nx + l->nz + l->u[i], l->form_nu[f] * sizeof(double)), v += l->form_nu[f];
        for (int k = 0; k < l->ns; k++) *v++ = q->y[l->shared[k]];
        l->value[f](q->kernel + l->input[i], r);
        memcpy(q->value + l->x[i], r, nx * sizeof(double));
        memcpy(q->value + l->nx + l->r[i], r + nx, nz * sizeof(double));
    }
}

/* Factors of a piece's matrix A (n, n) with rows in the order of `row`, with B (n, m) beside it: B becomes A^-1 B. */
static int eliminate(double *a, int n, int m, int *row)
{
    int width = n + m, last[n];
    for (int i = 0; i < n; i++) {
        row[i] = i;
        last[i] = n - 1;
        while (last[i] > 0 && a[width * i + last[i]] == 0.0) last[i]--;
    }
    for (int k = 0; k < n; k++) {
        int best = k, swapped;
        double most = 0.0;
        for (int i = k; i < n; i++) {
            double size = fabs(a[width * row[i] + k]);
            if (size > most) most = size, best = i;
        }
        if (!(most > 0.0) || !(most < 1e300)) return RI_SINGULAR;
        swapped = row[k], row[k] = row[best], row[best] = swapped;
        const double *pivot = a + width * row[k];
        int end = last[row[k]];
        for (int i = k + 1; i < n; i++) {
            double *own = a + width * row[i];
            if (own[k] == 0.0) continue;
            double share = own[k] / pivot[k];
            own[k] = share;
            for (int j = k + 1; j <= end; j++) own[j] -= share * pivot[j];
            if (last[row[i]] < end) last[row[i]] = end;
            for (int j = n; j < width; j++) own[j] -= share * pivot[j];
        }
    }
    for (int k = n - 1; k >= 0; k--) {
        double *own = a + width * row[k], by = 1.0 / own[k];
        for (int i = k + 1; i <= last[row[k]]; i++) {
            const double *behind = a + width * row[i];
            if (own[i] == 0.0) continue;
            for (int j = n; j < width; j++) own[j] -= own[i] * behind[j];
        }
        for (int j = n; j < width; j++) own[j] *= by;
    }
    return RI_OK;
}

/* The factors and A^-1 B without zeros, as they are used: `packed` has the inverses of the diagonal, the columns of A^-1 B,
 * then operations on a vector, by columns of the factors, as these do not wait for each other; `places` has the order of
 * the rows, the numbers of operations with both factors, the places that each changes and reads. */
static void pack(const double *a, int n, int m, int *places, double *packed)
{
    int *count = places + n, *place = count + 2, width = n + m;
    double *value = packed + n * (m + 1);
    for (int i = 0; i < n; i++) {
        const double *own = a + width * places[i];
        packed[i] = 1.0 / own[i];
        for (int j = 0; j < m; j++) packed[n * (j + 1) + i] = own[n + j];
    }
    for (int upper = 0; upper < 2; upper++) {
        count[upper] = 0;
        for (int k = 0; k < n; k++) {
            int j = upper ? n - 1 - k : k;
            for (int i = upper ? 0 : j + 1; i < (upper ? j : n); i++) {
                double share = a[width * places[i] + j];
                if (share == 0.0) continue;
                *value++ = upper ? share * packed[i] : share;
                *place++ = i, *place++ = j, count[upper]++;
            }
        }
    }
}

/* Solves with the packed factors. */
static void substitute(const double *packed, int n, int m, const int *places, const double *from, double *to)
{
    const int *count = places + n, *place = count + 2;
    const double *value = packed + n * (m + 1);
    for (int i = 0; i < n; i++) to[i] = from[places[i]];
    for (int k = 0; k < count[0]; k++, place += 2) to[place[0]] -= value[k] * to[place[1]];
    value += count[0];
    for (int i = 0; i < n; i++) to[i] *= packed[i];
    for (int k = 0; k < count[1]; k++, place += 2) to[place[0]] -= value[k] * to[place[1]];
}

/* The band has `band` diagonals on both sides, and room for as many more that exchanged rows fill. */
static double *entry(const ri_line *l, const ri_point *q, int i, int j)
{
    return q->band + 3 * l->band * i + j + l->band;
}

/* Behind the band, of each column the shares of its row in the `band` rows below. */
static double *shares(const ri_line *l, const ri_point *q)
{
    return q->band + (3 * l->band + 1) * l->unknowns;
}

static int factor_band(const ri_line *l, ri_point *q, int *pivot)
{
    int n = l->unknowns, b = l->band;
    double *share = shares(l, q);
    for (int k = 0; k < n; k++, share += b) {
        int best = k, rows = k + b < n - 1 ? b : n - 1 - k, columns = k + 2 * b < n - 1 ? 2 * b : n - 1 - k;
        double most = 0.0;
        for (int i = k; i <= k + rows; i++)
            if (fabs(*entry(l, q, i, k)) > most) most = fabs(*entry(l, q, i, k)), best = i;
        if (!(most > 0.0) || !(most < 1e300)) return RI_SINGULAR;
        pivot[k] = best;
        double *own = entry(l, q, k, k), *other = entry(l, q, best, k);
        if (best != k)
            for (int j = 0; j <= columns; j++) {
                double kept = own[j];
                own[j] = other[j], other[j] = kept;
            }
        *own = 1.0 / *own;
        for (int i = 0; i < rows; i++) {
            double *next = entry(l, q, k + 1 + i, k);
            share[i] = *next * *own;
            if (share[i] == 0.0) continue;
            for (int j = 1; j <= columns; j++) next[j] -= share[i] * own[j];
        }
    }
    return RI_OK;
}

static void solve_band(const ri_line *l, const ri_point *q, const int *pivot, double *v)
{
    int n = l->unknowns, b = l->band;
    const double *share = shares(l, q);
    for (int k = 0; k < n; k++, share += b) {
        int rows = k + b < n - 1 ? b : n - 1 - k;
        double kept = v[pivot[k]];
        v[pivot[k]] = v[k], v[k] = kept;
        for (int i = 0; i < rows; i++) v[k + 1 + i] -= share[i] * kept;
    }
    for (int k = n - 1; k >= 0; k--) {
        int columns = k + 2 * b < n - 1 ? 2 * b : n - 1 - k;
        const double *own = entry(l, q, k, k);
        double sum = v[k], other = 0.0;
        for (int j = 1; j < columns; j += 2) sum -= own[j] * v[k + j], other -= own[j + 1] * v[k + j + 1];
        if (columns % 2) sum -= own[columns] * v[k + columns];
        v[k] = (sum + other) * *own;
    }
}

/* A piece, with the values b of its kernel: its unknowns by those of its nodes, and its forces by these. */
static int factor_piece(const ri_line *l, ri_point *q, int i, const double *b, int *row)
{
    int f = l->form[i], n = l->form_nz[f], m = l->active_at[i + 1] - l->active_at[i], width = n + m;
    int given = l->form_given[f];
    const int *rows = l->rows, *columns = l->columns, *at = l->at, *order = l->order_r + l->order_at[f];
    double *a = q->dense + l->dense[i], *force = a + n * width;
    memset(a, 0, (n * width + given * m) * sizeof(double));
    for (int k = BLOCK(l, f, RI_OWN); k < BLOCK(l, f, RI_OWN + 1); k++) a[width * rows[k] + columns[k]] = b[at[k]];
    for (int k = BLOCK(l, f, RI_PORTS); k < BLOCK(l, f, RI_PORTS + 1); k++) a[width * rows[k] + n + columns[k]] = b[at[k]];
    for (int j = 0; j < n; j++) {
        double by = l->r_scale[l->r[i] + order[j]];
        for (int k = 0; k < width; k++) a[width * j + k] *= by;
    }
    if (eliminate(a, n, m, row)) {
        q->worst = l->r[i];
        return RI_SINGULAR;
    }
    for (int k = BLOCK(l, f, RI_FORCES); k < BLOCK(l, f, RI_FORCES + 1); k++) {
        const double *own = a + width * row[columns[k]] + n;
        for (int j = 0; j < m; j++) force[m * rows[k] + j] += b[at[k]] * own[j];
    }
    for (int k = BLOCK(l, f, RI_FORCES_PORTS); k < BLOCK(l, f, RI_FORCES_PORTS + 1); k++)
        force[m * rows[k] + columns[k]] += b[at[k]];
    pack(a, n, m, row, force + given * m);
    return RI_OK;
}

/* Whether a piece's factors, made for other inputs, serve Newton's method: they do where the inputs are much the same. */
static int serve(const double *kept, const double *v, int count)
{
    for (int k = 0; k < count; k++)
        if (!(fabs(v[k] - kept[k]) <= SAME * (1.0 + fabs(kept[k])))) return 0;
    return 1;
}

int ri_factor(const ri_line *l, ri_point *q, double c)
{
    int *pivot = q->pivot, again = c == 0.0 && q->step == 0.0;
    q->step = -1.0;
    memset(q->band, 0, (size_t)l->unknowns * (3 * l->band + 1) * sizeof(double));
    for (int i = 0; i < l->components; i++) {
        int f = l->form[i], nx = l->form_nx[f];
        const double *b = q->kernel + l->blocks[i];
        double *v = q->kernel + l->input[i];
        if (i < l->pieces) {
            int inputs = nx + l->form_nz[f] + l->form_ports[f] + l->form_nu[f] + l->ns + l->form_np[f] + l->form_nd[f];
            double *kept = v + inputs + 1;
            if (!again || !serve(kept, v, inputs)) {
                v[inputs] = c;
                memcpy(kept, v, inputs * sizeof(double));
                l->matrix[f](v, q->kernel + l->blocks[i]);
                if (factor_piece(l, q, i, b, pivot)) return RI_SINGULAR;
            }
            pivot += PIVOTS(l->form_nz[f]);
            continue;
        }
        l->matrix[f](v, q->kernel + l->blocks[i]);
        int first = l->unknown[i];
        for (int k = BLOCK(l, f, RI_OWN); k < BLOCK(l, f, RI_OWN + 1); k++)
            *entry(l, q, first + l->rows[k], first + l->columns[k]) -= b[l->at[k]];
        for (int k = BLOCK(l, f, RI_PORTS); k < BLOCK(l, f, RI_PORTS + 1); k++) {
            int port = l->port_at[i] + l->columns[k], piece = l->port_piece[port];
            if (piece < 0) continue;
            int g = l->form[piece], n = l->form_nz[g], m = l->active_at[piece + 1] - l->active_at[piece];
            int row = l->port_row[port] - l->form_nx[g] - n;
            const double *force = q->dense + l->dense[piece] + n * (n + m) + m * row;
            const int *unknown = l->active_unknown + l->active_at[piece];
            double *own = entry(l, q, first + l->rows[k], 0);
            for (int j = 0; j < m; j++) own[unknown[j]] -= b[l->at[k]] * force[j];
        }
        for (int k = 0; k < nx + l->form_nz[f]; k++) {
            double *own = entry(l, q, first + k, first + k) - l->band;
            double by = k < nx ? c : l->r_scale[l->r[i] + k - nx];
            if (k < nx && c > 0.0) own[l->band] += 1.0 / c;
            for (int j = 0; j < 3 * l->band + 1; j++) own[j] *= by;
            if (k < nx && c == 0.0) own[l->band] = 1.0;
        }
    }
    q->step = c;
    return factor_band(l, q, pivot);
}

/* A piece without its nodes: the moves of its algebraic variables in `to`, those of its forces. */
static void reduce_piece(const ri_line *l, const ri_point *q, int i, const int *row, const double *side, double *to,
                         double *force)
{
    int f = l->form[i], n = l->form_nz[f], m = l->active_at[i + 1] - l->active_at[i];
    const int *rows = l->rows, *columns = l->columns, *at = l->at, *order = l->order_r + l->order_at[f];
    const double *b = q->kernel + l->blocks[i], *x = side + l->x[i];
    const double *r = side + l->nx + l->r[i], *scale = l->r_scale + l->r[i];
    double right[n + 1];
    for (int k = 0; k < n; k++) right[k] = r[order[k]];
    for (int k = BLOCK(l, f, RI_STATES); k < BLOCK(l, f, RI_STATES + 1); k++) right[rows[k]] += b[at[k]] * x[columns[k]];
    for (int k = 0; k < n; k++) right[k] *= scale[order[k]];
    substitute(PACKED(l, q, i, f, n, m), n, m, row, right, to);
    for (int k = 0; k < l->form_given[f]; k++) force[k] = 0.0;
    for (int k = BLOCK(l, f, RI_FORCES); k < BLOCK(l, f, RI_FORCES + 1); k++) force[rows[k]] += b[at[k]] * to[columns[k]];
    for (int k = BLOCK(l, f, RI_FORCES_STATES); k < BLOCK(l, f, RI_FORCES_STATES + 1); k++)
        force[rows[k]] += b[at[k]] * x[columns[k]];
}

/* Adds what the moves `v` of the nodes' unknowns do to a piece; writes down its own moves. */
static void complete_piece(const ri_line *l, const ri_point *q, int i, const double *v, double *own, double *side)
{
    int f = l->form[i], nx = l->form_nx[f], n = l->form_nz[f], m = l->active_at[i + 1] - l->active_at[i];
    const int *rows = l->rows, *columns = l->columns, *at = l->at, *order = l->order_z + l->order_at[f];
    const int *unknown = l->active_unknown + l->active_at[i];
    const double *by = PACKED(l, q, i, f, n, m) + n, *b = q->kernel + l->blocks[i];
    double x[nx + 1], *z = side + l->nx + l->z[i];
    for (int j = 0; j < m; j++, by += n) {
        double move = v[unknown[j]];
        for (int k = 0; k < n; k++) own[k] += by[k] * move;
    }
    for (int k = 0; k < n; k++) z[order[k]] = own[k];
    for (int k = 0; k < nx; k++) x[k] = 0.0;
    for (int k = BLOCK(l, f, RI_S); k < BLOCK(l, f, RI_S + 1); k++) x[rows[k]] += b[at[k]] * own[columns[k]];
    for (int k = BLOCK(l, f, RI_T); k < BLOCK(l, f, RI_T + 1); k++) x[rows[k]] += b[at[k]] * side[l->x[i] + columns[k]];
    memcpy(side + l->x[i], x, nx * sizeof(double));
}

void ri_apply(const ri_line *l, ri_point *q, double c, double *side)
{
    double *own = q->room, *to = own, *v = q->room + l->nz;
    int *row = q->pivot;
    for (int i = 0; i < l->pieces; i++) {
        int f = l->form[i];
        reduce_piece(l, q, i, row, side, to, q->kernel + l->result[i] + l->form_nx[f] + l->form_nz[f]);
        row += PIVOTS(l->form_nz[f]), to += l->form_nz[f];
    }
    for (int i = l->pieces; i < l->components; i++) {
        int f = l->form[i], nx = l->form_nx[f], first = l->unknown[i];
        const double *b = q->kernel + l->blocks[i];
        for (int k = 0; k < nx; k++) v[first + k] = side[l->x[i] + k];
        for (int k = 0; k < l->form_nz[f]; k++) v[first + nx + k] = side[l->nx + l->r[i] + k];
        for (int k = BLOCK(l, f, RI_PORTS); k < BLOCK(l, f, RI_PORTS + 1); k++) {
            int port = l->port_at[i] + l->columns[k], piece = l->port_piece[port];
            if (piece >= 0) v[first + l->rows[k]] += b[l->at[k]] * q->kernel[l->result[piece] + l->port_row[port]];
        }
        for (int k = 0; k < nx; k++) v[first + k] *= c;
        for (int k = 0; k < l->form_nz[f]; k++) v[first + nx + k] *= l->r_scale[l->r[i] + k];
    }
    solve_band(l, q, row, v);
    for (int i = l->pieces; i < l->components; i++) {
        int f = l->form[i], nx = l->form_nx[f];
        memcpy(side + l->x[i], v + l->unknown[i], nx * sizeof(double));
        memcpy(side + l->nx + l->z[i], v + l->unknown[i] + nx, l->form_nz[f] * sizeof(double));
    }
    to = own;
    for (int i = 0; i < l->pieces; i++) {
        complete_piece(l, q, i, v, to, side);
        to += l->form_nz[l->form[i]];
    }
}
