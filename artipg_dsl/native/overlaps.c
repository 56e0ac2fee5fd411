/* Points of boxes in which two primitives may overlap: ``geometry.overlap`` asks whether these lie in both, and what those weigh that do.
   Poses of R rows are told by columns: rotation (9, R), translation (3, R), mirror (R,). Sums of rows are made by NumPy's own loop. */

#include "bodies.h"

typedef void loop(char **, const ptrdiff_t *, const ptrdiff_t *, void *);

/* Points out (3, n, count) of the object: fractions share (3, count) of boxes low, size (3, n) in the frames (n,) of rows. */
OUT void place_shares(int64_t n, int64_t count, int64_t rows, const double *share, const double *low, const double *size, const int64_t *frame,
                      const double *rotation, const double *translation, const double *mirror, double *out) {
    for (int64_t k = 0; k < n; k++) {
        const int64_t row = frame[k];
        double turn[9], shift[3], from[3], by[3];
        for (int i = 0; i < 9; i++) turn[i] = rotation[i * rows + row];
        for (int i = 0; i < 3; i++) shift[i] = translation[i * rows + row], from[i] = low[i * n + k], by[i] = size[i * n + k];
        for (int64_t p = 0; p < count; p++) {
            const double x = from[0] + by[0] * share[p], y = (from[1] + by[1] * share[count + p]) * mirror[row],
                         z = from[2] + by[2] * share[2 * count + p];
            for (int i = 0; i < 3; i++)
                out[(i * n + k) * count + p] = turn[3 * i] * x + turn[3 * i + 1] * y + turn[3 * i + 2] * z + shift[i];
        }
    }
}

/* The points (3, n, count) of the pairs ``at`` (k,) that are asked (n, count) in the frames (k,) of rows, out (3, k, width), and which they
   are, picked (k, width): all, where there are so many, else those of a pair with fewer than ``width`` end with one of them again and
   again. */
OUT void local_points(int64_t k, int64_t count, int64_t width, int64_t rows, const double *x, const double *y, const double *z,
                      const uint8_t *asked, const int64_t *at, const int64_t *frame, const double *rotation, const double *translation,
                      const double *mirror, double *out, int64_t *picked) {
    for (int64_t j = 0; j < k; j++) {
        const int64_t row = frame[j], first = at[j] * count;
        int64_t *own = picked + j * width, many = 0;
        double turn[9], shift[3];
        for (int i = 0; i < 9; i++) turn[i] = rotation[i * rows + row];
        for (int i = 0; i < 3; i++) shift[i] = translation[i * rows + row];
        for (int64_t p = 0; p < count && many < width; p++)
            if (width == count || asked[first + p]) own[many++] = p;
        for (int64_t p = many; p < width; p++) own[p] = own[many - 1];
        for (int64_t p = 0; p < width; p++) {
            const int64_t place = first + own[p];
            const double a = x[place] - shift[0], b = y[place] - shift[1], c = z[place] - shift[2];
            for (int i = 0; i < 3; i++) {
                const double found = turn[i] * a + turn[3 + i] * b + turn[6 + i] * c;
                out[(i * k + j) * width + p] = i == 1 ? found * mirror[row] : found;
            }
        }
    }
}

/* Of points (n, count) that are held (n, count): how many there are (n,), their mean (n, 3) and, with ``inertia``, the means of the products
   of any two coordinates from there (n, 3, 3); these are left alone where all are held, or none. ``room`` holds 4 count numbers. */
OUT void held_moments(int64_t n, int64_t count, int64_t inertia, const uint8_t *held, const double *x, const double *y, const double *z,
                      void *add, void *data, double *room, int64_t *many, double *mean, double *spread) {
    const double *axes[3] = {x, y, z};
    double *made = room + 3 * count;
    const ptrdiff_t length = count, steps[3] = {0, sizeof(double), 0};
    for (int64_t k = 0; k < n; k++) {
        const uint8_t *own = held + k * count;
        int64_t found = 0;
        for (int64_t p = 0; p < count; p++) found += own[p];
        many[k] = found;
        if (!found) continue;
        for (int i = 0; i < 3; i++) {
            const double *from = axes[i] + k * count;
            double sum = 0.0;
            char *args[3] = {(char *)&sum, (char *)made, (char *)&sum};
            for (int64_t p = 0; p < count; p++) made[p] = own[p] ? from[p] : 0.0;
            ((loop *)add)(args, &length, steps, data);
            mean[3 * k + i] = sum / found;
        }
        if (!inertia || found == count) continue;
        for (int i = 0; i < 3; i++)
            for (int64_t p = 0; p < count; p++) room[i * count + p] = axes[i][k * count + p] - mean[3 * k + i];
        for (int i = 0; i < 3; i++)
            for (int j = i; j < 3; j++) {
                double sum = 0.0;
                char *args[3] = {(char *)&sum, (char *)made, (char *)&sum};
                for (int64_t p = 0; p < count; p++) made[p] = own[p] ? room[i * count + p] * room[j * count + p] : 0.0;
                ((loop *)add)(args, &length, steps, data);
                spread[9 * k + 3 * i + j] = spread[9 * k + 3 * j + i] = sum / found;
            }
    }
}
