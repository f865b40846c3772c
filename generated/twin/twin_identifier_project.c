#include "twin_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 7
#define EPSILON DBL_EPSILON
#define HALVINGS 40 /* of a step */
#define SHORTER 0.7 /* of the part of a step that is possible */

#define IN_LINK 0
#define POSITIVE 1
#define FREE 2

/* Place of XX of each link, and what the other parameters are. */
static const int FIRST[LINKS] = {0, 11, 22, 33, 44, 55, 66};
static const unsigned char KIND[twin_STANDARD] = {
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, POSITIVE, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, POSITIVE, POSITIVE, POSITIVE, POSITIVE,
    POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE, POSITIVE,
    POSITIVE, POSITIVE
};

/* X = G s: base parameter i has the terms BEGIN[i] to BEGIN[i + 1] of these. */
static const int BEGIN[twin_PARAMETERS + 1] = {
    0, 11, 15, 16, 18, 19, 23, 26, 27, 32, 33, 34, 35, 39, 40, 43, 44, 46, 47, 48, 49, 50, 51, 52,
    53, 57, 59, 61, 63, 66, 67, 68, 69, 71, 72, 74, 75, 77, 78, 79, 80, 81, 82, 83, 84, 85, 86,
    87, 88, 89, 90, 91, 92, 93, 94, 95, 96, 97, 98
};
static const int PLACE[] = {
    5, 10, 14, 20, 25, 31, 42, 47, 53, 60, 69, 11, 14, 31, 42, 12, 13, 30, 15, 16, 21, 31, 42, 17,
    31, 42, 18, 22, 25, 36, 41, 42, 23, 24, 26, 27, 36, 41, 42, 28, 29, 41, 42, 32, 33, 36, 34,
    35, 37, 38, 39, 40, 43, 44, 47, 55, 60, 45, 57, 46, 56, 48, 59, 49, 54, 58, 50, 51, 61, 62,
    74, 63, 64, 75, 65, 66, 69, 67, 68, 70, 71, 72, 73, 76, 77, 78, 79, 80, 81, 82, 83, 84, 85,
    86, 87, 88, 89, 90
};
static const twin_real FACTOR[] = {
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)0.04,
    (twin_real)1.0,
    (twin_real)0.13,
    (twin_real)0.13,
    (twin_real)1.0,
    (twin_real)0.04,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)-0.09,
    (twin_real)-0.09,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-0.3,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)0.09,
    (twin_real)0.09,
    (twin_real)1.0,
    (twin_real)0.3,
    (twin_real)0.3,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)0.5,
    (twin_real)0.0625,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)0.5,
    (twin_real)0.0625,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)-0.25,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)-1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0,
    (twin_real)1.0
};

static int row_begin(int i)
{
    return i * twin_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const twin_real *s, twin_real *X)
{
    for (int i = 0; i < twin_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += FACTOR[k] * s[PLACE[k]];
        }
    }
}

/* G'x */
static void spread(const twin_real *x, twin_real *s)
{
    for (int i = 0; i < twin_STANDARD; i++) {
        s[i] = 0;
    }
    for (int i = 0; i < twin_PARAMETERS; i++) {
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            s[PLACE[k]] += FACTOR[k] * x[i];
        }
    }
}

/* R x */
static void times_factor(const twin_real *R, const twin_real *x, twin_real *out)
{
    for (int i = 0; i < twin_PARAMETERS; i++) {
        twin_real sum = 0;
        for (int j = i; j < twin_PARAMETERS; j++) {
            sum += R[row_begin(i) + j - i] * x[j];
        }
        out[i] = sum;
    }
}

/* The pseudo-inertia of XX XY XZ YY YZ ZZ MX MY MZ M. */
static void pseudo_inertia(const twin_real *x, twin_real *P)
{
    const twin_real half = (x[0] + x[3] + x[5]) / 2;
    const twin_real out[16] = {half - x[0], -x[1], -x[2], x[6], -x[1], half - x[3], -x[4], x[7],
                               -x[2], -x[4], half - x[5], x[8], x[6], x[7], x[8], x[9]};
    memcpy(P, out, sizeof out);
}

/* The parameters of which P is the pseudo-inertia. */
static void parameters(const twin_real *P, twin_real *x)
{
    const twin_real trace = P[0] + P[5] + P[10];
    const twin_real out[10] = {trace - P[0], -P[1], -P[2], trace - P[5], -P[6],
                               trace - P[10], P[3], P[7], P[11], P[15]};
    memcpy(x, out, sizeof out);
}

/* The matrix Y with tr(P Y) = x'y for the pseudo-inertia P of any x. */
static void dual(const twin_real *y, twin_real *Y)
{
    const twin_real sum = y[0] + y[3] + y[5];
    const twin_real out[16] = {sum - y[0], -y[1] / 2, -y[2] / 2, y[6] / 2, -y[1] / 2, sum - y[3],
                               -y[4] / 2, y[7] / 2, -y[2] / 2, -y[4] / 2, sum - y[5], y[8] / 2,
                               y[6] / 2, y[7] / 2, y[8] / 2, y[9]};
    memcpy(Y, out, sizeof out);
}

static void multiply(const twin_real *A, const twin_real *B, twin_real *out)
{
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            twin_real sum = 0;
            for (int k = 0; k < 4; k++) {
                sum += A[4 * i + k] * B[4 * k + j];
            }
            out[4 * i + j] = sum;
        }
    }
}

/* L of P = L L' in place; 0, or 1 where P is not positive definite by more than rounding. */
static int factor(twin_real *P)
{
    for (int j = 0; j < 4; j++) {
        twin_real pivot = P[5 * j];
        for (int k = 0; k < j; k++) {
            pivot -= P[4 * j + k] * P[4 * j + k];
        }
        if (!(pivot > 64 * EPSILON * P[5 * j])) {
            return 1;
        }
        const twin_real root = sqrt(pivot);
        P[5 * j] = root;
        for (int i = j + 1; i < 4; i++) {
            twin_real sum = P[4 * i + j];
            for (int k = 0; k < j; k++) {
                sum -= P[4 * i + k] * P[4 * j + k];
            }
            P[4 * i + j] = sum / root;
        }
    }
    return 0;
}

/* Whether a robot can have these parameters. */
static int possible(const twin_real *s)
{
    twin_real P[16];
    for (int i = 0; i < twin_STANDARD; i++) {
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
static twin_real reach(twin_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* H^-1 y in place, H the second derivative of the divergence at s: P Y P of each link. */
static void soften(const twin_real *s, const twin_real *s0, twin_real *y)
{
    twin_real P[16];
    twin_real Y[16];
    twin_real Z[16] = {0};
    for (int i = 0; i < twin_STANDARD; i++) {
        const twin_real size = KIND[i] == POSITIVE ? s[i] : reach(s0[i]);
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
static void slope(const twin_real *s, const twin_real *s0, twin_real *out)
{
    twin_real P[16];
    twin_real L[16];
    twin_real Z[16] = {0};
    for (int i = 0; i < twin_STANDARD; i++) {
        out[i] = KIND[i] == POSITIVE ? s[i] * s[i] / s0[i] - s[i] : s[i] - s0[i];
    }
    for (int l = 0; l < LINKS; l++) {
        twin_real *x = out + FIRST[l];
        pseudo_inertia(s + FIRST[l], P);
        pseudo_inertia(s0 + FIRST[l], L);
        (void)factor(L);
        for (int j = 0; j < 4; j++) { /* L^-1 P */
            for (int i = 0; i < 4; i++) {
                twin_real sum = P[4 * i + j];
                for (int k = 0; k < i; k++) {
                    sum -= L[4 * i + k] * Z[4 * k + j];
                }
                Z[4 * i + j] = sum / L[5 * i];
            }
        }
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                twin_real sum = 0;
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
static int solve(twin_real *K, twin_real *f)
{
    for (int j = 0; j < twin_PARAMETERS; j++) {
        twin_real *row = K + row_begin(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const twin_real root = sqrt(row[0]);
        for (int i = 0; i < twin_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < twin_PARAMETERS; i++) {
            twin_real *below = K + row_begin(i);
            for (int k = i; k < twin_PARAMETERS; k++) {
                below[k - i] -= row[i - j] * row[k - j];
            }
        }
        f[j] /= row[0];
        for (int i = j + 1; i < twin_PARAMETERS; i++) {
            f[i] -= row[i - j] * f[j];
        }
    }
    for (int j = twin_PARAMETERS - 1; j >= 0; j--) {
        const twin_real *row = K + row_begin(j);
        for (int i = j + 1; i < twin_PARAMETERS; i++) {
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
static int newton(const twin_real *R, const twin_real *wanted, const twin_real *s0,
                  const twin_real *s, twin_real mu, twin_real *step)
{
    twin_real K[twin_PARAMETERS * (twin_PARAMETERS + 1) / 2];
    twin_real f[twin_PARAMETERS];
    twin_real x[twin_PARAMETERS];
    twin_real v[twin_PARAMETERS];
    slope(s, s0, step);
    for (int j = 0; j < twin_STANDARD; j++) {
        step[j] -= s[j];
    }
    combine(step, x);
    for (int j = 0; j < twin_PARAMETERS; j++) {
        x[j] += wanted[j];
    }
    times_factor(R, x, f);
    for (int j = 0; j < twin_PARAMETERS; j++) {
        memset(v, 0, sizeof v);
        memcpy(v + j, R + row_begin(j), sizeof v - (size_t)j * sizeof v[0]);
        spread(v, step);
        soften(s, s0, step);
        combine(step, x);
        for (int i = j; i < twin_PARAMETERS; i++) {
            twin_real sum = i == j ? mu : 0;
            for (int k = i; k < twin_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
    if (solve(K, f) != 0) {
        return 1;
    }
    memset(v, 0, sizeof v);
    for (int i = 0; i < twin_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < twin_PARAMETERS; j++) {
            v[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(v, step);
    soften(s, s0, step);
    return 0;
}

int twin_identifier_project(const void *state, const twin_real *X0, twin_real *X)
{
    const twin_least_squares *known = twin_identifier_state(state);
    twin_real s[twin_STANDARD];
    twin_real step[twin_STANDARD];
    twin_real at[twin_STANDARD];
    twin_real wanted[twin_PARAMETERS];
    twin_real x[twin_PARAMETERS];
    twin_real r[twin_PARAMETERS];
    twin_real mu = 0;
    for (int i = 0; i < twin_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return twin_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (possible(X0) == 0) {
        return twin_NOT_POSITIVE_DEFINITE;
    }
    if (twin_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return twin_NOT_EXCITED;
    }
    combine(s, x);
    for (int i = 0; i < twin_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(known->R, x, r);
    for (int i = 0; i < twin_PARAMETERS; i++) {
        mu += r[i] * r[i] / (8 * LINKS);
    }
    for (int k = 0; k < STEPS; k++) {
        twin_real length = 1;
        int found = 0;
        if (newton(known->R, wanted, X0, s, mu, step) != 0) {
            break;
        }
        slope(s, X0, at);
        for (int i = 0; i < twin_STANDARD; i++) {
            step[i] -= at[i];
        }
        for (int halving = 0; halving < HALVINGS && found == 0; halving++) {
            for (int i = 0; i < twin_STANDARD; i++) {
                at[i] = s[i] + length * step[i];
            }
            found = possible(at);
            length /= found != 0 ? 1 : 2;
        }
        if (found != 0 && length >= 1) {
            memcpy(s, at, sizeof s);
            mu /= 2;
        } else if (found != 0) {
            for (int i = 0; i < twin_STANDARD; i++) {
                at[i] = s[i] + (twin_real)SHORTER * length * step[i];
            }
            if (possible(at) != 0) {
                memcpy(s, at, sizeof s);
            }
        }
    }
    combine(s, X);
    return twin_OK;
}
