/* How far the hull of several convex pieces reaches from them, as ``geometry.merge`` has it. */

#include "bodies.h"

#define MOST 64 /* ways at most */

typedef struct {
    const double *points, *normals, *offsets;
    const int64_t *point_start, *face_start;
} stock;

/* How far a point lies beyond the farthest of a piece's faces; what is ``enough`` ends the search. */
static double beyond(const stock *of, int64_t piece, const double *p, double enough) {
    double most = -INFINITY;
    for (int64_t f = of->face_start[piece]; f < of->face_start[piece + 1] && most < enough; f++) {
        const double away = dot(of->normals + 3 * f, p) - of->offsets[f];
        if (away > most) most = away;
    }
    return most;
}

/* The numbers of the points that reach farthest along ``way`` (ways, 3), with all extents scaled to 1; in order, each once. */
static int64_t extreme(const stock *of, int64_t count, const int64_t *pieces, int64_t ways, const double *way, const double **found) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY}, extent[3], best[MOST];
    int64_t first[MOST], at, number = 0;
    const double *farthest[MOST];
    for (int64_t k = 0; k < count; k++)
        for (at = of->point_start[pieces[k]]; at < of->point_start[pieces[k] + 1]; at++)
            for (int i = 0; i < 3; i++) {
                const double x = of->points[3 * at + i];
                if (x < low[i]) low[i] = x;
                if (x > high[i]) high[i] = x;
            }
    for (int i = 0; i < 3; i++) extent[i] = high[i] - low[i] > 1e-12 ? high[i] - low[i] : 1e-12;
    for (int64_t w = 0; w < ways; w++) best[w] = -INFINITY;
    for (int64_t k = 0; k < count; k++)
        for (at = of->point_start[pieces[k]]; at < of->point_start[pieces[k] + 1]; at++, number++) {
            const double *p = of->points + 3 * at;
            const double scaled[3] = {(p[0] - low[0]) / extent[0], (p[1] - low[1]) / extent[1], (p[2] - low[2]) / extent[2]};
            for (int64_t w = 0; w < ways; w++) {
                const double reach = dot(way + 3 * w, scaled);
                if (reach > best[w]) best[w] = reach, first[w] = number, farthest[w] = p;
            }
        }
    int64_t many = 0;
    for (int64_t last = -1;; many++) { /* the next larger number */
        int64_t next = -1;
        for (int64_t w = 0; w < ways; w++)
            if (first[w] > last && (next < 0 || first[w] < first[next])) next = w;
        if (next < 0) return many;
        last = first[next];
        found[many] = farthest[next];
    }
}

/* How far the hull of ``pieces`` (count,) reaches from the nearest where it does most, ``depth``, among the middles of pairs of extreme
   points; returns the face of the nearest piece that the first of such places is farthest beyond, counted over all pieces. What reaches
   farther than ``enough`` may be told by any place that does. */
OUT int64_t deepest(int64_t count, const int64_t *pieces, const double *points, const int64_t *point_start, const double *normals,
                    const double *offsets, const int64_t *face_start, int64_t ways, const double *way, double enough, double *depth) {
    const stock of = {points, normals, offsets, point_start, face_start};
    const double *corner[MOST];
    const int64_t many = extreme(&of, count, pieces, ways, way, corner);
    int64_t face = 0, hint = 0;
    double most = -INFINITY;
    for (int64_t i = 0; i < many; i++)
        for (int64_t j = i + 1; j < many && most <= enough; j++) {
            double p[3], least;
            int64_t k, near = hint, base = 0;
            for (int n = 0; n < 3; n++) p[n] = (corner[i][n] + corner[j][n]) / 2;
            least = beyond(&of, pieces[hint], p, INFINITY); /* a neighbour's nearest piece is likely this one's */
            for (k = 0; k < count && least > most; k++) {
                const double away = beyond(&of, pieces[k], p, least);
                if (away < least) least = away, near = k;
            }
            hint = near;
            if (least <= most) continue;
            most = least;
            for (k = 0; k < count && beyond(&of, pieces[k], p, INFINITY) > least; k++) /* of equals the first */
                base += face_start[pieces[k] + 1] - face_start[pieces[k]];
            for (int64_t f = face_start[pieces[k]]; f < face_start[pieces[k] + 1]; f++)
                if (dot(normals + 3 * f, p) - offsets[f] == least) {
                    face = base + f - face_start[pieces[k]];
                    break;
                }
        }
    *depth = most;
    return face;
}
