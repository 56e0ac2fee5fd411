/* Points on surfaces by the hundred thousand: the loops of ``geometry.points`` and ``geometry.hidden`` over candidates. */

#include "bodies.h"

/* Numbers in (0, 1), two for each lane: of n streams the ``count`` from ``lane`` on, as ``random.coarse`` has them. */
OUT void coarse(int64_t n, const uint64_t *stream, const int64_t *lane, const int64_t *count, double *u, double *v) {
    for (int64_t k = 0; k < n; k++)
        for (int64_t i = 0; i < count[k]; i++) {
            uint64_t word = (uint64_t)(lane[k] + i + 1) * 0x9E3779B97F4A7C15u + stream[k];
            word = (word ^ word >> 30) * 0xBF58476D1CE4E5B9u;
            word = (word ^ word >> 27) * 0x94D049BB133111EBu;
            word ^= word >> 31;
            *u++ = ((double)(word >> 32) + 0.5) * 0x1p-32;
            *v++ = ((double)(word & 0xFFFFFFFFu) + 0.5) * 0x1p-32;
        }
}

/* Of n objects, which have ``count`` rows in ``order`` from ``start`` on: pairs of different rows of one whose boxes (rows, 3) meet, of which
   the first is ``asked``. Writes up to ``room`` of them and returns how many there are. */
OUT int64_t near_rows(int64_t n, const int64_t *start, const int64_t *count, const int64_t *order, const double *low, const double *high,
                      const unsigned char *asked, int64_t room, int64_t *near, int64_t *other) {
    int64_t found = 0;
    for (int64_t k = 0; k < n; k++)
        for (int64_t i = start[k]; i < start[k] + count[k]; i++) {
            const double *a = low + 3 * order[i], *b = high + 3 * order[i];
            if (!asked[order[i]]) continue;
            for (int64_t j = start[k]; j < start[k] + count[k]; j++) {
                const double *c = low + 3 * order[j], *d = high + 3 * order[j];
                if (!(a[0] <= d[0] && c[0] <= b[0] && a[1] <= d[1] && c[1] <= b[1] && a[2] <= d[2] && c[2] <= b[2]) || i == j) continue;
                if (found < room) near[found] = order[i], other[found] = order[j];
                found++;
            }
        }
    return found;
}

/* cells and rows that may hide points on them: quads (4, 3, all) in the frames of the rows, packed ends of the fractions that these
   reach, and whether the last vector of the quad counts */
typedef struct {
    const double *quad;
    const uint32_t *least, *most;
    const unsigned char *planar;
} pairs;

/* Of n pairs, ``asked``, each with a run of points: the points within reach, and where they are in the frame of the row (3, room). */
OUT int64_t near_flat(int64_t n, const int64_t *asked, const int64_t *start, const int64_t *count, const double *u, const double *v,
                      const uint32_t *spot, int64_t all, const pairs *of, int64_t room, int64_t *pair, int64_t *point, double *local) {
    int64_t found = 0;
    for (int64_t k = 0; k < n; k++) {
        const int64_t own = asked[k];
        const uint32_t least = of->least[own], most = of->most[own];
        for (int64_t at = start[k]; at < start[k] + count[k]; at++) {
            if (((spot[at] - least) | (most - spot[at])) & 0x80008000u) continue;
            for (int axis = 0; axis < 3; axis++) {
                const double *q = of->quad + axis * all + own;
                double place = q[0] + u[at] * q[3 * all] + v[at] * q[6 * all];
                if (of->planar[own]) place += u[at] * v[at] * q[9 * all];
                local[axis * room + found] = place;
            }
            pair[found] = own, point[found++] = at;
        }
    }
    return found;
}

/* poses of rows (9, all), (3, all), (all,) and boxes (3, all) in the frame of the object */
typedef struct {
    const double *rotation, *translation, *mirror, *low, *high;
} rows;

/* Of n points, ``asked``, at ``place`` (3, points) and rows that may hide each, a run of ``others``: which lie in the row's box, and where in
   its frame (3, room). */
OUT int64_t near_loose(int64_t n, const int64_t *asked, const int64_t *start, const int64_t *count, const int64_t *others, int64_t points,
                       const double *place, int64_t all, const rows *of, int64_t room, int64_t *other, int64_t *point, double *local) {
    int64_t found = 0;
    for (int64_t k = 0; k < n; k++) {
        const double p[3] = {place[asked[k]], place[points + asked[k]], place[2 * points + asked[k]]};
        for (int64_t at = start[k]; at < start[k] + count[k]; at++) {
            const int64_t row = others[at];
            double off[3];
            int axis;
            for (axis = 0; axis < 3; axis++)
                if (!(p[axis] >= of->low[axis * all + row] && p[axis] <= of->high[axis * all + row])) break;
            if (axis < 3) continue;
            for (axis = 0; axis < 3; axis++) off[axis] = p[axis] - of->translation[axis * all + row];
            for (axis = 0; axis < 3; axis++) {
                const double *turn = of->rotation + axis * all + row;
                local[axis * room + found] = turn[0] * off[0] + turn[3 * all] * off[1] + turn[6 * all] * off[2];
            }
            local[room + found] *= of->mirror[row];
            other[found] = row, point[found++] = asked[k];
        }
    }
    return found;
}

/* cells (3, all) and (all,), and the rows they are of */
typedef struct {
    const double *origin, *a, *b, *c, *normal;
    const signed char *shape;
    const int64_t *row, *patch, *site, *table_row;
} surfaces;

/* points bound to cells that are not flat, sorted: which candidates they are, where (3, loose) and which way out */
typedef struct {
    const int64_t *at;
    const double *place, *normal;
} bent;

/* where points go */
typedef struct {
    int32_t *site, *row;
    int16_t *patch;
    double *u, *v, *position, *normal;
} points;

/* Of the candidates of n pools, ``wanted`` of each, those that are not hidden, as many as there is room for, thinned evenly by a ``shift``:
   written from ``target`` on, or where ``place`` has these places. Candidates come by cells, from ``first`` on, which have ``count``; ``flat``: the
   kind whose last vector counts. */
OUT void keep_points(int64_t n, const int64_t *wanted, const int64_t *seen, const int64_t *room, const int64_t *shift, const int64_t *target,
                     const unsigned char *hidden, const double *u, const double *v, int64_t first, const int64_t *count, int64_t all,
                     int64_t flat, const surfaces *of, int64_t loose, const bent *others, const int64_t *place, points *out) {
    int64_t at = 0, cell = first, left = count[0], nth = 0;
    for (int64_t k = 0; k < n; k++) {
        int64_t rank = 0, next = target[k];
        for (int64_t i = 0; i < wanted[k]; i++, at++, left--) {
            while (!left) left = count[++cell - first];
            const int64_t own = nth < loose && others->at[nth] == at ? nth++ : -1;
            if (hidden[at]) continue;
            if (room[k] < seen[k] && (rank++ * room[k] + shift[k]) % seen[k] + room[k] < seen[k]) continue;
            const int64_t to = place ? place[next] : next;
            next++;
            out->site[to] = (int32_t)of->site[of->row[cell]], out->row[to] = (int32_t)of->table_row[of->row[cell]];
            out->patch[to] = (int16_t)of->patch[cell];
            out->u[to] = u[at], out->v[to] = v[at];
            for (int axis = 0; axis < 3; axis++) {
                const int64_t c = axis * all + cell, b = axis * loose + own;
                double where;
                if (own >= 0)
                    where = others->place[b];
                else {
                    where = of->origin[c] + u[at] * of->a[c] + v[at] * of->b[c];
                    if (of->shape[cell] == flat) where += u[at] * v[at] * of->c[c];
                }
                out->position[3 * to + axis] = where;
                out->normal[3 * to + axis] = own >= 0 ? others->normal[b] : of->normal[c];
            }
        }
    }
}

/* frames of rows: turns (9, all) and shifts (3, all) that carry them to the object, mirrors (all,), and centres (3, all) that are taken off
   there; null where there is none */
typedef struct {
    const double *turn, *shift, *mirror, *center;
} frames;

/* Of vectors (.., 3) those ``at`` (n,), each in the frame of its row: the coordinates along some ``axes`` (many,), (n,) each. */
OUT void in_frames(int64_t n, const int64_t *at, const int64_t *row, const double *vectors, int64_t all, const frames *of, int64_t many,
                   const int64_t *axes, double *const *out) {
    for (int64_t k = 0; k < n; k++) {
        const int64_t own = row[k];
        const double *given = vectors + 3 * at[k];
        double off[3];
        for (int i = 0; i < 3; i++) off[i] = of->shift ? given[i] - of->shift[i * all + own] : given[i];
        for (int64_t i = 0; i < many; i++) {
            const double *turn = of->turn + axes[i] * all + own;
            double value = turn[0] * off[0] + turn[3 * all] * off[1] + turn[6 * all] * off[2];
            if (axes[i] == 1) value *= of->mirror[own];
            out[i][k] = of->center ? value - of->center[axes[i] * all + own] : value;
        }
    }
}
