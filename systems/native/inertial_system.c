/* The equations of a system with inertia, and its linear system: (M / c - J) u = r with the step c, M one for states. For
 * c = 0 the states stay as they are. */
#include <math.h>
#include <string.h>
#include "inertial.h"

#define SAME 1e-5 /* by how much inputs may differ, relative */

/* Integers of the packed factors of a piece. */
#define PIVOTS(n) ((n) * ((n) + 3))
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
        double *v = q->kernel + l->input[i] + l->form_nx[f] + l->form_nz[f] + l->form_ports[f] + l->form_nu[f];
        for (int k = 0; k < l->ns; k++) *v++ = q->y[l->shared[k]];
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
        }
        memcpy(v, q->y + l->nx + l->nz + l->u[i], l->form_nu[f] * sizeof(double));
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

/* The factors without their zeros, in the order in which they are used: of each row those on the left of its diagonal,
 * the inverse of that, those on the right; `columns` has the rows' order, where each part begins, and the columns. */
static void pack(const double *a, int n, int m, int *columns, double *packed)
{
    int *begin = columns + n, *column = begin + 2 * n, count = 0;
    for (int i = 0; i < n; i++) {
        const double *own = a + (n + m) * columns[i];
        begin[2 * i] = count;
        for (int j = 0; j < i; j++)
            if (own[j] != 0.0) column[count] = j, packed[count++] = own[j];
        begin[2 * i + 1] = count;
        column[count] = i, packed[count++] = 1.0 / own[i];
        for (int j = i + 1; j < n; j++)
            if (own[j] != 0.0) column[count] = j, packed[count++] = own[j];
    }
}

/* Solves with the packed factors. */
static void substitute(const double *packed, int n, const int *columns, const double *from, double *to)
{
    const int *begin = columns + n, *column = begin + 2 * n;
    int end = begin[2 * n - 1] + 1;
    for (int i = 0; i < n; i++) {
        double sum = from[columns[i]];
        for (int k = begin[2 * i]; k < begin[2 * i + 1]; k++) sum -= packed[k] * to[column[k]];
        to[i] = sum;
    }
    for (int i = n - 1; i >= 0; i--) {
        double sum = to[i];
        for (int k = begin[2 * i + 1] + 1; k < end; k++) sum -= packed[k] * to[column[k]];
        to[i] = sum * packed[begin[2 * i + 1]];
        end = begin[2 * i];
    }
}

/* The band has `band` diagonals on both sides, and room for as many more that exchanged rows fill. */
static double *entry(const ri_line *l, const ri_point *q, int i, int j)
{
    return q->band + 3 * l->band * i + j + l->band;
}

static int factor_band(const ri_line *l, ri_point *q, int *pivot)
{
    int n = l->unknowns, b = l->band;
    for (int k = 0; k < n; k++) {
        int best = k, rows = k + b < n - 1 ? k + b : n - 1, columns = k + 2 * b < n - 1 ? k + 2 * b : n - 1;
        double most = 0.0;
        for (int i = k; i <= rows; i++)
            if (fabs(*entry(l, q, i, k)) > most) most = fabs(*entry(l, q, i, k)), best = i;
        if (!(most > 0.0) || !(most < 1e300)) return RI_SINGULAR;
        pivot[k] = best;
        double *own = entry(l, q, k, k), *other = entry(l, q, best, k);
        if (best != k)
            for (int j = 0; j <= columns - k; j++) {
                double kept = own[j];
                own[j] = other[j], other[j] = kept;
            }
        for (int i = k + 1; i <= rows; i++) {
            double *next = entry(l, q, i, k);
            if (*next == 0.0) continue;
            double share = *next / *own;
            *next = share;
            for (int j = 1; j <= columns - k; j++) next[j] -= share * own[j];
        }
    }
    return RI_OK;
}

static void solve_band(const ri_line *l, const ri_point *q, const int *pivot, double *v)
{
    int n = l->unknowns, b = l->band;
    for (int k = 0; k < n; k++) {
        double kept = v[pivot[k]];
        v[pivot[k]] = v[k], v[k] = kept;
        for (int i = k + 1; i <= k + b && i < n; i++) v[i] -= *entry(l, q, i, k) * kept;
    }
    for (int k = n - 1; k >= 0; k--) {
        const double *own = entry(l, q, k, k);
        double sum = v[k];
        for (int j = 1; j <= 2 * b && k + j < n; j++) sum -= own[j] * v[k + j];
        v[k] = sum / *own;
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
    substitute(q->dense + l->dense[i] + n * (n + m) + l->form_given[f] * m, n, row, right, to);
    for (int k = 0; k < l->form_given[f]; k++) force[k] = 0.0;
    for (int k = BLOCK(l, f, RI_FORCES); k < BLOCK(l, f, RI_FORCES + 1); k++) force[rows[k]] += b[at[k]] * to[columns[k]];
    for (int k = BLOCK(l, f, RI_FORCES_STATES); k < BLOCK(l, f, RI_FORCES_STATES + 1); k++)
        force[rows[k]] += b[at[k]] * x[columns[k]];
}

/* Adds what the moves `v` of the nodes' unknowns do to a piece; writes down its own moves. */
static void complete_piece(const ri_line *l, const ri_point *q, int i, const int *row, const double *v, double *own,
                           double *side)
{
    int f = l->form[i], nx = l->form_nx[f], n = l->form_nz[f], m = l->active_at[i + 1] - l->active_at[i];
    const int *rows = l->rows, *columns = l->columns, *at = l->at, *order = l->order_z + l->order_at[f];
    const int *unknown = l->active_unknown + l->active_at[i];
    const double *a = q->dense + l->dense[i] + n, *b = q->kernel + l->blocks[i];
    double x[nx + 1], move[m + 1], *z = side + l->nx + l->z[i];
    for (int j = 0; j < m; j++) move[j] = v[unknown[j]];
    for (int k = 0; k < n; k++) {
        const double *by = a + (n + m) * row[k];
        for (int j = 0; j < m; j++) own[k] += by[j] * move[j];
        z[order[k]] = own[k];
    }
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
    row = q->pivot, to = own;
    for (int i = 0; i < l->pieces; i++) {
        complete_piece(l, q, i, row, v, to, side);
        row += PIVOTS(l->form_nz[l->form[i]]), to += l->form_nz[l->form[i]];
    }
}
