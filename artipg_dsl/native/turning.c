/* Bodies that turn beside others that stay: the steps of ``validity.validate`` for intervals of angles. Sines and cosines are given:
   they are NumPy's. */

#include "bodies.h"

double swept(const double *corners, int64_t n, const double *turn, const double *shift, const double *axis, const double *origin,
                    double c, double s, const double *direction) {
    double along = dot(axis, direction), flat[3], across[3], off[3], local[3], most = 0.0;
    int i;
    for (i = 0; i < 3; i++) flat[i] = direction[i] - axis[i] * along, off[i] = shift[i] - origin[i];
    cross(flat, axis, across);
    for (int64_t k = 0; k < n; k++) {
        double ahead, aside, radius, reach;
        apply(turn, corners + 3 * k, local);
        for (i = 0; i < 3; i++) local[i] += off[i];
        ahead = dot(local, flat), aside = fabs(dot(local, across));
        radius = sqrt(ahead * ahead + aside * aside);
        reach = ahead >= radius * c ? radius : ahead * c + aside * s;
        reach = along * dot(local, axis) + reach;
        if (k == 0 || !(reach <= most)) most = reach;
        if (most != most) break; /* no number: nothing is proved by it */
    }
    return most + dot(origin, direction);
}

/* n placed bodies, each about an axis through an origin by an angle of cosine ``c`` and sine ``s``, along a direction. */
OUT void sweep(int64_t n, const side *moved, const double *axis, const double *origin, const double *c, const double *s,
               const double *direction, double *out) {
    for (int64_t k = 0; k < n; k++)
        out[k] = swept(moved->corners[k], moved->count[k], moved->turn + 9 * k, moved->shift + 3 * k, axis + 3 * k, origin + 3 * k, c[k],
                       s[k], direction + 3 * k);
}

/* intervals of angles of pairs: axis and origin of the turn, the angle in the middle and half the interval, cosines and sines of both (of
   no more than a half turn), how far a radian advances, the gap that is asked for, null for none; boxes of the pieces at rest */
typedef struct {
    const double *axis, *origin, *middle, *half, *cos_middle, *sin_middle, *cos_half, *sin_half, *advance, *gap, *low, *high;
    const int64_t *piece, *other;
} turns;

/* Which of n pairs meet in the middle of their intervals, and which are proved to stay apart in all of them. */
OUT void examine(int64_t n, const side *moved, const side *still, const turns *all, double near, int64_t steps, unsigned char *hit,
                 unsigned char *apart) {
    for (int64_t k = 0; k < n; k++) {
        const double *axis = all->axis + 3 * k, *origin = all->origin + 3 * k;
        double turn[9], shift[3], v[3], back[3], one[3], two[3], along = all->advance[k] * all->middle[k], least, most, length;
        const int64_t zero = 0;
        const side own = {moved->corners + k, moved->count + k, &zero, turn, shift, NULL, NULL};
        const side other = {still->corners + k, still->count + k, NULL, NULL, NULL, NULL, NULL};
        const double *low = all->low + 3 * all->piece[k], *high = all->high + 3 * all->piece[k];
        const double *lows = all->low + 3 * all->other[k], *highs = all->high + 3 * all->other[k];
        int i;
        rotation(axis, all->cos_middle[k], all->sin_middle[k], turn);
        apply(turn, origin, one);
        for (i = 0; i < 3; i++) shift[i] = origin[i] - one[i] + axis[i] * along;
        for (i = 0; i < 3; i++) two[i] = (low[i] + high[i]) / 2;
        apply(turn, two, one);
        for (i = 0; i < 3; i++) v[i] = one[i] + shift[i] - (lows[i] + highs[i]) / 2;
        if (dot(v, v) < 1e-24) v[0] = 1.0, v[1] = v[2] = 0.0;
        hit[k] = (unsigned char)part(&own, &other, 0, near, steps, v);
        apart[k] = 0;
        if (all->gap) {
            length = sqrt(dot(v, v));
            hit[k] |= length < all->gap[k];
        } else
            length = 0.0;
        if (hit[k]) continue;
        for (i = 0; i < 3; i++) back[i] = -v[i];
        least = -swept(own.corners[0], own.count[0], turn, shift, axis, origin, all->cos_half[k], all->sin_half[k], back);
        least -= fabs(dot(axis, v) * all->advance[k] * all->half[k]);
        support(&other, 0, v, two);
        most = dot(two, v);
        apart[k] = all->gap ? least - most >= all->gap[k] * length : least >= most;
    }
}

/* what lies on links: boxes of links, the range of pieces of each, and boxes of pieces */
typedef struct {
    const double *lows, *highs, *low, *high;
    const int64_t *begin, *end;
} scene;

/* Of n boxes the pieces of the links ``first`` .. ``stop`` whose boxes they overlap; not those of links that a joint moves along: links
   (depth links above each in ``chain``) that hang on ``child``, where that is told. Writes up to ``room`` pairs, returns how many there are. */
OUT int64_t near_pieces(int64_t n, const int64_t *first, const int64_t *stop, const double *low, const double *high, const int64_t *child,
                        int64_t depth, const int64_t *chain, const scene *all, int64_t room, int64_t *box, int64_t *piece) {
    int64_t found = 0;
    for (int64_t k = 0; k < n; k++) {
        const double *a = low + 3 * k, *b = high + 3 * k;
        for (int64_t link = first[k]; link < stop[k]; link++) {
            const double *c = all->lows + 3 * link, *d = all->highs + 3 * link;
            int64_t up = 0;
            if (!(a[0] < d[0] && c[0] < b[0] && a[1] < d[1] && c[1] < b[1] && a[2] < d[2] && c[2] < b[2])) continue;
            if (child) {
                while (up < depth && chain[link * depth + up] != child[k]) up++;
                if (up < depth) continue;
            }
            for (int64_t other = all->begin[link]; other < all->end[link]; other++) {
                const double *e = all->low + 3 * other, *f = all->high + 3 * other;
                if (!(a[0] < f[0] && e[0] < b[0] && a[1] < f[1] && e[1] < b[1] && a[2] < f[2] && e[2] < b[2])) continue;
                if (found < room) box[found] = k, piece[found] = other;
                found++;
            }
        }
    }
    return found;
}

/* Points (k, each, 3) by the turn of each row (k, 3, 3), and a shift (k, 3) after it unless that is null. */
OUT void turn_points(int64_t k, int64_t each, const double *turn, const double *points, const double *shift, double *out) {
    for (int64_t row = 0; row < k; row++, turn += 9)
        for (int64_t n = 0; n < each; n++, points += 3, out += 3) {
            apply(turn, points, out);
            for (int i = 0; shift && i < 3; i++) out[i] += shift[3 * row + i];
        }
}
