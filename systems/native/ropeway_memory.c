/* The arrays of an instance, whose sizes are in tables, and its saved state. */
#include <stdlib.h>
#include <string.h>
#include "ropeway.h"

#define LEAST_PIVOT 1e-14 /* of a scaled matrix */

/* An array: where the pointer to it is, the number of its entries, and the size of one. */
typedef struct {
    void *pointer;
    int count;
    size_t size;
} array;

#define DOUBLES(pointer, count) {&(pointer), count, sizeof(double)}
#define INTS(pointer, count) {&(pointer), count, sizeof(int)}
#define BYTES(pointer, count) {&(pointer), count, 1}
#define COUNT(arrays) (sizeof arrays / sizeof *arrays)

/* Bytes that arrays take; with `memory` their pointers are set. Each has an entry more, and begins at a multiple of 8. */
static size_t lay_out(const array *arrays, size_t count, unsigned char *memory)
{
    size_t at = 0;
    for (size_t i = 0; i < count; i++) {
        if (memory) {
            void *place = memory + at;
            memcpy(arrays[i].pointer, &place, sizeof place);
        }
        at += (((size_t)arrays[i].count + 1) * arrays[i].size + 7) / 8 * 8;
    }
    return at;
}

/* The arrays of the state. */
static size_t of_state(rw_instance *m, unsigned char *memory)
{
    rw_state *s = &m->s;
    int own = !(RW_SECTIONS || RW_INERTIAL); /* else its matrix is no part of it */
    const array arrays[] = {
        DOUBLES(s->now.x, RW_NX), DOUBLES(s->now.z, RW_NZ), DOUBLES(s->held.x, RW_NX), DOUBLES(s->held.z, RW_NZ),
        DOUBLES(s->ahead.zrate, RW_NZ), DOUBLES(s->ahead.z, RW_NZ), DOUBLES(s->slope, RW_NU), DOUBLES(s->stop_speed, RW_NE),
        DOUBLES(s->u, RW_NU), DOUBLES(s->p, RW_NP), DOUBLES(s->d, RW_ND), DOUBLES(s->mass, RW_NM),
        DOUBLES(s->rate, RW_NX), DOUBLES(s->zrate, RW_NZ), DOUBLES(s->y, RW_NY),
        INTS(s->passed, RW_NK), INTS(s->broken, RW_NL), INTS(s->ticks, RW_NC), INTS(s->on, RW_NSW),
        DOUBLES(s->lu.jac, own * RW_NNZ),
    };
    return lay_out(arrays, COUNT(arrays), memory);
}

/* The workspace. */
static size_t of_calls(rw_instance *m, unsigned char *memory)
{
    const int line = RW_SECTIONS ? rs_work_size(&rw_line) : 0, entries = RW_NNZ > RW_DNNZ ? RW_NNZ : RW_DNNZ;
    const int saved = (int)rw_saved_size(m), zones = RW_INERTIAL;
    const array arrays[] = {
        DOUBLES(m->f, RW_NX), DOUBLES(m->g, RW_NZ), DOUBLES(m->residual, RW_NW), DOUBLES(m->increment, RW_NW),
        DOUBLES(m->w, RW_NW), DOUBLES(m->first, RW_NW), DOUBLES(m->values, entries),
        DOUBLES(m->dx, RW_NX), DOUBLES(m->dz, RW_NZ), DOUBLES(m->du, RW_NU), DOUBLES(m->dp, RW_NP), DOUBLES(m->dd, RW_ND),
        DOUBLES(m->dm, RW_NM), DOUBLES(m->df, RW_NX), DOUBLES(m->dg, RW_NZ), DOUBLES(m->dy, RW_NY),
        BYTES(m->backup, saved), DOUBLES(m->sample, RW_NQ), DOUBLES(m->fresh, RW_ND),
        DOUBLES(m->margin, RW_NG), DOUBLES(m->margin_before, RW_NG), DOUBLES(m->no_margin, RW_NG), DOUBLES(m->limit, RW_NL),
        DOUBLES(m->indicator, RW_NK + RW_NL + RW_NB), DOUBLES(m->input_rate, RW_NU), DOUBLES(m->input_begin, RW_NU),
        DOUBLES(m->input_end, RW_NU),
        BYTES(m->changes, RW_ND), BYTES(m->just, RW_NK), BYTES(m->forward, RW_NK), BYTES(m->backward, RW_NK),
        DOUBLES(m->line_work, line), DOUBLES(m->rope, RW_NK), DOUBLES(m->us_rate, RW_NU),
        {&m->used, RW_NK, sizeof(long long)}, DOUBLES(m->coupling, RW_NCP), DOUBLES(m->us, RW_NU),
        DOUBLES(m->stage[0], RW_NX), DOUBLES(m->stage[1], RW_NX), DOUBLES(m->stage[2], RW_NX), DOUBLES(m->stage[3], RW_NX),
        DOUBLES(m->base, RW_NX), {&m->due, RW_NK, sizeof(rw_crossing)},
        DOUBLES(m->goal_p, RW_NP), DOUBLES(m->goal_mass, RW_NM), DOUBLES(m->goal_x, RW_NX),
        DOUBLES(m->from.x, RW_NX), DOUBLES(m->from.z, RW_NZ), DOUBLES(m->path_from.x, RW_NX), DOUBLES(m->path_from.z, RW_NZ),
        DOUBLES(m->path_to.x, RW_NX), DOUBLES(m->path_to.z, RW_NZ), DOUBLES(m->trial.x, RW_NX), DOUBLES(m->trial.z, RW_NZ),
        DOUBLES(m->good_z, RW_NZ), DOUBLES(m->before_z, RW_NZ),
        INTS(m->passed_before, RW_NK), INTS(m->broken_before, RW_NL),
        DOUBLES(m->core.y, RW_CORE_Y), DOUBLES(m->core.value, RW_CORE_VALUE), DOUBLES(m->core.kernel, RW_CORE_KERNEL),
        DOUBLES(m->core.dense, RW_CORE_DENSE), INTS(m->core.pivot, RW_CORE_PIVOT), DOUBLES(m->core.band, RW_CORE_BAND),
        DOUBLES(m->core.room, RW_CORE_ROOM), {&m->thresholds, RW_NTH, sizeof(rw_threshold)},
        {&m->zones_due, RW_NTH, sizeof(rw_threshold)}, {&m->known, 4 * (RW_SLOTS + 1), sizeof(rw_moving_slot)},
        DOUBLES(m->y_here, zones * RW_NY), DOUBLES(m->y_later, zones * RW_NY), DOUBLES(m->y_earlier, zones * RW_NY),
        DOUBLES(m->watch_low, RW_NK), DOUBLES(m->watch_high, RW_NK), DOUBLES(m->input_reached, RW_NU),
        INTS(m->watched, RW_NK), INTS(m->watch_of, RW_NK),
        DOUBLES(m->value, RW_VALUES), DOUBLES(m->change, RW_VALUES), DOUBLES(m->course_from.x, RW_NX), DOUBLES(m->course_from.z, RW_NZ),
        DOUBLES(m->course_to.x, RW_NX), DOUBLES(m->course_to.z, RW_NZ), DOUBLES(m->course_rate, RW_NX),
        DOUBLES(m->course_end_rate, RW_NX), DOUBLES(m->since, RW_NSEC), INTS(m->sections, RW_NSEC),
        DOUBLES(m->start_x, RW_NX), DOUBLES(m->start_z, RW_NZ), DOUBLES(m->start_d, RW_ND), DOUBLES(m->start_rate, RW_NX),
        DOUBLES(m->start_zrate, RW_NZ), INTS(m->start_passed, RW_NK),
    };
    return lay_out(arrays, COUNT(arrays), memory);
}

/* The arrays of an instance, filled with zeros; 1 where there is no memory for them. */
int rw_take_memory(rw_instance *m)
{
    m->state_memory = of_state(m, NULL);
    m->memory = calloc(1, m->state_memory + of_calls(m, NULL) + (RW_NNZ + 1) * sizeof(double));
    if (!m->memory || rn_new_factors(&m->whole, RW_NW) || rn_new_factors(&m->drives, RW_NX)) {
        rw_leave_memory(m);
        return 1;
    }
    m->whole.least = m->drives.least = LEAST_PIVOT;
    m->s.memory = m->memory;
    of_state(m, m->memory);
    of_calls(m, m->memory + m->state_memory);
    if (RW_SECTIONS || RW_INERTIAL) m->s.lu.jac = (double *)(m->memory + m->state_memory + of_calls(m, NULL));
    return 0;
}

void rw_leave_memory(rw_instance *m)
{
    rn_free_factors(&m->whole);
    rn_free_factors(&m->drives);
    free(m->memory);
}

/* The numbers of a state that are in no array. */
static const struct {
    size_t place, size;
} numbers[] = {
    {0, offsetof(rw_state, now)},
    {offsetof(rw_state, now.t), sizeof(double)},
    {offsetof(rw_state, held.t), sizeof(double)},
    {offsetof(rw_state, ahead), offsetof(rw_ahead, zrate)},
    {offsetof(rw_state, lu), offsetof(rw_matrix_state, jac)},
};

size_t rw_saved_size(const rw_instance *m)
{
    size_t size = m->state_memory;
    for (size_t i = 0; i < COUNT(numbers); i++) size += numbers[i].size;
    return size;
}

/* Writes the state to `rw_saved_size` bytes. */
void rw_save(rw_instance *m, unsigned char *bytes)
{
    for (size_t i = 0; i < COUNT(numbers); bytes += numbers[i++].size)
        memcpy(bytes, (unsigned char *)&m->s + numbers[i].place, numbers[i].size);
    memcpy(bytes, m->s.memory, m->state_memory);
}

/* Reads a state that was saved. */
void rw_restore(rw_instance *m, const unsigned char *bytes)
{
    for (size_t i = 0; i < COUNT(numbers); bytes += numbers[i++].size)
        memcpy((unsigned char *)&m->s + numbers[i].place, bytes, numbers[i].size);
    memcpy(m->s.memory, bytes, m->state_memory);
}

/* A state of zeros. */
void rw_clear(rw_instance *m)
{
    for (size_t i = 0; i < COUNT(numbers); i++) memset((unsigned char *)&m->s + numbers[i].place, 0, numbers[i].size);
    memset(m->s.memory, 0, m->state_memory);
}

void rw_copy_point(rw_point *to, const rw_point *from)
{
    to->t = from->t;
    memcpy(to->x, from->x, RW_NX * sizeof(double));
    memcpy(to->z, from->z, RW_NZ * sizeof(double));
}
