/* A system with inertia in time: consistent points by Newton's method, steps by the Rosenbrock method Rodas5P.
 *
 * Rodas5P has order 5(4) and eight stages, is L-stable and stiffly accurate, and keeps its order for equations of index
 * 1: G. Steinebach, Construction of Rosenbrock-Wanner method Rodas5P and numerical benchmarks within the Julia
 * Differential Equations package, BIT 63 (2023) 27. A step needs one matrix and no iterations; it depends on nothing
 * before it, so that an event costs no restart. */
#include <math.h>
#include <string.h>
#include "inertial.h"

#define STAGES 8
#define ITERATIONS 30
#define CLOSE 1e-10   /* scaled move of the last iteration of Newton's method */
#define ROUNDED 1e-6   /* below this a move that does not become smaller is rounding */
#define CHORD 1e-4    /* below this its next iteration has the same matrix */
#define APART 1e-5    /* time over which rates are differences [s] */
#define LONGEST 0.5   /* longest step [s] */
#define NEAR 1e-7     /* how near to a bound a watched state is there [m] */

static const double GAMMA = 0.21193756319429014;
static const double A[STAGES][STAGES] = {
    {0},
    {3.0},
    {2.849394379747939, 0.45842242204463923},
    {-6.954028509809101, 2.489845061869568, -10.358996098473584},
    {2.8029986275628964, 0.5072464736228206, -0.3988312541770524, -0.04721187230404641},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 1.0},
    {-7.502846399306121, 2.561846144803919, -11.627539656261098, -0.18268767659942256, 0.030198172008377946, 1.0, 1.0},
};
static const double C[STAGES][STAGES] = {
    {0},
    {-14.155112264123755},
    {-17.97296035885952, -2.859693295451294},
    {147.12150275711716, -1.41221402718213, 71.68940251302358},
    {165.43517024871676, -0.4592823456491126, 42.90938336958603, -5.961986721573306},
    {24.854864614690072, -3.0009227002832186, 47.4931110020768, 5.5814197821558125, -0.6610691825249471},
    {30.91273214028599, -3.1208243349937974, 77.79954646070892, 34.28646028294783, -19.097331116725623,
     -28.087943162872662},
    {37.80277123390563, -3.2571969029072276, 112.26918849496327, 66.9347231244047, -40.06618937091002,
     -54.66780262877968, -9.48861652309627},
};
static const double AT[STAGES] = {0.0, 0.6358126895828704, 0.4095798393397535, 0.9769306725060716, 0.4288403609558664,
                                  1.0, 1.0, 1.0};
static const double D[STAGES] = {0.21193756319429014, -0.42387512638858027, -0.3384627126235924, 1.8046452872882734,
                                 2.325825639765069};

/* Sets the inputs of y to their values `h` seconds after the point. */
static void put_inputs(const ri_line *l, ri_point *q, double h)
{
    double *u = q->y + l->nx + l->nz;
    for (int i = 0; i < l->nu; i++) u[i] = q->u[i] + h * q->u_rate[i];
}

/* Norm of the scaled residuals. */
static double residual(const ri_line *l, ri_point *q)
{
    double sum = 0.0, largest = -1.0;
    for (int i = 0; i < l->nz; i++) {
        double e = fabs(q->value[l->nx + i] * l->r_scale[i]);
        sum += e * e;
        if (!(e <= largest)) largest = e, q->worst = i;
    }
    return sqrt(sum);
}

/* Moves the algebraic variables of y from `start` by a share of `move`; returns the norm there. */
static double moved(const ri_line *l, ri_point *q, const double *start, const double *move, double share)
{
    for (int i = 0; i < l->nz; i++) q->y[l->nx + i] = start[i] + share * move[l->nx + i];
    ri_evaluate(l, q);
    return residual(l, q);
}

/* Newton's method for the algebraic variables of y; the matrix for c = 0 is left behind. */
static int consistent(const ri_line *l, ri_point *q)
{
    double *move = q->room + 2 * l->nz + l->unknowns, *start = move + l->nx + l->nz, before, last = 1e300;
    int fresh = 0;
    ri_evaluate(l, q);
    before = residual(l, q);
    for (int k = 0; k < ITERATIONS; k++) {
        double largest = 0.0, share = 1.0, norm;
        if (!(before < 1e300)) return RI_STUCK;
        if (!fresh && ri_factor(l, q, 0.0)) return RI_SINGULAR;
        memset(move, 0, l->nx * sizeof(double));
        memcpy(move + l->nx, q->value + l->nx, l->nz * sizeof(double));
        ri_apply(l, q, 0.0, move);
        for (int i = 0; i < l->nz; i++) largest = fmax(largest, fabs(move[l->nx + i] / l->z_nominal[i]));
        memcpy(start, q->y + l->nx, l->nz * sizeof(double));
        norm = moved(l, q, start, move, share);
        while (!(norm <= before) && largest > ROUNDED && share > 1e-6) norm = moved(l, q, start, move, share /= 2.0);
        if (largest <= CLOSE || (largest < ROUNDED && largest > last / 4.0)) return RI_OK;
        if (share <= 1e-6) return RI_STUCK;
        before = norm, last = largest, fresh = largest < CHORD;
    }
    return RI_SLOW;
}

/* Rates of the algebraic variables at a consistent point y, with the matrix for c = 0. */
static void find_rates(const ri_line *l, ri_point *q)
{
    int n = l->nx + l->nz;
    double *side = q->room + 2 * l->nz + l->unknowns, *x = side + n;
    memcpy(q->x_rate, q->value, l->nx * sizeof(double));
    memcpy(x, q->y, l->nx * sizeof(double));
    for (int way = 1; way >= -1; way -= 2) {
        for (int i = 0; i < l->nx; i++) q->y[i] = x[i] + way * APART * q->x_rate[i];
        put_inputs(l, q, way * APART);
        ri_evaluate(l, q);
        for (int i = l->nx; i < n; i++) side[i] = way > 0 ? q->value[i] : (side[i] - q->value[i]) / (2.0 * APART);
    }
    memset(side, 0, l->nx * sizeof(double));
    ri_apply(l, q, 0.0, side);
    memcpy(q->z_rate, side + l->nx, l->nz * sizeof(double));
}

int ri_solve(const ri_line *l, ri_point *q)
{
    int failed;
    ri_load(l, q);
    failed = consistent(l, q);
    if (failed) return failed;
    memcpy(q->z, q->y + l->nx, l->nz * sizeof(double));
    find_rates(l, q);
    return RI_OK;
}

/* A step of h seconds from `y0`, whose rates and residuals are `first`, to y; the error relative to the tolerance. */
static int step(const ri_line *l, ri_point *q, const ri_run *run, double h, const double *y0, const double *first,
                const double *drift, double *error)
{
    int n = l->nx + l->nz;
    double *stage = q->room + 2 * l->nz + l->unknowns + 3 * n, sum = 0.0;
    double begin = run->time;
    if (ri_factor(l, q, GAMMA * h)) return RI_SINGULAR;
    for (int s = 0; s < STAGES; s++) {
        double *own = stage + s * n;
        const double *value = first;
        if (s > 0) {
            memcpy(q->y, y0, n * sizeof(double));
            for (int j = 0; j < s; j++)
                for (int i = 0; i < n; i++) q->y[i] += A[s][j] * stage[j * n + i];
            put_inputs(l, q, begin + AT[s] * h);
            ri_evaluate(l, q);
            value = q->value;
        }
        for (int i = 0; i < n; i++) own[i] = value[i] + (D[s] != 0.0 ? D[s] * h * drift[i] : 0.0);
        for (int j = 0; j < s; j++)
            for (int i = 0; i < l->nx; i++) own[i] += C[s][j] / h * stage[j * n + i];
        ri_apply(l, q, GAMMA * h, own);
    }
    const double *last = stage + (STAGES - 1) * n;
    for (int i = 0; i < n; i++) q->y[i] += last[i];
    for (int i = 0; i < l->nx; i++) {
        double e = last[i] / l->x_nominal[i];
        sum += e * e;
    }
    *error = sqrt(sum / (l->nx > 0 ? l->nx : 1)) / run->tolerance;
    return *error < 1e300 ? RI_OK : RI_STUCK;
}

/* Rates and residuals at y into `first`, and by how much inputs change these [per s] into `drift`. */
static void look(const ri_line *l, ri_point *q, double time, double *first, double *drift)
{
    int n = l->nx + l->nz, moving = 0;
    for (int i = 0; i < l->nu; i++) moving = moving || q->u_rate[i] != 0.0;
    memset(drift, 0, n * sizeof(double));
    for (int way = 1; moving && way >= -1; way -= 2) {
        put_inputs(l, q, time + way * APART);
        ri_evaluate(l, q);
        for (int i = 0; i < n; i++) drift[i] += way * q->value[i] / (2.0 * APART);
    }
    put_inputs(l, q, time);
    ri_evaluate(l, q);
    memcpy(first, q->value, n * sizeof(double));
}

/* The time after which a watched state is at its bound, seen from `x` with its rates; at most h [s]. */
static double until_bound(const ri_run *run, const double *x, const double *rate, double h)
{
    for (int i = 0; i < run->watches; i++) {
        double v = rate[run->watched[i]], gap = (v > 0.0 ? run->high[i] : run->low[i]) - x[run->watched[i]];
        if (v != 0.0 && gap * v > 0.0 && gap / v < h) h = gap / v;
    }
    return h;
}

/* The time after which a watched state that has moved from `x`, with its rates there, to `to` in h seconds is at its
 * bound, by the parabola through both. */
static double back_to_bound(const ri_run *run, int which, const double *x, const double *rate, const double *to, double h)
{
    int place = run->watched[which];
    double way = to[place] - x[place], gap = (way > 0.0 ? run->high[which] : run->low[which]) - x[place];
    double v = rate[place] * h, curve = way - v, root = v * v + 4.0 * curve * gap, share = gap / way;
    if (root > 0.0 && way * (v + copysign(sqrt(root), way)) > 0.0) share = 2.0 * gap / (v + copysign(sqrt(root), way));
    return h * (share > 0.0 && share < 1.0 ? share : fmin(0.95, fmax(0.02, gap / way)));
}

/* The watched state that is farthest beyond a bound, and by how much [m]. */
static double beyond(const ri_run *run, const double *x, int *which)
{
    double most = -1e300;
    for (int i = 0; i < run->watches; i++) {
        double at = x[run->watched[i]], over = fmax(at - run->high[i], run->low[i] - at);
        if (over > most) most = over, *which = i;
    }
    return most;
}

/* Writes down where the run is. */
static void note(const ri_line *l, ri_run *run, const double *x, const double *z, const double *x_rate)
{
    double *row = run->trace;
    if (!row) return;
    row += run->steps * (1 + 2 * l->nx + l->nz);
    *row++ = run->time;
    memcpy(row, x, l->nx * sizeof(double));
    memcpy(row + l->nx, z, l->nz * sizeof(double));
    memcpy(row + l->nx + l->nz, x_rate, l->nx * sizeof(double));
}

int ri_move(const ri_line *l, ri_point *q, ri_run *run)
{
    int n = l->nx + l->nz, failed = RI_OK, rejected = 0, which = -1, full = 0;
    double *y0 = q->room + 2 * l->nz + l->unknowns, *first = y0 + n, *drift = first + n, error, end = run->stop;
    run->steps = run->rejected = 0, run->hit = -1;
    ri_load(l, q);
    while (run->hit < 0 && !full && end - run->time > 1e-12 * (1.0 + fabs(end))) {
        double left = end - run->time, h = fmin(run->h, LONGEST), over;
        look(l, q, run->time, first, drift);
        memcpy(y0, q->y, n * sizeof(double));
        note(l, run, y0, y0 + l->nx, first);
        if (!rejected) h = until_bound(run, y0, first, h);
        h = fmax(h, run->shortest);
        h = h > left * 0.9999 ? left : h > left / 2.0 ? left / 2.0 : h;
        failed = step(l, q, run, h, y0, first, drift, &error);
        if (failed || error > 1.0) {
            if (h <= run->shortest) break;
            run->h = h * (failed ? 0.25 : fmax(0.2, 0.9 * pow(error, -0.2)));
            memcpy(q->y, y0, n * sizeof(double));
            run->rejected++, rejected = 1;
            continue;
        }
        over = beyond(run, q->y, &which);
        if (over > NEAR && h > 2.0 * run->shortest) { /* again, to the bound */
            run->h = back_to_bound(run, which, y0, first, q->y, h);
            memcpy(q->y, y0, n * sizeof(double));
            rejected = 1;
            continue;
        }
        if (over >= -NEAR) run->hit = which;
        run->time += h, run->steps++;
        full = run->trace && run->steps + 1 >= run->room;
        double grown = h * fmin(rejected ? 1.0 : 5.0, fmax(0.2, 0.9 * pow(fmax(error, 1e-6), -0.2)));
        run->h = h < run->h ? fmax(run->h, grown) : grown;
        rejected = 0;
    }
    if (failed || (end - run->time > 1e-9 && run->hit < 0 && !full)) return failed ? failed : RI_SHORT;
    memcpy(q->x, q->y, l->nx * sizeof(double));
    memcpy(q->u, q->y + l->nx + l->nz, l->nu * sizeof(double));
    if (run->hit < 0 && end - run->time <= 1e-9) run->time = end;
    put_inputs(l, q, 0.0);
    failed = consistent(l, q);
    if (failed) return failed;
    memcpy(q->z, q->y + l->nx, l->nz * sizeof(double));
    find_rates(l, q);
    note(l, run, q->x, q->z, q->x_rate);
    return RI_OK;
}
