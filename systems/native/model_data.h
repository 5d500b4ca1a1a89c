/* Tables of one system: model_data.c, which is generated, has their values. */
#ifndef MODEL_DATA_H
#define MODEL_DATA_H

#define RS_INSIDE
#include "calls.h"
#include "inertial.h"
#include "sections.h"
#include "sparse_lu.h"

#define RW_FINGERPRINT 39

/* A function of t, x, z, u, p, d, whose entries are the first of the values: places of its results, `row`; some have
 * derivatives, others kernels for changes. */
typedef struct {
    rn_calls calls;
    rn_derivatives derivatives;
    const rn_kernel *tangents;
    int rows;
    const int *row;
} rw_network;

/* Sizes and numbers: of states, algebraic variables, inputs, parameters, discrete variables, outputs, masses, states and
 * algebraic variables together, entries of their matrix; of supports, limits, switches, stops, schedules, inputs that are
 * rates of others, clocks and the most entries of one, places of a carriage, borders between them, their most margins;
 * `coupled`: rates depend on states. Of a line by sections, which `sections` marks:
 * their number, and the entries of the derivatives and of the matrix of its drives. Of a system with inertia, which `inertial`
 * marks: room of its core, most slots of a span, most thresholds of loads. `groups` of directions for the
 * matrix; `values` of the largest network. */
typedef struct {
    int nx, nz, nu, np, nd, ny, nm, nw, nnz, nk, nl, nsw, ne, ns, nf, nc, nq, npl, nb, ng;
    int coupled, sections, nsec, ncp, dnnz, groups, values;
    int inertial, core_y, core_value, core_kernel, core_dense, core_pivot, core_band, core_room, slots, nth;
    double tolerance, force_scale, force_near, stop_deceleration, mean_span;
    double zone, zone_past, zone_near, zone_beyond, zone_early, zone_joined; /* see support_zones.py */
} rw_sizes;

extern const rw_sizes rw_size;
#define RW_NX rw_size.nx
#define RW_NZ rw_size.nz
#define RW_NU rw_size.nu
#define RW_NP rw_size.np
#define RW_ND rw_size.nd
#define RW_NY rw_size.ny
#define RW_NM rw_size.nm
#define RW_NW rw_size.nw
#define RW_NNZ rw_size.nnz
#define RW_NK rw_size.nk
#define RW_NL rw_size.nl
#define RW_NSW rw_size.nsw
#define RW_NE rw_size.ne
#define RW_NS rw_size.ns
#define RW_NF rw_size.nf
#define RW_NC rw_size.nc
#define RW_NQ rw_size.nq
#define RW_NPL rw_size.npl
#define RW_NB rw_size.nb
#define RW_NG rw_size.ng
#define RW_COUPLED rw_size.coupled
#define RW_SECTIONS rw_size.sections
#define RW_NSEC rw_size.nsec
#define RW_NCP rw_size.ncp
#define RW_DNNZ rw_size.dnnz
#define RW_GROUPS rw_size.groups
#define RW_VALUES rw_size.values
#define RW_INERTIAL rw_size.inertial
#define RW_CORE_Y rw_size.core_y
#define RW_CORE_VALUE rw_size.core_value
#define RW_CORE_KERNEL rw_size.core_kernel
#define RW_CORE_DENSE rw_size.core_dense
#define RW_CORE_PIVOT rw_size.core_pivot
#define RW_CORE_BAND rw_size.core_band
#define RW_CORE_ROOM rw_size.core_room
#define RW_SLOTS rw_size.slots
#define RW_NTH rw_size.nth
#define RW_TOLERANCE rw_size.tolerance
#define RW_FORCE_SCALE rw_size.force_scale
#define RW_FORCE_NEAR rw_size.force_near
#define RW_STOP_DECELERATION rw_size.stop_deceleration
#define RW_MEAN_SPAN rw_size.mean_span
#define RW_ZONE rw_size.zone
#define RW_ZONE_PAST rw_size.zone_past
#define RW_ZONE_NEAR rw_size.zone_near
#define RW_ZONE_BEYOND rw_size.zone_beyond
#define RW_ZONE_EARLY rw_size.zone_early
#define RW_ZONE_JOINED rw_size.zone_joined

extern const char rw_fingerprint[RW_FINGERPRINT]; /* of the content of this FMU */
extern const rn_pattern rw_whole, rw_drives;      /* the whole system, and the drives of a line alone */
extern const int rw_whole_colind[], rw_drives_colind[]; /* where their columns begin */
extern const rs_line rw_line;
extern const ri_line rw_core;

/* of each place of a carriage, or one: f and g, but of a line by sections; f, g and y with changes; f and g with
 * derivatives by x and z, where the compiled core does not solve the system; margins */
extern const rw_network rw_net_equations[], rw_net_all[], rw_net_matrix[], rw_net_margins[];
/* f; f with derivatives by x and z; outputs that have limits; of each clock the new values of its entries */
extern const rw_network rw_net_rates[], rw_net_coupling[], rw_net_limits[], rw_net_clock[];

/* start values and scales */
extern const double rw_x_start[], rw_z_start[], rw_u_start[], rw_p_start[], rw_d_start[], rw_mass_start[];
extern const int rw_passed_start[];
extern const double rw_x_nominal[], rw_z_nominal[], rw_r_nominal[];
extern const int rw_group[];

/* variables */
extern const char *const rw_equation_name[], *const rw_input_name[], *const rw_variable_name[];
extern const int rw_followed_input[], rw_followed_source[], rw_switch[], rw_switch_shown[], rw_access[], rw_tunable[];
extern const double rw_least[], rw_most[];
extern const int rw_above[];

/* inputs in time */
extern const int rw_schedule_input[], rw_schedule_first[], rw_stop_input[], rw_stop_correction[], rw_wind[], rw_north[];
extern const double rw_schedule_time[], rw_schedule_value[];

/* ropes: by support, by run, loads */
extern const int rw_run_of[], rw_travel[], rw_length_start[], rw_slot_count[], rw_slot_mass[], rw_slot_at[], rw_slot_ride[];
extern const int rw_slot_empty[], rw_slot_drag[], rw_force[], rw_held[], rw_held_travel[], rw_law[], rw_vertical_b[], rw_pull_b[];
extern const char *const rw_support_name[];
extern const int rw_run_first[], rw_around[], rw_load_first[], rw_mass_first[];
extern const double rw_span_scale[], rw_feed_spacing[], rw_load_place[], rw_load_drag[];

/* motion of slots of a system with inertia, by span */
extern const int rw_slot_place[], rw_slot_velocity[], rw_slot_pull[], rw_slot_acceleration[], rw_slot_station[], rw_slot_tied[];
extern const int rw_slot_joined[], rw_slot_lost[], rw_mass_per_length[], rw_damping[];

/* drives of a line by sections */
extern const int rw_coupling_colind[], rw_coupling_row[], rw_state_section_first[], rw_state_section[];

/* limits, clocks, places of a carriage */
extern const int rw_limit_output[];
extern const double rw_limit_low[], rw_limit_high[], rw_limit_scale[], rw_limit_slack[];
extern const char *const rw_limit_name[];
extern const double rw_clock_period[], rw_clock_phase[];
extern const int rw_clock_first[], rw_clock_entry[], rw_clock_corrects[];
extern const int rw_passage_first[], rw_passage_to[];
extern const double rw_passage_jump[];
extern const char *const rw_passage_event[];

#endif
