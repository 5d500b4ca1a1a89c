/* The work of a span with two loads in one iteration of Newton's method, written by hand: what a compiled run cannot be
 * faster than. Results as those of a kernel (see systems/solvers/line_sections.py). */
#include <math.h>

#ifdef _WIN32
#define API __declspec(dllexport)
#else
#define API __attribute__((visibility("default")))
#endif

typedef struct {
    double force[3], weight, compliance, length, at[2], load[2], way[3];
} span;

/* The solution of (A + B f f' + C (f z' + z f') ...) x = right: a system in the span's plane, and one across it. */
static void solved(const span *q, double h2, double a, double b, double c, double e, const double *right, double *x)
{
    double along = (q->force[0] * right[0] + q->force[1] * right[1]) / h2;
    double inverse = 1.0 / ((a + b * h2) * e - c * c * h2);
    double level = (e * along - c * right[2]) * inverse - along / a;
    x[0] = right[0] / a + q->force[0] * level;
    x[1] = right[1] / a + q->force[1] * level;
    x[2] = ((a + b * h2) * right[2] - c * h2 * along) * inverse;
}

static void work(const span *q, double *r)
{
    double fx = q->force[0], fy = q->force[1], h2 = fx * fx + fy * fy, v0 = q->force[2], w = q->weight, c1 = q->compliance;
    double a = 0.0, b = 0.0, c = 0.0, e = 0.0, rise = 0.0, at_a[3] = {0.0, 0.0, 0.0}, at_b[3];
    double t0 = sqrt(h2 + v0 * v0);
    for (int i = 0; i < 3; i++) {
        double begin = i ? q->at[i - 1] : 0.0, l = (i < 2 ? q->at[i] : q->length) - begin;
        double gain = w * l, v1 = v0 + gain, t1 = sqrt(h2 + v1 * v1), s = t0 + t1, v = v0 + v1, product = t0 * t1;
        double per_s = 1.0 / s, per_product = 1.0 / product, share = 1.0 / t1 + c1;
        double turned = l * (1.0 + (h2 + v0 * v0 + v1 * v1) / (product + v0 * v1)) * per_product * per_s;
        if (i) { /* the load moves with the rope at end a */
            double before = 1.0 / t0 + c1;
            at_a[0] -= before * fx, at_a[1] -= before * fy, at_a[2] -= before * v0;
        }
        a += log1p(2.0 * gain / (s - gain)) / w + c1 * l;
        b -= turned;
        c -= l * v * per_s * per_product;
        e += h2 * turned + c1 * l;
        rise += l * v * (per_s + 0.5 * c1);
        at_b[0] = share * fx, at_b[1] = share * fy, at_b[2] = share * v1;
        for (int k = 0; k < 3; k++) at_a[k] += at_b[k];
        if (i < 2) v0 = v1 + q->load[i], t0 = sqrt(h2 + v0 * v0);
        else v0 = v1;
    }
    double right[3][3] = {{0}}, ride = w;
    for (int k = 0; k < 3; k++) {
        r[k] = (k < 2 ? q->force[k] * a : rise) - q->way[k];
        r[3 + k] = k < 2 ? -q->force[k] : -v0;
        right[0][k] = -r[k], right[1][k] = -at_a[k], right[2][k] = at_b[k];
    }
    for (int side = 0; side < 3; side++) {
        solved(q, h2, a, b, c, e, right[side], r + 6 + 3 * side);
        for (int k = 0; k < 3; k++) r[15 + 3 * side + k] = -r[6 + 3 * side + k];
    }
    r[20] -= ride;
    r[23] += ride;
}

API void once(const span *q, double *r)
{
    work(q, r);
}

API void loop(span *q, double *r, int n)
{
    for (int i = 0; i < n; i++) {
        q->force[0] += 1e-6;
        work(q, r);
    }
}
