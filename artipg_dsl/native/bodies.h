/* Convex bodies in pairs, as all files here see them. Each sum and product stands in the order in which NumPy's code has it, so that
   the bits are the same; compiled without contraction of products and sums. */

#ifndef BODIES_H
#define BODIES_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#if defined(_WIN32)
#define OUT __declspec(dllexport)
#else
#define OUT __attribute__((visibility("default")))
#endif

/* a side of all pairs: where the corners of each body lie and how many they are; its turn and shift from rest, those of the number
   ``pose`` where that is told, or the shifts between which it is swept; null where there is none */
typedef struct {
    const double *const *corners;
    const int64_t *count, *pose;
    const double *turn, *shift, *first, *last;
} side;

static inline double dot(const double *a, const double *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static inline void cross(const double *a, const double *b, double *out) {
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void apply(const double *turn, const double *v, double *out) {
    for (int i = 0; i < 3; i++) out[i] = turn[3 * i] * v[0] + turn[3 * i + 1] * v[1] + turn[3 * i + 2] * v[2];
}

static inline void apply_back(const double *turn, const double *v, double *out) {
    for (int i = 0; i < 3; i++) out[i] = turn[i] * v[0] + turn[3 + i] * v[1] + turn[6 + i] * v[2];
}

/* the point of body ``k`` that lies farthest along a direction */
void support(const side *body, int64_t k, const double *direction, double *out);

/* whether two bodies overlap; ``v``, at first from the second to the first, becomes a direction in which the first lies beyond the second */
int part(const side *first, const side *second, int64_t k, double near, int64_t steps, double *v);

#endif
