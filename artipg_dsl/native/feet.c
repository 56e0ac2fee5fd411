/* On what objects stand: outlines of feet in the plane, as ``validity.hull`` has them, and whether objects tip over their edges, as
   ``validity.stance`` has it. */

#include "bodies.h"

typedef void loop(char **, const ptrdiff_t *, const ptrdiff_t *, void *);

/* Leaves out of n points those well inside the polygon of the outermost ones along some ``ways`` (many, 2), and all but one of the same. */
static int64_t outermost(int64_t n, double *x, double *y, unsigned char *inside, int64_t many, const double *ways, double well) {
    int64_t left = 0, first = 0, last = 0;
    int any = 0;
    for (int64_t k = 0; k < n; k++) inside[k] = 1;
    for (int64_t way = 0; way <= many; way++, last = first) {
        const double *along = ways + 2 * (way % many);
        double most = -INFINITY, e, f, length;
        for (int64_t k = 0; k < n; k++)
            if (x[k] * along[0] + y[k] * along[1] > most) most = x[k] * along[0] + y[k] * along[1], first = k;
        if (!way) continue;
        e = x[first] - x[last], f = y[first] - y[last], length = sqrt(e * e + f * f);
        if (!(length > 0.0)) continue; /* one point is outermost in several directions */
        any = 1;
        for (int64_t k = 0; k < n; k++) inside[k] &= e * (y[k] - y[last]) - f * (x[k] - x[last]) > well * length;
    }
    for (int64_t k = 0; k < n; k++) {
        int64_t same = 0;
        if (any && inside[k]) continue;
        while (same < left && !(x[same] == x[k] && y[same] == y[k])) same++;
        if (same == left) x[left] = x[k], y[left++] = y[k];
    }
    return left;
}

/* Corners of the outlines of sets of points (each, 2), where they are ``valid``, one set after the other; how many each has (sets,). Angles
   are told by ``atan2``, NumPy's own loop. ``room`` holds six numbers for each point of a set. */
OUT void outlines(int64_t sets, int64_t each, const double *points, const unsigned char *valid, int64_t few, int64_t many, const double *ways,
                  double near, double well, void *atan2, void *data, double *room, int64_t *count, double *out) {
    double *x = room, *y = x + each, *ahead = y + each, *aside = ahead + each, *turn = aside + each, *length = turn + each;
    const ptrdiff_t steps[3] = {sizeof(double), sizeof(double), sizeof(double)};
    for (int64_t set = 0; set < sets; set++, points += 2 * each, valid += each) {
        double along[2] = {0.0, -1.0}, low = INFINITY, at[2] = {NAN, NAN}, first[2];
        int64_t n = 0, made = 0;
        ptrdiff_t total;
        for (int64_t k = 0; k < each; k++)
            if (valid[k]) x[n] = points[2 * k], y[n++] = points[2 * k + 1];
        if (each > few) n = outermost(n, x, y, (unsigned char *)ahead, many, ways, well);
        for (int64_t k = 0; k < n; k++) low = x[k] < low ? x[k] : low;
        for (int64_t k = 0; k < n; k++)
            if (x[k] <= low + near && !(at[1] <= y[k])) at[0] = x[k], at[1] = y[k];
        first[0] = at[0], first[1] = at[1];
        for (total = n; made <= n; made++) {
            char *args[3] = {(char *)aside, (char *)ahead, (char *)turn};
            double least = INFINITY, far = -1.0, back[2];
            int64_t best = -1;
            *out++ = at[0], *out++ = at[1];
            for (int64_t k = 0; k < n; k++) {
                const double a = x[k] - at[0], b = y[k] - at[1];
                length[k] = sqrt(a * a + b * b);
                ahead[k] = a * along[0] + b * along[1], aside[k] = along[0] * b - along[1] * a;
            }
            ((loop *)atan2)(args, &total, steps, data);
            for (int64_t k = 0; k < n; k++) {
                turn[k] += near;
                if (turn[k] < 0.0) turn[k] += 2 * 3.141592653589793;
                if (length[k] > near && turn[k] < least) least = turn[k];
            }
            for (int64_t k = 0; k < n; k++)
                if (length[k] > near && turn[k] <= least + near && length[k] > far) far = length[k], best = k;
            if (best < 0) break;
            back[0] = x[best] - first[0], back[1] = y[best] - first[1];
            if (!(back[0] * back[0] + back[1] * back[1] > near * near)) break;
            along[0] = (x[best] - at[0]) / far, along[1] = (y[best] - at[1]) / far;
            at[0] = x[best], at[1] = y[best];
        }
        count[set] = made + 1;
    }
}

/* what objects weigh: centre (3), floor, mass and what nested joints may move of it (kg m) of each; where in ``order`` the overlaps and in
   ``turn`` the joints of each begin (one more than there are); of joints what they move the centre by (steps, 3) */
typedef struct {
    const double *center, *floor, *total, *spare;
    const int64_t *begin, *order, *from, *turn;
    int64_t steps;
    const double *values;
} standing;

/* overlaps: of which primitive each is and what that weighs; the box at rest, the ball about what moves, and whether it rests; what may be
   lost at most, and what the box would hold */
typedef struct {
    const int64_t *row;
    const double *own, *place, *half, *ball, *radius;
    const unsigned char *rests;
    const double *most, *full;
} overlaps;

/* how far a point lies beyond an edge, less its height by the tilt */
static double beyond(const double *p, const double *foot, const double *normal, double floor, double tilt) {
    return (p[0] - foot[0]) * normal[0] + (p[1] - foot[1]) * normal[1] - tilt * (p[2] - floor);
}

static double larger(double a, double b) { return a > b ? a : b; }

static double smaller(double a, double b) { return a < b ? a : b; }

/* Of n edges of objects ``of``, through ``foot`` along ``normal`` (n, 2): whether the objects stand for certain over all of theirs, and
   whether they tip over one. */
OUT void over_edges(int64_t n, const int64_t *of, const double *foot, const double *normal, const standing *them, const overlaps *over,
                    double tangent, double steep, double sampled, double rounding, unsigned char *stands, unsigned char *tips) {
    for (int64_t edge = 0; edge < n; edge++, foot += 2, normal += 2) {
        const int64_t own = of[edge];
        const double floor = them->floor[own], total = them->total[own];
        for (int level = 0; level < 2; level++) {
            const double tilt = level ? 0.0 : tangent, rest = beyond(them->center + 3 * own, foot, normal, floor, tilt);
            double moved = 0.0, gone = 0.0, gained = 0.0;
            for (int64_t k = them->from[own]; k < them->from[own + 1]; k++) {
                const double *way = them->values + 3 * them->steps * them->turn[k];
                double least = 0.0;
                for (int64_t step = 0; step < them->steps; step++, way += 3)
                    least = smaller(way[0] * normal[0] + way[1] * normal[1] - tilt * way[2], least);
                moved += least;
            }
            for (int64_t k = them->begin[own]; k < them->begin[own + 1];) {
                const int64_t row = over->row[them->order[k]], first = them->order[k];
                double lost = 0.0, reach = -INFINITY, missed = 0.0, out = -INFINITY;
                for (; k < them->begin[own + 1] && over->row[them->order[k]] == row; k++) {
                    const int64_t at = them->order[k];
                    const double *half = over->half + 3 * at, kg = over->most[at];
                    const double middle = beyond(over->place + 3 * at, foot, normal, floor, tilt);
                    const double wide = fabs(normal[0]) * half[0] + fabs(normal[1]) * half[1] + tilt * half[2];
                    double most = middle + wide, taken;
                    if (!over->rests[at]) most = beyond(over->ball + 3 * at, foot, normal, floor, tilt) + steep * over->radius[at];
                    most = larger(most, 0.0);
                    taken = kg * most;
                    if (over->rests[at] && most > 0.0) { /* no more than the box has */
                        const double all = (middle + wide) * (middle + wide) / larger(4 * wide, 1e-300);
                        taken = smaller(taken, over->full[at] * ((middle >= wide ? middle : all) + sampled * wide));
                    }
                    lost += taken, reach = larger(most, reach);
                    most = larger(wide - middle, 0.0); /* outside of the edge */
                    missed += kg * most, out = larger(most, out);
                }
                gone += smaller(lost, over->own[first] * reach);
                gained += smaller(missed, over->own[first] * out);
            }
            if (!((rest + moved) * total - gone - steep * them->spare[own] > rounding * total)) stands[own] = 0;
            if (!level && rest * total + gained < -rounding * total) tips[own] = 1;
        }
    }
}
