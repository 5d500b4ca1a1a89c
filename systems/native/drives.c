/* Rates of drives, from the kernels of their equations and the forces of the ropes at their ports. */
#include <math.h>
#include <string.h>
#include "moving.h"

#define FELT 1e-9 /* rate per scaled force that says that a limit is active */

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

/* Divides `work`; returns how much of it there is. */
static double *divide(const rs_line *l, const rs_drives *s, double *work, rs_drive_room *r)
{
    int inputs, results, n = (RS_NODES - 1) * s->most, ports = 3 * s->port_first[s->drives];
    sizes(l, s, &inputs, &results);
    r->v = work, work += inputs;
    r->result = work, work += results;
    r->force = work, work += ports;
    r->by_state = work, work += ports * s->most;
    r->series = work, work += RS_TERMS * s->most;
    r->matrix = work, work += n * (n + 1);
    r->right = work, work += n;
    r->z = work, work += RS_NODES * l->nz;
    r->z_rate = work, work += l->nz;
    r->x_rate = work, work += l->nx;
    r->u = work, work += l->nu;
    r->u_rate = work, work += l->nu;
    return work;
}

int rs_drives_size(const rs_line *l, const rs_drives *s)
{
    rs_drive_room r;
    double *none = 0;
    return (int)(divide(l, s, none, &r) - none);
}

rs_drive_room rs_room_of(const rs_line *l, const rs_drives *s)
{
    rs_drive_room r;
    divide(l, s, s->work, &r);
    return r;
}

void rs_drive(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r, int i,
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

void rs_pull(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const rs_drive_room *r, int i)
{
    for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++) {
        double *force = r->force + 3 * port;
        if (s->port_span[port] >= 0)
            rs_end_force(l, q, m, s->port_span[port], s->port_end[port], force);
        else
            force[0] = force[1] = force[2] = 0.0;
    }
}

int rs_feels(const rs_line *l, const rs_drives *s, const rs_drive_room *r, int i)
{
    int form = s->form[i], n = s->states[form], columns = 3 * s->ports[form];
    const double *by = r->result + n * (2 + n + s->inputs[form]);
    for (int row = 0; row < n && s->tied[form]; row++)
        for (int c = 0; c < columns; c++) {
            int span = s->port_span[s->port_first[i] + c / 3];
            if (span >= 0 && !(fabs(by[row * columns + c]) * l->z_nominal[l->force[span] + c % 3] < FELT)) return 1;
        }
    return 0;
}

int rs_drive_sections(const rs_line *l, const rs_drives *s, int i, int *sections, int count)
{
    for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++) {
        int known = s->port_span[port] < 0, section = known ? 0 : l->section_of[s->port_span[port]];
        for (int k = 0; k < count && !known; k++) known = sections[k] == section;
        if (!known && count < RS_MOST) sections[count++] = section;
    }
    return count;
}

static int is_beside(const rs_line *l, const rs_drives *s, int i, const int *sections, int count)
{
    for (int port = s->port_first[i]; port < s->port_first[i + 1]; port++)
        for (int k = 0; k < count; k++)
            if (s->port_span[port] >= 0 && l->section_of[s->port_span[port]] == sections[k]) return 1;
    return 0;
}

/* Whether a drive that is moved by itself feels the ropes here. */
static int reaches_limit(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s,
                         const rs_drive_room *r, int i)
{
    if (!s->tied[s->form[i]] || s->limited[i]) return 0;
    rs_pull(l, q, m, s, r, i);
    rs_drive(l, q, m, s, r, i, 0.0, q->x + s->x[i]);
    return rs_feels(l, s, r, i);
}

/* Whether the rates of a drive beside some sections, or of any, depend on the ropes here, though it is moved by itself. */
int rs_coupled(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s, const int *sections, int count)
{
    rs_drive_room r = rs_room_of(l, s);
    for (int i = 0; i < s->drives; i++)
        if ((!sections || is_beside(l, s, i, sections, count)) && reaches_limit(l, q, m, s, &r, i)) return 1;
    return 0;
}

int rs_note_limits(const rs_line *l, const rs_point *q, const rs_motion *m, const rs_drives *s)
{
    rs_drive_room r = rs_room_of(l, s);
    int found = 0;
    for (int i = 0; i < s->drives; i++)
        if (reaches_limit(l, q, m, s, &r, i)) found = s->limited[i] = 1;
    return found;
}

int rs_limited(const rs_line *l, const rs_drives *s, const int *sections, int count)
{
    for (int i = 0; i < s->drives; i++)
        if (s->limited[i] && (!sections || is_beside(l, s, i, sections, count))) return 1;
    return 0;
}

/* Rates of all states here. */
int rs_rates(const rs_line *l, rs_point *q, const rs_motion *m, const rs_drives *s)
{
    rs_drive_room r = rs_room_of(l, s);
    for (int i = 0; i < s->drives; i++) {
        rs_pull(l, q, m, s, &r, i);
        rs_drive(l, q, m, s, &r, i, 0.0, q->x + s->x[i]);
        memcpy(q->x_rate + s->x[i], r.result, s->states[s->form[i]] * sizeof(double));
    }
    return RS_REACHED;
}
