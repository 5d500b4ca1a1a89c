/* A system with inertia: pieces of rope, each with its unknowns eliminated by themselves, and the nodes that they hang
 * on, whose unknowns form a banded system. All is in tables; what is compiled are the kernels of kinds of components
 * (see component_kernels.py). Nothing here is global. */
#ifndef INERTIAL_H
#define INERTIAL_H

#ifdef RS_INSIDE /* of another library: not visible outside of it */
#define RI_API
#elif defined(_WIN32)
#define RI_API __declspec(dllexport)
#else
#define RI_API __attribute__((visibility("default")))
#endif

typedef void (*ri_kernel)(const double *v, double *r);

enum { RI_OK, RI_SINGULAR, RI_STUCK, RI_SLOW, RI_SHORT };

/* What the kernel of a piece's matrix gives, block after block; of a node only the first two: its own equations by its
 * own variables, and by its ports. Of the step c: S and T give the change of the states, S dz + T r. */
enum { RI_OWN, RI_PORTS, RI_STATES, RI_FORCES, RI_FORCES_STATES, RI_FORCES_PORTS, RI_S, RI_T, RI_BLOCKS };

typedef struct {
    int nx, nz, nu, np, ns, pieces, components, unknowns, band;
    /* of each form: sizes; where its blocks begin in `rows` and `columns` (RI_BLOCKS + 1 each), and its order in
     * `order_r` and `order_z` */
    const int *form_nx, *form_nz, *form_nu, *form_np, *form_nd, *form_ports, *form_given, *block, *order_at;
    const int *rows, *columns, *at, *order_r, *order_z; /* `at`: where an entry stands among the kernel's results */
    /* of each component, pieces first: its form, first places in the vectors, in `port_...`, of its kernels' input,
     * results and blocks in the work, of the dense matrices of a piece; of a node its first unknown */
    const int *form, *x, *z, *r, *u, *p, *d, *port_at, *input, *result, *blocks, *dense, *unknown;
    /* of each entry of a port: the place in (x, z, u, p, 0, 1) where it stands, or the piece and its result; of a piece
     * also the place of what is added */
    const int *port_source, *port_aside, *port_piece, *port_row;
    /* of each piece, from `active_at` on: the unknowns of nodes that it reads, the columns of its blocks by ports */
    const int *active_at, *active_unknown;
    const int *shared; /* (ns,): places in (x, z, u, p, 0, 1) */
    const double *x_nominal, *z_nominal, *r_scale; /* the last: one over the nominals of the residuals */
    const ri_kernel *value, *matrix;
} ri_line;

/* A point of it, its rates, and room to work. */
typedef struct {
    double *x, *z, *u, *p, *d;
    double *x_rate, *z_rate; /* found [per s] */
    const double *u_rate;
    double *y;     /* (x, z, u, p, 0, 1) */
    double *value; /* rates of the states, residuals */
    double *kernel; /* inputs, results and blocks of kernels */
    double *dense; /* matrices of the pieces */
    int *pivot;
    double *band; /* matrix of the nodes */
    double *room; /* 20 (nx + nz) + unknowns */
    double step;  /* of the factors; below 0: none */
    int worst;    /* of a failure: the residual that is worst */
} ri_point;

/* A run of the point: from `time` to `stop`, with `h` as the step that is tried first; `tolerance` of a step, absolute on
 * scaled states. It ends earlier where one of the `watched` states is beyond `low` or `high`, and where its `trace` is
 * full: that has `room` for rows of time, x, z and the rates of x, at the start and after each step; 0: not wanted. */
typedef struct {
    double time, stop, h, tolerance, shortest;
    int watches, steps, rejected, hit, room;
    const int *watched;
    const double *low, *high;
    double *trace;
} ri_run;

RI_API int ri_solve(const ri_line *line, ri_point *q);
RI_API int ri_move(const ri_line *line, ri_point *q, ri_run *run);

void ri_load(const ri_line *line, ri_point *q);
void ri_evaluate(const ri_line *line, ri_point *q);
int ri_factor(const ri_line *line, ri_point *q, double c);
void ri_apply(const ri_line *line, ri_point *q, double c, double *side);

#endif
