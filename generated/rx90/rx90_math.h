/* Cosine and sine of 1, 2 or 4 angles at once, to 1.3 units in the last place.
 *
 * The angle less a multiple t of pi/2 (Cody and Waite, in three parts, and what rounding lost of
 * them), then minimax polynomials on (-pi/4, pi/4). No branch depends on one angle alone, so that
 * compilers keep the angles side by side in vector registers. Far angles, NaN and arithmetic that
 * is not plain IEEE double are left to libm. Private to the kernels.
 */
#ifndef rx90_MATH_H
#define rx90_MATH_H

#include <float.h>
#include <math.h>
#include <stddef.h>

/* Largest sum of absolute angles for which t times the first part of pi/2 is exact. */
#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST) \
    || FLT_EVAL_METHOD != 0
#define rx90_NEAR (-1.0)
#else
#define rx90_NEAR 1e5
#endif

/* Added and taken away again, it rounds a double to an integer. */
#define rx90_ROUND 6755399441055744.0

static inline void rx90_cosine_sine(double x, double *cosine, double *sine)
{
#if defined(__clang__) && __clang_major__ >= 11
#pragma clang fp reassociate(off) /* clang does not tell -fassociative-math by a macro */
#endif
    const double t = (x * 0.6366197723675814 + rx90_ROUND) - rx90_ROUND;
    const double head = x - t * 1.5707963267341256;
    const double middle = t * 6.077100506303966e-11;
    const double tail = t * 2.0222662487959506e-21;
    const double first = head - middle;
    const double r = first - tail;
    const double lost = ((first - r) - tail) + ((head - first) - middle);
    const double z = r * r;
    const double w = z * z;
    const double s = r
        + (r * z
                * ((-0.16666666666666632 + z * 0.008333333333322413)
                    + w * ((-0.00019841269829807819 + z * 2.7557313691921887e-06)
                        + w * (-2.5050758115840255e-08 + z * 1.589679568451575e-10)))
            + lost);
    const double c = (1.0 - 0.5 * z)
        + (w * ((0.0416666666666666 + z * -0.0013888888888874125)
                + w * ((2.4801587289482184e-05 + z * -2.7557314352332913e-07)
                    + w * (2.0875723273266597e-09 + z * -1.1359647806143871e-11)))
            - r * lost);
    /* sin(t pi/2) is what t has over an even number; cos(t pi/2) is 0 or the sign of t/2. */
    const double half = (t * 0.5 + rx90_ROUND) - rx90_ROUND;
    const double quarter = (half * 0.5 + rx90_ROUND) - rx90_ROUND;
    const double odd = t - 2.0 * half;
    const double second = half - 2.0 * quarter;
    const double even = 1.0 - (odd * odd + 2.0 * (second * second));
    *cosine = c * even - s * odd;
    *sine = s * even + c * odd;
}

typedef struct { double c[1]; double s[1]; } rx90_angles1;
typedef struct { double c[2]; double s[2]; } rx90_angles2;
typedef struct { double c[4]; double s[4]; } rx90_angles4;

static inline rx90_angles1 rx90_sincos1(const double *x)
{
    rx90_angles1 out;
    for (size_t i = 0; i < 1u; ++i) {
        rx90_cosine_sine(x[i], &out.c[i], &out.s[i]);
    }
    if (!(fabs(x[0]) <= rx90_NEAR)) {
        for (size_t i = 0; i < 1u; ++i) {
            out.c[i] = cos(x[i]);
            out.s[i] = sin(x[i]);
        }
    }
    return out;
}

static inline rx90_angles2 rx90_sincos2(const double *x)
{
    rx90_angles2 out;
    for (size_t i = 0; i < 2u; ++i) {
        rx90_cosine_sine(x[i], &out.c[i], &out.s[i]);
    }
    if (!(fabs(x[0]) + fabs(x[1]) <= rx90_NEAR)) {
        for (size_t i = 0; i < 2u; ++i) {
            out.c[i] = cos(x[i]);
            out.s[i] = sin(x[i]);
        }
    }
    return out;
}

static inline rx90_angles4 rx90_sincos4(const double *x)
{
    rx90_angles4 out;
    for (size_t i = 0; i < 4u; ++i) {
        rx90_cosine_sine(x[i], &out.c[i], &out.s[i]);
    }
    if (!(fabs(x[0]) + fabs(x[1]) + fabs(x[2]) + fabs(x[3]) <= rx90_NEAR)) {
        for (size_t i = 0; i < 4u; ++i) {
            out.c[i] = cos(x[i]);
            out.s[i] = sin(x[i]);
        }
    }
    return out;
}

#endif
