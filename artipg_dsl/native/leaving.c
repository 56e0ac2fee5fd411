/* Parallel rays from points of objects, and the triangles that they enter, as ``geometry.outside`` has them. */

#include "bodies.h"

/* sorted by object, of which each has those between two ``ends`` (objects + 1,): numbers of their vertices ``face`` (3, count), ``normal``
   (3, count), ``cell`` (count,) */
typedef struct {
    const int64_t *face, *cell, *ends;
    const double *normal;
    int64_t count;
} triangles;

/* ``vertex`` (3, vertices); of each its place ``flat`` (2, vertices) and its bins (2, vertices), of so many ``wide``, across; two axes across the
   rays, and their way; how many bins there are in a metre, ``scale`` (2, objects) */
typedef struct {
    const double *vertex, *flat;
    const int16_t *bins;
    const double *frame, *scale;
    int64_t vertices, objects, wide;
} picture;

/* m points (3, m), by the axes of the frame; the bin of each, among those of all objects, one after the other; or null, the cells ``own`` (m,) */
typedef struct {
    const double *point;
    const int64_t *bin, *own;
    int64_t count;
} rays;

static void span(const int16_t *bins, const int64_t *corner, int64_t *low, int64_t *high) {
    *low = *high = bins[corner[0]];
    for (int k = 1; k < 3; k++) {
        const int64_t bin = bins[corner[k]];
        *low = bin < *low ? bin : *low;
        *high = bin > *high ? bin : *high;
    }
}

/* Which of the rays enter none of the triangles: ``leaves`` (m,), all of it 1 at first; of points with cells, which leave none from behind but those
   of that cell. ``there`` (objects,): which objects have points. Room to work in: ``begin`` (objects * wide * wide + 1,), all of it 0, and
   ``order`` (m,). */
OUT void leave(const triangles *all, const picture *seen, const rays *some, const uint8_t *there, double edge, int64_t *begin,
               int64_t *order, uint8_t *leaves) {
    const int64_t wide = seen->wide, m = some->count, many = all->count, bins = seen->objects * wide * wide;
    const double *axis = seen->frame, *way = seen->frame + 6, side = some->own ? -1.0 : 1.0;
    const double *px = some->point, *py = px + m, *pz = py + m;

    for (int64_t k = 0; k < m; k++) begin[some->bin[k] + 1]++;
    for (int64_t k = 0; k < bins; k++) begin[k + 1] += begin[k];
    for (int64_t k = m; k-- > 0;) order[--begin[some->bin[k] + 1]] = k; /* now the points of bin k begin at begin[k + 1] */
    for (int64_t k = 0; k < bins; k++) begin[k] = begin[k + 1];
    begin[bins] = m;

    for (int64_t o = 0; o < seen->objects; o++) {
        if (!there[o]) continue;
        const double size = edge / (seen->scale[o] * seen->scale[seen->objects + o]);
        for (int64_t t = all->ends[o]; t < all->ends[o + 1]; t++) {
            const double n[3] = {all->normal[t], all->normal[many + t], all->normal[2 * many + t]};
            const double slope = way[0] * n[0] + way[1] * n[1] + way[2] * n[2];
            if (!(some->own ? slope > 0.0 : slope < 0.0)) continue;
            const int64_t corner[3] = {all->face[t], all->face[many + t], all->face[2 * many + t]};
            int64_t left, right, bottom, top;
            span(seen->bins, corner, &left, &right);
            span(seen->bins + seen->vertices, corner, &bottom, &top);
            double x[3], y[3], deep, a[3], b[3], c[3], turned[3];
            int known = 0;
            for (int64_t row = bottom; row <= top; row++) {
                const int64_t head = (o * wide + row) * wide;
                const int64_t first = begin[head + left], last = begin[head + right + 1];
                if (first == last) continue;
                if (!known) {
                    for (int k = 0; k < 3; k++) {
                        const int64_t v = corner[some->own ? 2 - k : k];
                        x[k] = seen->flat[v], y[k] = seen->flat[seen->vertices + v];
                    }
                    const double *v = seen->vertex + corner[some->own ? 2 : 0];
                    deep = way[0] * v[0] + way[1] * v[seen->vertices] + way[2] * v[2 * seen->vertices];
                    for (int k = 0; k < 3; k++) {
                        const int next = (k + 1) % 3;
                        a[k] = y[k] - y[next], b[k] = x[next] - x[k], c[k] = x[k] * y[next] - x[next] * y[k];
                        turned[k] = axis[3 * k] * (side * n[0]) + axis[3 * k + 1] * (side * n[1]) + axis[3 * k + 2] * (side * n[2]);
                    }
                    known = 1;
                }
                for (int64_t at = first; at < last; at++) {
                    const int64_t k = order[at];
                    if (!leaves[k]) continue;
                    if (!(a[0] * px[k] + b[0] * py[k] + c[0] <= size)) continue;
                    if (!(a[1] * px[k] + b[1] * py[k] + c[1] <= size)) continue;
                    if (!(a[2] * px[k] + b[2] * py[k] + c[2] <= size)) continue;
                    const double gap = turned[0] * (x[0] - px[k]) + turned[1] * (y[0] - py[k]) + turned[2] * (deep - pz[k]);
                    if (gap < 0.0 && !(some->own && some->own[k] == all->cell[t])) leaves[k] = 0;
                }
            }
        }
    }
}

/* Where vertices (3, vertices) lie across rays, by two axes (2, 3) across: ``flat`` (2, vertices), and their bins, of so many ``wide`` each way,
   ``bins`` (2, vertices), in pictures of objects, of ``many`` (objects,) vertices each, that begin at ``origin`` (2, objects) with ``scale``
   (2, objects) bins a metre. Those of objects that are not ``there`` (objects,) are left as they are. */
OUT void lay_flat(const double *vertex, int64_t vertices, const int64_t *many, int64_t objects, const uint8_t *there, const double *axes,
                  const double *origin, const double *scale, int64_t wide, double *flat, int16_t *bins) {
    const double *x = vertex, *y = x + vertices, *z = y + vertices;
    for (int k = 0; k < 2; k++, flat += vertices, bins += vertices) {
        const double f = axes[3 * k], g = axes[3 * k + 1], h = axes[3 * k + 2], last = (double)(wide - 1);
        for (int64_t o = 0, v = 0; o < objects; o++) {
            const double from = origin[k * objects + o], each = scale[k * objects + o];
            if (!there[o]) {
                v += many[o];
                continue;
            }
            for (int64_t end = v + many[o]; v < end; v++) {
                const double place = f * x[v] + g * y[v] + h * z[v], bin = (place - from) * each;
                flat[v] = place;
                bins[v] = (int16_t)(bin > 0.0 ? bin < last ? bin : last : 0.0);
            }
        }
    }
}
