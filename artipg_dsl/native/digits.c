/* Numbers as text, with the bytes of C's %.{n}g, %.6f and %d in the "C" locale, which are Python's, and of Python's JSON. A number times
   a power of ten is kept as a sum of two, so that which way it rounds is always known; what is too large or too small for that is left to
   the caller. */

#include "bodies.h"

#define EXACT 22 /* powers of ten up to this one are numbers themselves */

static const double TENS[EXACT + 1] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                       1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
static const double TENTHS[] = {1e0,   1e-1,  1e-2,  1e-3,  1e-4,  1e-5,  1e-6,  1e-7,  1e-8,  1e-9,  1e-10, 1e-11, 1e-12,
                                1e-13, 1e-14, 1e-15, 1e-16, 1e-17, 1e-18, 1e-19, 1e-20, 1e-21, 1e-22, 1e-23, 1e-24, 1e-25,
                                1e-26, 1e-27, 1e-28, 1e-29, 1e-30};
#define LEAST 1e-30

/* value * 10^power, to the nearest whole number, of two the even one; -1 where that is not known. The value is positive, the result
   below 2^52. */
static int64_t scaled(double value, int power) {
    double low = 0.0, part;
    int exact = 1;
    if (power > EXACT) {
        const double high = value * TENS[EXACT];
        low = fma(value, TENS[EXACT], -high) * TENS[power - EXACT];
        value = high;
        power -= EXACT;
        exact = 0;
    }
    const double whole = value * TENS[power], floor_ = floor(whole);
    part = whole - floor_ - 0.5;
    if (part > 1e-3) return (int64_t)floor_ + 1;
    if (part < -1e-3) return (int64_t)floor_;
    low += fma(value, TENS[power], -whole);
    if (!exact && fabs(part + low) < 1e-12) return -1;
    part += low;
    if (part == 0.0) return (int64_t)floor_ + ((int64_t)floor_ & 1);
    return (int64_t)floor_ + (part > 0.0);
}

static char *put_whole(char *out, int64_t value) {
    char room[20], *at = room + 20;
    uint64_t rest = value < 0 ? -(uint64_t)value : (uint64_t)value;
    do {
        *--at = (char)('0' + rest % 10);
        rest /= 10;
    } while (rest);
    if (value < 0) *out++ = '-';
    memcpy(out, at, (size_t)(room + 20 - at));
    return out + (room + 20 - at);
}

/* The end of what is written, or null. */
static char *put_general(char *out, double value, int digits) {
    char room[20];
    int power = 0, count, k;
    int64_t whole;
    if (signbit(value)) *out++ = '-';
    value = fabs(value);
    if (value == 0.0) {
        *out++ = '0';
        return out;
    }
    if (!(value >= LEAST && value < TENS[digits])) return 0;
    if (value >= 1.0)
        while (value >= TENS[power + 1]) power++;
    else
        while (value < TENTHS[-power]) power--;
    whole = scaled(value, digits - 1 - power);
    if (whole < 0) return 0;
    if (whole < (int64_t)TENS[digits - 1]) return 0; /* the power of ten is not quite where its double is */
    if (whole >= (int64_t)TENS[digits]) {
        whole /= 10;
        power++;
    }
    for (k = digits; k > 0; k--) {
        room[k - 1] = (char)('0' + whole % 10);
        whole /= 10;
    }
    for (count = digits; count > 1 && room[count - 1] == '0'; count--);
    if (power < -4 || power >= digits) {
        *out++ = room[0];
        if (count > 1) *out++ = '.';
        for (k = 1; k < count; k++) *out++ = room[k];
        *out++ = 'e';
        *out++ = power < 0 ? '-' : '+';
        power = power < 0 ? -power : power;
        *out++ = (char)('0' + power / 10);
        *out++ = (char)('0' + power % 10);
        return out;
    }
    if (power < 0) {
        *out++ = '0';
        *out++ = '.';
        for (k = -1; k > power; k--) *out++ = '0';
        for (k = 0; k < count; k++) *out++ = room[k];
        return out;
    }
    for (k = 0; k <= power; k++) *out++ = k < count ? room[k] : '0';
    if (count > power + 1) *out++ = '.';
    for (k = power + 1; k < count; k++) *out++ = room[k];
    return out;
}

static const char PAIRS[] = "00010203040506070809101112131415161718192021222324252627282930313233343536373839404142434445464748495051525354"
                            "555657585960616263646566676869707172737475767778798081828384858687888990919293949596979899";

static char *put_fixed(char *out, double value, int digits) {
    int64_t whole;
    int k;
    if (signbit(value)) *out++ = '-';
    value = fabs(value);
    if (!(value < 1e9)) return 0;
    whole = scaled(value, digits);
    if (whole < 0) return 0;
    if (digits == 6 && whole < 10000000) { /* most numbers: one digit before the point, and pairs of them behind it */
        const uint32_t all = (uint32_t)whole, behind = all % 1000000;
        out[0] = (char)('0' + all / 1000000);
        out[1] = '.';
        memcpy(out + 2, PAIRS + 2 * (behind / 10000), 2);
        memcpy(out + 4, PAIRS + 2 * (behind / 100 % 100), 2);
        memcpy(out + 6, PAIRS + 2 * (behind % 100), 2);
        return out + 8;
    }
    out = put_whole(out, whole / (int64_t)TENS[digits]);
    whole %= (int64_t)TENS[digits];
    *out++ = '.';
    for (k = digits; k > 0; k--) {
        out[k - 1] = (char)('0' + whole % 10);
        whole /= 10;
    }
    return out + digits;
}

/* Rows of ``columns`` numbers in ``out``; returns its length, -1 where one of them cannot be written here. ``form``: 0 whole numbers,
   1 with so many significant ``digits`` (up to 12), 2 with so many (6) behind the point. What stands before each column and after the
   last is ``marks``, one after the other, each up to its end in ``ends`` (columns + 1,). */
OUT int64_t print_rows(int64_t rows, int64_t columns, int64_t form, int64_t digits, const void *values, const char *marks,
                       const int64_t *ends, char *out) {
    const double *number = values;
    const int64_t *whole = values;
    char *at = out;
    for (int64_t row = 0; row < rows; row++) {
        int64_t from = 0;
        for (int64_t column = 0; column <= columns; column++) {
            for (; from < ends[column]; from++) *at++ = marks[from];
            if (column == columns) break;
            if (form == 0)
                at = put_whole(at, *whole++);
            else if (form == 1)
                at = put_general(at, *number++, (int)digits);
            else
                at = put_fixed(at, *number++, (int)digits);
            if (!at) return -1;
        }
    }
    return at - out;
}

/* Rows of ``columns`` numbers with six digits behind the point, blanks between, and the word of each row, if there are ``words``: word k is from
   ``ends[k]`` to ``ends[k + 1]``. The first ``lead`` numbers of each row stand in ``head``, too, which is so long as ``length`` says. Returns
   the length of ``out``, -1 where a number cannot be written here. */
OUT int64_t print_told(int64_t rows, int64_t columns, const double *number, const int64_t *word, const char *words, const int64_t *ends,
                       char *out, int64_t lead, char *head, int64_t *length) {
    char *at = out, *top = head;
    for (int64_t row = 0; row < rows; row++) {
        const char *begin = at;
        for (int64_t column = 0; column < columns; column++) {
            if (column) *at++ = ' ';
            at = put_fixed(at, *number++, 6);
            if (!at) return -1;
            if (column + 1 == lead) {
                memcpy(top, begin, (size_t)(at - begin));
                top += at - begin;
                *top++ = '\n';
            }
        }
        if (words) {
            const int64_t from = ends[word[row]], to = ends[word[row] + 1];
            if (columns) *at++ = ' ';
            memcpy(at, words + from, (size_t)(to - from));
            at += to - from;
        }
        *at++ = '\n';
    }
    *length = top - head;
    return at - out;
}

/* A whole number of billionths, as Python writes the number that is nearest to it: below 10^15 no shorter text tells it from all others. */
static char *put_billionths(char *out, int64_t whole) {
    char room[9];
    int count = 9, k;
    if (whole < 0) *out++ = '-', whole = -whole;
    if (whole && whole < 100000) { /* below 1e-4 */
        int digits = 1;
        for (int64_t rest = whole; rest >= 10; rest /= 10) digits++;
        for (k = digits; k > 0; k--, whole /= 10) room[k - 1] = (char)('0' + whole % 10);
        for (count = digits; room[count - 1] == '0'; count--);
        *out++ = room[0];
        if (count > 1) *out++ = '.';
        for (k = 1; k < count; k++) *out++ = room[k];
        memcpy(out, "e-0", 3);
        out[3] = (char)('0' + 10 - digits);
        return out + 4;
    }
    out = put_whole(out, whole / 1000000000);
    uint32_t behind = (uint32_t)(whole % 1000000000);
    *out++ = '.';
    for (k = 4; k > 0; k--, behind /= 100) memcpy(room + 2 * k - 1, PAIRS + 2 * (behind % 100), 2);
    room[0] = (char)('0' + behind);
    while (count > 1 && room[count - 1] == '0') count--;
    memcpy(out, room, 9);
    return out + count;
}

/* a column of records: words by their numbers (rows,); or whole numbers (rows,); or numbers (rows,), null where there is none; or rows
   (rows, width) of numbers, null where they are ``absent``, if any may be */
typedef struct {
    int64_t form, width;
    const void *values;
    const unsigned char *absent;
} column;

/* Records in ``out``: what stands before each column and after the last is ``marks``, each up to its end in ``ends`` (columns + 1,); word k is
   from ``word_ends[k]`` to ``word_ends[k + 1]``; where each record ends is ``done`` (rows,). Numbers are rounded to billionths, as NumPy does.
   Returns the length, -1 where a number cannot be written here. */
OUT int64_t print_records(int64_t rows, int64_t columns, const column *of, const char *marks, const int64_t *ends, const char *words,
                          const int64_t *word_ends, char *out, int64_t *done) {
    char *at = out;
    for (int64_t row = 0; row < rows; row++) {
        int64_t from = 0;
        for (int64_t k = 0;; k++) {
            memcpy(at, marks + from, (size_t)(ends[k] - from));
            at += ends[k] - from;
            from = ends[k];
            if (k == columns) break;
            if (of[k].form < 2) {
                const int64_t own = ((const int64_t *)of[k].values)[row];
                if (of[k].form) {
                    at = put_whole(at, own);
                    continue;
                }
                memcpy(at, words + word_ends[own], (size_t)(word_ends[own + 1] - word_ends[own]));
                at += word_ends[own + 1] - word_ends[own];
                continue;
            }
            const double *number = (const double *)of[k].values + row * of[k].width;
            if (of[k].form == 2 ? isnan(*number) : of[k].absent && of[k].absent[row]) {
                memcpy(at, "null", 4);
                at += 4;
                continue;
            }
            if (of[k].form == 3) *at++ = '[';
            for (int64_t i = 0; i < of[k].width; i++) {
                const double whole = rint(number[i] * 1e9);
                if (!(fabs(whole) < 1e15)) return -1;
                if (i) *at++ = ',';
                at = put_billionths(at, (int64_t)whole);
            }
            if (of[k].form == 3) *at++ = ']';
        }
        done[row] = at - out;
    }
    return at - out;
}
