/* Which triangles are nearest in a picture, as ``geometry.rays`` has it. */

#include "bodies.h"

/* Of triangles, each of which is looked for in columns and rows from ``low`` (count, 2) up to ``high`` (count, 2), with the coefficients
   ``planes`` (count, 4, 3) of column, row and 1 of three edges, inside where all are at least 0, and of the nearness: in ``keys`` (rows *
   columns,), all of it 0 at first, the bits of the nearness in single precision of what is nearest, and its number plus 1. */
OUT void cover(int64_t count, const double *planes, const int64_t *low, const int64_t *high, int64_t columns, uint64_t *keys) {
    for (int64_t t = 0; t < count; t++, planes += 12) {
        const double *a = planes, *b = planes + 3, *c = planes + 6, *d = planes + 9;
        for (int64_t row = low[2 * t + 1]; row < high[2 * t + 1]; row++) {
            const double down = (double)row, aj = a[1] * down, bj = b[1] * down, cj = c[1] * down, dj = d[1] * down;
            uint64_t *key = keys + row * columns;
            for (int64_t column = low[2 * t]; column < high[2 * t]; column++) {
                const double i = (double)column;
                if (!(a[0] * i + aj + a[2] >= 0.0) || !(b[0] * i + bj + b[2] >= 0.0) || !(c[0] * i + cj + c[2] >= 0.0)) continue;
                const double value = d[0] * i + dj + d[2];
                const float near = (float)(value < 1e-9 ? 1e-9 : value);
                uint32_t told;
                memcpy(&told, &near, sizeof told);
                const uint64_t mine = (uint64_t)told << 32 | (uint64_t)(t + 1);
                if (mine > key[column]) key[column] = mine;
            }
        }
    }
}
