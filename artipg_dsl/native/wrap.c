/* The faces of convex hulls, point by point, as ``geometry.wrap`` has them. However they are found, they are told only where they are
   beyond doubt, which leaves one answer. */

#include "bodies.h"
#include <stdlib.h>

#define CLEAR 1e-14 /* how far beyond a face a point lies that is a corner; the points are within a box of 1 */
#define DEEP 1e-6   /* and how far behind all one that is in no doubt, but for faces that are needles: */
#define NEEDLE 1e-5 /* twice the area of one, by the square of its longest edge at the first corner */

/* a triangle that turns outwards; the face across the edge that begins at each corner; the plane */
typedef struct {
    int64_t corner[3], across[3];
    double normal[3], offset;
    int there, seen;
} face;

typedef struct {
    const double *points;
    face *faces;
    int64_t *unused, *made, *begins; /* faces to be used again; new faces; the new face that begins at a point, or -1 */
    int64_t top, spare; /* faces that were ever there; how many are to be used again */
    unsigned char *deep; /* whether a point lies deep within */
} hull;

static void less(const double *a, const double *b, double *out) {
    for (int i = 0; i < 3; i++) out[i] = a[i] - b[i];
}

static double norm(const double *a) { return sqrt(dot(a, a)); }

static int64_t add(hull *of, int64_t a, int64_t b, int64_t c) {
    const int64_t k = of->spare ? of->unused[--of->spare] : of->top++;
    face *made = of->faces + k;
    double e[3], f[3];
    less(of->points + 3 * b, of->points + 3 * a, e);
    less(of->points + 3 * c, of->points + 3 * a, f);
    cross(e, f, made->normal);
    const double length = norm(made->normal);
    for (int i = 0; i < 3; i++) made->normal[i] /= length > 0 ? length : 1.0;
    made->offset = dot(made->normal, of->points + 3 * a);
    made->corner[0] = a, made->corner[1] = b, made->corner[2] = c;
    made->there = 1, made->seen = 0;
    return k;
}

static void join(face *faces, int64_t k, int64_t with) { /* by the edge that they share */
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            if (faces[k].corner[i] == faces[with].corner[(j + 1) % 3] && faces[k].corner[(i + 1) % 3] == faces[with].corner[j])
                faces[k].across[i] = with, faces[with].across[j] = k;
}

/* Four points far apart; 0 where they span next to nothing. */
static int begin(hull *of, int64_t count) {
    const double *p = of->points;
    double e[3], f[3], n[3], most = -1.0;
    int64_t a = 0, b = 0, c = 0, d = 0, k;
    if (count < 4) return 0;
    for (k = 1; k < count; k++)
        if (p[3 * k] < p[3 * a]) a = k;
    for (k = 0; k < count; k++) {
        less(p + 3 * k, p + 3 * a, e);
        if (dot(e, e) > most) most = dot(e, e), b = k;
    }
    less(p + 3 * b, p + 3 * a, e);
    for (k = 0, most = -1.0; k < count; k++) {
        less(p + 3 * k, p + 3 * a, f);
        cross(e, f, n);
        if (dot(n, n) > most) most = dot(n, n), c = k;
    }
    less(p + 3 * c, p + 3 * a, f);
    cross(e, f, n);
    for (k = 0, most = -1.0; k < count; k++) {
        less(p + 3 * k, p + 3 * a, f);
        if (fabs(dot(n, f)) > most) most = fabs(dot(n, f)), d = k;
    }
    if (!(most > 1e-9)) return 0;
    less(p + 3 * d, p + 3 * a, f);
    if (dot(n, f) > 0) k = b, b = c, c = k; /* d lies behind a, b, c */
    add(of, a, b, c), add(of, a, d, b), add(of, b, d, c), add(of, c, d, a);
    for (k = 0; k < 4; k++)
        for (int64_t with = 0; with < k; with++) join(of->faces, k, with);
    return 1;
}

/* The hull with one more point; 0 where the faces that it lies beyond have no single rim. */
static int extend(hull *of, int64_t point) {
    const double *p = of->points + 3 * point;
    const int64_t top = of->top;
    int64_t k, made = 0, steps = 0;
    int whole = 1;
    double most = -INFINITY;
    for (k = 0; k < top; k++) {
        face *one = of->faces + k;
        const double away = dot(one->normal, p) - one->offset;
        one->seen = one->there && away > CLEAR;
        if (one->there && away > most) most = away;
    }
    of->deep[point] = most < -DEEP;
    if (!(most > CLEAR)) return 1;
    for (k = 0; k < top; k++)
        for (int i = 0; i < 3 && of->faces[k].seen; i++) {
            const int64_t beyond = of->faces[k].across[i];
            if (of->faces[beyond].seen) continue;
            const int64_t a = of->faces[k].corner[i], b = of->faces[k].corner[(i + 1) % 3], own = add(of, a, b, point);
            of->faces[own].across[0] = beyond;
            for (int j = 0; j < 3; j++)
                if (of->faces[beyond].corner[j] == b) of->faces[beyond].across[j] = own;
            whole &= of->begins[a] < 0;
            of->begins[a] = of->made[made++] = own;
        }
    for (k = 0; k < made; k++) {
        face *one = of->faces + of->made[k];
        const int64_t next = of->begins[one->corner[1]];
        whole &= next >= 0;
        if (next >= 0) one->across[1] = next, of->faces[next].across[2] = of->made[k];
    }
    if (whole && made) {
        k = of->made[0];
        do k = of->faces[k].across[1], steps++;
        while (k != of->made[0] && steps <= made);
    }
    for (k = 0; k < made; k++) of->begins[of->faces[of->made[k]].corner[0]] = -1;
    for (k = 0; k < top; k++)
        if (of->faces[k].seen) of->faces[k].there = of->faces[k].seen = 0, of->unused[of->spare++] = k;
    return whole && steps == made;
}

/* Whether a point lies behind a face beyond doubt. */
static int behind(const double *a, const double *normal, double length, double longest, const double *p, double doubt) {
    double w[3];
    less(p, a, w);
    return -dot(normal, w) > doubt * (length + longest * (fabs(w[0]) + fabs(w[1]) + fabs(w[2])));
}

/* Which corner of a face has the least number. */
static int least(const face *of) {
    const int64_t *c = of->corner;
    return c[0] < c[1] ? (c[0] < c[2] ? 0 : 2) : (c[1] < c[2] ? 1 : 2);
}

/* Whether the faces are those of the hull beyond doubt: each corner across an edge, and all that are no corners, lie behind. */
static int certain(const hull *of, int64_t count, double doubt) {
    for (int64_t k = 0; k < of->top; k++) {
        const face *one = of->faces + k;
        double e[3], f[3], n[3];
        if (!one->there) continue;
        const int first = least(one);
        const double *a = of->points + 3 * one->corner[first];
        less(of->points + 3 * one->corner[(first + 1) % 3], a, e);
        less(of->points + 3 * one->corner[(first + 2) % 3], a, f);
        cross(e, f, n);
        const double length = norm(n), longest = dot(e, e) > dot(f, f) ? dot(e, e) : dot(f, f);
        for (int i = 0; i < 3; i++) {
            const face *next = of->faces + one->across[i];
            for (int j = 0; j < 3; j++)
                if (next->corner[j] != one->corner[i] && next->corner[j] != one->corner[(i + 1) % 3] &&
                    !behind(a, n, length, longest, of->points + 3 * next->corner[j], doubt))
                    return 0;
        }
        const int needle = !(length > NEEDLE * longest);
        for (int64_t p = 0; p < count; p++)
            if (of->begins[p] < 0 && (needle || !of->deep[p]) && !behind(a, n, length, longest, of->points + 3 * p, doubt)) return 0;
    }
    return 1;
}

static int in_order(const void *one, const void *other) {
    const int64_t *a = one, *b = other;
    for (int i = 0; i < 3; i++)
        if (a[i] != b[i]) return a[i] < b[i] ? -1 : 1;
    return 0;
}

/* The faces of the hulls of ``count`` sets of points, each begun where ``start`` says, in a box of 1: triples of numbers within the set, one
   after the other in ``found``, with room for twice the points; how many of each are in ``many``, 0 where there is doubt. Returns how many
   there are of all, -1 where there is no memory. */
OUT int64_t wrap(int64_t count, const int64_t *start, const double *points, double doubt, int64_t *many, int64_t *found) {
    int64_t most = 4, told = 0, k, n;
    for (k = 0; k < count; k++)
        if (start[k + 1] - start[k] > most) most = start[k + 1] - start[k];
    const int64_t room = 5 * most; /* 2 most faces, and a new one beyond each of their 3 most edges before the old ones go */
    hull of = {NULL, malloc(room * sizeof(face)), malloc(room * sizeof(int64_t)), malloc(room * sizeof(int64_t)),
               malloc(most * sizeof(int64_t)), 0, 0, malloc(most)};
    if (!of.faces || !of.unused || !of.made || !of.begins || !of.deep) told = -1;
    for (k = 0; k < count && told >= 0; k++) {
        const int64_t size = start[k + 1] - start[k];
        int whole;
        of.points = points + 3 * start[k], of.top = of.spare = many[k] = 0;
        for (n = 0; n < size; n++) of.begins[n] = -1;
        whole = begin(&of, size);
        for (n = 0; n < size && whole; n++) whole = extend(&of, n);
        if (!whole) continue;
        for (n = 0; n < of.top; n++)
            for (int i = 0; i < 3 && of.faces[n].there; i++) of.begins[of.faces[n].corner[i]] = 0; /* from here on: what is a corner */
        if (!certain(&of, size, doubt)) continue;
        int64_t *out = found + 3 * told;
        for (n = 0; n < of.top; n++) {
            if (!of.faces[n].there) continue;
            for (int i = 0; i < 3; i++) out[3 * many[k] + i] = of.faces[n].corner[(least(of.faces + n) + i) % 3];
            many[k]++;
        }
        qsort(out, (size_t)many[k], 3 * sizeof(int64_t), in_order);
        told += many[k];
    }
    free(of.faces), free(of.unused), free(of.made), free(of.begins), free(of.deep);
    return told;
}

/* Which keys are the first of their value in their set, ``first`` (N,); set k from ``start[k]`` to ``start[k + 1]``. -1 without memory. */
OUT int64_t first_of_each(int64_t count, const int64_t *start, const int64_t *keys, unsigned char *first) {
    int64_t most = 1, room = 2;
    for (int64_t k = 0; k < count; k++)
        if (start[k + 1] - start[k] > most) most = start[k + 1] - start[k];
    while (room < 2 * most) room *= 2;
    int64_t *table = malloc(room * sizeof(int64_t)); /* of numbers of keys, or -1 */
    if (!table) return -1;
    for (int64_t k = 0; k < count; k++) {
        const int64_t size = start[k + 1] - start[k];
        uint64_t mask = 1;
        while (mask + 1 < 2 * (uint64_t)size) mask = 2 * mask + 1;
        memset(table, 0xff, (mask + 1) * sizeof(int64_t));
        for (int64_t n = start[k]; n < start[k + 1]; n++) {
            uint64_t at = ((uint64_t)keys[n] * 0x9e3779b97f4a7c15u) >> 20 & mask;
            while (table[at] >= 0 && keys[table[at]] != keys[n]) at = (at + 1) & mask;
            first[n] = table[at] < 0;
            if (first[n]) table[at] = n;
        }
    }
    free(table);
    return 0;
}

/* Whether faces (n, 3) fit each of k sets of points (count, 3), as ``geometry.hulls.fits`` has it: neither the corners ``across`` their
   edges (n, 3) nor any of m ``others`` stand out by more than ``flat``. ``scaled`` holds as many numbers as a set. */
OUT void fit_faces(int64_t k, int64_t count, const double *points, int64_t n, const int64_t *faces, const int64_t *across, int64_t m,
                   const int64_t *others, double flat, double *scaled, unsigned char *out) {
    for (int64_t set = 0; set < k; set++, points += 3 * count) {
        double low[3], high[3], reach = 1e-300;
        int fit = 1;
        for (int i = 0; i < 3; i++) {
            low[i] = high[i] = points[i];
            for (int64_t p = 1; p < count; p++) {
                const double at = points[3 * p + i];
                low[i] = at < low[i] ? at : low[i], high[i] = at > high[i] ? at : high[i];
            }
            reach = high[i] - low[i] > reach ? high[i] - low[i] : reach;
        }
        for (int64_t p = 0; p < 3 * count; p++) scaled[p] = (points[p] - low[p % 3]) / reach;
        for (int64_t face = 0; fit && face < n; face++) {
            const double *a = scaled + 3 * faces[3 * face];
            double e[3], f[3], normal[3], most;
            less(scaled + 3 * faces[3 * face + 1], a, e);
            less(scaled + 3 * faces[3 * face + 2], a, f);
            cross(e, f, normal);
            most = dot(normal, a) + flat * norm(normal) + 1e-18;
            for (int i = 0; i < 3; i++) fit &= dot(normal, scaled + 3 * across[3 * face + i]) <= most; /* no number does not fit */
            for (int64_t p = 0; fit && p < m; p++) fit = dot(normal, scaled + 3 * others[p]) <= most;
        }
        out[set] = (unsigned char)fit;
    }
}
