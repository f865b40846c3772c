#include "puma560_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 6
#define EPSILON DBL_EPSILON
#define HALVINGS 40 /* of a step */
#define SHORTER 0.7 /* of the part of a step that is possible */

#define IN_LINK 0
#define POSITIVE 1
#define FREE 2

/* Place of XX of each link, and what the other parameters are. */
static const int FIRST[LINKS] = {0, 11, 22, 33, 44, 55};
static const unsigned char KIND[puma560_STANDARD] = {
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE,
    POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE
};

/* X = G s: base parameter i has the terms BEGIN[i] to BEGIN[i + 1] of these. */
static const int BEGIN[puma560_PARAMETERS + 1] = {
    0, 11, 17, 18, 24, 25, 31, 36, 37, 44, 49, 50, 51, 57, 61, 66, 67, 70, 71, 72, 73, 75, 76, 78,
    79, 82, 83, 84, 85, 87, 88, 90, 91, 93, 94, 95, 96, 97, 98, 99, 100, 101, 102, 103, 104, 105,
    106, 107, 108, 109, 110, 111, 112
};
static const int PLACE[] = {
    5, 10, 14, 19, 20, 25, 30, 31, 42, 53, 64, 11, 14, 31, 42, 53, 64, 12, 13, 30, 31, 42, 53, 64,
    15, 16, 21, 31, 42, 53, 64, 17, 31, 42, 53, 64, 18, 22, 25, 36, 41, 42, 53, 64, 23, 41, 42,
    53, 64, 24, 26, 27, 36, 41, 42, 53, 64, 28, 42, 53, 64, 29, 41, 42, 53, 64, 32, 33, 36, 47,
    34, 35, 37, 38, 47, 39, 40, 52, 43, 44, 47, 58, 45, 46, 48, 49, 58, 50, 51, 63, 54, 55, 58,
    56, 57, 59, 60, 61, 62, 65, 66, 67, 68, 69, 70, 71, 72, 73, 74, 75, 76, 77
};
static const puma560_real FACTOR[] = {
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)0.487,
    (puma560_real)0.05929225,
    (puma560_real)1.0,
    (puma560_real)0.3002,
    (puma560_real)0.20898125,
    (puma560_real)0.20939334,
    (puma560_real)0.20939334,
    (puma560_real)0.20939334,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)-0.18645124,
    (puma560_real)-0.18645124,
    (puma560_real)-0.18645124,
    (puma560_real)-0.18645124,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)-0.4318,
    (puma560_real)0.04033012,
    (puma560_real)0.04033012,
    (puma560_real)0.04033012,
    (puma560_real)0.04033012,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)0.18645124,
    (puma560_real)0.18645124,
    (puma560_real)0.18645124,
    (puma560_real)0.18645124,
    (puma560_real)1.0,
    (puma560_real)0.4318,
    (puma560_real)0.4318,
    (puma560_real)0.4318,
    (puma560_real)0.4318,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)1.0,
    (puma560_real)0.8662,
    (puma560_real)0.18716352,
    (puma560_real)0.18716352,
    (puma560_real)0.18716352,
    (puma560_real)1.0,
    (puma560_real)-0.0203,
    (puma560_real)-0.00879193,
    (puma560_real)-0.00879193,
    (puma560_real)-0.00879193,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)0.8662,
    (puma560_real)0.1879877,
    (puma560_real)0.1879877,
    (puma560_real)0.1879877,
    (puma560_real)1.0,
    (puma560_real)-0.0203,
    (puma560_real)-0.0203,
    (puma560_real)-0.0203,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)-0.4331,
    (puma560_real)-0.4331,
    (puma560_real)-0.4331,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)-1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0,
    (puma560_real)1.0
};

static int row_begin(int i)
{
    return i * puma560_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const puma560_real *s, puma560_real *X)
{
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += FACTOR[k] * s[PLACE[k]];
        }
    }
}

/* G'x */
static void spread(const puma560_real *x, puma560_real *s)
{
    for (int i = 0; i < puma560_STANDARD; i++) {
        s[i] = 0;
    }
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            s[PLACE[k]] += FACTOR[k] * x[i];
        }
    }
}

/* R x */
static void times_factor(const puma560_real *R, const puma560_real *x, puma560_real *out)
{
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        puma560_real sum = 0;
        for (int j = i; j < puma560_PARAMETERS; j++) {
            sum += R[row_begin(i) + j - i] * x[j];
        }
        out[i] = sum;
    }
}

/* The pseudo-inertia of XX XY XZ YY YZ ZZ MX MY MZ M. */
static void pseudo_inertia(const puma560_real *x, puma560_real *P)
{
    const puma560_real half = (x[0] + x[3] + x[5]) / 2;
    const puma560_real out[16] = {half - x[0], -x[1], -x[2], x[6], -x[1], half - x[3], -x[4], x[7],
                               -x[2], -x[4], half - x[5], x[8], x[6], x[7], x[8], x[9]};
    memcpy(P, out, sizeof out);
}

/* The parameters of which P is the pseudo-inertia. */
static void parameters(const puma560_real *P, puma560_real *x)
{
    const puma560_real trace = P[0] + P[5] + P[10];
    const puma560_real out[10] = {trace - P[0], -P[1], -P[2], trace - P[5], -P[6],
                               trace - P[10], P[3], P[7], P[11], P[15]};
    memcpy(x, out, sizeof out);
}

/* The matrix Y with tr(P Y) = x'y for the pseudo-inertia P of any x. */
static void dual(const puma560_real *y, puma560_real *Y)
{
    const puma560_real sum = y[0] + y[3] + y[5];
    const puma560_real out[16] = {sum - y[0], -y[1] / 2, -y[2] / 2, y[6] / 2, -y[1] / 2, sum - y[3],
                               -y[4] / 2, y[7] / 2, -y[2] / 2, -y[4] / 2, sum - y[5], y[8] / 2,
                               y[6] / 2, y[7] / 2, y[8] / 2, y[9]};
    memcpy(Y, out, sizeof out);
}

static void multiply(const puma560_real *A, const puma560_real *B, puma560_real *out)
{
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            puma560_real sum = 0;
            for (int k = 0; k < 4; k++) {
                sum += A[4 * i + k] * B[4 * k + j];
            }
            out[4 * i + j] = sum;
        }
    }
}

/* L of P = L L' in place; 0, or 1 where P is not positive definite by more than rounding. */
static int factor(puma560_real *P)
{
    for (int j = 0; j < 4; j++) {
        puma560_real pivot = P[5 * j];
        for (int k = 0; k < j; k++) {
            pivot -= P[4 * j + k] * P[4 * j + k];
        }
        if (!(pivot > 64 * EPSILON * P[5 * j])) {
            return 1;
        }
        const puma560_real root = sqrt(pivot);
        P[5 * j] = root;
        for (int i = j + 1; i < 4; i++) {
            puma560_real sum = P[4 * i + j];
            for (int k = 0; k < j; k++) {
                sum -= P[4 * i + k] * P[4 * j + k];
            }
            P[4 * i + j] = sum / root;
        }
    }
    return 0;
}

/* Whether a robot can have these parameters. */
static int possible(const puma560_real *s)
{
    puma560_real P[16];
    for (int i = 0; i < puma560_STANDARD; i++) {
        if (KIND[i] == POSITIVE && !(s[i] > 0)) {
            return 0;
        }
    }
    for (int l = 0; l < LINKS; l++) {
        pseudo_inertia(s + FIRST[l], P);
        if (factor(P) != 0) {
            return 0;
        }
    }
    return 1;
}

/* How far a free parameter goes for a unit of divergence. */
static puma560_real reach(puma560_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* H^-1 y in place, H the second derivative of the divergence at s: P Y P of each link. */
static void soften(const puma560_real *s, const puma560_real *s0, puma560_real *y)
{
    puma560_real P[16];
    puma560_real Y[16];
    puma560_real Z[16] = {0};
    for (int i = 0; i < puma560_STANDARD; i++) {
        const puma560_real size = KIND[i] == POSITIVE ? s[i] : reach(s0[i]);
        y[i] *= KIND[i] == IN_LINK ? 1 : size * size;
    }
    for (int l = 0; l < LINKS; l++) {
        pseudo_inertia(s + FIRST[l], P);
        dual(y + FIRST[l], Y);
        multiply(P, Y, Z);
        multiply(Z, P, Y);
        parameters(Y, y + FIRST[l]);
    }
}

/* H^-1 times the slope of the divergence at s: P P0^-1 P - P of each link. */
static void slope(const puma560_real *s, const puma560_real *s0, puma560_real *out)
{
    puma560_real P[16];
    puma560_real L[16];
    puma560_real Z[16] = {0};
    for (int i = 0; i < puma560_STANDARD; i++) {
        out[i] = KIND[i] == POSITIVE ? s[i] * s[i] / s0[i] - s[i] : s[i] - s0[i];
    }
    for (int l = 0; l < LINKS; l++) {
        puma560_real *x = out + FIRST[l];
        pseudo_inertia(s + FIRST[l], P);
        pseudo_inertia(s0 + FIRST[l], L);
        (void)factor(L);
        for (int j = 0; j < 4; j++) { /* L^-1 P */
            for (int i = 0; i < 4; i++) {
                puma560_real sum = P[4 * i + j];
                for (int k = 0; k < i; k++) {
                    sum -= L[4 * i + k] * Z[4 * k + j];
                }
                Z[4 * i + j] = sum / L[5 * i];
            }
        }
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                puma560_real sum = 0;
                for (int k = 0; k < 4; k++) {
                    sum += Z[4 * k + i] * Z[4 * k + j];
                }
                L[4 * i + j] = sum - P[4 * i + j];
            }
        }
        parameters(L, x);
    }
}

/* Solve K f = f in place for the upper triangle of K, which becomes its factor. Nonzero where K is
 * not positive definite. */
static int solve(puma560_real *K, puma560_real *f)
{
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        puma560_real *row = K + row_begin(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const puma560_real root = sqrt(row[0]);
        for (int i = 0; i < puma560_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < puma560_PARAMETERS; i++) {
            puma560_real *below = K + row_begin(i);
            for (int k = i; k < puma560_PARAMETERS; k++) {
                below[k - i] -= row[i - j] * row[k - j];
            }
        }
        f[j] /= row[0];
        for (int i = j + 1; i < puma560_PARAMETERS; i++) {
            f[i] -= row[i - j] * f[j];
        }
    }
    for (int j = puma560_PARAMETERS - 1; j >= 0; j--) {
        const puma560_real *row = K + row_begin(j);
        for (int i = j + 1; i < puma560_PARAMETERS; i++) {
            f[j] -= row[i - j] * f[i];
        }
        f[j] /= row[0];
    }
    return 0;
}

/* The step of Newton's method from s, in standard parameters:
 *
 *     -h + H^-1 G'R'f,   (mu I + R G H^-1 G'R') f = R (Y - G s) + R G h,   h = H^-1 slope.
 *
 * Nonzero where rounding leaves none. */
static int newton(const puma560_real *R, const puma560_real *wanted, const puma560_real *s0,
                  const puma560_real *s, puma560_real mu, puma560_real *step)
{
    puma560_real K[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2];
    puma560_real f[puma560_PARAMETERS];
    puma560_real x[puma560_PARAMETERS];
    puma560_real v[puma560_PARAMETERS];
    slope(s, s0, step);
    for (int j = 0; j < puma560_STANDARD; j++) {
        step[j] -= s[j];
    }
    combine(step, x);
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        x[j] += wanted[j];
    }
    times_factor(R, x, f);
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        memset(v, 0, sizeof v);
        memcpy(v + j, R + row_begin(j), sizeof v - (size_t)j * sizeof v[0]);
        spread(v, step);
        soften(s, s0, step);
        combine(step, x);
        for (int i = j; i < puma560_PARAMETERS; i++) {
            puma560_real sum = i == j ? mu : 0;
            for (int k = i; k < puma560_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
    if (solve(K, f) != 0) {
        return 1;
    }
    memset(v, 0, sizeof v);
    for (int i = 0; i < puma560_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < puma560_PARAMETERS; j++) {
            v[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(v, step);
    soften(s, s0, step);
    return 0;
}

int puma560_identifier_project(const void *state, const puma560_real *X0, puma560_real *X)
{
    const puma560_least_squares *known = puma560_identifier_state(state);
    puma560_real s[puma560_STANDARD];
    puma560_real step[puma560_STANDARD];
    puma560_real at[puma560_STANDARD];
    puma560_real wanted[puma560_PARAMETERS];
    puma560_real x[puma560_PARAMETERS];
    puma560_real r[puma560_PARAMETERS];
    puma560_real mu = 0;
    for (int i = 0; i < puma560_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return puma560_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (possible(X0) == 0) {
        return puma560_NOT_POSITIVE_DEFINITE;
    }
    if (puma560_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return puma560_NOT_EXCITED;
    }
    combine(s, x);
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(known->R, x, r);
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        mu += r[i] * r[i] / (8 * LINKS);
    }
    for (int k = 0; k < STEPS; k++) {
        puma560_real length = 1;
        int found = 0;
        if (newton(known->R, wanted, X0, s, mu, step) != 0) {
            break;
        }
        slope(s, X0, at);
        for (int i = 0; i < puma560_STANDARD; i++) {
            step[i] -= at[i];
        }
        for (int halving = 0; halving < HALVINGS && found == 0; halving++) {
            for (int i = 0; i < puma560_STANDARD; i++) {
                at[i] = s[i] + length * step[i];
            }
            found = possible(at);
            length /= found != 0 ? 1 : 2;
        }
        if (found != 0 && length >= 1) {
            memcpy(s, at, sizeof s);
            mu /= 2;
        } else if (found != 0) {
            for (int i = 0; i < puma560_STANDARD; i++) {
                at[i] = s[i] + (puma560_real)SHORTER * length * step[i];
            }
            if (possible(at) != 0) {
                memcpy(s, at, sizeof s);
            }
        }
    }
    combine(s, X);
    return puma560_OK;
}
