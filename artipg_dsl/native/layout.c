/* Lays a tape out for `run`: the types of its values, along what they vary, which steps are needed, and the registers they use.
   A step of constants is carried out here, by the loop that NumPy calls for two Python numbers. */

#include "tape.h"

enum { PLAIN, TRUTH, POWER, WHERE }; /* kinds of operations, as in plan.py */
enum { MADE, GIVEN, FIXED };         /* what comes out, as in plan.py */

typedef struct {
    int64_t variables, constants, steps, outputs;
    const uint8_t *size, *along;          /* of each variable: bytes of a number, and along what it varies */
    const double *constant;               /* and of each constant: its value and its bytes */
    const uint8_t *constant_size;
    const int32_t *code, *asked, *wanted; /* of each step its operation; the arguments of all; the values that come out */
    const uint8_t *inputs, *kind;         /* of each operation */
    const int64_t *table;                 /* and of each of its forms, for numbers and for truth values, a loop and what it is given */
    int64_t ne, number, same;             /* three of the operations */
    int64_t *head;                        /* what is found: as `run` takes it */
    op *ops;
    reg *regs;
    double *pool;
    int64_t *result;                      /* of each output: what it is, and its number */
    double *fixed;                        /* its value, if it is a constant */
    int64_t *made;                        /* of each array: along what it varies, bytes of a number */
    int64_t *count;                       /* arrays, constants in the pool, whether there is a power of columns */
} request;

typedef struct {
    double constant; /* a truth value in its first byte */
    int32_t uses, reg, number; /* number: the same as a number, of a truth value */
    uint8_t size, along, fixed, kept, needed;
} value;

typedef struct {
    int32_t code, form, inputs, in[3], out;
} step;

typedef struct {
    const request *asked;
    value *values;
    step *steps;
    int64_t count, many; /* values, steps */
} plan;

static int32_t keep(plan *p, uint8_t size, uint8_t along, int fixed, double constant) {
    value *v = p->values + p->count;
    v->constant = constant;
    v->uses = 0;
    v->reg = v->number = -1;
    v->size = size;
    v->along = along;
    v->fixed = (uint8_t)fixed;
    v->kept = v->needed = 0;
    return (int32_t)p->count++;
}

static int32_t add(plan *p, int64_t code, int form, int inputs, const int32_t *in, uint8_t size) {
    const int64_t *found = p->asked->table + 4 * code + 2 * form;
    int fixed = 1, k;
    uint8_t along = ONE;
    step *s;
    for (k = 0; k < inputs; k++) {
        const value *v = p->values + in[k];
        along |= v->along;
        fixed &= v->fixed;
    }
    if (fixed) {
        char *args[4];
        double out = 0.0; /* room for either kind */
        ptrdiff_t one = 1, far[4] = {0, 0, 0, 0};
        for (k = 0; k < inputs; k++) args[k] = (char *)&p->values[in[k]].constant;
        args[inputs] = (char *)&out;
        far[inputs] = size;
        ((loop *)(uintptr_t)found[0])(args, &one, far, (void *)(uintptr_t)found[1]);
        return keep(p, size, ONE, 1, out);
    }
    s = p->steps + p->many++;
    s->code = (int32_t)code;
    s->form = form;
    s->inputs = inputs;
    for (k = 0; k < 3; k++) s->in[k] = k < inputs ? in[k] : 0;
    s->out = keep(p, size, along, 0, 0.0);
    return s->out;
}

static int32_t as_number(plan *p, int32_t at) {
    if (p->values[at].size == 8) return at;
    if (p->values[at].number < 0) {
        int32_t made = add(p, p->asked->number, 0, 1, &at, 8);
        p->values[at].number = made;
    }
    return p->values[at].number;
}

/* The value that a step makes; -1 where NumPy has to do it. */
static int32_t take(plan *p, int64_t code, const int32_t *asked) {
    int inputs = p->asked->inputs[code], kind = p->asked->kind[code], numbers = 0, k;
    int32_t in[3];
    for (k = 0; k < inputs; k++) {
        in[k] = asked[k];
        numbers += p->values[in[k]].size == 8;
    }
    if (kind == WHERE) {
        if (p->values[in[0]].size == 8) {
            int32_t both[2];
            both[0] = in[0];
            both[1] = keep(p, 8, ONE, 1, 0.0);
            in[0] = add(p, p->asked->ne, 0, 2, both, 1);
        }
        if (p->values[in[1]].size == 1 && p->values[in[2]].size == 1) return add(p, code, 1, 3, in, 1);
        in[1] = as_number(p, in[1]);
        in[2] = as_number(p, in[2]);
        return add(p, code, 0, 3, in, 8);
    }
    if (!numbers) return kind == TRUTH ? add(p, code, 1, inputs, in, 1) : -1; /* NumPy's sums of truth values are truth values */
    if (kind == POWER && !p->values[in[1]].fixed) {
        int base = p->values[in[0]].along, exponent = p->values[in[1]].along;
        p->asked->count[2] = 1;
        if (exponent == ROW && base == EVERY) { /* its loop squares where an exponent of 2 does not move; NumPy lets this one move */
            in[1] = as_number(p, in[1]);
            in[1] = add(p, p->asked->same, 0, 1, in + 1, 8);
            p->values[in[1]].along = EVERY;
        } else if (exponent == ONE || exponent != (base | exponent)) {
            return -1;
        }
    }
    for (k = 0; k < inputs; k++) in[k] = as_number(p, in[k]);
    return add(p, code, 0, inputs, in, kind == TRUTH ? 1 : 8);
}

static int32_t placed(plan *p, int32_t at, int64_t *regs) {
    const request *asked = p->asked;
    value *v = p->values + at;
    if (v->reg < 0) {
        reg *r = asked->regs + *regs;
        v->reg = (int32_t)(*regs)++;
        r->along = v->fixed ? ONE : v->along;
        r->size = v->size;
        if (v->fixed) {
            r->kind = CONSTANT;
            r->size = 8;
            r->at = 8 * asked->count[1];
            asked->pool[asked->count[1]++] = v->constant;
        } else {
            r->kind = INPUT;
            r->at = at;
        }
    }
    return v->reg;
}

static void place_outputs(plan *p, const int32_t *place, int64_t *regs) {
    const request *asked = p->asked;
    for (int64_t i = 0; i < asked->outputs; i++) {
        int32_t at = place[asked->wanted[i]];
        value *v = p->values + at;
        int64_t *result = asked->result + 2 * i;
        if (v->fixed) {
            result[0] = FIXED;
            result[1] = v->size;
            asked->fixed[i] = v->size == 8 ? v->constant : *(uint8_t *)&v->constant;
        } else if (at < asked->variables) {
            result[0] = GIVEN;
            result[1] = at;
        } else {
            if (v->reg < 0) {
                int64_t made = asked->count[0]++;
                reg *r = asked->regs + *regs;
                v->reg = (int32_t)(*regs)++;
                r->kind = OUTPUT;
                r->along = v->along;
                r->size = v->size;
                r->at = asked->variables + made;
                asked->made[2 * made] = v->along;
                asked->made[2 * made + 1] = v->size;
            }
            result[0] = MADE;
            result[1] = asked->regs[v->reg].at - asked->variables;
        }
    }
}

/* Registers for the steps that vary along ``phase``. ``free``: room for as many as there are values, twice. */
static void place_steps(plan *p, int phase, int64_t *regs, int32_t *free) {
    const request *asked = p->asked;
    int32_t *unused[2], unused_count[2] = {0, 0};
    unused[0] = free;
    unused[1] = free + p->count;
    for (int64_t i = 0; i < p->many; i++) {
        const step *s = p->steps + i;
        value *v = p->values + s->out;
        op *o;
        int k;
        if (!v->needed || v->along != phase) continue;
        o = asked->ops + asked->head[0]++;
        o->function = asked->table[4 * s->code + 2 * s->form];
        o->data = asked->table[4 * s->code + 2 * s->form + 1];
        o->inputs = s->inputs;
        for (k = 0; k < 3; k++) o->in[k] = k < s->inputs ? placed(p, s->in[k], regs) : 0;
        if (v->reg < 0) {
            int wide = v->size == 8; /* registers are of numbers or of truth values */
            if (unused_count[wide]) {
                v->reg = unused[wide][--unused_count[wide]];
            } else {
                reg *r = asked->regs + *regs;
                v->reg = (int32_t)(*regs)++;
                r->kind = SPARE;
                r->along = phase;
                r->size = v->size;
                r->at = asked->head[2 + phase]++;
            }
        }
        for (k = 0; k < s->inputs; k++) {
            value *used = p->values + s->in[k];
            if (!--used->uses && !used->kept && !used->fixed && asked->regs[used->reg].kind == SPARE) {
                int wide = used->size == 8;
                unused[wide][unused_count[wide]++] = used->reg;
            }
        }
        o->out = v->reg;
        o->phase = phase;
        asked->head[6 + phase]++;
    }
}

/* 0: done; 1: NumPy has to do it; 2: no memory. */
OUT int64_t lay_out(const request *asked) {
    int64_t first = asked->variables + asked->constants, most = first + 6 * asked->steps, i, regs = 0;
    plan p = {asked, malloc((size_t)(most + 1) * sizeof(value)), malloc((size_t)(5 * asked->steps + 1) * sizeof(step)), 0, 0};
    int32_t *place = malloc((size_t)(first + asked->steps + 1) * sizeof(int32_t));
    int32_t *free_ones = NULL;
    const int32_t *next = asked->asked;
    int done = 2;
    if (!p.values || !p.steps || !place) goto end;
    for (i = 0; i < asked->variables; i++) place[i] = keep(&p, asked->size[i], asked->along[i], 0, 0.0);
    for (i = 0; i < asked->constants; i++) {
        double held = asked->constant[i];
        if (asked->constant_size[i] == 1) {
            uint8_t truth = held != 0.0;
            held = 0.0;
            memcpy(&held, &truth, 1);
        }
        place[asked->variables + i] = keep(&p, asked->constant_size[i], ONE, 1, held);
    }
    for (i = 0; i < asked->steps; i++) {
        int32_t in[3] = {0, 0, 0};
        int k, inputs = asked->inputs[asked->code[i]];
        for (k = 0; k < inputs; k++) in[k] = place[*next++];
        place[first + i] = take(&p, asked->code[i], in);
        if (place[first + i] < 0) {
            done = 1;
            goto end;
        }
    }
    for (i = 0; i < asked->outputs; i++) p.values[place[asked->wanted[i]]].needed = p.values[place[asked->wanted[i]]].kept = 1;
    for (i = p.many - 1; i >= 0; i--) {
        const step *s = p.steps + i;
        if (p.values[s->out].needed)
            for (int k = 0; k < s->inputs; k++) {
                value *v = p.values + s->in[k];
                v->needed = 1;
                v->uses++;
                v->kept |= v->along != p.values[s->out].along;
            }
    }
    free_ones = malloc((size_t)(2 * p.count + 1) * sizeof(int32_t));
    if (!free_ones) goto end;
    place_outputs(&p, place, &regs);
    for (int phase = ONE; phase <= EVERY; phase++) place_steps(&p, phase, &regs, free_ones);
    asked->head[1] = regs;
    done = 0;
end:
    free(p.values);
    free(p.steps);
    free(place);
    free(free_ones);
    feclearexcept(FE_ALL_EXCEPT);
    return done;
}
