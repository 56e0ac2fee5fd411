/* Normals of meshes for pictures, as ``robot.shading`` has them. Sums are made by NumPy's own loop, which adds in an order of its own. */

#include "bodies.h"

typedef void loop(char **, const ptrdiff_t *, const ptrdiff_t *, void *);

static void to_unit(const double *v, double *out) {
    const double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++) out[i] = length > 0 ? v[i] / length : i == 2 ? 1.0 : 0.0;
}

/* Of k meshes of n vertices and of triangles ``faces`` (f, 3): unit normals (k, f, 3), and the cosines (k, f, 3) of their corners. */
OUT void shade_faces(int64_t k, int64_t n, int64_t f, const double *vertices, const int64_t *faces, double *normal, double *cosine) {
    for (int64_t row = 0; row < k; row++, vertices += 3 * n)
        for (int64_t face = 0; face < f; face++, normal += 3, cosine += 3) {
            double edge[3][3], length[3], made[3];
            int i, j;
            for (j = 0; j < 3; j++) {
                const double *from = vertices + 3 * faces[3 * face + j], *to = vertices + 3 * faces[3 * face + (j + 1) % 3];
                for (i = 0; i < 3; i++) edge[j][i] = to[i] - from[i];
                length[j] = sqrt(dot(edge[j], edge[j]));
            }
            cross(edge[0], edge[1], made);
            to_unit(made, normal);
            for (j = 0; j < 3; j++) {
                const double both = length[j] * length[(j + 2) % 3];
                const double found = -dot(edge[j], edge[(j + 2) % 3]) / (both > 0 ? both : 1.0);
                cosine[j] = found < -1.0 ? -1.0 : found > 1.0 ? 1.0 : found;
            }
        }
}

/* Of k meshes: unit normals (k, w, 3) of vertices, of whose corners vertex v has those from ``start[v]`` to ``start[v + 1]`` in ``corner``,
   each with the normal (k, f, 3) of its face by its angle (k, f, 3). In the order ``rank`` (w,), vertices with one ``source`` (w,) are neighbours,
   ``most`` at once; they are added up where they differ by less than the angle of the cosine ``sharp``. ``room`` holds 3 f + 6 w numbers. */
OUT void shade_vertices(int64_t k, int64_t f, int64_t w, const double *normal, const double *angle, const int64_t *corner, const int64_t *start,
                        const int64_t *rank, const int64_t *source, int64_t most, double sharp, void *add, void *data, double *room,
                        double *out) {
    double *summed = room + 3 * f, *own = summed + 3 * w;
    const ptrdiff_t steps[3] = {0, sizeof(double), 0};
    for (int64_t row = 0; row < k; row++, normal += 3 * f, angle += 3 * f, out += 3 * w) {
        for (int64_t v = 0; v < w; v++)
            for (int i = 0; i < 3; i++) {
                const ptrdiff_t others = start[v + 1] - start[v] - 1;
                double *total = summed + 3 * v + i;
                char *args[3] = {(char *)total, (char *)(room + 1), (char *)total};
                for (int64_t c = start[v]; c < start[v + 1]; c++) room[c - start[v]] = normal[3 * (corner[c] / 3) + i] * angle[corner[c]];
                *total = room[0];
                if (others > 0) ((loop *)add)(args, &others, steps, data);
            }
        for (int64_t v = 0; v < w; v++) to_unit(summed + 3 * v, own + 3 * v);
        memcpy(out, summed, 3 * w * sizeof(double));
        for (int64_t shift = 1; shift < most; shift++)
            for (int back = 0; back < 2; back++)
                for (int64_t v = 0; v + shift < w; v++) {
                    const int64_t a = rank[v], b = rank[v + shift];
                    if (source[a] != source[b]) continue;
                    const int near = dot(own + 3 * a, own + 3 * b) > sharp;
                    for (int i = 0; i < 3; i++) out[3 * (back ? b : a) + i] += near ? summed[3 * (back ? a : b) + i] : 0.0;
                }
        for (int64_t v = 0; v < w; v++) {
            const double made[3] = {out[3 * v], out[3 * v + 1], out[3 * v + 2]};
            to_unit(made, out + 3 * v);
        }
    }
}
