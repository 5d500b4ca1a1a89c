/* A line by sections: each span's forces eliminated by itself, the travels of idlers by a tridiagonal system for each
 * section between driven supports, loads that cross supports. All is in tables; what is compiled are the kernels of
 * kinds of spans and supports (see line_sections.py). Nothing here is global: eight threads take eight rs_point. */
#ifndef SECTIONS_H
#define SECTIONS_H

#ifdef RS_INSIDE /* of another library: not visible outside of it */
#define RS_API
#elif defined(_WIN32)
#define RS_API __declspec(dllexport)
#else
#define RS_API __attribute__((visibility("default")))
#endif

#define RS_SPAN 24  /* results of a span's kernel */
#define RS_SUPPORT 9 /* results of a support's kernel */
#define RS_NODES 13 /* Chebyshev points of a window */

typedef void (*rs_kernel)(const double *v, double *r);

enum { RS_OK, RS_SINGULAR, RS_STUCK, RS_SLOW, RS_AWAY };

/* Tables of a line. */
typedef struct {
    int spans, supports, sections, slots, nx, nz, nu, np, ns, runs;
    /* of each span; `drag`: -1 without weather; `on_idlers`: whether a support of its run lets rope run; of each form of
     * spans the number of parameters */
    const int *form, *parameters, *force, *closure, *mass, *at, *ride, *drag, *start, *empty, *count, *length_start;
    const int *on_idlers;
    const int *form_parameters;
    /* of each support */
    const int *point, *state, *travel, *balance, *support_form, *support_parameters, *support_discrete, *speed;
    const int *support_form_parameters, *support_form_discrete;
    /* of each section: first and last support, first span; section of each span */
    const int *first, *last, *first_span, *section_of;
    /* of each support: its run, whether it can hold a load, whether a drum lets rope run there by itself; of each run:
     * its first support, whether the rope is endless, whether it is fed */
    const int *run_of, *held, *free_end, *run_first, *around, *fed;
    /* what all kernels read: places in (p, u), (ns,) */
    const int *shared;
    const double *z_nominal, *r_nominal;
    const rs_kernel *kernels;         /* [form][used slots] */
    const rs_kernel *support_kernels; /* [support form] */
} rs_line;

/* A point of a line, with the loads in each span, and room to work. */
typedef struct {
    double *x, *z, *u, *p, *d;
    long long *used;                     /* of each span: slots with a load */
    double *x_rate, *u_rate;             /* [per s] */
    double *z_rate;
    double *work; /* rs_work_size(line) doubles */
    int worst;    /* of a failure: the residual that is worst */
} rs_point;

RS_API int rs_work_size(const rs_line *line);
void rs_linearise(const rs_line *line, rs_point *q, int section);
void rs_section_rates(const rs_line *line, rs_point *q, int section);
void rs_span(const rs_line *line, const rs_point *q, int span, double *result);
void rs_support(const rs_line *line, const rs_point *q, int k, const double *coming, const double *going, double *result);
RS_API int rs_solve(const rs_line *line, rs_point *q, int section, int rates);
RS_API int rs_solve_all(const rs_line *line, rs_point *q, int rates);
RS_API int rs_solve_many(const rs_line *line, rs_point *q, int cases, const long long *stride, unsigned char *good);
void rs_keep(const rs_line *line, int section, const double *from, double *to);
double rs_travel(const rs_line *line, const rs_point *q, int k);
int rs_is_last(const rs_line *line, int k);
int rs_beside(const rs_line *line, int k, int *sections, int count, int most);
int rs_stable(const rs_line *line, const rs_point *q, const int *sign);

#endif
