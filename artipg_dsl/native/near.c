/* The nearest of points that stand in many sets, each looked for in a set of its own: what ``fit.near`` asks for. */

#include "bodies.h"

#define LEAF 10   /* points that are not divided further */
#define MOST 6    /* axes, three at least */
#define BESIDE 16 /* neighbours at most */

/* points (n, axes) in the order of the tree, which numbers they had, and the nodes: the axis that divides them, -1 for a leaf; where their
   points begin and end, or their first and second child; where the first child ends along the axis, and where the second begins */
typedef struct {
    int64_t axes;
    double *place;
    int64_t *number, *node;
    double *gap;
} tree;

static int64_t grow(const tree *of, int64_t begin, int64_t end, int64_t *count) {
    const int64_t axes = of->axes, own = (*count)++;
    int64_t *node = of->node + 3 * own, widest = 0;
    double low[MOST], high[MOST];
    for (int64_t a = 0; a < axes; a++) low[a] = INFINITY, high[a] = -INFINITY;
    for (int64_t k = begin; k < end; k++)
        for (int64_t a = 0; a < axes; a++) {
            const double x = of->place[k * axes + a];
            if (x < low[a]) low[a] = x;
            if (x > high[a]) high[a] = x;
        }
    for (int64_t a = 1; a < axes; a++)
        if (high[a] - low[a] > high[widest] - low[widest]) widest = a;
    const double middle = low[widest] + 0.5 * (high[widest] - low[widest]);
    if (end - begin <= LEAF || !(middle > low[widest]) || !(middle < high[widest])) {
        node[0] = -1, node[1] = begin, node[2] = end;
        return own;
    }
    int64_t first = begin, last = end;
    double before = -INFINITY, behind = INFINITY;
    while (first < last) {
        double *one = of->place + first * axes, x = one[widest];
        if (x <= middle) {
            if (x > before) before = x;
            first++;
            continue;
        }
        if (x < behind) behind = x;
        double *other = of->place + --last * axes;
        const int64_t held = of->number[first];
        of->number[first] = of->number[last], of->number[last] = held;
        for (int64_t a = 0; a < axes; a++) {
            const double y = one[a];
            one[a] = other[a], other[a] = y;
        }
    }
    node[0] = widest;
    of->gap[2 * own] = before, of->gap[2 * own + 1] = behind;
    const int64_t left = grow(of, begin, first, count);
    const int64_t right = grow(of, first, end, count);
    node[1] = left, node[2] = right;
    return own;
}

/* Trees of ``sets``, whose points lie at ``place`` one set after the other, ``many`` of each, with their ``number``s: both are put in the order
   of the trees. ``root``: the first node of each set, -1 for one without points; ``box``: its corners (2, axes). */
OUT void plant(int64_t sets, const int64_t *many, int64_t axes, double *place, int64_t *number, int64_t *node, double *gap, int64_t *root,
               double *box) {
    const tree of = {axes, place, number, node, gap};
    int64_t begin = 0, count = 0;
    for (int64_t s = 0; s < sets; begin += many[s++]) {
        double *low = box + 2 * axes * s, *high = low + axes;
        for (int64_t a = 0; a < axes; a++) low[a] = INFINITY, high[a] = -INFINITY;
        for (int64_t k = begin; k < begin + many[s]; k++)
            for (int64_t a = 0; a < axes; a++) {
                const double x = place[k * axes + a];
                if (x < low[a]) low[a] = x;
                if (x > high[a]) high[a] = x;
            }
        root[s] = many[s] ? grow(&of, begin, begin + many[s], &count) : -1;
    }
}

/* a point that is looked for: the nearest so far, ``most`` at most, by the squares of their distances, the nearest first; ``far``: how large
   these may be */
typedef struct {
    const tree *of;
    const double *x;
    double off[MOST], apart[BESIDE], far;
    int64_t nearest[BESIDE], found, most;
} search;

static void look(search *by, int64_t at, double apart) {
    const tree *of = by->of;
    const int64_t axes = of->axes, *node = of->node + 3 * at;
    if (node[0] < 0) {
        for (int64_t k = node[1]; k < node[2]; k++) {
            const double *place = of->place + k * axes;
            const double one = by->x[0] - place[0], two = by->x[1] - place[1], three = by->x[2] - place[2];
            double away = one * one + two * two + three * three;
            if (!(away < by->far)) continue;
            for (int64_t a = 3; a < axes; a++) {
                const double off = by->x[a] - place[a];
                away += off * off;
            }
            if (!(away < by->far)) continue;
            int64_t rank = by->found < by->most ? by->found++ : by->most - 1;
            for (; rank && by->apart[rank - 1] > away; rank--)
                by->apart[rank] = by->apart[rank - 1], by->nearest[rank] = by->nearest[rank - 1];
            by->apart[rank] = away, by->nearest[rank] = of->number[k];
            if (by->found == by->most) by->far = by->apart[by->most - 1];
        }
        return;
    }
    const int64_t axis = node[0];
    const double x = by->x[axis], before = x - of->gap[2 * at], behind = of->gap[2 * at + 1] - x, held = by->off[axis];
    const int second = behind < before;
    const double off = second ? before : behind;
    look(by, node[1 + second], apart);
    const double then = apart - held * held + off * off;
    if (then * (1.0 - 1e-12) >= by->far) return; /* rounding must not hide a point */
    by->off[axis] = off;
    look(by, node[2 - second], then);
    by->off[axis] = held;
}

/* Of n points (n, axes), the ``most`` nearest (n, most) of the set ``of`` which each is looked for in, by their numbers, ``none`` where there
   are no more within the distance ``within``; and how far these lie (n, most). */
OUT void nearest_of(int64_t n, const double *points, const int64_t *of, int64_t axes, double *place, int64_t *number, int64_t *node, double *gap,
                    int64_t sets, const int64_t *root, const double *box, int64_t most, double within, int64_t none, int64_t *found,
                    double *apart) {
    const tree all = {axes, place, number, node, gap};
    for (int64_t k = 0; k < n; k++) {
        const int64_t set = of[k];
        search by = {&all, points + k * axes, {0}, {0}, within * within, {0}, 0, most};
        if (set >= 0 && set < sets && root[set] >= 0) {
            double away = 0.0;
            for (int64_t a = 0; a < axes; a++) {
                const double *low = box + 2 * axes * set + a, x = by.x[a];
                by.off[a] = x < low[0] ? low[0] - x : x > low[axes] ? x - low[axes] : 0.0;
                away += by.off[a] * by.off[a];
            }
            if (away * (1.0 - 1e-12) < by.far) look(&by, root[set], away);
        }
        for (int64_t r = 0; r < most; r++) {
            found[k * most + r] = r < by.found ? by.nearest[r] : none;
            apart[k * most + r] = r < by.found ? sqrt(by.apart[r]) : INFINITY;
        }
    }
}
