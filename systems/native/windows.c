/* Trajectories of drives over a window: in closed form where their rates are linear in their states and in time, else by
 * collocation at its Chebyshev points. Drives at a limit feel the ropes: the sections beside them are solved at each of
 * these points. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define LEAST_WINDOW 1e-5 /* [s] */
#define STEADY 1e-14      /* scaled changes of the states over a window that are rounding */
#define LINEAR 1e-11      /* scaled deviation from rates that are linear */
#define CLOSE 1e-10       /* scaled step of Newton's method that is the last one */
#define RESOLVED 1e-9     /* scaled part of the highest polynomials in a trajectory */
#define FAST 8.0          /* change of the states' rates over a window that a power series follows */
#define ITERATIONS 12
#define SWEEPS 30         /* of drives at a limit, each with the others where they were */
#define BEYOND 1.02       /* a window with ropes ends there, as part of the time until a load crosses, */
#define BEHIND 1e-4       /* and so much later [s] */
#define SWING 2e-3        /* scaled deviation of a tension from its prediction that a drive may feel */
#define GROWTH 4.0        /* most that a window with ropes is longer than the one before */

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

/* Rate of a force of `rs_end_force`. */
static void end_force_rate(const rs_line *l, const rs_point *q, const rs_motion *m, int span, int end, double *rate)
{
    int k = l->start[span];
    double longer = rs_travel_rate(l, q, k) - rs_travel_rate(l, q, k + 1);
    for (int axis = 0; axis < 3; axis++) {
        rate[axis] = q->z_rate[l->force[span] + axis];
        if (end) rate[axis] = -(rate[axis] + longer * m->pull[3 * span + axis]);
    }
}

/* Forces at the ports of a drive at point j of a window, and their derivatives by its states: the sections beside it are
 * solved there. */
static int pull_there(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s,
                      const rs_drive_room *r, int i, int j, double h)
{
    int sections[RS_MOST], count = rs_drive_sections(l, s, i, sections, 0), n = s->states[s->form[i]];
    int first = s->port_first[i], ports = s->port_first[i + 1] - first;
    rs_point there = *q;
    there.x = s->window + j * l->nx, there.x_rate = r->x_rate;
    there.z = r->z + j * l->nz, there.z_rate = r->z_rate;
    there.u = r->u, there.u_rate = r->u_rate;
    for (int c = 0; c < l->nu; c++) there.u[c] = q->u[c] + h * s->nodes[j] * q->u_rate[c], there.u_rate[c] = 0.0;
    for (int k = 0; k < count; k++)
        if (rs_solve(l, &there, sections[k], 0) != RS_OK) return 0;
    rs_pull(l, &there, m, s, r, i);
    memset(there.x_rate, 0, l->nx * sizeof(double));
    for (int a = 0; a < n; a++) {
        there.x_rate[s->x[i] + a] = 1.0;
        for (int k = 0; k < count; k++) rs_section_rates(l, &there, sections[k]);
        for (int port = 0; port < ports; port++) {
            double *by = r->by_state + 3 * (a * ports + port);
            if (s->port_span[first + port] >= 0)
                end_force_rate(l, &there, m, s->port_span[first + port], s->port_end[first + port], by);
            else
                by[0] = by[1] = by[2] = 0.0;
        }
        there.x_rate[s->x[i] + a] = 0.0;
    }
    return 1;
}

/* A step of Newton's method for the states of a drive at the points of a window; `worst` takes its scaled size where that
 * is larger. 0 where there is none. */
static int step(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r, int i,
                double h, double *worst)
{
    int form = s->form[i], n = s->states[form], all = (RS_NODES - 1) * n, forces = 3 * s->ports[form];
    const double *nominal = s->nominal + s->x[i], *by_force = r->result + n * (2 + n + s->inputs[form]);
    memset(r->matrix, 0, all * (all + 1) * sizeof(double));
    for (int j = 1; j < RS_NODES; j++) {
        double *x = s->window + j * l->nx + s->x[i], *rates = s->rates + j * l->nx + s->x[i];
        if (s->limited[i] && !pull_there(l, q, m, s, r, i, j, h)) return 0;
        rs_drive(l, q, m, s, r, i, h * s->nodes[j], x);
        memcpy(rates, r->result, n * sizeof(double));
        for (int a = 0; a < n; a++) {
            double *row = r->matrix + ((j - 1) * n + a) * (all + 1), change = -h * rates[a];
            for (int k = 0; k < RS_NODES; k++) {
                double by = s->derivative[j * RS_NODES + k];
                change += by * (s->window[k * l->nx + s->x[i] + a] - q->x[s->x[i] + a]);
                if (k > 0) row[(k - 1) * n + a] += by;
            }
            for (int b = 0; b < n; b++) {
                double by = r->result[n + a * n + b];
                for (int c = 0; s->limited[i] && c < forces; c++) by += by_force[a * forces + c] * r->by_state[b * forces + c];
                row[(j - 1) * n + b] -= h * by;
            }
            row[all] = -change;
        }
    }
    if (!solve_dense(r->matrix, all, r->right)) return 0;
    for (int j = 1; j < RS_NODES; j++)
        for (int a = 0; a < n; a++) {
            double move = r->right[(j - 1) * n + a];
            s->window[j * l->nx + s->x[i] + a] += move;
            if (!(fabs(move) / nominal[a] <= *worst)) *worst = fabs(move) / nominal[a];
        }
    return isfinite(*worst);
}

/* Newton's method for the states of a drive at the points of a window, which stand there already as they are guessed. */
static int collocate(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r,
                     int i, double h)
{
    for (int turn = 0; turn < ITERATIONS; turn++) {
        double worst = 0.0;
        if (!step(l, q, m, s, r, i, h, &worst)) return 0;
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
static int expand(const rs_point *q, const rs_drives *s, const rs_drive_room *r, int i, double h)
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
    for (k = 1; k < RS_TERMS; k++) {
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

/* A drive where its window starts. */
static void start(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r, int i)
{
    size_t size = s->states[s->form[i]] * sizeof(double);
    rs_pull(l, q, m, s, r, i);
    for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++) {
        memcpy(r->first + 3 * port, r->force + 3 * port, 3 * sizeof(double));
        memset(r->rate + 3 * port, 0, 3 * sizeof(double));
        if (s->port_span[port] >= 0) end_force_rate(l, q, m, s->port_span[port], s->port_end[port], r->rate + 3 * port);
    }
    rs_drive(l, q, m, s, r, i, 0.0, q->x + s->x[i]);
    memcpy(s->window + s->x[i], q->x + s->x[i], size);
    memcpy(s->rates + s->x[i], r->result, size);
    memcpy(q->x_rate + s->x[i], r->result, size);
}

/* Forces at the ports of a drive as their rates at the window's start predict them. */
static void predict(const rs_drives *s, const rs_drive_room *r, int i, double after)
{
    for (int c = 3 * s->port_first[i]; c < 3 * s->port_first[i + 1]; c++) r->force[c] = r->first[c] + after * r->rate[c];
}

/* States and rates of a drive at the points of a window of h seconds. RS_PASSED: a shorter one is needed; RS_COUPLED: a
 * limit is active there. */
static int trajectory(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r,
                      int i, double h)
{
    int form = s->form[i], n = s->states[form], terms, linear = 1;
    start(l, q, m, s, r, i);
    if (s->limited[i] || rs_feels(l, s, r, i)) return RS_COUPLED;
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
    int step = terms > 2 ? 1 : 3; /* what is no parabola may reach a limit and leave it between two of fewer points */
    for (int j = step; j < RS_NODES && linear; j += step) {
        predict(s, r, i, h * s->nodes[j]);
        rs_drive(l, q, m, s, r, i, h * s->nodes[j], s->window + j * l->nx + s->x[i]);
        for (int a = 0; a < n; a++) {
            double away = h * fabs(r->result[a] - s->rates[j * l->nx + s->x[i] + a]) / s->nominal[s->x[i] + a];
            linear = linear && away <= LINEAR;
        }
        if (linear && rs_feels(l, s, r, i)) return RS_COUPLED;
    }
    predict(s, r, i, 0.0);
    if (!linear && !collocate(l, q, m, s, r, i, h)) return RS_PASSED;
    if (terms > 2 || !linear) /* else a polynomial already */
        if (!resolved(l, s, i, h)) return RS_PASSED;
    for (int j = 1; j < RS_NODES && !linear && s->tied[form]; j++)
        for (int now = 1; now >= 0; now--) { /* it is moved with the forces as they are now */
            predict(s, r, i, now ? 0.0 : h * s->nodes[j]);
            rs_drive(l, q, m, s, r, i, h * s->nodes[j], s->window + j * l->nx + s->x[i]);
            if (rs_feels(l, s, r, i)) return RS_COUPLED;
        }
    return RS_REACHED;
}

/* The sections beside drives at a limit, solved where the window starts, with their rates. */
static int solve_beside(const rs_line *l, rs_point *q, rs_motion *m, const rs_drives *s)
{
    int sections[RS_MOST], count;
    for (int i = 0; i < s->drives; i++) {
        count = s->limited[i] ? rs_drive_sections(l, s, i, sections, 0) : 0;
        for (int k = 0; k < count; k++) {
            if ((m->failure = rs_solve(l, q, sections[k], 1)) != RS_OK) return RS_FAILED;
            m->touched[sections[k]] = 1;
        }
    }
    return RS_REACHED;
}

/* Whether a drive beside those at a limit comes to its own within the window, from now on `limited`: RS_COUPLED. */
static int drawn_in(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r,
                    double h)
{
    int sections[RS_MOST], code = RS_REACHED;
    for (int i = 0; i < s->drives; i++) {
        if (s->limited[i] || !s->tied[s->form[i]]) continue;
        int count = rs_drive_sections(l, s, i, sections, 0);
        if (!rs_limited(l, s, sections, count)) continue;
        for (int j = 1; j < RS_NODES && !s->limited[i]; j++) {
            if (!pull_there(l, q, m, s, r, i, j, h)) return RS_PASSED;
            rs_drive(l, q, m, s, r, i, h * s->nodes[j], s->window + j * l->nx + s->x[i]);
            if (rs_feels(l, s, r, i)) s->limited[i] = 1, code = RS_COUPLED;
        }
    }
    return code;
}

/* Trajectories of all drives at a limit over a window of h seconds, in which no load crosses. RS_PASSED: a shorter one is
 * needed; RS_COUPLED: more drives come to a limit. */
static int with_ropes(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r,
                      double h)
{
    double worst = INFINITY;
    for (int j = 1; j < RS_NODES; j++) {
        for (int i = 0; i < l->nz; i++) r->z[j * l->nz + i] = q->z[i] + h * s->nodes[j] * q->z_rate[i];
        for (int i = 0; i < s->drives; i++)
            for (int x = s->x[i]; s->limited[i] && x < s->x[i] + s->states[s->form[i]]; x++)
                s->window[j * l->nx + x] = q->x[x] + h * s->nodes[j] * q->x_rate[x];
    }
    for (int sweep = 0; sweep < SWEEPS && worst > CLOSE; sweep++) {
        worst = 0.0;
        for (int i = 0; i < s->drives; i++)
            if (s->limited[i] && !step(l, q, m, s, r, i, h, &worst)) return RS_PASSED;
    }
    if (worst > CLOSE) return RS_PASSED;
    for (int i = 0; i < s->drives; i++)
        if (s->limited[i] && !resolved(l, s, i, h)) return RS_PASSED;
    return drawn_in(l, q, m, s, r, h);
}

/* The window of all drives from now on: to `end`, or shorter where a drive changes fast. Those at a limit move `with` the
 * sections beside them, else RS_COUPLED. */
static int window(const rs_line *l, rs_point *q, rs_motion *m, rs_drives *s, double end, int with)
{
    rs_drive_room r = rs_room_of(l, s);
    double h = end - m->time;
    m->begin = m->time;
    m->window = s->window;
    m->window_rates = s->rates;
    for (;;) {
        int code = RS_REACHED, limits = rs_limited(l, s, 0, 0);
        for (int i = 0; i < s->drives && code != RS_PASSED; i++)
            if ((code = trajectory(l, q, m, s, &r, i, h)) == RS_COUPLED) s->limited[i] = limits = 1;
        if (limits && code != RS_PASSED) {
            rs_coming next;
            double most = GROWTH * s->last;
            if (!with) return RS_COUPLED;
            if ((code = solve_beside(l, q, m, s)) != RS_REACHED) return code;
            rs_foresee(l, q, m, 0, 0);
            if (rs_next(l, q, m, &next) && next.time >= 0.0) most = fmin(most, BEYOND * next.time + BEHIND);
            if (h > most) {
                h = most;
                continue;
            }
            if ((code = with_ropes(l, q, m, s, &r, h)) == RS_COUPLED) continue;
            if (code == RS_REACHED) s->last = h;
        }
        m->h = h;
        if (code != RS_PASSED) return RS_REACHED;
        if (h < LEAST_WINDOW) return RS_ASTRAY;
        h *= 0.5;
    }
}

int rs_drive_window(const rs_line *l, rs_point *q, rs_motion *m, rs_drives *s, double end)
{
    return window(l, q, m, s, end, 1);
}

/* Entry `c` of the unknowns at a part of a window of h seconds, by the cubic polynomial through both ends. */
static double between(const rs_point *q, const double *z, const double *rate, int c, double h, double part)
{
    double far = 1.0 - part;
    return far * far * ((1.0 + 2.0 * part) * z[c] + part * h * rate[c]) +
           part * part * ((1.0 + 2.0 * far) * q->z[c] - far * h * q->z_rate[c]);
}

/* Whether a drive that has moved by itself came to a limit since the window's start, where the unknowns and their rates
 * were these: looked at where the tensions beside it are not as predicted. From now on it is `limited`. */
int rs_swung(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const double *z,
             const double *rate)
{
    rs_drive_room r = rs_room_of(l, s);
    double h = m->time - m->begin;
    int found = 0;
    for (int i = 0; i < s->drives; i++) {
        int swings = 0;
        if (!s->tied[s->form[i]] || s->limited[i]) continue;
        for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++) {
            int span = s->port_span[port], c = span < 0 ? 0 : l->force[span];
            for (int axis = 0; span >= 0 && axis < 3; axis++)
                if (fabs(q->z[c + axis] - z[c + axis] - h * rate[c + axis]) > SWING * l->z_nominal[c + axis]) swings = 1;
            if (span >= 0 && m->touched[l->section_of[span]]) swings = -RS_NODES;
        }
        for (int j = 1; j < RS_NODES && swings > 0 && !s->limited[i]; j++) {
            rs_point there = *q;
            there.x = s->window + j * l->nx, there.z = r.z;
            if (s->nodes[j] * m->h > h) break;
            for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++) {
                int span = s->port_span[port], k = span < 0 ? 0 : l->start[span];
                int places[5] = {l->force[span < 0 ? 0 : span], 0, 0, l->travel[k], l->travel[k + 1]};
                places[1] = places[0] + 1, places[2] = places[0] + 2;
                for (int n = 0; span >= 0 && n < 5; n++)
                    if (places[n] >= 0) r.z[places[n]] = between(q, z, rate, places[n], h, s->nodes[j] * m->h / h);
            }
            rs_pull(l, &there, m, s, &r, i);
            rs_drive(l, q, m, s, &r, i, s->nodes[j] * m->h - h, there.x + s->x[i]);
            if (rs_feels(l, s, &r, i)) found = s->limited[i] = 1;
        }
    }
    return found;
}

/* The window of drives that move by themselves. */
int rs_window(const rs_line *l, rs_point *q, rs_motion *m, rs_drives *s, double end)
{
    memset(s->limited, 0, s->drives * sizeof(int));
    int code = window(l, q, m, s, end, 0);
    memset(s->limited, 0, s->drives * sizeof(int));
    return code;
}
