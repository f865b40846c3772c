/* A panel: the same number of as many samples as a vector register holds, side by side.
 *
 * Vector extensions of gcc and clang, no intrinsics. The width follows from the instruction set
 * that the compiler was told; 1 stands for a compiler without them, and for C++: single calls in a
 * loop.
 * Private to the kernels.
 */
#ifndef puma560_LANES_H
#define puma560_LANES_H

#include "puma560.h"

#if !defined(__GNUC__) || defined(__cplusplus)
#define puma560_WIDTH 1
#elif defined(__AVX512F__)
#define puma560_WIDTH 8
#elif defined(__AVX__)
#define puma560_WIDTH 4
#elif defined(__SSE2__) || (defined(__ARM_NEON) && defined(__aarch64__))
#define puma560_WIDTH 2
#else
#define puma560_WIDTH 1
#endif

#if puma560_WIDTH > 1
#include <math.h>
#include <stdint.h>
#include <string.h>

/* The next multiple of the width: arrays of panels are read and written in whole blocks. */
#define BLOCKS(size) (((size) + puma560_WIDTH - 1u) / puma560_WIDTH * puma560_WIDTH)
/* Numbers from the first row of a panel to the end of the blocks of the last. */
#define REACH(size) ((puma560_WIDTH - 1u) * (size) + BLOCKS(size))
#define ALWAYS static inline __attribute__((always_inline))
#define ONCE static __attribute__((noinline))
/* Functions of this header that are not called often, and not by every kernel. */
#if defined(__clang__)
#define SELDOM static inline __attribute__((noinline))
#else
#define SELDOM static __attribute__((noinline, unused))
#endif

typedef double lanes __attribute__((vector_size(8 * puma560_WIDTH)));
typedef int64_t mask __attribute__((vector_size(8 * puma560_WIDTH)));
/* The same anywhere in memory. */
typedef double apart __attribute__((vector_size(8 * puma560_WIDTH), aligned(8), may_alias));

/* Blocks of a transposition stay in registers where their loops are unrolled. */
#if defined(__clang__)
#define UNROLLED _Pragma("clang loop unroll(full)")
#define SHUFFLED(a, b, ...) __builtin_shufflevector(a, b, __VA_ARGS__)
#define STREAM(place, value) __builtin_nontemporal_store(value, place)
#else
#define UNROLLED _Pragma("GCC unroll 16")
#define SHUFFLED(a, b, ...) __builtin_shuffle(a, b, (mask) { __VA_ARGS__ })
#if defined(__AVX512F__)
#define STREAM(place, value) __builtin_ia32_movntpd512((double *)(place), value)
#elif defined(__AVX__)
#define STREAM(place, value) __builtin_ia32_movntpd256((double *)(place), value)
#elif defined(__SSE2__)
#define STREAM(place, value) __builtin_ia32_movntpd((double *)(place), value)
#else
#define STREAM(place, value) (*(place) = (value))
#endif
#endif

/* Streamed stores are seen by others after this. */
ALWAYS void stream_end(void)
{
#if defined(__SSE2__)
    __builtin_ia32_sfence();
#endif
}

/* Only whole lines of the cache are worth streaming, and only to an address that can take them. */
ALWAYS int streamed(int wanted, const double *place)
{
    return (wanted != 0) && (sizeof(lanes) == 64u) && ((uintptr_t)place % sizeof(lanes) == 0u);
}

ALWAYS lanes lanes_all(double value)
{
    return (lanes) { 0 } + value;
}

ALWAYS void lanes_put(apart *place, lanes value, const int stream)
{
    if (stream) {
        STREAM((lanes *)(void *)place, value);
    } else {
        *place = value;
    }
}

ALWAYS lanes lanes_abs(lanes x)
{
    return (lanes)((mask)x & INT64_MAX);
}

/* 1 or -1, and 0 for 0 and NaN. */
ALWAYS lanes lanes_sign(lanes x)
{
    const mask one = (mask)lanes_all(1.0);
    return (lanes)(one & (mask)(x > 0.0)) - (lanes)(one & (mask)(x < 0.0));
}

ALWAYS int lanes_any(mask m)
{
#if defined(__AVX512F__)
    const lanes where = (lanes)m; /* true is a NaN */
    return __builtin_ia32_cmppd512_mask(where, where, 3, 255u, 4) != 0;
#elif defined(__AVX__)
    return __builtin_ia32_movmskpd256((lanes)m) != 0;
#else
    int any = 0;
    for (size_t i = 0; i < puma560_WIDTH; ++i) {
        any |= m[i] != 0;
    }
    return any;
#endif
}

#define LANES_OF(function)                                                                         \
    static inline lanes lanes_##function(lanes x)                                                  \
    {                                                                                              \
        for (size_t i = 0; i < puma560_WIDTH; ++i) {                                                  \
            x[i] = function(x[i]);                                                                 \
        }                                                                                          \
        return x;                                                                                  \
    }
LANES_OF(sin)
LANES_OF(cos)
LANES_OF(tanh)
LANES_OF(exp)
LANES_OF(log)

typedef struct { lanes c; lanes s; } turned;

/* Cosine and sine of near angles, as in the single call (see puma560_math.h). */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__)
#define NEAR (-1.0)
#else
#define NEAR 1e5
#endif
#define ROUND 6755399441055744.0

ALWAYS turned lanes_turn(lanes x)
{
#if defined(__clang__) && __clang_major__ >= 11
#pragma clang fp reassociate(off)
#endif
    const lanes turns = x * 0.6366197723675814 + ROUND; /* its last bits count quarter turns */
    const lanes t = turns - ROUND;
    const lanes head = x - t * 1.5707963267341256;
    const lanes middle = t * 6.077100506303966e-11;
    const lanes tail = t * 2.0222662487959506e-21;
    const lanes first = head - middle;
    const lanes r = first - tail;
    const lanes lost = ((first - r) - tail) + ((head - first) - middle);
    const lanes z = r * r;
    const lanes w = z * z;
    const lanes s = r
        + (r * z
                * ((-0.16666666666666632 + z * 0.008333333333322413)
                    + w * ((-0.00019841269829807819 + z * 2.7557313691921887e-06)
                        + w * (-2.5050758115840255e-08 + z * 1.589679568451575e-10)))
            + lost);
    const lanes c = (1.0 - 0.5 * z)
        + (w * ((0.0416666666666666 + z * -0.0013888888888874125)
                + w * ((2.4801587289482184e-05 + z * -2.7557314352332913e-07)
                    + w * (2.0875723273266597e-09 + z * -1.1359647806143871e-11)))
            - r * lost);
    /* Odd quarters change places; the second bit is the sign of the sine, and of the cosine a
     * quarter later. */
    const mask quarters = (mask)turns;
    const mask swap = ((mask)s ^ (mask)c) & -(quarters & 1);
    return (turned) {
        (lanes)((mask)c ^ swap ^ (((quarters + 1) << 62) & INT64_MIN)),
        (lanes)((mask)s ^ swap ^ ((quarters << 62) & INT64_MIN)),
    };
}

/* Far angles and NaN, by libm; near ones stay what they are, whatever stands beside them. Values
 * go in and out: a variable whose address is known to another function lives in memory. */
SELDOM turned lanes_far(lanes x, turned near)
{
    for (size_t i = 0; i < puma560_WIDTH; ++i) {
        if (!(fabs(x[i]) <= NEAR)) {
            near.c[i] = cos(x[i]);
            near.s[i] = sin(x[i]);
        }
    }
    return near;
}

/* Exchange the two off-diagonal blocks of each pair of rows. */
#define EXCHANGE(a, b, low, high)                                                                  \
    do {                                                                                           \
        const lanes above = SHUFFLED(a, b, low);                                                   \
        b = SHUFFLED(a, b, high);                                                                  \
        a = above;                                                                                 \
    } while (0)

/* Transpose a block of puma560_WIDTH rows of puma560_WIDTH numbers. */
ALWAYS void transpose(lanes v[puma560_WIDTH])
{
#if puma560_WIDTH == 16
#define LOW1 0, 16, 2, 18, 4, 20, 6, 22, 8, 24, 10, 26, 12, 28, 14, 30
#define HIGH1 1, 17, 3, 19, 5, 21, 7, 23, 9, 25, 11, 27, 13, 29, 15, 31
#define LOW2 0, 1, 16, 17, 4, 5, 20, 21, 8, 9, 24, 25, 12, 13, 28, 29
#define HIGH2 2, 3, 18, 19, 6, 7, 22, 23, 10, 11, 26, 27, 14, 15, 30, 31
#define LOW4 0, 1, 2, 3, 16, 17, 18, 19, 8, 9, 10, 11, 24, 25, 26, 27
#define HIGH4 4, 5, 6, 7, 20, 21, 22, 23, 12, 13, 14, 15, 28, 29, 30, 31
#define LOW8 0, 1, 2, 3, 4, 5, 6, 7, 16, 17, 18, 19, 20, 21, 22, 23
#define HIGH8 8, 9, 10, 11, 12, 13, 14, 15, 24, 25, 26, 27, 28, 29, 30, 31
    EXCHANGE(v[0], v[1], LOW1, HIGH1);
    EXCHANGE(v[2], v[3], LOW1, HIGH1);
    EXCHANGE(v[4], v[5], LOW1, HIGH1);
    EXCHANGE(v[6], v[7], LOW1, HIGH1);
    EXCHANGE(v[8], v[9], LOW1, HIGH1);
    EXCHANGE(v[10], v[11], LOW1, HIGH1);
    EXCHANGE(v[12], v[13], LOW1, HIGH1);
    EXCHANGE(v[14], v[15], LOW1, HIGH1);
    EXCHANGE(v[0], v[2], LOW2, HIGH2);
    EXCHANGE(v[1], v[3], LOW2, HIGH2);
    EXCHANGE(v[4], v[6], LOW2, HIGH2);
    EXCHANGE(v[5], v[7], LOW2, HIGH2);
    EXCHANGE(v[8], v[10], LOW2, HIGH2);
    EXCHANGE(v[9], v[11], LOW2, HIGH2);
    EXCHANGE(v[12], v[14], LOW2, HIGH2);
    EXCHANGE(v[13], v[15], LOW2, HIGH2);
    EXCHANGE(v[0], v[4], LOW4, HIGH4);
    EXCHANGE(v[1], v[5], LOW4, HIGH4);
    EXCHANGE(v[2], v[6], LOW4, HIGH4);
    EXCHANGE(v[3], v[7], LOW4, HIGH4);
    EXCHANGE(v[8], v[12], LOW4, HIGH4);
    EXCHANGE(v[9], v[13], LOW4, HIGH4);
    EXCHANGE(v[10], v[14], LOW4, HIGH4);
    EXCHANGE(v[11], v[15], LOW4, HIGH4);
    EXCHANGE(v[0], v[8], LOW8, HIGH8);
    EXCHANGE(v[1], v[9], LOW8, HIGH8);
    EXCHANGE(v[2], v[10], LOW8, HIGH8);
    EXCHANGE(v[3], v[11], LOW8, HIGH8);
    EXCHANGE(v[4], v[12], LOW8, HIGH8);
    EXCHANGE(v[5], v[13], LOW8, HIGH8);
    EXCHANGE(v[6], v[14], LOW8, HIGH8);
    EXCHANGE(v[7], v[15], LOW8, HIGH8);
#elif puma560_WIDTH == 8
#define LOW1 0, 8, 2, 10, 4, 12, 6, 14
#define HIGH1 1, 9, 3, 11, 5, 13, 7, 15
#define LOW2 0, 1, 8, 9, 4, 5, 12, 13
#define HIGH2 2, 3, 10, 11, 6, 7, 14, 15
#define LOW4 0, 1, 2, 3, 8, 9, 10, 11
#define HIGH4 4, 5, 6, 7, 12, 13, 14, 15
    EXCHANGE(v[0], v[1], LOW1, HIGH1);
    EXCHANGE(v[2], v[3], LOW1, HIGH1);
    EXCHANGE(v[4], v[5], LOW1, HIGH1);
    EXCHANGE(v[6], v[7], LOW1, HIGH1);
    EXCHANGE(v[0], v[2], LOW2, HIGH2);
    EXCHANGE(v[1], v[3], LOW2, HIGH2);
    EXCHANGE(v[4], v[6], LOW2, HIGH2);
    EXCHANGE(v[5], v[7], LOW2, HIGH2);
    EXCHANGE(v[0], v[4], LOW4, HIGH4);
    EXCHANGE(v[1], v[5], LOW4, HIGH4);
    EXCHANGE(v[2], v[6], LOW4, HIGH4);
    EXCHANGE(v[3], v[7], LOW4, HIGH4);
#elif puma560_WIDTH == 4
#define LOW1 0, 4, 2, 6
#define HIGH1 1, 5, 3, 7
#define LOW2 0, 1, 4, 5
#define HIGH2 2, 3, 6, 7
    EXCHANGE(v[0], v[1], LOW1, HIGH1);
    EXCHANGE(v[2], v[3], LOW1, HIGH1);
    EXCHANGE(v[0], v[2], LOW2, HIGH2);
    EXCHANGE(v[1], v[3], LOW2, HIGH2);
#elif puma560_WIDTH == 2
#define LOW1 0, 2
#define HIGH1 1, 3
    EXCHANGE(v[0], v[1], LOW1, HIGH1);
#endif
}

/* The row that all samples share, or the first. */
ALWAYS void lanes_shared(const double *row, size_t size, lanes *to)
{
    for (size_t i = 0; i < size; ++i) {
        to[i] = lanes_all(row[i]);
    }
}

/* Return a copy of the last rows from which a panel can be read: the last one stands for those that
 * are missing. `padded` holds REACH(size). */
SELDOM const double *lanes_last(
    const double *rows, size_t size, size_t stride, size_t count, double *padded)
{
    memset(padded, 0, REACH(size) * sizeof(double));
    for (size_t i = 0; i < puma560_WIDTH; ++i) {
        const size_t row = (i < count) ? i : (count - 1u);
        memcpy(&padded[i * size], &rows[row * stride], size * sizeof(double));
    }
    return padded;
}

/* Read the panel of sample k from rows of `size` numbers, `stride` apart, into BLOCKS(size) lanes.
 * Blocks reach behind a row, not behind the last one. */
ALWAYS void lanes_read(const double *rows, size_t size, size_t stride, size_t k, size_t N,
    double *padded, lanes *to)
{
    rows = &rows[k * stride];
    if ((N - k < puma560_WIDTH) || ((N - k - puma560_WIDTH) * stride < BLOCKS(size) - size)) {
        rows = lanes_last(rows, size, stride, N - k < puma560_WIDTH ? N - k : puma560_WIDTH, padded);
        stride = size;
    }
    for (size_t at = 0; at < size; at += puma560_WIDTH) {
        lanes v[puma560_WIDTH];
        UNROLLED
        for (size_t i = 0; i < puma560_WIDTH; ++i) {
            v[i] = *(const apart *)&rows[i * stride + at];
        }
        transpose(v);
        UNROLLED
        for (size_t i = 0; i < puma560_WIDTH; ++i) {
            to[at + i] = v[i];
        }
    }
}

/* Write a panel of `size` lanes as puma560_WIDTH rows. */
ALWAYS void lanes_rows(const lanes *from, size_t size, double *rows)
{
    size_t at = 0;
    while (at < size) {
        lanes v[puma560_WIDTH];
        if ((at + puma560_WIDTH > size) && (size >= puma560_WIDTH)) {
            at = size - puma560_WIDTH; /* the last block overlaps the one before */
        }
        UNROLLED
        for (size_t i = 0; i < puma560_WIDTH; ++i) {
            v[i] = from[at + i];
        }
        transpose(v);
        UNROLLED
        for (size_t i = 0; i < puma560_WIDTH; ++i) {
            if (size >= puma560_WIDTH) {
                *(apart *)&rows[i * size + at] = v[i];
            } else {
                memcpy(&rows[i * size], &v[i],
                    (size < puma560_WIDTH ? size : puma560_WIDTH) * sizeof(double));
            }
        }
        at += puma560_WIDTH;
    }
}

/* Copy past the cache. */
static inline void stream_copy(double *to, const double *from, size_t count)
{
    for (; (count > 0u) && ((uintptr_t)to % sizeof(lanes) != 0u); --count) {
        *to++ = *from++;
    }
    for (; count >= puma560_WIDTH; count -= puma560_WIDTH) {
        STREAM((lanes *)(void *)to, *(const apart *)(const void *)from);
        to += puma560_WIDTH;
        from += puma560_WIDTH;
    }
    for (; count > 0u; --count) {
        *to++ = *from++;
    }
}

/* Write `count` rows of a panel; `scratch` holds puma560_WIDTH rows. */
ALWAYS void lanes_store(const lanes *from, size_t size, size_t count, int stream,
    double *scratch, double *rows)
{
    if ((count == puma560_WIDTH) && !stream) {
        lanes_rows(from, size, rows);
        return;
    }
    lanes_rows(from, size, scratch);
    if (stream) {
        stream_copy(rows, scratch, count * size);
    } else {
        memcpy(rows, scratch, count * size * sizeof(double));
    }
}

#endif

#endif
