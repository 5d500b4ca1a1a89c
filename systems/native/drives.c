/* Trajectories of drives over a window: in closed form where their rates are linear in their states and in time, else by
 * collocation at its Chebyshev points. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define LEAST_WINDOW 1e-4 /* [s] */
#define FELT 1e-9         /* rate per scaled force that says that a limit is active */
#define STEADY 1e-14      /* scaled changes of the states over a window that are rounding */
#define LINEAR 1e-11      /* scaled deviation from rates that are linear */
#define CLOSE 1e-10       /* scaled step of Newton's method that is the last one */
#define RESOLVED 1e-9     /* scaled part of the highest polynomials in a trajectory */
#define FAST 8.0          /* change of the states' rates over a window that a power series follows */
#define TERMS 60
#define ITERATIONS 12

/* Room for one drive. */
typedef struct {
    double *v, *result, *force; /* of its kernel; forces at its ports, of all drives */
    double *series, *rates, *matrix, *right;
} room;

static int inputs_of(const rs_line *l, const rs_drives *s, int form)
{
    return 1 + l->ns + s->states[form] + s->inputs[form] + s->parameters[form] + s->discrete[form] + 3 * s->ports[form];
}

static int results_of(const rs_drives *s, int form)
{
    int n = s->states[form];
    return n * (2 + n + s->inputs[form] + 3 * s->ports[form]);
}

static void sizes(const rs_line *l, const rs_drives *s, int *inputs, int *results)
{
    *inputs = *results = 1;
    for (int i = 0; i < s->drives; i++) {
        int a = inputs_of(l, s, s->form[i]), b = results_of(s, s->form[i]);
        if (a > *inputs) *inputs = a;
        if (b > *results) *results = b;
    }
}

int rs_drives_size(const rs_line *l, const rs_drives *s)
{
    int inputs, results, n = (RS_NODES - 1) * s->most;
    sizes(l, s, &inputs, &results);
    return inputs + results + 3 * s->port_first[s->drives] + (TERMS + 2) * s->most + RS_NODES * s->most + n * (n + 1) + n;
}

static room room_of(const rs_line *l, const rs_drives *s)
{
    room r;
    int inputs, results, n = (RS_NODES - 1) * s->most;
    sizes(l, s, &inputs, &results);
    r.v = s->work;
    r.result = r.v + inputs;
    r.force = r.result + results;
    r.series = r.force + 3 * s->port_first[s->drives];
    r.rates = r.series + (TERMS + 2) * s->most;
    r.matrix = r.rates + RS_NODES * s->most;
    r.right = r.matrix + n * (n + 1);
    return r;
}

/* The kernel of a drive `after` some time with its states `x`, and inputs that follow their rates. */
static void evaluate(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const room *r, int i,
                     double after, const double *x)
{
    int form = s->form[i];
    double *to = r->v;
    *to++ = m->time + after;
    for (int j = 0; j < l->ns; j++) *to++ = l->shared[j] < l->np ? q->p[l->shared[j]] : q->u[l->shared[j] - l->np];
    memcpy(to, x, s->states[form] * sizeof(double)), to += s->states[form];
    for (int j = s->u[i]; j < s->u[i] + s->inputs[form]; j++) *to++ = q->u[j] + after * q->u_rate[j];
    memcpy(to, q->p + s->p[i], s->parameters[form] * sizeof(double)), to += s->parameters[form];
    memcpy(to, q->d + s->d[i], s->discrete[form] * sizeof(double)), to += s->discrete[form];
    memcpy(to, r->force + 3 * s->port_first[i], 3 * s->ports[form] * sizeof(double));
    s->kernels[form](r->v, r->result);
}

static void pull(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const room *r, int i)
{
    for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++) {
        double *force = r->force + 3 * port;
        if (s->port_span[port] >= 0)
            rs_end_force(l, q, m, s->port_span[port], s->port_end[port], force);
        else
            force[0] = force[1] = force[2] = 0.0;
    }
}

/* Whether the rates of a drive in r->result depend on the forces at its ports. */
static int feels(const rs_line *l, const rs_drives *s, const room *r, int i)
{
    int form = s->form[i], n = s->states[form], columns = 3 * s->ports[form];
    const double *by = r->result + n * (2 + n + s->inputs[form]);
    for (int row = 0; row < n; row++)
        for (int c = 0; c < columns; c++) {
            int span = s->port_span[s->port_first[i] + c / 3];
            if (span >= 0 && !(fabs(by[row * columns + c]) * l->z_nominal[l->force[span] + c % 3] < FELT)) return 1;
        }
    return 0;
}

static int beside(const rs_line *l, const rs_drives *s, int i, const int *sections, int count)
{
    for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++)
        for (int k = 0; k < count; k++)
            if (s->port_span[port] >= 0 && l->section_of[s->port_span[port]] == sections[k]) return 1;
    return 0;
}

/* Whether the rates of a drive beside some sections, or of any, depend on the ropes here. */
int rs_coupled(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const int *sections, int count)
{
    room r = room_of(l, s);
    for (int i = 0; i < s->drives; i++) {
        if (!s->tied[s->form[i]] || (sections && !beside(l, s, i, sections, count))) continue;
        pull(l, q, m, s, &r, i);
        evaluate(l, q, m, s, &r, i, 0.0, q->x + s->x[i]);
        if (feels(l, s, &r, i)) return 1;
    }
    return 0;
}

/* Rates of all states here. */
int rs_rates(const rs_line *l, rs_point *q, const rs_motion *m, const rs_drives *s)
{
    room r = room_of(l, s);
    for (int i = 0; i < s->drives; i++) {
        pull(l, q, m, s, &r, i);
        evaluate(l, q, m, s, &r, i, 0.0, q->x + s->x[i]);
        memcpy(q->x_rate + s->x[i], r.result, s->states[s->form[i]] * sizeof(double));
    }
    return RS_REACHED;
}

/* Solves the linear system whose matrix and right-hand side stand in rows of n + 1; the solution is in `x`. */
static int solve_dense(double *a, int n, double *x)
{
    for (int k = 0; k < n; k++) {
        int best = k, w = n + 1;
        for (int i = k + 1; i < n; i++)
            if (fabs(a[i * w + k]) > fabs(a[best * w + k])) best = i;
        if (!(fabs(a[best * w + k]) > 0.0)) return 0;
        for (int j = k; best != k && j <= n; j++) {
            double t = a[k * w + j];
            a[k * w + j] = a[best * w + j];
            a[best * w + j] = t;
        }
        for (int i = k + 1; i < n; i++) {
            double share = a[i * w + k] / a[k * w + k];
            for (int j = k + 1; share != 0.0 && j <= n; j++) a[i * w + j] -= share * a[k * w + j];
        }
    }
    for (int i = n - 1; i >= 0; i--) {
        x[i] = a[i * (n + 1) + n];
        for (int j = i + 1; j < n; j++) x[i] -= a[i * (n + 1) + j] * x[j];
        x[i] /= a[i * (n + 1) + i];
    }
    return 1;
}

/* Newton's method for the states at the points of a window, which stand there already as they are guessed. */
static int collocate(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const room *r, int i,
                     double h)
{
    int form = s->form[i], n = s->states[form], all = (RS_NODES - 1) * n;
    const double *nominal = s->nominal + s->x[i];
    for (int turn = 0; turn < ITERATIONS; turn++) {
        double worst = 0.0;
        memset(r->matrix, 0, all * (all + 1) * sizeof(double));
        for (int j = 1; j < RS_NODES; j++) {
            double *x = s->window + j * l->nx + s->x[i], *rates = s->rates + j * l->nx + s->x[i];
            evaluate(l, q, m, s, r, i, h * s->nodes[j], x);
            memcpy(rates, r->result, n * sizeof(double));
            for (int a = 0; a < n; a++) {
                double *row = r->matrix + ((j - 1) * n + a) * (all + 1), change = -h * rates[a];
                for (int k = 0; k < RS_NODES; k++) {
                    double by = s->derivative[j * RS_NODES + k];
                    change += by * (s->window[k * l->nx + s->x[i] + a] - q->x[s->x[i] + a]);
                    if (k > 0) row[(k - 1) * n + a] += by;
                }
                for (int b = 0; b < n; b++) row[(j - 1) * n + b] -= h * r->result[n + a * n + b];
                row[all] = -change;
            }
        }
        if (!solve_dense(r->matrix, all, r->right)) return 0;
        for (int j = 1; j < RS_NODES; j++)
            for (int a = 0; a < n; a++) {
                double move = r->right[(j - 1) * n + a];
                s->window[j * l->nx + s->x[i] + a] += move;
                if (!(fabs(move) / nominal[a] <= worst)) worst = fabs(move) / nominal[a];
            }
        if (!isfinite(worst)) return 0;
        if (worst <= CLOSE) return 1;
    }
    return 0;
}

/* Whether a polynomial of the window's degree follows the states of a drive. The rates at the window's start, where it
 * is not made to agree, show what changes before the next point. */
static int resolved(const rs_line *l, const rs_drives *s, int i, double h)
{
    for (int a = s->x[i]; a < s->x[i] + s->states[s->form[i]]; a++) {
        double last = 0.0, before = 0.0, start = -h * s->rates[a];
        for (int j = 0; j < RS_NODES; j++) {
            double moved = s->window[j * l->nx + a] - s->window[a], part = s->weights[j] * moved;
            last += part / (RS_NODES - 1);
            before += 2.0 * part * (1.0 - 2.0 * s->nodes[j]) / (RS_NODES - 1);
            start += s->derivative[j] * moved;
        }
        if (!(fabs(last) + fabs(before) <= RESOLVED * s->nominal[a])) return 0;
        if (!(fabs(start) <= (RS_NODES - 1) * (RS_NODES - 1) * RESOLVED * s->nominal[a])) return 0;
    }
    return 1;
}

/* The power series of states whose rates are linear, from the kernel's results at the window's start; its coefficients
 * for a time of one in units of h are in r->series by state. Returns their number, 0 where the states change too fast. */
static int expand(const rs_point *q, const rs_drives *s, const room *r, int i, double h)
{
    int form = s->form[i], n = s->states[form], nu = s->inputs[form], k;
    const double *by_x = r->result + n, *by_u = by_x + n * n, *by_time = by_u + n * nu;
    double *c = r->series, size = 0.0;
    for (int a = 0; a < n; a++) {
        double row = 0.0;
        for (int b = 0; b < n; b++) row += fabs(by_x[a * n + b]) * s->nominal[s->x[i] + b] / s->nominal[s->x[i] + a];
        if (row > size) size = row;
        c[a] = h * r->result[a];
    }
    for (k = 1; k < TERMS; k++) {
        double largest = 0.0;
        for (int a = 0; a < n; a++) {
            double next = 0.0;
            for (int b = 0; b < n; b++) next += by_x[a * n + b] * c[(k - 1) * n + b];
            if (k == 1) {
                next += h * by_time[a];
                for (int j = 0; j < nu; j++) next += h * by_u[a * nu + j] * q->u_rate[s->u[i] + j];
            }
            c[k * n + a] = h * next / (k + 1);
            next = fabs(c[k * n + a]) / s->nominal[s->x[i] + a];
            if (!(next <= largest)) largest = next;
        }
        if (largest <= STEADY) return k;
        if (size * h > FAST) return 0;
    }
    return isfinite(size) ? k : 0;
}

/* States and rates of a drive at the points of a window of h seconds. RS_PASSED: a shorter one is needed. */
static int trajectory(const rs_line *l, const rs_point *q, const rs_motion *m, rs_drives *s, const room *r, int i, double h)
{
    int form = s->form[i], n = s->states[form], terms, linear = 1;
    pull(l, q, m, s, r, i);
    evaluate(l, q, m, s, r, i, 0.0, q->x + s->x[i]);
    if (s->tied[form] && feels(l, s, r, i)) return RS_COUPLED;
    memcpy(s->window + s->x[i], q->x + s->x[i], n * sizeof(double));
    memcpy(s->rates + s->x[i], r->result, n * sizeof(double));
    memcpy(q->x_rate + s->x[i], r->result, n * sizeof(double));
    if (!(terms = expand(q, s, r, i, h))) return RS_PASSED;
    for (int j = 1; j < RS_NODES; j++)
        for (int a = 0; a < n; a++) {
            double x = 0.0, rate = 0.0, tau = s->nodes[j];
            for (int k = terms - 1; k >= 0; k--) {
                x = x * tau + r->series[k * n + a];
                rate = rate * tau + (k + 1) * r->series[k * n + a];
            }
            s->window[j * l->nx + s->x[i] + a] = q->x[s->x[i] + a] + tau * x;
            s->rates[j * l->nx + s->x[i] + a] = rate / h;
        }
    int step = terms > 2 ? 1 : 3; /* what is no parabola can reach a limit and leave it between two points */
    for (int j = step; j < RS_NODES && linear; j += step) {
        evaluate(l, q, m, s, r, i, h * s->nodes[j], s->window + j * l->nx + s->x[i]);
        for (int a = 0; a < n; a++) {
            double away = h * fabs(r->result[a] - s->rates[j * l->nx + s->x[i] + a]) / s->nominal[s->x[i] + a];
            linear = linear && away <= LINEAR;
        }
        if (linear && s->tied[form] && feels(l, s, r, i)) return RS_COUPLED;
    }
    if (!linear && !collocate(l, q, m, s, r, i, h)) return RS_PASSED;
    if (terms > 2 || !linear) /* else a polynomial already */
        if (!resolved(l, s, i, h)) return RS_PASSED;
    for (int j = 3; j < RS_NODES && !linear && s->tied[form]; j += 3) {
        evaluate(l, q, m, s, r, i, h * s->nodes[j], s->window + j * l->nx + s->x[i]);
        if (feels(l, s, r, i)) return RS_COUPLED;
    }
    return RS_REACHED;
}

/* The window of all drives from now on: to `end`, or shorter where a drive changes fast. */
int rs_window(const rs_line *l, rs_point *q, rs_motion *m, rs_drives *s, double end)
{
    room r = room_of(l, s);
    double h = end - m->time;
    m->begin = m->time;
    m->window = s->window;
    m->window_rates = s->rates;
    for (;;) {
        int code = RS_REACHED;
        for (int i = 0; i < s->drives && code == RS_REACHED; i++) code = trajectory(l, q, m, s, &r, i, h);
        m->h = h;
        if (code != RS_PASSED) return code;
        if (h < LEAST_WINDOW) return RS_ASTRAY;
        h *= 0.5;
    }
}
