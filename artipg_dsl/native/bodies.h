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

/* the rotation about a unit axis by an angle of which ``c`` and ``s`` are cosine and sine */
static inline void rotation(const double *axis, double c, double s, double *out) {
    const double t = 1.0 - c, x = axis[0], y = axis[1], z = axis[2];
    out[0] = x * x * t + c, out[1] = x * y * t - z * s, out[2] = x * z * t + y * s;
    out[3] = x * y * t + z * s, out[4] = y * y * t + c, out[5] = y * z * t - x * s;
    out[6] = x * z * t - y * s, out[7] = y * z * t + x * s, out[8] = z * z * t + c;
}

/* the point of body ``k`` that lies farthest along a direction */
void support(const side *body, int64_t k, const double *direction, double *out);

/* whether two bodies overlap; ``v``, at first from the second to the first, becomes a direction in which the first lies beyond the second */
int part(const side *first, const side *second, int64_t k, double near, int64_t steps, double *v);

/* how far a body of n corners, posed, reaches along a direction while it turns about an axis through an origin by up to an angle either way,
   of which ``c`` and ``s`` are cosine and sine */
double swept(const double *corners, int64_t n, const double *turn, const double *shift, const double *axis, const double *origin, double c,
             double s, const double *direction);

#endif
