/* A model as a network of kernels: each component is one call of the kernel of its kind, which reads entries of the
 * model's vectors and results of earlier calls. What is compiled are the kernels; how they are joined is in tables (see
 * kernel_network.py). Nothing here is global: threads share a network, each with values of its own. */
#ifndef NETWORK_H
#define NETWORK_H

#include "calls.h"
#include "sparse_lu.h"

/* The values are entries of the vectors, results of calls, sums, and the number one. */
typedef struct {
    rn_calls calls;
    rn_pattern pattern; /* of the matrix: residuals by unknowns */
    int sums, drifts, entries, balances;
    /* of each sum of products: its place, and the end of its terms: first those of the matrix, then `drifts` of rates */
    const int *sum, *terms_end, *factor, *other;
    /* of each unknown its place; of each residual its place; of each residual its drift where rates are asked for */
    const int *unknown, *residual, *drift;
    const int *entry; /* of each entry of the matrix its place; -1: zero */
    /* travels that can be held back: residual, unknown, entry of the matrix; `sign` */
    const int *balance_residual, *balance_unknown, *balance_entry;
    const double *sign;
} rn_network;

/* What a solve is given besides the start. */
typedef struct {
    double *values; /* (values,): vectors are filled in */
    const double *scale, *weight, *target, *anchor; /* of unknowns, residuals, residuals, unknowns */
    double damping, shortest;
    int iterations, rates;
} rn_problem;

RN_API void rn_evaluate(const rn_network *net, double *values);
RN_API void rn_matrix(const rn_network *net, const rn_problem *q, const double *v, double *entries);
RN_API int rn_solve(const rn_network *net, const rn_problem *q, double *v, double *residual, double *rates);

#endif
