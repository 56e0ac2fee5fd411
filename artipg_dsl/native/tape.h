/* A tape as it is laid out (layout.c) and run (machine.c). */

#ifndef TAPE_H
#define TAPE_H

#include <fenv.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define OUT __declspec(dllexport)
#else
#define OUT __attribute__((visibility("default")))
#endif

typedef void loop(char **, const ptrdiff_t *, const ptrdiff_t *, void *);

/* of a register: what it stands for, and along what it varies */
enum { CONSTANT, INPUT, OUTPUT, SPARE };
enum { ONE, ROW, COLUMN, EVERY };

typedef struct {
    int64_t function, data, inputs, in[3], out, phase;
} op;

typedef struct {
    int64_t kind, along, size, at; /* at: place in the pool of constants (bytes), number of the array or of the spare one */
} reg;

typedef struct {
    int64_t ops, regs, spare[4], phase[4]; /* ops in order of phases; spare registers that vary along each; ops of each phase */
} head;

#endif
