#include "panda_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 7
#define EPSILON DBL_EPSILON
#define TRIES 60 /* of the length of a step */
#define SHORTER 0.9 /* each, and this part of the possible length is taken */

#define IN_LINK 0
#define POSITIVE 1

/* Place of XX of each link, and what the other parameters are. */
static const int FIRST[LINKS] = {0, 11, 22, 33, 44, 55, 66};
static const unsigned char KIND[panda_STANDARD] = {
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
static const int BEGIN[panda_PARAMETERS + 1] = {
    0, 3, 12, 13, 14, 15, 24, 25, 32, 36, 38, 39, 40, 46, 51, 53, 54, 61, 66, 67, 68, 74, 78, 83,
    84, 88, 89, 90, 91, 94, 95, 97, 98, 102, 104, 105, 106, 109, 111, 113, 114, 116, 117, 118,
    119, 120, 121, 122, 123, 124, 125, 126, 127, 128, 129, 130, 131, 132, 133, 134, 135, 136, 137
};
static const int PLACE[] = {
    5, 10, 14, 11, 14, 25, 30, 31, 42, 53, 64, 75, 12, 13, 15, 16, 21, 25, 30, 31, 42, 53, 64, 75,
    17, 18, 30, 31, 42, 53, 64, 75, 22, 25, 36, 42, 23, 41, 24, 26, 27, 36, 42, 53, 64, 75, 28,
    42, 53, 64, 75, 29, 41, 32, 33, 36, 47, 52, 53, 64, 75, 34, 52, 53, 64, 75, 35, 37, 38, 47,
    52, 53, 64, 75, 39, 53, 64, 75, 40, 52, 53, 64, 75, 43, 44, 47, 58, 75, 45, 46, 48, 49, 58,
    75, 50, 51, 63, 54, 55, 58, 69, 75, 56, 74, 57, 59, 60, 69, 75, 61, 75, 62, 74, 65, 66, 69,
    67, 68, 70, 71, 72, 73, 76, 77, 78, 79, 80, 81, 82, 83, 84, 85, 86, 87, 88, 89, 90
};
static const panda_real FACTOR[] = {
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)0.632,
    (panda_real)0.099856,
    (panda_real)0.10666225,
    (panda_real)0.10666225,
    (panda_real)0.10666225,
    (panda_real)0.10666225,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)0.632,
    (panda_real)0.099856,
    (panda_real)0.10666225,
    (panda_real)0.10666225,
    (panda_real)0.10666225,
    (panda_real)0.10666225,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)-0.316,
    (panda_real)-0.316,
    (panda_real)-0.316,
    (panda_real)-0.316,
    (panda_real)-0.316,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)-0.00680625,
    (panda_real)1.0,
    (panda_real)0.0825,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)0.00680625,
    (panda_real)0.0136125,
    (panda_real)0.0136125,
    (panda_real)0.0136125,
    (panda_real)1.0,
    (panda_real)0.0825,
    (panda_real)0.0825,
    (panda_real)0.0825,
    (panda_real)0.0825,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)0.768,
    (panda_real)0.14064975,
    (panda_real)0.14064975,
    (panda_real)0.14064975,
    (panda_real)1.0,
    (panda_real)0.0825,
    (panda_real)0.03168,
    (panda_real)0.03168,
    (panda_real)0.03168,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)0.768,
    (panda_real)0.15426225,
    (panda_real)0.15426225,
    (panda_real)0.15426225,
    (panda_real)1.0,
    (panda_real)-0.0825,
    (panda_real)-0.0825,
    (panda_real)-0.0825,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)0.384,
    (panda_real)0.384,
    (panda_real)0.384,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)0.007744,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)0.007744,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)-0.007744,
    (panda_real)1.0,
    (panda_real)0.088,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)0.007744,
    (panda_real)1.0,
    (panda_real)0.088,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)-1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0,
    (panda_real)1.0
};

static int row_begin(int i)
{
    return i * panda_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const panda_real *s, panda_real *X)
{
    for (int i = 0; i < panda_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += FACTOR[k] * s[PLACE[k]];
        }
    }
}

/* G'x */
static void spread(const panda_real *x, panda_real *s)
{
    for (int i = 0; i < panda_STANDARD; i++) {
        s[i] = 0;
    }
    for (int i = 0; i < panda_PARAMETERS; i++) {
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            s[PLACE[k]] += FACTOR[k] * x[i];
        }
    }
}

/* R x */
static void times_factor(const panda_real *R, const panda_real *x, panda_real *out)
{
    for (int i = 0; i < panda_PARAMETERS; i++) {
        panda_real sum = 0;
        for (int j = i; j < panda_PARAMETERS; j++) {
            sum += R[row_begin(i) + j - i] * x[j];
        }
        out[i] = sum;
    }
}

/* The pseudo-inertia of XX XY XZ YY YZ ZZ MX MY MZ M. */
static void pseudo_inertia(const panda_real *x, panda_real *P)
{
    const panda_real half = (x[0] + x[3] + x[5]) / 2;
    const panda_real out[16] = {half - x[0], -x[1], -x[2], x[6], -x[1], half - x[3], -x[4], x[7],
                               -x[2], -x[4], half - x[5], x[8], x[6], x[7], x[8], x[9]};
    memcpy(P, out, sizeof out);
}

/* The parameters of which P is the pseudo-inertia. */
static void parameters(const panda_real *P, panda_real *x)
{
    const panda_real trace = P[0] + P[5] + P[10];
    const panda_real out[10] = {trace - P[0], -P[1], -P[2], trace - P[5], -P[6],
                               trace - P[10], P[3], P[7], P[11], P[15]};
    memcpy(x, out, sizeof out);
}

/* The matrix Y with tr(P Y) = x'y for the pseudo-inertia P of any x. */
static void dual(const panda_real *y, panda_real *Y)
{
    const panda_real sum = y[0] + y[3] + y[5];
    const panda_real out[16] = {sum - y[0], -y[1] / 2, -y[2] / 2, y[6] / 2, -y[1] / 2, sum - y[3],
                               -y[4] / 2, y[7] / 2, -y[2] / 2, -y[4] / 2, sum - y[5], y[8] / 2,
                               y[6] / 2, y[7] / 2, y[8] / 2, y[9]};
    memcpy(Y, out, sizeof out);
}

/* The y of dual(y) = Y. */
static void undual(const panda_real *Y, panda_real *y)
{
    const panda_real sum = (Y[0] + Y[5] + Y[10]) / 2;
    const panda_real out[10] = {sum - Y[0], -2 * Y[1], -2 * Y[2], sum - Y[5], -2 * Y[6],
                               sum - Y[10], 2 * Y[3], 2 * Y[7], 2 * Y[11], Y[15]};
    memcpy(y, out, sizeof out);
}

static void multiply(const panda_real *A, const panda_real *B, panda_real *out)
{
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            panda_real sum = 0;
            for (int k = 0; k < 4; k++) {
                sum += A[4 * i + k] * B[4 * k + j];
            }
            out[4 * i + j] = sum;
        }
    }
}

/* L of P = L L' in place; 0, or 1 where P is not positive definite by more than rounding. */
static int factor(panda_real *P)
{
    for (int j = 0; j < 4; j++) {
        panda_real pivot = P[5 * j];
        for (int k = 0; k < j; k++) {
            pivot -= P[4 * j + k] * P[4 * j + k];
        }
        if (!(pivot > 64 * EPSILON * P[5 * j])) {
            return 1;
        }
        const panda_real root = sqrt(pivot);
        P[5 * j] = root;
        for (int i = j + 1; i < 4; i++) {
            panda_real sum = P[4 * i + j];
            for (int k = 0; k < j; k++) {
                sum -= P[4 * i + k] * P[4 * j + k];
            }
            P[4 * i + j] = sum / root;
        }
    }
    return 0;
}

/* V = P^-1 from L of P = L L', which becomes L^-1. */
static void invert(panda_real *L, panda_real *V)
{
    for (int j = 0; j < 4; j++) {
        L[5 * j] = 1 / L[5 * j];
        for (int i = j + 1; i < 4; i++) {
            panda_real sum = 0;
            for (int k = j; k < i; k++) {
                sum -= L[4 * i + k] * L[4 * k + j];
            }
            L[4 * i + j] = sum / L[5 * i];
        }
    }
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            panda_real sum = 0;
            for (int k = i > j ? i : j; k < 4; k++) {
                sum += L[4 * k + i] * L[4 * k + j];
            }
            V[4 * i + j] = sum;
        }
    }
}

/* Whether the matrix of each link is positive definite, and what is positive is above 0: with
 * pseudo_inertia, whether a robot can have these parameters. */
static int inside(const panda_real *x, void (*matrix)(const panda_real *, panda_real *))
{
    panda_real P[16];
    for (int i = 0; i < panda_STANDARD; i++) {
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
static panda_real reach(panda_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* S y in place: (P Y Z^-1 + Z^-1 Y P) / 2 of each link, V its Z^-1. */
static void soften(const panda_real *s, const panda_real *z, const panda_real *V,
                   const panda_real *X0, panda_real mu, panda_real *y)
{
    panda_real P[16];
    panda_real Y[16];
    panda_real Z[16] = {0};
    for (int i = 0; i < panda_STANDARD; i++) {
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
static void slope(const panda_real *X0, panda_real *y0)
{
    panda_real P[16];
    panda_real V[16] = {0};
    for (int i = 0; i < panda_STANDARD; i++) {
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
static int normal_factor(const panda_real *R, const panda_real *s, const panda_real *z,
                         const panda_real *V, const panda_real *X0, panda_real mu, panda_real *K)
{
    panda_real x[panda_PARAMETERS];
    panda_real y[panda_STANDARD];
    for (int j = 0; j < panda_PARAMETERS; j++) {
        memset(x, 0, sizeof x);
        memcpy(x + j, R + row_begin(j), sizeof x - (size_t)j * sizeof x[0]);
        spread(x, y);
        soften(s, z, V, X0, mu, y);
        combine(y, x);
        for (int i = j; i < panda_PARAMETERS; i++) {
            panda_real sum = i == j ? 1 : 0;
            for (int k = i; k < panda_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
    for (int j = 0; j < panda_PARAMETERS; j++) {
        panda_real *row = K + row_begin(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const panda_real root = sqrt(row[0]);
        for (int i = 0; i < panda_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < panda_PARAMETERS; i++) {
            panda_real *below = K + row_begin(i);
            for (int k = i; k < panda_PARAMETERS; k++) {
                below[k - i] -= row[i - j] * row[k - j];
            }
        }
    }
    return 0;
}

/* Solve K f = f in place for the factor of K. */
static void solve(const panda_real *K, panda_real *f)
{
    for (int j = 0; j < panda_PARAMETERS; j++) {
        const panda_real *row = K + row_begin(j);
        f[j] /= row[0];
        for (int i = j + 1; i < panda_PARAMETERS; i++) {
            f[i] -= row[i - j] * f[j];
        }
    }
    for (int j = panda_PARAMETERS - 1; j >= 0; j--) {
        const panda_real *row = K + row_begin(j);
        for (int i = j + 1; i < panda_PARAMETERS; i++) {
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
static void newton(const panda_real *R, const panda_real *K, const panda_real *wanted,
                   const panda_real *s, const panda_real *z, const panda_real *V,
                   const panda_real *X0, const panda_real *y0, panda_real mu, panda_real t,
                   panda_real *ds, panda_real *dz)
{
    panda_real f[panda_PARAMETERS];
    panda_real x[panda_PARAMETERS];
    panda_real inverse[10] = {0};
    panda_real soft[panda_STANDARD];
    for (int i = 0; i < panda_STANDARD; i++) { /* dz: S t y0, then G'R'f */
        dz[i] = t * y0[i];
    }
    soften(s, z, V, X0, mu, dz);
    for (int i = 0; i < panda_STANDARD; i++) { /* ds becomes h */
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
    for (int i = 0; i < panda_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(R, x, f);
    solve(K, f);
    memset(x, 0, sizeof x);
    for (int i = 0; i < panda_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < panda_PARAMETERS; j++) {
            x[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(x, dz);
    memcpy(soft, dz, sizeof soft);
    soften(s, z, V, X0, mu, soft);
    for (int i = 0; i < panda_STANDARD; i++) {
        ds[i] -= soft[i] + s[i];
        dz[i] += t * y0[i] - z[i];
    }
}

/* s + length ds, z + length dz, and whether both are inside. */
static int move(const panda_real *s, const panda_real *ds, const panda_real *z, const panda_real *dz,
                panda_real length, panda_real *s_at, panda_real *z_at)
{
    for (int i = 0; i < panda_STANDARD; i++) {
        s_at[i] = s[i] + length * ds[i];
        z_at[i] = z[i] + length * dz[i];
    }
    return inside(s_at, pseudo_inertia) != 0 && inside(z_at, dual) != 0;
}

/* The length of a step, and where it ends; 0 if rounding leaves none. */
static panda_real go_along(const panda_real *s, const panda_real *ds, const panda_real *z,
                          const panda_real *dz, panda_real *s_at, panda_real *z_at)
{
    panda_real length = 1;
    int found = 0;
    for (int k = 0; k < TRIES && found == 0; k++) {
        found = move(s, ds, z, dz, length, s_at, z_at);
        length *= (panda_real)SHORTER;
    }
    return found != 0 && move(s, ds, z, dz, length, s_at, z_at) != 0 ? length : 0;
}

/* |R (G s - Y)|^2 and X = G s */
static panda_real distance(const panda_real *R, const panda_real *wanted, const panda_real *s,
                          panda_real *X)
{
    panda_real x[panda_PARAMETERS];
    panda_real r[panda_PARAMETERS];
    panda_real sum = 0;
    combine(s, X);
    for (int i = 0; i < panda_PARAMETERS; i++) {
        x[i] = X[i] - wanted[i];
    }
    times_factor(R, x, r);
    for (int i = 0; i < panda_PARAMETERS; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

int panda_identifier_project(const void *state, const panda_real *X0, panda_real *X)
{
    const panda_least_squares *known = panda_identifier_state(state);
    panda_real K[panda_PARAMETERS * (panda_PARAMETERS + 1) / 2];
    panda_real V[16 * LINKS];
    panda_real s[panda_STANDARD];
    panda_real z[panda_STANDARD];
    panda_real y0[panda_STANDARD];
    panda_real ds[panda_STANDARD];
    panda_real dz[panda_STANDARD];
    panda_real s_at[panda_STANDARD];
    panda_real z_at[panda_STANDARD];
    panda_real wanted[panda_PARAMETERS];
    panda_real x[panda_PARAMETERS];
    panda_real length = 1;
    for (int i = 0; i < panda_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return panda_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (inside(X0, pseudo_inertia) == 0) {
        return panda_NOT_POSITIVE_DEFINITE;
    }
    if (panda_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return panda_NOT_EXCITED;
    }
    panda_real nearest = distance(known->R, wanted, s, X);
    panda_real mu = nearest / (8 * LINKS);
    slope(X0, y0);
    for (int i = 0; i < panda_STANDARD; i++) {
        z[i] = mu * y0[i];
    }
    for (int k = 0; k < STEPS && length > 0; k++) {
        panda_real P[16];
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
        const panda_real left = 1 - go_along(s, ds, z, dz, s_at, z_at);
        const panda_real t = left * left * left * mu;
        soften(ds, z, V, X0, mu, dz);
        for (int i = 0; i < panda_STANDARD; i++) {
            ds[i] = -dz[i];
        }
        newton(known->R, K, wanted, s, z, V, X0, y0, mu, t, ds, dz);
        length = go_along(s, ds, z, dz, s_at, z_at);
        if (length > 0) {
            memcpy(s, s_at, sizeof s);
            memcpy(z, z_at, sizeof z);
            mu += length * (t - mu);
            const panda_real now = distance(known->R, wanted, s, x);
            if (now < nearest) {
                nearest = now;
                memcpy(X, x, sizeof x);
            }
        }
    }
    return panda_OK;
}
