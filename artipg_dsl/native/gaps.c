/* How far the hull of several convex pieces reaches from them, as ``geometry.merge`` has it. */

#include "bodies.h"

#define MOST 64 /* ways at most */

typedef struct {
    const double *points, *normals, *offsets;
    const int64_t *point_start, *face_start;
} stock;

typedef struct {
    int64_t ways;
    const double *way; /* (ways, 3) what extreme points are extreme along */
    double tolerance;
} asked;

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
    for (int64_t w = 0; w < ways; w++) best[w] = -INFINITY, first[w] = -1; /* none, where all are no numbers */
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
   points; returns the face of the nearest piece that the first of such places is farthest beyond, counted over all pieces. */
OUT int64_t deepest(const double *points, const int64_t *point_start, const double *normals, const double *offsets,
                    const int64_t *face_start, int64_t ways, const double *way, const int64_t *pieces, int64_t count, double *depth) {
    const stock of = {points, normals, offsets, point_start, face_start};
    const double *corner[MOST];
    const int64_t many = extreme(&of, count, pieces, ways, way, corner);
    int64_t face = 0, hint = 0;
    double most = -INFINITY;
    for (int64_t i = 0; i < many; i++)
        for (int64_t j = i + 1; j < many; j++) {
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

/* Whether a point lies beyond no face of a piece by more than ``tolerance``. */
static int holds(const stock *of, int64_t piece, const double *p, double tolerance) {
    for (int64_t f = of->face_start[piece]; f < of->face_start[piece + 1]; f++)
        if (dot(of->normals + 3 * f, p) - of->offsets[f] > tolerance) return 0;
    return 1;
}

/* Whether ``deepest`` of ``pieces`` (count,) is at most the tolerance: asked without how far it is. */
static int within(const stock *of, const asked *ask, int64_t count, const int64_t *pieces) {
    const double *corner[MOST];
    int64_t hint = 0;
    if (count < 2) return 1;
    const int64_t many = extreme(of, count, pieces, ask->ways, ask->way, corner);
    for (int64_t i = 0; i < many; i++)
        for (int64_t j = i + 1; j < many; j++) {
            double p[3];
            int64_t k = 0;
            for (int n = 0; n < 3; n++) p[n] = (corner[i][n] + corner[j][n]) / 2;
            if (holds(of, pieces[hint], p, ask->tolerance)) continue;
            while (k < count && !holds(of, pieces[k], p, ask->tolerance)) k++;
            if (k == count) return 0;
            hint = k;
        }
    return 1;
}

/* Parts one after the other, each the ``pieces`` from ``begin`` to before ``end``, put together as long as the hull of all reaches from
   them by no more than is asked: which cluster each is of, ``found`` (parts,). ``row`` has room for all pieces of the parts. */
static void put_together(const stock *of, const asked *ask, const int64_t *pieces, int64_t parts, const int64_t *begin, const int64_t *end,
                         int64_t *row, int64_t *found) {
    int64_t count = 0, cluster = -1;
    for (int64_t k = 0; k < parts; k++) {
        const int64_t more = end[k] - begin[k];
        memcpy(row + count, pieces + begin[k], sizeof(int64_t) * more);
        if (k && within(of, ask, count + more, row)) {
            count += more;
        } else {
            memmove(row, row + count, sizeof(int64_t) * more);
            count = more;
            cluster++;
        }
        found[k] = cluster;
    }
}

OUT void chain(const double *points, const int64_t *point_start, const double *normals, const double *offsets, const int64_t *face_start,
               int64_t ways, const double *way, double tolerance, const int64_t *pieces, int64_t parts, const int64_t *begin,
               const int64_t *end, int64_t *row, int64_t *found) {
    const stock of = {points, normals, offsets, point_start, face_start};
    const asked ask = {ways, way, tolerance};
    put_together(&of, &ask, pieces, parts, begin, end, row, found);
}

/* Where the sector ``k`` of ``count`` begins among ``steps``. */
static int64_t sector(int64_t steps, int64_t k, int64_t count) { return (steps * k + count - 1) / count; }

/* Whether the hulls of so many sectors of each of ``names``, whose pieces begin at ``start``, reach from them by no more than is asked;
   of several names, steps around an axis are alike. */
static int fits(const stock *of, const asked *ask, const int64_t *pieces, int64_t names, const int64_t *start, int64_t count) {
    for (int64_t m = 0; m < names; m++)
        for (int64_t at = 0; at < (names == 1 ? count : 2); at++) {
            const int64_t k = names == 1 ? at : at * (count / 4), steps = start[m + 1] - start[m];
            const int64_t first = sector(steps, k, count), last = sector(steps, k + 1, count);
            if (!within(of, ask, last - first, pieces + start[m] + first)) return 0;
        }
    return 1;
}

/* ``_grid`` of ``names`` whose pieces begin at ``start`` (names + 1,): labels from ``label`` on to ``found``; returns the next label.
   ``room`` (4, names), ``row`` as for ``put_together``. */
static int64_t grid(const stock *of, const asked *ask, const int64_t *pieces, int64_t names, const int64_t *start, int64_t numbers,
                    const int64_t *sectors, int64_t label, int64_t *room, int64_t *row, int64_t *found) {
    int64_t most = 0, low = 0, high = 0, *begin = room, *end = room + names, *together = room + 2 * names;
    for (int64_t m = 0; m < names; m++)
        if (start[m + 1] - start[m] > most) most = start[m + 1] - start[m];
    while (high < numbers && sectors[high] < most) high++;
    const int64_t last = high;
    while (low < high) { /* with more sectors gaps are less */
        const int64_t middle = (low + high) / 2;
        if (fits(of, ask, pieces, names, start, sectors[middle])) high = middle;
        else low = middle + 1;
    }
    const int64_t count = low < last ? sectors[low] : most;
    for (int64_t m = 0; m < names; m++)
        begin[m] = start[m], end[m] = start[m] + sector(start[m + 1] - start[m], 1, count);
    together[0] = 0;
    if (names > 1) put_together(of, ask, pieces, names, begin, end, row, together);
    for (int64_t k = 0; k < count; k++)
        for (int64_t m = 0, next; m < names; m = next) {
            int64_t any = 0;
            for (next = m; next < names && together[next] == together[m]; next++) {
                const int64_t steps = start[next + 1] - start[next], to = start[next] + sector(steps, k + 1, count);
                for (int64_t at = start[next] + sector(steps, k, count); at < to; at++) found[at] = label, any = 1;
            }
            label += any;
        }
    return label;
}

/* ``clusters`` of every primitive among ``pieces`` (count,), ``unit`` and ``name`` (count,) of each: which cluster each is of, ``found``.
   ``sectors`` (numbers,) is how many there may be, ascending; ``room`` (6 * count + 1,). */
OUT void cluster(const double *points, const int64_t *point_start, const double *normals, const double *offsets, const int64_t *face_start,
                 int64_t ways, const double *way, double tolerance, const int64_t *pieces, int64_t count, const int64_t *unit,
                 const int64_t *name, int64_t numbers, const int64_t *sectors, int64_t *room, int64_t *found) {
    const stock of = {points, normals, offsets, point_start, face_start};
    const asked ask = {ways, way, tolerance};
    int64_t label = 0, *row = room, *start = room + count, *more = start + count + 1;
    for (int64_t from = 0, to; from < count; from = to) {
        int64_t names = 0, single = 0;
        for (to = from; to < count && unit[to] == unit[from];) { /* a run of names of one step, or of several */
            int64_t next = to + 1;
            while (next < count && unit[next] == unit[from] && name[next] == name[to]) next++;
            if (names && single != (next == to + 1)) break;
            single = next == to + 1;
            start[names++] = to;
            to = start[names] = next;
        }
        if (!single) {
            label = grid(&of, &ask, pieces, names, start, numbers, sectors, label, more, row, found);
            continue;
        }
        put_together(&of, &ask, pieces, names, start, start + 1, row, more);
        for (int64_t m = 0; m < names; m++) found[start[m]] = label + more[m];
        label += more[names - 1] + 1;
    }
}
