/* Depth pictures of clouds from many sides, as ``fit.outer`` has them. */

#include "bodies.h"

#define SIDES 64 /* at most */

/* Points (n, 3) from ``low``, as a picture along the first two of ``frame`` (3, 3) has them: in which of its cells each lies, how deep along the
   third, and the nearest to the eye of each cell, ``front`` (across, across), which begins at ``least`` (2,). */
static void draw(int64_t n, const double *points, const double *low, const double *frame, double cell, int64_t across, double *flat,
                 int64_t *spot, double *depth, double *least, double *front) {
    double *x = flat, *y = flat + n;
    least[0] = least[1] = INFINITY;
    for (int64_t k = 0; k < n; k++) {
        const double p[3] = {points[3 * k] - low[0], points[3 * k + 1] - low[1], points[3 * k + 2] - low[2]};
        x[k] = dot(p, frame), y[k] = dot(p, frame + 3), depth[k] = dot(p, frame + 6);
    }
    for (int64_t k = 0; k < n; k++) {
        least[0] = x[k] < least[0] ? x[k] : least[0];
        least[1] = y[k] < least[1] ? y[k] : least[1];
    }
    for (int64_t k = 0; k < across * across; k++) front[k] = -INFINITY;
    for (int64_t k = 0; k < n; k++) {
        spot[k] = (int64_t)((x[k] - least[0]) / cell) * across + (int64_t)((y[k] - least[1]) / cell);
        double *nearest = front + spot[k];
        *nearest = depth[k] > *nearest ? depth[k] : *nearest; /* without a branch, which could not be foreseen */
    }
}

/* The pictures of K clouds (K, n, 3) with their ``low`` corners and ``cell``s, from each of the ``sides`` (sides, 3, 3): ``least``
   (K, sides, 2) and ``front`` (K, sides, across, across). ``flat`` (3, n) and ``spot`` (n,) are room to work in. */
OUT void depth_pictures(int64_t count, int64_t n, const double *points, const double *low, const double *cell, int64_t sides,
                        const double *frames, int64_t across, double *least, double *front, double *flat, int64_t *spot) {
    for (int64_t k = 0; k < count; k++)
        for (int64_t s = 0; s < sides; s++) {
            const int64_t at = k * sides + s;
            draw(n, points + 3 * n * k, low + 3 * k, frames + 9 * s, cell[k], across, flat, spot, flat + 2 * n, least + 2 * at,
                 front + at * across * across);
        }
}

/* pictures of clouds T that may hide points as well: their low corners, cells, ``least`` (T, sides, 2), ``front`` (T, sides, across, across) */
typedef struct {
    const double *low, *cell, *least, *front;
} screens;

/* From which of the ``sides`` points of K clouds (K, n, 3) are seen, each its bit in ``seen`` (K, n): what is not deeper than a cell is wide below
   the cloud's own picture, each as many cells ``across`` (K,), nor below that of the ``target`` (K,) among ``others``, if there are any. */
OUT void depth_sides(int64_t count, int64_t n, const double *points, const double *low, const double *cell, int64_t sides,
                     const double *frames, const int64_t *across, double *front, double *flat, int64_t *spot, const int64_t *target,
                     const screens *others, int64_t wide, uint64_t *seen) {
    double *depth = flat + 2 * n;
    for (int64_t k = 0; k < count; k++) {
        uint64_t *own = seen + n * k;
        for (int64_t i = 0; i < n; i++) own[i] = 0;
        for (int64_t s = 0; s < sides && s < SIDES; s++) {
            const double *frame = frames + 9 * s;
            double least[2];
            draw(n, points + 3 * n * k, low + 3 * k, frame, cell[k], across[k], flat, spot, depth, least, front);
            if (!target) {
                for (int64_t i = 0; i < n; i++) own[i] |= (uint64_t)(depth[i] >= front[spot[i]] - cell[k]) << s;
                continue;
            }
            const int64_t t = target[k];
            const double *from = others->low + 3 * t, *begin = others->least + 2 * (t * sides + s), width = others->cell[t];
            const double *screen = others->front + (t * sides + s) * wide * wide;
            for (int64_t i = 0; i < n; i++) {
                if (!(depth[i] >= front[spot[i]] - cell[k])) continue;
                const double *q = points + 3 * (n * k + i), p[3] = {q[0] - from[0], q[1] - from[1], q[2] - from[2]};
                const double x = (dot(p, frame) - begin[0]) / width, y = (dot(p, frame + 3) - begin[1]) / width;
                if (x < 0 || y < 0 || x >= wide || y >= wide) {
                    own[i] |= (uint64_t)1 << s;
                    continue;
                }
                own[i] |= (uint64_t)(dot(p, frame + 6) >= screen[(int64_t)x * wide + (int64_t)y] - width) << s;
            }
        }
    }
}
