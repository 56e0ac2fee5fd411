/* Runs tapes: straight-line programs over columns of numbers, a block at a time, so that what is in between stays in the
   first cache. Every operation on numbers is an inner loop of NumPy, called through the pointer in its ufunc, or one of those
   below, which only move values: the bits are those NumPy would have made. Nothing here follows from a program. */

#include "tape.h"

/* ------------------------------------------------------------ loops that move values */

OUT void choose8(char **args, const ptrdiff_t *n, const ptrdiff_t *steps, void *data) {
    const char *c = args[0], *a = args[1], *b = args[2];
    char *out = args[3];
    ptrdiff_t i, count = *n;
    (void)data;
    if (steps[0] == 1 && steps[1] == 8 && steps[2] == 8 && steps[3] == 8) {
        const uint64_t *x = (const uint64_t *)a, *y = (const uint64_t *)b;
        uint64_t *z = (uint64_t *)out;
        for (i = 0; i < count; i++) {
            uint64_t mask = (uint64_t)0 - (uint64_t)(c[i] != 0);
            z[i] = (x[i] & mask) | (y[i] & ~mask);
        }
        return;
    }
    for (i = 0; i < count; i++, c += steps[0], a += steps[1], b += steps[2], out += steps[3])
        *(uint64_t *)out = *c ? *(const uint64_t *)a : *(const uint64_t *)b;
}

OUT void choose1(char **args, const ptrdiff_t *n, const ptrdiff_t *steps, void *data) {
    const char *c = args[0], *a = args[1], *b = args[2];
    char *out = args[3];
    (void)data;
    for (ptrdiff_t i = 0; i < *n; i++, c += steps[0], a += steps[1], b += steps[2], out += steps[3])
        *out = *c ? *a : *b;
}

/* a truth value as a number */
OUT void number(char **args, const ptrdiff_t *n, const ptrdiff_t *steps, void *data) {
    const char *a = args[0];
    char *out = args[1];
    (void)data;
    for (ptrdiff_t i = 0; i < *n; i++, a += steps[0], out += steps[1])
        *(double *)out = *a ? 1.0 : 0.0;
}

/* a number again */
OUT void same8(char **args, const ptrdiff_t *n, const ptrdiff_t *steps, void *data) {
    const char *a = args[0];
    char *out = args[1];
    (void)data;
    for (ptrdiff_t i = 0; i < *n; i++, a += steps[0], out += steps[1]) *(double *)out = *(const double *)a;
}

/* ------------------------------------------------------------ arrays of NumPy */

typedef struct {
    char *data;
    int nd;
    ptrdiff_t *dimensions, *strides;
    void *base, *descr;
    int flags;
} array;

enum { CONTIGUOUS = 0x1, ALIGNED = 0x100, WRITEABLE = 0x400 };

static const array *array_of(int64_t object, int64_t header) { return (const array *)(uintptr_t)(object + header); }

/* What is read of an array, for Python to compare with what it knows of it. */
OUT void look(int64_t object, int64_t header, int64_t *found) {
    const array *a = array_of(object, header);
    found[0] = (int64_t)(uintptr_t)a->data;
    found[1] = a->nd;
    found[2] = a->dimensions[0];
    found[3] = a->strides[0];
    found[4] = a->flags;
}

/* ------------------------------------------------------------ tapes */

static void play(const op *from, const op *to, char **place, const ptrdiff_t *step, ptrdiff_t n) {
    for (; from < to; from++) {
        char *args[4];
        ptrdiff_t steps[4];
        int64_t k;
        for (k = 0; k < from->inputs; k++) {
            args[k] = place[from->in[k]];
            steps[k] = step[from->in[k]];
        }
        args[k] = place[from->out];
        steps[k] = step[from->out];
        ((loop *)(uintptr_t)from->function)(args, &n, steps, (void *)(uintptr_t)from->data);
    }
}

/* Runs a tape over ``outer`` rows of ``inner`` columns. ``objects`` are the arrays: inputs, then outputs.
   0: done; 1: an array is not as it must be; 2: no memory. */
OUT int run(const head *tape, const op *ops, const reg *regs, const char *pool, const int64_t *objects, int64_t header,
            int64_t outer, int64_t inner, int64_t block) {
    int64_t count = tape->regs, i, r, start;
    size_t room = 0, slot = (size_t)block * 8 + 64, wide = ((size_t)inner * 8 + 127) & ~(size_t)63;
    char **place, **base, *work, *spare;
    ptrdiff_t *step, *one, *onward;
    const op *edge[5];

    for (i = 0; i < count; i++)
        if (regs[i].kind == INPUT || regs[i].kind == OUTPUT) {
            const array *a = array_of(objects[regs[i].at], header);
            if (!(a->flags & ALIGNED)) return 1;
            if (!(a->flags & CONTIGUOUS) && (a->nd != 1 || a->strides[0] <= 0 || outer != 1 || regs[i].kind != INPUT)) return 1;
        }
    room = (size_t)count * (2 * sizeof(char *) + 3 * sizeof(ptrdiff_t)) + 64;
    room += (size_t)(tape->spare[ONE] + tape->spare[ROW]) * 64 + (size_t)tape->spare[COLUMN] * wide;
    room += (size_t)tape->spare[EVERY] * slot + 64;
    work = malloc(room);
    if (!work) return 2;
    place = (char **)work;
    base = place + count;
    step = (ptrdiff_t *)(base + count);
    one = step + count;
    onward = one + count;
    spare = (char *)(((uintptr_t)(onward + count) + 63) & ~(uintptr_t)63);

    for (i = 0; i < count; i++) {
        const reg *g = regs + i;
        step[i] = one[i] = g->size;
        onward[i] = 0;
        if (g->kind == CONSTANT) {
            base[i] = (char *)pool + g->at;
            step[i] = one[i] = 0;
        } else if (g->kind == SPARE) {
            char *from = spare;
            if (g->along >= COLUMN) from += (size_t)(tape->spare[ONE] + tape->spare[ROW]) * 64;
            if (g->along == EVERY) from += (size_t)tape->spare[COLUMN] * wide;
            if (g->along == ROW) from += (size_t)tape->spare[ONE] * 64;
            base[i] = from + (size_t)g->at * (g->along == EVERY ? slot : g->along == COLUMN ? wide : 64);
            if (g->along < COLUMN) step[i] = 0;
            if (g->along == COLUMN) onward[i] = g->size;
        } else {
            const array *a = array_of(objects[g->at], header);
            base[i] = a->data;
            if (g->along < COLUMN) step[i] = 0;
            else {
                if (a->nd == 1 && outer == 1) step[i] = one[i] = a->strides[0];
                onward[i] = step[i];
            }
        }
        place[i] = base[i];
    }
    edge[0] = ops;
    for (i = 0; i < 4; i++) edge[i + 1] = edge[i] + tape->phase[i];

    play(edge[0], edge[1], place, one, 1);
    play(edge[2], edge[3], place, step, inner); /* columns, once for all rows */
    for (r = 0; r < outer; r++) {
        for (i = 0; i < count; i++)
            if (regs[i].along == ROW && (regs[i].kind == INPUT || regs[i].kind == OUTPUT)) place[i] = base[i] + r * regs[i].size;
        play(edge[1], edge[2], place, one, 1);
        for (start = 0; start < inner; start += block) {
            for (i = 0; i < count; i++)
                if (onward[i]) place[i] = base[i] + ((regs[i].along == EVERY ? r * inner : 0) + start) * onward[i];
            play(edge[3], edge[4], place, step, inner - start < block ? inner - start : block);
        }
        for (i = 0; i < count; i++)
            if (onward[i]) place[i] = base[i];
    }
    free(work);
    feclearexcept(FE_ALL_EXCEPT);
    return 0;
}
