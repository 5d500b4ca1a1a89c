/* Newton's method on the sections of a line. */
#include <math.h>
#include <string.h>
#include "sections.h"

#define CLOSE 1e-12  /* scaled step that the next iteration would make at a root */
#define SMALL 1e-11  /* scaled residual of a root */
#define LARGE 1e9       /* scaled step of a matrix that is singular but for rounding */
#define ITERATIONS 50

/* Room for one section. */
typedef struct {
    double *span, *support;                 /* results of the kernels */
    double *lower, *upper, *right, *travel; /* of the tridiagonal system, by support */
    double *pivot;
    double *move, *before;                  /* step and start of an iteration, (nz,) */
    double *input;
} room;

static room room_of(const rs_line *l, double *work)
{
    room r;
    r.span = work, work += RS_SPAN * l->spans;
    r.support = work, work += RS_SUPPORT * l->supports;
    r.lower = work, work += l->supports;
    r.upper = work, work += l->supports;
    r.right = work, work += l->supports;
    r.travel = work, work += l->supports;
    r.pivot = work, work += l->supports;
    r.move = work, work += l->nz;
    r.before = work, work += l->nz;
    r.input = work;
    return r;
}

int rs_work_size(const rs_line *l)
{
    return (RS_SPAN + 3 * 8) * l->spans + (RS_SUPPORT + 5) * l->supports + 2 * l->nz + 4 * (l->slots + 8) + 256;
}

double rs_travel(const rs_line *l, const rs_point *q, int k)
{
    return l->state[k] >= 0 ? q->x[l->state[k]] : l->travel[k] >= 0 ? q->z[l->travel[k]] : 0.0;
}

/* Whether a support is the last one of its run. */
int rs_is_last(const rs_line *l, int k)
{
    return k + 1 == l->run_first[l->run_of[k] + 1];
}

/* The sections on both sides of a support, added to `sections`, at most so many; returns how many they are. */
int rs_beside(const rs_line *l, int k, int *sections, int count, int most)
{
    int run = l->run_of[k], ends[3] = {-1, -1, -1};
    if (k > l->run_first[run]) ends[0] = l->section_of[k - run - 1];
    if (!rs_is_last(l, k)) ends[1] = l->section_of[k - run];
    if (k == l->run_first[run] && l->around[run]) ends[2] = l->section_of[l->run_first[run + 1] - run - 2];
    for (int e = 0; e < 3; e++) {
        int known = ends[e] < 0;
        for (int i = 0; i < count && !known; i++) known = sections[i] == ends[e];
        if (!known && count < most) sections[count++] = ends[e];
    }
    return count;
}

/* Slots of the kernel for so many loads: kernels for many loads are few. */
static int slots_for(int used)
{
    return used <= 8 ? used : (used + 7) / 8 * 8;
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Writes down what all kernels read; returns where that ends. */
static double *shared_at(const rs_line *l, const rs_point *q, double *to)
{
    for (int i = 0; i < l->ns; i++) *to++ = l->shared[i] < l->np ? q->p[l->shared[i]] : q->u[l->shared[i] - l->np];
    return to;
}

static void span_at(const rs_line *l, const rs_point *q, int i, double *v, double *result)
{
    int form = l->form[i], used = (int)q->used[i], n = l->form_parameters[form], a = l->start[i];
    int slots = slots_for(used);
    double *to = shared_at(l, q, v), length = q->p[l->length_start[i]] + rs_travel(l, q, a) - rs_travel(l, q, a + 1);
    memcpy(to, q->z + l->force[i], 3 * sizeof(double)), to += 3;
    memcpy(to, q->p + l->parameters[i], n * sizeof(double)), to += n;
    memcpy(to, q->d + l->mass[i], used * sizeof(double));
    memcpy(to + slots, q->d + l->at[i], used * sizeof(double));
    memcpy(to + 2 * slots, q->d + l->ride[i], used * sizeof(double));
    for (int j = used; j < slots; j++) { /* without mass, at the end */
        to[j] = to[2 * slots + j] = 0.0;
        to[slots + j] = length;
    }
    to += 3 * slots;
    if (l->drag[i] >= 0) {
        memcpy(to, q->d + l->drag[i], used * sizeof(double));
        for (int j = used; j < slots; j++) to[j] = 0.0;
        to += slots;
    }
    for (int end = 0; end < 2; end++) {
        for (int axis = 0; axis < 3; axis++) *to++ = q->p[l->point[3 * (a + end) + axis]];
        *to++ = rs_travel(l, q, a + end);
    }
    l->kernels[form * (l->slots + 1) + used](v, result);
}

static void support_at(const rs_line *l, const rs_point *q, int k, const double *coming, const double *going, double *v,
                       double *result)
{
    int form = l->support_form[k], speed = l->speed[k];
    double *to = shared_at(l, q, v);
    memcpy(to, q->p + l->support_parameters[k], l->support_form_parameters[form] * sizeof(double));
    to += l->support_form_parameters[form];
    memcpy(to, q->d + l->support_discrete[k], l->support_form_discrete[form] * sizeof(double));
    to += l->support_form_discrete[form];
    *to++ = q->z[l->travel[k]];
    for (int i = 0; i < 3; i++) *to++ = coming ? coming[3 + i] : 0.0;
    for (int i = 0; i < 3; i++) *to++ = going ? going[i] : 0.0;
    *to++ = speed < 0 ? 0.0 : speed < l->nx ? q->x[speed] : q->u[speed - l->nx];
    l->support_kernels[form](v, result);
}

/* Kernels of a section at the present point; the norm of its scaled residuals and the largest of them. */
static double evaluate(const rs_line *l, rs_point *q, int section, const room *r, double *largest)
{
    int a = l->first[section], b = l->last[section], span = l->first_span[section];
    double sum = 0.0;
    *largest = 0.0;
    q->worst = l->closure[span];
    for (int k = a; k <= b; k++) {
        double *own = r->span + RS_SPAN * (span + k - a), e;
        if (k < b) {
            span_at(l, q, span + k - a, r->input, own);
            for (int i = 0; i < 3; i++) {
                e = fabs(own[i] / l->r_nominal[l->closure[span + k - a] + i]);
                sum += e * e;
                if (!(e <= *largest)) *largest = e, q->worst = l->closure[span + k - a] + i;
            }
        }
        if (l->travel[k] < 0) continue;
        support_at(l, q, k, k > a ? own - RS_SPAN : 0, k < b ? q->z + l->force[span + k - a] : 0, r->input,
                   r->support + RS_SUPPORT * k);
        e = fabs(r->support[RS_SUPPORT * k] / l->r_nominal[l->balance[k]]);
        sum += e * e;
        if (!(e <= *largest)) *largest = e, q->worst = l->balance[k];
    }
    return sqrt(sum);
}

/* The tridiagonal matrix of the free travels, eliminated. */
static void eliminate(const rs_line *l, int section, const room *r)
{
    int a = l->first[section], b = l->last[section], span = l->first_span[section];
    for (int k = a; k <= b; k++) {
        const double *s = r->support + RS_SUPPORT * k;
        const double *before = r->span + RS_SPAN * (span + k - a - 1), *after = before + RS_SPAN;
        double diagonal = s[1], lower = 0.0, upper = 0.0;
        if (l->travel[k] < 0) {
            r->lower[k] = r->upper[k] = 0.0;
            r->pivot[k] = 1.0;
            continue;
        }
        if (k > a) lower = dot(s + 2, before + 18), diagonal += dot(s + 2, before + 21);
        if (k < b) upper = dot(s + 5, after + 12), diagonal += dot(s + 5, after + 9);
        r->lower[k] = lower;
        r->pivot[k] = 1.0 / (k > a ? diagonal - lower * r->upper[k - 1] : diagonal);
        r->upper[k] = upper * r->pivot[k];
    }
}

/* Its solution for the right-hand side in r->right, in r->travel. */
static void substitute(const rs_line *l, int section, const room *r)
{
    int a = l->first[section], b = l->last[section];
    for (int k = a; k <= b; k++)
        r->travel[k] = (r->right[k] - (k > a ? r->lower[k] * r->travel[k - 1] : 0.0)) * r->pivot[k];
    for (int k = b - 1; k >= a; k--) r->travel[k] -= r->upper[k] * r->travel[k + 1];
}

/* Newton's step of a section in r->move; its largest entry, scaled. */
static double step(const rs_line *l, int section, const room *r)
{
    int a = l->first[section], b = l->last[section], span = l->first_span[section];
    double size = 0.0;
    eliminate(l, section, r);
    for (int k = a; k <= b; k++) {
        const double *s = r->support + RS_SUPPORT * k;
        const double *before = r->span + RS_SPAN * (span + k - a - 1), *after = before + RS_SPAN;
        r->right[k] = 0.0;
        if (l->travel[k] < 0) continue;
        r->right[k] = -s[0];
        if (k > a) r->right[k] -= dot(s + 2, before + 15);
        if (k < b) r->right[k] -= dot(s + 5, after + 6);
    }
    substitute(l, section, r);
    for (int k = a; k <= b; k++) {
        const double *own = r->span + RS_SPAN * (span + k - a);
        if (k < b)
            for (int i = 0; i < 3; i++) {
                int place = l->force[span + k - a] + i;
                r->move[place] = own[6 + i] + own[9 + i] * r->travel[k] + own[12 + i] * r->travel[k + 1];
                double e = fabs(r->move[place]) / l->z_nominal[place];
                if (!(e <= size)) size = e;
            }
        if (l->travel[k] >= 0) {
            r->move[l->travel[k]] = r->travel[k];
            double e = fabs(r->travel[k]) / l->z_nominal[l->travel[k]];
            if (!(e <= size)) size = e;
        }
    }
    return size;
}

/* Rates of a section's algebraic variables, from the kernels as they are. */
static void rates_of(const rs_line *l, rs_point *q, int section, const room *r)
{
    int a = l->first[section], b = l->last[section], span = l->first_span[section];
    for (int k = a; k <= b; k++) {
        int speed = l->speed[k];
        if (l->travel[k] < 0)
            r->right[k] = l->state[k] >= 0 ? q->x_rate[l->state[k]] : 0.0;
        else {
            double rate = speed < 0 ? 0.0 : speed < l->nx ? q->x_rate[speed] : q->u_rate[speed - l->nx];
            r->right[k] = -r->support[RS_SUPPORT * k + 8] * rate;
        }
    }
    substitute(l, section, r);
    for (int k = a; k <= b; k++) {
        const double *own = r->span + RS_SPAN * (span + k - a);
        if (k < b)
            for (int i = 0; i < 3; i++)
                q->z_rate[l->force[span + k - a] + i] = own[9 + i] * r->travel[k] + own[12 + i] * r->travel[k + 1];
        if (l->travel[k] >= 0) q->z_rate[l->travel[k]] = r->travel[k];
    }
}

/* Whether the balances of all idlers are stable, where sections have just been solved: more travel lowers the residual of
 * those of sign 1 and raises that of sign -1. */
int rs_stable(const rs_line *l, const rs_point *q, const int *sign)
{
    room r = room_of(l, q->work);
    for (int k = 0; k < l->supports; k++)
        if (l->travel[k] >= 0 && !(r.pivot[k] * sign[k] < 0.0)) return 0;
    return 1;
}

/* z = before + share * move, for the variables of a section. */
static void put(const rs_line *l, rs_point *q, int section, const room *r, double share)
{
    int a = l->first[section], b = l->last[section], span = l->first_span[section];
    for (int k = a; k <= b; k++) {
        int force = k < b ? l->force[span + k - a] : 0, travel = l->travel[k];
        if (k < b)
            for (int i = force; i < force + 3; i++) q->z[i] = r->before[i] + share * r->move[i];
        if (travel >= 0) q->z[travel] = r->before[travel] + share * r->move[travel];
    }
}

/* Copies what belongs to a section from one vector (nz,) to another. */
void rs_keep(const rs_line *l, int section, const double *from, double *to)
{
    int a = l->first[section], b = l->last[section], span = l->first_span[section];
    for (int k = a; k <= b; k++) {
        if (k < b) memcpy(to + l->force[span + k - a], from + l->force[span + k - a], 3 * sizeof(double));
        if (l->travel[k] >= 0) to[l->travel[k]] = from[l->travel[k]];
    }
}

/* Kernels of a section at the present point, and its matrix, for rs_section_rates. */
void rs_linearise(const rs_line *l, rs_point *q, int section)
{
    room r = room_of(l, q->work);
    double largest;
    evaluate(l, q, section, &r, &largest);
    eliminate(l, section, &r);
}

/* Rates of a section's algebraic variables, from the kernels as they are. */
void rs_section_rates(const rs_line *l, rs_point *q, int section)
{
    room r = room_of(l, q->work);
    rates_of(l, q, section, &r);
}

/* The kernel of a span at the present point. */
void rs_span(const rs_line *l, const rs_point *q, int span, double *result)
{
    room r = room_of(l, q->work);
    span_at(l, q, span, r.input, result);
}

/* The kernel of a support at the present point, for forces of the rope coming in, on the support, and going out. */
void rs_support(const rs_line *l, const rs_point *q, int k, const double *coming, const double *going, double *result)
{
    room r = room_of(l, q->work);
    double span[6] = {0};
    memcpy(span + 3, coming, 3 * sizeof(double));
    support_at(l, q, k, span, going, r.input, result);
}

/* Solves a section in place; with `rates`, those of its variables too. */
int rs_solve(const rs_line *l, rs_point *q, int section, int rates)
{
    room r = room_of(l, q->work);
    double before = INFINITY, last = INFINITY, taken = 0.0, largest;
    int n = 3 * (l->last[section] - l->first[section]) + 1;
    for (int turn = 0; turn < ITERATIONS; turn++) {
        double norm = evaluate(l, q, section, &r, &largest), size, coming;
        if (turn > 0 && !(norm <= 0.9 * before || (last < 1e-6 && norm <= 1e-12))) {
            size = step(l, section, &r);
            if (last < 1e-6 && size < 1e-8) goto solved; /* rounding is all that is left */
            double share = 0.5;
            /* r.move is the new step: the one that has led here is the way from r.before */
            rs_keep(l, section, q->z, r.move);
            for (int i = 0; i < l->nz; i++) r.move[i] -= r.before[i];
            for (;; share *= 0.5) {
                if (share < 1e-7) return taken > LARGE ? RS_SINGULAR : RS_STUCK;
                put(l, q, section, &r, share);
                norm = evaluate(l, q, section, &r, &largest);
                if (norm <= (1.0 - 0.1 * share) * before) break;
            }
            last = INFINITY;
        }
        size = step(l, section, &r);
        if (!isfinite(size)) return RS_SINGULAR;
        coming = isfinite(last) ? size * (size / last) * (size / last) : 100.0 * size * size;
        rs_keep(l, section, q->z, r.before);
        if (size <= CLOSE || norm <= 1e-15 * sqrt((double)n)) goto solved;
        put(l, q, section, &r, 1.0);
        if (coming <= CLOSE) {
            if (rates) rates_of(l, q, section, &r);
            if (last < 1e-2 && size <= 1e-3 * last && norm <= 1e-6) return RS_OK;
            if (size <= 1e-8) return RS_OK;
            evaluate(l, q, section, &r, &largest);
            if (largest <= SMALL) return RS_OK;
        }
        before = norm;
        last = taken = size;
    }
    return RS_SLOW;
solved:
    rs_keep(l, section, q->z, r.before);
    put(l, q, section, &r, 1.0);
    if (rates) rates_of(l, q, section, &r);
    return RS_OK;
}

int rs_solve_all(const rs_line *l, rs_point *q, int rates)
{
    for (int s = 0; s < l->sections; s++) {
        int failed = rs_solve(l, q, s, rates);
        if (failed) return failed;
    }
    return RS_OK;
}

/* Cases one after the other: each vector of the next one, and its loads in the spans, are `stride` entries behind; those
 * solved are `good`. */
int rs_solve_many(const rs_line *l, rs_point *q, int cases, const long long *stride, unsigned char *good)
{
    for (int i = 0; i < cases; i++) {
        good[i] = rs_solve_all(l, q, 0) == RS_OK;
        q->x += stride[0], q->z += stride[1], q->u += stride[2], q->p += stride[3], q->d += stride[4];
        q->used += stride[5];
    }
    return RS_OK;
}
