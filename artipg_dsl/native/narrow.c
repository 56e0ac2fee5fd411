/* Which convex bodies overlap: the steps of ``geometry.collide``, pair by pair in place of all pairs at once. */

#include "bodies.h"

/* ------------------------------------------------------------ the point of a tetrahedron nearest the origin */

static void offer(const double s[4][3], int n, const int *which, const double *share, int valid, double *best, double *weight) {
    double point[3], square;
    int i, k;
    if (!valid) return;
    for (i = 0; i < 3; i++) {
        point[i] = share[0] * s[which[0]][i];
        for (k = 1; k < n; k++) point[i] += share[k] * s[which[k]][i];
    }
    square = dot(point, point);
    if (!(square < *best * (1.0 - 1e-12))) return;
    *best = square;
    for (i = 0; i < 4; i++) weight[i] = 0.0;
    for (k = 0; k < n; k++) weight[which[k]] = share[k];
}

static const int PAIRS[6][2] = {{0, 1}, {0, 2}, {0, 3}, {1, 2}, {1, 3}, {2, 3}};
static const int TRIPLES[4][3] = {{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}};

static void nearest_of(const double s[4][3], double *value, double *weight) {
    double best = INFINITY, a[3], b[3], c[3], o[3], p[3], q[3], r[3], share[4];
    int i, k;
    for (i = 0; i < 4; i++) weight[i] = 0.0;
    for (i = 0; i < 4; i++) {
        share[0] = 1.0;
        offer(s, 1, &i, share, 1, &best, weight);
    }
    for (k = 0; k < 6; k++) {
        const double *from = s[PAIRS[k][0]], *to = s[PAIRS[k][1]];
        double square, t;
        for (i = 0; i < 3; i++) a[i] = to[i] - from[i];
        square = dot(a, a);
        t = -dot(from, a) / (square > 0 ? square : 1.0);
        share[0] = 1.0 - t;
        share[1] = t;
        offer(s, 2, PAIRS[k], share, square > 1e-30 && t > 0 && t < 1, &best, weight);
    }
    for (k = 0; k < 4; k++) {
        const double *from = s[TRIPLES[k][0]], *one = s[TRIPLES[k][1]], *two = s[TRIPLES[k][2]];
        double aa, ab, bb, pa, pb, det, safe, u, v;
        for (i = 0; i < 3; i++) {
            a[i] = one[i] - from[i];
            b[i] = two[i] - from[i];
        }
        aa = dot(a, a), ab = dot(a, b), bb = dot(b, b);
        pa = -dot(from, a), pb = -dot(from, b);
        det = aa * bb - ab * ab;
        safe = det > 0 ? det : 1.0;
        u = (bb * pa - ab * pb) / safe;
        v = (aa * pb - ab * pa) / safe;
        share[0] = 1.0 - u - v;
        share[1] = u;
        share[2] = v;
        offer(s, 3, TRIPLES[k], share, det > 1e-14 * aa * bb && u > 0 && v > 0 && u + v < 1, &best, weight);
    }
    for (i = 0; i < 3; i++) {
        a[i] = s[1][i] - s[0][i];
        b[i] = s[2][i] - s[0][i];
        c[i] = s[3][i] - s[0][i];
        o[i] = -s[0][i];
    }
    cross(b, c, p);
    cross(o, c, q);
    cross(b, o, r);
    {
        double volume = dot(a, p), scale = sqrt(dot(a, a) * dot(b, b) * dot(c, c));
        int solid = fabs(volume) > 1e-12 * scale;
        double safe = solid ? volume : 1.0;
        double u = dot(o, p) / safe, v = dot(a, q) / safe, w = dot(a, r) / safe, rest = 1.0 - u - v - w;
        if (solid && rest > 0 && u > 0 && v > 0 && w > 0) weight[0] = rest, weight[1] = u, weight[2] = v, weight[3] = w;
    }
    for (i = 0; i < 3; i++) {
        value[i] = weight[0] * s[0][i];
        for (k = 1; k < 4; k++) value[i] += weight[k] * s[k][i];
    }
}

/* Tetrahedra (n, 4, 3): the points (n, 3) nearest the origin and their weights (n, 4). */
OUT void closest(int64_t n, const double *simplex, double *value, double *weight) {
    for (int64_t k = 0; k < n; k++) nearest_of((const double(*)[3])(simplex + 12 * k), value + 3 * k, weight + 4 * k);
}

/* ------------------------------------------------------------ pairs of bodies */

void support(const side *body, int64_t k, const double *direction, double *out) {
    int64_t i, n = body->count[k], at = 0, pose = body->pose ? body->pose[k] : k;
    const double *corners = body->corners[k], *turn = body->turn ? body->turn + 9 * pose : NULL;
    double own[3], best, value;
    if (turn)
        apply_back(turn, direction, own);
    else
        memcpy(own, direction, sizeof own);
    best = dot(corners, own);
    for (i = 1; i < n; i++) {
        value = dot(corners + 3 * i, own);
        if (value > best) best = value, at = i;
    }
    corners += 3 * at;
    if (body->first) {
        const double *first = body->first + 3 * k, *last = body->last + 3 * k;
        const double *end = dot(first, own) >= dot(last, own) ? first : last;
        for (i = 0; i < 3; i++) out[i] = corners[i] + end[i];
    } else if (turn && body->shift) {
        apply(turn, corners, out);
        for (i = 0; i < 3; i++) out[i] += body->shift[3 * pose + i];
    } else
        memcpy(out, corners, sizeof own);
}

static void between(const side *first, const side *second, int64_t k, const double *v, double *out) {
    double back[3] = {-v[0], -v[1], -v[2]}, one[3], two[3];
    support(first, k, back, one);
    support(second, k, v, two);
    for (int i = 0; i < 3; i++) out[i] = one[i] - two[i];
}

int part(const side *first, const side *second, int64_t k, double near, int64_t steps, double *v) {
    double s[4][3], weight[4] = {1.0, 0.0, 0.0, 0.0}, point[3], size, least;
    int i, inside = 0, apart = 0;
    between(first, second, k, v, point);
    size = sqrt(dot(point, point)) + sqrt(dot(v, v));
    least = size * size;
    least = 1e-22 * (least < 1e-12 ? 1e-12 : least);
    for (i = 0; i < 4; i++) memcpy(s[i], point, sizeof point);
    memcpy(v, point, sizeof point);
    for (int64_t step = 0; step < steps; step++) {
        double away, length;
        int slot = 0;
        between(first, second, k, v, point);
        away = dot(v, point);
        length = dot(v, v);
        apart |= away > 1e-12 * size * sqrt(length);
        if ((apart && away >= near * length) || length - away <= 1e-10 * length) break;
        for (i = 1; i < 4; i++)
            if (weight[i] < weight[slot]) slot = i;
        memcpy(s[slot], point, sizeof point);
        nearest_of((const double(*)[3])s, v, weight);
        inside = dot(v, v) <= least || (weight[0] > 0 && weight[1] > 0 && weight[2] > 0 && weight[3] > 0);
        if (inside) break;
    }
    return inside && !apart;
}

/* Pairs of bodies: whether they overlap (n,), and in ``nearest`` (n, 3), at first from body to body, the direction in which the first
   lies beyond the second. */
OUT void separate(int64_t n, const side *first, const side *second, double near, int64_t steps, double *nearest, unsigned char *hit) {
    for (int64_t k = 0; k < n; k++) hit[k] = (unsigned char)part(first, second, k, near, steps, nearest + 3 * k);
}

/* ------------------------------------------------------------ bodies whose faces are moved inwards */

/* Corners (points, 3) of n bodies, those of each from ``first`` on, with the planes of their faces (triangles, 3) moved inwards by
   ``margin``. ``cells`` holds 9 numbers for each point, ``normals`` 3 for each face and ``ends`` 4 for each body; ``owner`` (points). */
OUT void inset(int64_t n, const int64_t *first, int64_t points, const double *place, int64_t triangles, const int64_t *faces, double margin,
               double *cells, double *normals, double *ends, int64_t *owner, double *out) {
    int64_t k, f;
    int i, j;
    for (k = 0; k < n; k++) {
        const int64_t stop = k + 1 < n ? first[k + 1] : points;
        for (i = 0; i < 3; i++) {
            double low = place[3 * first[k] + i], high = low;
            for (f = first[k] + 1; f < stop; f++) {
                const double at = place[3 * f + i];
                if (at < low) low = at;
                if (at > high) high = at;
            }
            ends[4 * k + i] = (low + high) / 2;
        }
        ends[4 * k + 3] = 0.0;
        for (f = first[k]; f < stop; f++) owner[f] = k;
    }
    for (f = 0; f < triangles; f++) { /* which way the faces of each body run */
        const double *a = place + 3 * faces[3 * f], *b = place + 3 * faces[3 * f + 1], *c = place + 3 * faces[3 * f + 2];
        double one[3], two[3], *normal = normals + 3 * f, *end = ends + 4 * owner[faces[3 * f]], length;
        for (i = 0; i < 3; i++) one[i] = b[i] - a[i], two[i] = c[i] - a[i];
        cross(one, two, normal);
        length = sqrt(dot(normal, normal));
        for (i = 0; i < 3; i++) normal[i] = length > 0 ? normal[i] / length : 0.0, one[i] = a[i] - end[i];
        end[3] += dot(normal, one);
    }
    memset(cells, 0, (size_t)points * 9 * sizeof *cells);
    for (f = 0; f < triangles; f++) {
        double v[3];
        for (i = 0; i < 3; i++) v[i] = ends[4 * owner[faces[3 * f]] + 3] < 0.0 ? -normals[3 * f + i] : normals[3 * f + i];
        for (j = 0; j < 3; j++) {
            double *cell = cells + 9 * faces[3 * f + j];
            for (i = 0; i < 3; i++) cell[i] += v[i] * v[i], cell[6 + i] += v[i];
            cell[3] += v[1] * v[2], cell[4] += v[2] * v[0], cell[5] += v[0] * v[1];
        }
    }
    for (k = 0; k < points; k++) {
        const double *cell = cells + 9 * k;
        const double a = cell[0] + 1e-6, b = cell[1] + 1e-6, c = cell[2] + 1e-6, d = cell[3], e = cell[4], f_ = cell[5];
        const double aa = b * c - d * d, bb = a * c - e * e, cc = a * b - f_ * f_;
        const double dd = e * f_ - a * d, ee = f_ * d - b * e, ff = d * e - c * f_;
        const double det = a * aa + f_ * ff + e * ee, x = -cell[6], y = -cell[7], z = -cell[8];
        double move[3] = {aa * x + ff * y + ee * z, ff * x + bb * y + dd * z, ee * x + dd * y + cc * z}, reach, most;
        for (i = 0; i < 3; i++) move[i] /= det > 0 ? det : 1.0;
        reach = sqrt(dot(move, move));
        most = 20.0 / (reach > 1e-300 ? reach : 1e-300);
        for (i = 0; i < 3; i++) out[3 * k + i] = place[3 * k + i] + margin * (move[i] * (most < 1.0 ? most : 1.0));
    }
}
