/* A system with inertia, solved as inertial.h says. */
#include <string.h>
#include "ropeway.h"

/* The present point in the core, which changes it in place; inputs are those in m->us. */
ri_point *rw_core_point(rw_instance *m)
{
    ri_point *q = &m->core;
    rw_inputs_at(m, m->s.now.t, m->us);
    memcpy(m->us_rate, m->s.slope, RW_NU * sizeof(double));
    rw_input_rates(m, m->s.now.t, 1.0, m->us_rate);
    q->x = m->s.now.x, q->z = m->s.now.z, q->u = m->us, q->p = m->s.p, q->d = m->s.d;
    q->x_rate = m->s.rate, q->z_rate = m->s.zrate, q->u_rate = m->us_rate;
    q->y = m->core_y, q->value = m->core_value, q->kernel = m->core_kernel, q->dense = m->core_dense;
    q->pivot = m->core_pivot, q->band = m->core_band, q->room = m->core_room;
    q->step = -1.0; /* nothing depends on calls before */
    return q;
}

/* Whether the core has solved the line and found all rates; `failed` is what it returned. */
int rw_core_solved(rw_instance *m, int failed)
{
    int solved = !failed && rw_all_finite(m->s.rate, RW_NX) && rw_all_finite(m->s.zrate, RW_NZ);
    m->s.solved = m->s.rated = solved;
    m->s.shown = m->s.lu.valid = 0;
    return solved;
}

/* Solves the algebraic variables, and finds all rates; after a failure they are unchanged, and 0 is returned. */
int rw_core_solve(rw_instance *m)
{
    double before[RW_NZ + 1];
    memcpy(before, m->s.now.z, RW_NZ * sizeof(double));
    if (rw_core_solved(m, ri_solve(&rw_core, rw_core_point(m)))) return 1;
    memcpy(m->s.now.z, before, RW_NZ * sizeof(double));
    return 0;
}
