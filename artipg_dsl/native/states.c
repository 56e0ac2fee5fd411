/* Bodies in many states of joints: the steps of ``validity.following``, state by state. */

#include "bodies.h"

/* ------------------------------------------------------------ boxes that overlap */

/* a box (low, high) about a box that is turned and shifted */
static void box_of(const double *turn, const double *shift, const double *low, const double *high, double *out) {
    double middle[3], half[3], at, wide;
    int i;
    for (i = 0; i < 3; i++) middle[i] = (low[i] + high[i]) / 2, half[i] = (high[i] - low[i]) / 2;
    for (i = 0; i < 3; i++) {
        const double *row = turn + 3 * i;
        at = dot(row, middle) + shift[i];
        wide = fabs(row[0]) * half[0] + fabs(row[1]) * half[1] + fabs(row[2]) * half[2];
        out[i] = at - wide, out[3 + i] = at + wide;
    }
}

static int meets(const double *a, const double *b) {
    return a[0] < b[3] && b[0] < a[3] && a[1] < b[4] && b[1] < a[4] && a[2] < b[5] && b[2] < a[5];
}

/* what lies on links: ``begin`` and ``end`` of the pieces of each, sorted by link; boxes at rest of pieces and of links */
typedef struct {
    const int64_t *begin, *end, *owner;
    const double *low, *high, *lows, *highs;
} scene;

/* States (S) of links (L): which pieces come near one another, those of the pairs of links ``one``, ``two`` (P) of objects that are
   ``asked`` (S, B). Writes up to ``room`` rows of state, piece, piece to ``found`` and returns how many there are. ``boxes`` holds 6
   numbers for each piece and 12 for each link, ``seen`` (2 L) and ``rows`` (pieces) are room to work in. */
OUT int64_t near_in_states(
    int64_t states, int64_t links, int64_t objects, const double *turn, const double *shift, const scene *all, int64_t pairs,
    const int64_t *one, const int64_t *two, const unsigned char *asked, int64_t pieces, double *boxes, int64_t *seen, int64_t *rows,
    int64_t room, int64_t *found) {
    double *whole = boxes + 6 * pieces, *held = whole + 6 * links;
    int64_t *posed = seen, *filled = seen + links, total = 0, s, p, k, n, side;
    for (k = 0; k < 2 * links; k++) seen[k] = -1;
    for (s = 0; s < states; s++) {
        for (p = 0; p < pairs; p++) {
            const int64_t both[2] = {one[p], two[p]};
            if (!asked[s * objects + all->owner[both[0]]]) continue;
            for (side = 0; side < 2; side++) {
                int64_t l = both[side], at = s * links + l;
                if (posed[l] == s) continue;
                posed[l] = s;
                box_of(turn + 9 * at, shift + 3 * at, all->lows + 3 * l, all->highs + 3 * l, whole + 6 * l);
            }
            if (!meets(whole + 6 * both[0], whole + 6 * both[1])) continue;
            for (side = 0; side < 2; side++) {
                int64_t l = both[side], at = s * links + l;
                double *around = held + 6 * l;
                if (filled[l] == s) continue;
                filled[l] = s;
                for (k = all->begin[l]; k < all->end[l]; k++) {
                    double *box = boxes + 6 * k;
                    box_of(turn + 9 * at, shift + 3 * at, all->low + 3 * k, all->high + 3 * k, box);
                    for (n = 0; n < 3; n++) {
                        if (k == all->begin[l] || box[n] < around[n]) around[n] = box[n];
                        if (k == all->begin[l] || box[3 + n] > around[3 + n]) around[3 + n] = box[3 + n];
                    }
                }
            }
            n = 0;
            for (k = all->begin[both[1]]; k < all->end[both[1]]; k++)
                if (meets(boxes + 6 * k, held + 6 * both[0])) rows[n++] = k;
            for (k = all->begin[both[0]]; n && k < all->end[both[0]]; k++) {
                const double *box = boxes + 6 * k;
                if (!meets(box, held + 6 * both[1])) continue;
                for (int64_t m = 0; m < n; m++) {
                    if (!meets(box, boxes + 6 * rows[m])) continue;
                    if (total < room) found[3 * total] = s, found[3 * total + 1] = k, found[3 * total + 2] = rows[m];
                    total++;
                }
            }
        }
    }
    return total;
}

/* ------------------------------------------------------------ bodies that overlap */

/* a direction that parted two pieces, in the frames of both */
typedef struct {
    int64_t piece, other;
    double own[2][3];
} way;

enum { WAYS = 1 << 14 };

OUT int64_t way_size(void) { return WAYS * (int64_t)sizeof(way); }

/* whether a direction keeps the bodies ``k`` apart by more than ``clear`` */
static int parts(const side *first, const side *second, int64_t k, const double *v, double clear) {
    double back[3] = {-v[0], -v[1], -v[2]}, one[3], two[3], off[3];
    support(first, k, back, one);
    support(second, k, v, two);
    for (int i = 0; i < 3; i++) off[i] = one[i] - two[i];
    return dot(v, off) > clear;
}

/* Which of n pairs of pieces overlap: a direction that parted the same two before is tried first, as it turns with the one and as it
   turns with the other. ``low``, ``high``: boxes of the pieces at rest; ``kept``: ``way_size`` bytes to work in. */
OUT void meet_in_states(
    int64_t n, const side *first, const side *second, const int64_t *piece, const int64_t *other, const double *low, const double *high,
    double clear, int64_t steps, void *kept, unsigned char *hit) {
    way *known = kept;
    int64_t k;
    int i, end;
    for (k = 0; k < WAYS; k++) known[k].piece = -1;
    for (k = 0; k < n; k++) {
        way *own = known + (((uint64_t)piece[k] * 2654435761u + (uint64_t)other[k] * 40503u) & (WAYS - 1));
        const side *sides[2] = {first, second};
        const double *turns[2] = {first->turn + 9 * first->pose[k], second->turn + 9 * second->pose[k]};
        double v[3], places[2][3], length;
        hit[k] = 0;
        if (own->piece == piece[k] && own->other == other[k]) {
            for (end = 0; end < 2; end++) {
                apply(turns[end], own->own[end], v);
                if (parts(first, second, k, v, clear)) break;
            }
            if (end < 2) continue;
        }
        for (end = 0; end < 2; end++) {
            int64_t at = 3 * (end ? other[k] : piece[k]);
            double middle[3];
            for (i = 0; i < 3; i++) middle[i] = (low[at + i] + high[at + i]) / 2;
            apply(turns[end], middle, places[end]);
            for (i = 0; i < 3; i++) places[end][i] += sides[end]->shift[3 * sides[end]->pose[k] + i];
        }
        for (i = 0; i < 3; i++) v[i] = places[0][i] - places[1][i];
        if (dot(v, v) < 1e-24) v[0] = 1.0, v[1] = v[2] = 0.0;
        hit[k] = (unsigned char)part(first, second, k, 0.5, steps, v);
        length = sqrt(dot(v, v));
        if (hit[k] || !(length > 0.0)) continue;
        for (i = 0; i < 3; i++) v[i] /= length;
        own->piece = piece[k], own->other = other[k];
        for (end = 0; end < 2; end++) apply_back(turns[end], v, own->own[end]);
    }
}
