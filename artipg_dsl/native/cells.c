/* Two pieces and intervals of several joints: the steps of ``validity.together``, cell by cell. Sines and cosines are given: they are
   NumPy's. */

#include "bodies.h"

/* the joints of a batch, at rest: unit axes and points on them, what a radian advances, whether each turns or slides */
typedef struct {
    const double *axis, *origin, *advance;
    const unsigned char *turns, *slides;
} joints;

/* n cells with c joints each, those of the first piece in the first half of the columns: joint (-1: none), middle and half of its interval,
   cosine and sine of both where it turns (of half of it up to a half turn), how far a corner moves for one unit; the pieces, and boxes of
   all pieces at rest */
typedef struct {
    const int64_t *joint, *piece, *other;
    const double *middle, *wide, *cos_middle, *sin_middle, *cos_wide, *sin_wide, *radius, *low, *high;
} cells;

enum { MOST = 64 }; /* columns of one side */

static void advanced(const joints *all, int64_t joint, double by, double *shift) {
    const double along = (all->slides[joint] ? 1.0 : all->advance[joint]) * by;
    for (int i = 0; i < 3; i++) shift[i] = shift[i] + all->axis[3 * joint + i] * along;
}

/* turn and shift from rest by joints from the innermost to the outermost, and their axes and points on them there */
static void posed(const joints *all, const cells *of, int64_t at, int64_t half, double *turn, double *shift, double axis[][3],
                  double origin[][3]) {
    int64_t column, inner;
    int i, j;
    for (i = 0; i < 9; i++) turn[i] = i % 4 == 0;
    shift[0] = shift[1] = shift[2] = 0.0;
    for (column = 0; column < half; column++) {
        const int64_t joint = of->joint[at + column];
        double own[9], moved[3], next[9], column_of[3], made[3];
        if (joint < 0) continue;
        memcpy(axis[column], all->axis + 3 * joint, sizeof moved);
        memcpy(origin[column], all->origin + 3 * joint, sizeof moved);
        rotation(axis[column], of->cos_middle[at + column], of->sin_middle[at + column], own);
        apply(own, origin[column], made);
        for (i = 0; i < 3; i++) moved[i] = origin[column][i] - made[i];
        advanced(all, joint, of->middle[at + column], moved);
        for (j = 0; j < 3; j++) {
            for (i = 0; i < 3; i++) column_of[i] = turn[3 * i + j];
            apply(own, column_of, made);
            for (i = 0; i < 3; i++) next[3 * i + j] = made[i];
        }
        memcpy(turn, next, sizeof next);
        apply(own, shift, made);
        for (i = 0; i < 3; i++) shift[i] = made[i] + moved[i];
        for (inner = 0; inner < column; inner++) {
            if (of->joint[at + inner] < 0) continue;
            apply(own, axis[inner], made);
            memcpy(axis[inner], made, sizeof made);
            apply(own, origin[inner], made);
            for (i = 0; i < 3; i++) origin[inner][i] = made[i] + moved[i];
        }
    }
}

/* Of each cell: whether the pieces meet in the middle, the unit direction that parts them there and how far it does, how far each joint
   alone takes them towards one another (n, c), how far those of either side together do at most (2, n), how far the piece of that side
   reaches that way (2, n), and whether several of its joints move. 0 if there are too many joints. */
OUT int64_t examine_cells(
    int64_t n, int64_t c, const side *first, const side *second, const joints *all, const cells *of, double near, int64_t steps,
    unsigned char *hit, double *away, double *length, double *between, double *loss, double *bounds, double *least, unsigned char *many) {
    const int64_t half = c / 2;
    if (half > MOST) return 0;
    for (int64_t k = 0; k < n; k++) {
        double turn[2][9], shift[2][3], axis[2][MOST][3], origin[2][MOST][3], place[2][3], *v = away + 3 * k;
        const int64_t zero = 0, piece[2] = {of->piece[k], of->other[k]};
        const side own[2] = {{first->corners + k, first->count + k, &zero, turn[0], shift[0], NULL, NULL},
                             {second->corners + k, second->count + k, &zero, turn[1], shift[1], NULL, NULL}};
        int i, end;
        for (end = 0; end < 2; end++) {
            double middle[3];
            posed(all, of, k * c + end * half, half, turn[end], shift[end], axis[end], origin[end]);
            for (i = 0; i < 3; i++) middle[i] = (of->low[3 * piece[end] + i] + of->high[3 * piece[end] + i]) / 2;
            apply(turn[end], middle, place[end]);
            for (i = 0; i < 3; i++) place[end][i] += shift[end][i];
        }
        for (i = 0; i < 3; i++) v[i] = place[0][i] - place[1][i];
        if (dot(v, v) < 1e-24) v[0] = 1.0, v[1] = v[2] = 0.0;
        hit[k] = (unsigned char)part(&own[0], &own[1], 0, near, steps, v);
        length[k] = sqrt(dot(v, v));
        if (!(length[k] >= 1e-12)) length[k] = length[k] != length[k] ? length[k] : 1e-12;
        for (i = 0; i < 3; i++) v[i] /= length[k];
        between[k] = 0.0;
        for (end = 0; end < 2; end++) {
            const int64_t at = k * c + end * half;
            double ahead[3], point[3], reached, alone = 0.0, inner = 0.0;
            int64_t column, last = -1, moving = 0;
            for (i = 0; i < 3; i++) ahead[i] = end ? v[i] : -v[i];
            support(&own[end], 0, ahead, point);
            reached = least[end * n + k] = dot(point, ahead);
            between[k] -= reached;
            for (column = 0; column < half; column++) {
                const int64_t joint = of->joint[at + column];
                double far, along;
                loss[at + column] = 0.0;
                if (joint < 0 || !(of->wide[at + column] > 0.0)) continue;
                last = column, moving++;
                far = swept(own[end].corners[0], own[end].count[0], turn[end], shift[end], axis[end][column], origin[end][column],
                            of->cos_wide[at + column], of->sin_wide[at + column], ahead) - reached;
                along = (all->slides[joint] ? 1.0 : fabs(all->advance[joint])) * of->wide[at + column];
                loss[at + column] = (far > 0.0 || far != far ? far : 0.0) + fabs(dot(axis[end][column], ahead)) * along;
            }
            for (column = 0; column < half; column++) {
                alone = alone + loss[at + column];
                inner = inner + (column < last ? of->wide[at + column] * of->radius[at + column] : 0.0);
            }
            many[end * n + k] = moving > 1;
            bounds[end * n + k] = moving > 1 ? loss[at + last] + inner : alone;
        }
    }
    return 1;
}

/* ------------------------------------------------------------ corners on the way of several joints */

enum { PLACES = 8 };

/* what one joint of a cell makes of a corner: turns by so many angles, each with how much farther out it puts it, and ways along */
typedef struct {
    const double *axis, *origin;
    double turn[PLACES][9], wider[PLACES], slide[PLACES];
    int64_t count;
} step;

/* how far n corners reach along a direction, and ``beyond``, when the joints are at each of their places: from the outermost joint on, what
   it does to a corner is done to the direction instead, once for all of them */
static double farthest(const step *steps, int64_t left, const double *ahead, double beyond, const double *corners, int64_t n) {
    double most = -INFINITY, value, bare[3], way[3], along, started;
    int64_t k;
    while (left && !steps[left - 1].count) left--;
    if (!left) {
        for (k = 0; k < n; k++) {
            value = dot(corners + 3 * k, ahead) + beyond;
            if (value > most) most = value;
            if (value != value) return value;
        }
        return most;
    }
    const step *own = steps + left - 1;
    along = dot(ahead, own->axis), started = dot(ahead, own->origin);
    for (k = 0; k < own->count; k++) {
        apply_back(own->turn[k], ahead, bare);
        for (int i = 0; i < 3; i++) way[i] = bare[i] * own->wider[k] + own->axis[i] * ((1.0 - own->wider[k]) * along);
        value = beyond + (started + along * own->slide[k]) - dot(way, own->origin);
        value = farthest(steps, left - 1, way, value, corners, n);
        if (value > most) most = value;
        if (value != value) return value;
    }
    return most;
}

/* How far n pieces reach along directions while their joints (n, c) go through their intervals: for each ``count`` places of up to 8, with
   cosine and sine of the angle, what the way out is multiplied by, and the way along the axis (n, c, 8). 0 if there are too many joints. */
OUT int64_t reach_of_cells(int64_t n, int64_t c, const side *body, const joints *all, const int64_t *joint, const int64_t *count,
                           const double *cosine, const double *sine, const double *wider, const double *slide, const double *ahead,
                           double *out) {
    step steps[MOST];
    if (c > MOST) return 0;
    for (int64_t k = 0; k < n; k++) {
        for (int64_t column = 0; column < c; column++) {
            const int64_t at = k * c + column;
            step *own = steps + column;
            own->count = joint[at] >= 0 ? count[at] : 0;
            if (!own->count) continue;
            own->axis = all->axis + 3 * joint[at], own->origin = all->origin + 3 * joint[at];
            for (int64_t p = 0; p < own->count; p++) {
                rotation(own->axis, cosine[at * PLACES + p], sine[at * PLACES + p], own->turn[p]);
                own->wider[p] = wider[at * PLACES + p], own->slide[p] = slide[at * PLACES + p];
            }
        }
        out[k] = farthest(steps, c, ahead + 3 * k, 0.0, body->corners[k], body->count[k]);
    }
    return 1;
}
