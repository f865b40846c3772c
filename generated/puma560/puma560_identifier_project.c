#include "puma560_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 6
#define EPSILON DBL_EPSILON
#define TRIES 60 /* of the length of a step */
#define SHORTER 0.9 /* each, and this part of the possible length is taken */

#define IN_LINK 0
#define POSITIVE 1

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

/* The y of dual(y) = Y. */
static void undual(const puma560_real *Y, puma560_real *y)
{
    const puma560_real sum = (Y[0] + Y[5] + Y[10]) / 2;
    const puma560_real out[10] = {sum - Y[0], -2 * Y[1], -2 * Y[2], sum - Y[5], -2 * Y[6],
                               sum - Y[10], 2 * Y[3], 2 * Y[7], 2 * Y[11], Y[15]};
    memcpy(y, out, sizeof out);
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

/* V = P^-1 from L of P = L L', which becomes L^-1. */
static void invert(puma560_real *L, puma560_real *V)
{
    for (int j = 0; j < 4; j++) {
        L[5 * j] = 1 / L[5 * j];
        for (int i = j + 1; i < 4; i++) {
            puma560_real sum = 0;
            for (int k = j; k < i; k++) {
                sum -= L[4 * i + k] * L[4 * k + j];
            }
            L[4 * i + j] = sum / L[5 * i];
        }
    }
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            puma560_real sum = 0;
            for (int k = i > j ? i : j; k < 4; k++) {
                sum += L[4 * k + i] * L[4 * k + j];
            }
            V[4 * i + j] = sum;
        }
    }
}

/* Whether the matrix of each link is positive definite, and what is positive is above 0: with
 * pseudo_inertia, whether a robot can have these parameters. */
static int inside(const puma560_real *x, void (*matrix)(const puma560_real *, puma560_real *))
{
    puma560_real P[16];
    for (int i = 0; i < puma560_STANDARD; i++) {
        if (KIND[i] == POSITIVE && !(x[i] > 0)) {
            return 0;
        }
    }
    for (int l = 0; l < LINKS; l++) {
        matrix(x + FIRST[l], P);
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

/* S y in place: (P Y Z^-1 + Z^-1 Y P) / 2 of each link, V its Z^-1. */
static void soften(const puma560_real *s, const puma560_real *z, const puma560_real *V,
                   const puma560_real *X0, puma560_real mu, puma560_real *y)
{
    puma560_real P[16];
    puma560_real Y[16];
    puma560_real Z[16] = {0};
    for (int i = 0; i < puma560_STANDARD; i++) {
        if (KIND[i] == POSITIVE) {
            y[i] *= s[i] / z[i];
        } else {
            y[i] *= KIND[i] == IN_LINK ? 1 : reach(X0[i]) * reach(X0[i]) / mu;
        }
    }
    for (int l = 0; l < LINKS; l++) {
        pseudo_inertia(s + FIRST[l], P);
        dual(y + FIRST[l], Y);
        multiply(P, Y, Z);
        multiply(Z, V + 16 * l, Y);
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < i; j++) {
                Y[4 * j + i] = (Y[4 * i + j] + Y[4 * j + i]) / 2;
            }
        }
        parameters(Y, y + FIRST[l]);
    }
}

/* The slope of the divergence where it is measured from, tr(P0^-1 P) and s / X0, which is what z
 * begins with. */
static void slope(const puma560_real *X0, puma560_real *y0)
{
    puma560_real P[16];
    puma560_real V[16] = {0};
    for (int i = 0; i < puma560_STANDARD; i++) {
        y0[i] = KIND[i] == POSITIVE ? 1 / X0[i] : 0;
    }
    for (int l = 0; l < LINKS; l++) {
        pseudo_inertia(X0 + FIRST[l], P);
        (void)factor(P);
        invert(P, V);
        undual(V, y0 + FIRST[l]);
    }
}

/* The factor of K = I + R G S G'R', upper triangle. Nonzero where it is not positive definite. */
static int normal_factor(const puma560_real *R, const puma560_real *s, const puma560_real *z,
                         const puma560_real *V, const puma560_real *X0, puma560_real mu, puma560_real *K)
{
    puma560_real x[puma560_PARAMETERS];
    puma560_real y[puma560_STANDARD];
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        memset(x, 0, sizeof x);
        memcpy(x + j, R + row_begin(j), sizeof x - (size_t)j * sizeof x[0]);
        spread(x, y);
        soften(s, z, V, X0, mu, y);
        combine(y, x);
        for (int i = j; i < puma560_PARAMETERS; i++) {
            puma560_real sum = i == j ? 1 : 0;
            for (int k = i; k < puma560_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
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
    }
    return 0;
}

/* Solve K f = f in place for the factor of K. */
static void solve(const puma560_real *K, puma560_real *f)
{
    for (int j = 0; j < puma560_PARAMETERS; j++) {
        const puma560_real *row = K + row_begin(j);
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
}

/* The steps of s and of z = mu y0 + G'R'f towards P Z = t I and f = R (G s - Y), where ds holds
 * the terms of second order at first:
 *
 *     K f = R (G h - Y),   h = s + t Z^-1 - S t y0 + (second order),
 *     ds = h - S G'R'f - s,   dz = t y0 + G'R'f - z.
 */
static void newton(const puma560_real *R, const puma560_real *K, const puma560_real *wanted,
                   const puma560_real *s, const puma560_real *z, const puma560_real *V,
                   const puma560_real *X0, const puma560_real *y0, puma560_real mu, puma560_real t,
                   puma560_real *ds, puma560_real *dz)
{
    puma560_real f[puma560_PARAMETERS];
    puma560_real x[puma560_PARAMETERS];
    puma560_real inverse[10] = {0};
    puma560_real soft[puma560_STANDARD];
    for (int i = 0; i < puma560_STANDARD; i++) { /* dz: S t y0, then G'R'f */
        dz[i] = t * y0[i];
    }
    soften(s, z, V, X0, mu, dz);
    for (int i = 0; i < puma560_STANDARD; i++) { /* ds becomes h */
        ds[i] += s[i] - dz[i] + (KIND[i] == POSITIVE ? t / z[i] : 0);
        ds[i] = KIND[i] > POSITIVE ? X0[i] : ds[i];
    }
    for (int l = 0; l < LINKS; l++) {
        parameters(V + 16 * l, inverse);
        for (int i = 0; i < 10; i++) {
            ds[FIRST[l] + i] += t * inverse[i];
        }
    }
    combine(ds, x);
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(R, x, f);
    solve(K, f);
    memset(x, 0, sizeof x);
    for (int i = 0; i < puma560_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < puma560_PARAMETERS; j++) {
            x[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(x, dz);
    memcpy(soft, dz, sizeof soft);
    soften(s, z, V, X0, mu, soft);
    for (int i = 0; i < puma560_STANDARD; i++) {
        ds[i] -= soft[i] + s[i];
        dz[i] += t * y0[i] - z[i];
    }
}

/* s + length ds, z + length dz, and whether both are inside. */
static int move(const puma560_real *s, const puma560_real *ds, const puma560_real *z, const puma560_real *dz,
                puma560_real length, puma560_real *s_at, puma560_real *z_at)
{
    for (int i = 0; i < puma560_STANDARD; i++) {
        s_at[i] = s[i] + length * ds[i];
        z_at[i] = z[i] + length * dz[i];
    }
    return inside(s_at, pseudo_inertia) != 0 && inside(z_at, dual) != 0;
}

/* The length of a step, and where it ends; 0 if rounding leaves none. */
static puma560_real go_along(const puma560_real *s, const puma560_real *ds, const puma560_real *z,
                          const puma560_real *dz, puma560_real *s_at, puma560_real *z_at)
{
    puma560_real length = 1;
    int found = 0;
    for (int k = 0; k < TRIES && found == 0; k++) {
        found = move(s, ds, z, dz, length, s_at, z_at);
        length *= (puma560_real)SHORTER;
    }
    return found != 0 && move(s, ds, z, dz, length, s_at, z_at) != 0 ? length : 0;
}

/* |R (G s - Y)|^2 and X = G s */
static puma560_real distance(const puma560_real *R, const puma560_real *wanted, const puma560_real *s,
                          puma560_real *X)
{
    puma560_real x[puma560_PARAMETERS];
    puma560_real r[puma560_PARAMETERS];
    puma560_real sum = 0;
    combine(s, X);
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        x[i] = X[i] - wanted[i];
    }
    times_factor(R, x, r);
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

int puma560_identifier_project(const void *state, const puma560_real *X0, puma560_real *X)
{
    const puma560_least_squares *known = puma560_identifier_state(state);
    puma560_real K[puma560_PARAMETERS * (puma560_PARAMETERS + 1) / 2];
    puma560_real V[16 * LINKS];
    puma560_real s[puma560_STANDARD];
    puma560_real z[puma560_STANDARD];
    puma560_real y0[puma560_STANDARD];
    puma560_real ds[puma560_STANDARD];
    puma560_real dz[puma560_STANDARD];
    puma560_real s_at[puma560_STANDARD];
    puma560_real z_at[puma560_STANDARD];
    puma560_real wanted[puma560_PARAMETERS];
    puma560_real x[puma560_PARAMETERS];
    puma560_real length = 1;
    for (int i = 0; i < puma560_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return puma560_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (inside(X0, pseudo_inertia) == 0) {
        return puma560_NOT_POSITIVE_DEFINITE;
    }
    if (puma560_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return puma560_NOT_EXCITED;
    }
    puma560_real nearest = distance(known->R, wanted, s, X);
    puma560_real mu = nearest / (8 * LINKS);
    slope(X0, y0);
    for (int i = 0; i < puma560_STANDARD; i++) {
        z[i] = mu * y0[i];
    }
    for (int k = 0; k < STEPS && length > 0; k++) {
        puma560_real P[16];
        for (int l = 0; l < LINKS; l++) {
            dual(z + FIRST[l], P);
            (void)factor(P);
            invert(P, V + 16 * l);
        }
        if (normal_factor(known->R, s, z, V, X0, mu, K) != 0) {
            break;
        }
        memset(ds, 0, sizeof ds);
        newton(known->R, K, wanted, s, z, V, X0, y0, mu, 0, ds, dz);
        const puma560_real left = 1 - go_along(s, ds, z, dz, s_at, z_at);
        const puma560_real t = left * left * left * mu;
        soften(ds, z, V, X0, mu, dz);
        for (int i = 0; i < puma560_STANDARD; i++) {
            ds[i] = -dz[i];
        }
        newton(known->R, K, wanted, s, z, V, X0, y0, mu, t, ds, dz);
        length = go_along(s, ds, z, dz, s_at, z_at);
        if (length > 0) {
            memcpy(s, s_at, sizeof s);
            memcpy(z, z_at, sizeof z);
            mu += length * (t - mu);
            const puma560_real now = distance(known->R, wanted, s, x);
            if (now < nearest) {
                nearest = now;
                memcpy(X, x, sizeof x);
            }
        }
    }
    return puma560_OK;
}
