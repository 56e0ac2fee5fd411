/* Moments of solids by quadrature: the sums of ``geometry.quadrature`` over the places of one patch, row by row. Sums of rows are made
   by NumPy's own loop, which adds in an order of its own. */

#include <stddef.h>
#include <stdint.h>

#include "bodies.h"

typedef void loop(char **, const ptrdiff_t *, const ptrdiff_t *, void *);

typedef struct {
    loop *add;
    void *data;
    int64_t n;
} adder;

static double total(const adder *by, double *values) {
    double found = 0.0;
    char *args[3] = {(char *)&found, (char *)values, (char *)&found};
    const ptrdiff_t count = by->n, steps[3] = {0, sizeof(double), 0};
    by->add(args, &count, steps, by->data);
    return found;
}

/* Row sums (k,) of values (k, n). */
OUT void row_sums(int64_t k, int64_t n, void *add, void *data, double *values, double *out) {
    const adder by = {(loop *)add, data, n};
    for (int64_t row = 0; row < k; row++) out[row] = total(&by, values + row * n);
}

/* Adds to volume, first and, with ``inertia``, second moments of the instances ``rows`` (k,) about ``middle`` what a patch gives at n
   places: its six ``terms``, position and du x dv, lie ``strides`` (6, 2) bytes apart by row and place. ``room`` holds 7 n numbers. */
OUT void add_moments(int64_t k, int64_t n, int64_t inertia, const char *const *terms, const int64_t *strides, const double *weight,
                     const int64_t *rows, const double *middle, void *add, void *data, double *room, double *volume, double *first,
                     double *second) {
    const adder by = {(loop *)add, data, n};
    double *x[3] = {room, room + n, room + 2 * n}, *flow[3] = {room + 3 * n, room + 4 * n, room + 5 * n}, *made = room + 6 * n;
    for (int64_t row = 0; row < k; row++) {
        const int64_t own = rows[row];
        int64_t p;
        int i, j;
        for (i = 0; i < 3; i++) {
            const char *at = terms[i] + row * strides[2 * i], *to = terms[3 + i] + row * strides[2 * (3 + i)];
            const int64_t step = strides[2 * i + 1], way = strides[2 * (3 + i) + 1];
            for (p = 0; p < n; p++) {
                x[i][p] = *(const double *)(at + p * step) - middle[3 * own + i];
                flow[i][p] = *(const double *)(to + p * way) * weight[p];
            }
        }
        for (p = 0; p < n; p++) made[p] = x[0][p] * flow[0][p] + x[1][p] * flow[1][p] + x[2][p] * flow[2][p];
        volume[own] += total(&by, made) / 3;
        for (i = 0; i < 3; i++) {
            double *square = flow[i];
            for (p = 0; p < n; p++) square[p] = x[i][p] * x[i][p] * flow[i][p];
            first[3 * own + i] += total(&by, square) / 2;
            for (j = 0; inertia && j < 3; j++) {
                for (p = 0; p < n; p++) made[p] = square[p] * x[j][p];
                second[9 * own + 3 * i + j] += total(&by, made) / (i == j ? 3 : 2);
            }
        }
    }
}
