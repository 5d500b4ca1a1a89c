/* Sparse LU. */
#ifndef SPARSE_LU_H
#define SPARSE_LU_H

#ifdef RS_INSIDE /* of another library: not visible outside of it */
#define RN_API
#elif defined(_WIN32)
#define RN_API __declspec(dllexport)
#else
#define RN_API __attribute__((visibility("default")))
#endif

enum { RN_OK, RN_SINGULAR, RN_STUCK, RN_SLOW, RN_MEMORY };

/* A sparse matrix by columns: ends of columns, rows; the columns in the `order` in which they are eliminated, and the row
 * that each should take: one of the first `inner` for the first `inner` columns, then just that one. */
typedef struct {
    int n, inner;
    const int *column_end, *row, *order, *diagonal;
} rn_pattern;

/* Factors of a matrix. A pivot that is not above `least` is zero. */
typedef struct {
    int n, size_l, size_u, steps, known; /* steps: columns that are eliminated; known: all of an earlier matrix */
    int *lower_end, *upper_end, *step_of, *lower, *upper, *mark, *stack, *place, *reached;
    double *l, *u, *work, least;
} rn_factors;

int rn_new_factors(rn_factors *f, int n);
void rn_free_factors(rn_factors *f);
int rn_factor(rn_factors *f, const rn_pattern *a, const double *entries);
RN_API int rn_pivots(const rn_pattern *pattern, const double *entries, const int *take, double *pivots);
void rn_back(const rn_factors *f, const rn_pattern *a, double *b);

#endif
