#include "twin_identifier_project.h"

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

/* The y of dual(y) = Y. */
static void undual(const twin_real *Y, twin_real *y)
{
    const twin_real sum = (Y[0] + Y[5] + Y[10]) / 2;
    const twin_real out[10] = {sum - Y[0], -2 * Y[1], -2 * Y[2], sum - Y[5], -2 * Y[6],
                               sum - Y[10], 2 * Y[3], 2 * Y[7], 2 * Y[11], Y[15]};
    memcpy(y, out, sizeof out);
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

/* V = P^-1 from L of P = L L', which becomes L^-1. */
static void invert(twin_real *L, twin_real *V)
{
    for (int j = 0; j < 4; j++) {
        L[5 * j] = 1 / L[5 * j];
        for (int i = j + 1; i < 4; i++) {
            twin_real sum = 0;
            for (int k = j; k < i; k++) {
                sum -= L[4 * i + k] * L[4 * k + j];
            }
            L[4 * i + j] = sum / L[5 * i];
        }
    }
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            twin_real sum = 0;
            for (int k = i > j ? i : j; k < 4; k++) {
                sum += L[4 * k + i] * L[4 * k + j];
            }
            V[4 * i + j] = sum;
        }
    }
}

/* Whether the matrix of each link is positive definite, and what is positive is above 0: with
 * pseudo_inertia, whether a robot can have these parameters. */
static int inside(const twin_real *x, void (*matrix)(const twin_real *, twin_real *))
{
    twin_real P[16];
    for (int i = 0; i < twin_STANDARD; i++) {
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
static twin_real reach(twin_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* S y in place: (P Y Z^-1 + Z^-1 Y P) / 2 of each link, V its Z^-1. */
static void soften(const twin_real *s, const twin_real *z, const twin_real *V,
                   const twin_real *X0, twin_real mu, twin_real *y)
{
    twin_real P[16];
    twin_real Y[16];
    twin_real Z[16] = {0};
    for (int i = 0; i < twin_STANDARD; i++) {
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
static void slope(const twin_real *X0, twin_real *y0)
{
    twin_real P[16];
    twin_real V[16] = {0};
    for (int i = 0; i < twin_STANDARD; i++) {
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
static int normal_factor(const twin_real *R, const twin_real *s, const twin_real *z,
                         const twin_real *V, const twin_real *X0, twin_real mu, twin_real *K)
{
    twin_real x[twin_PARAMETERS];
    twin_real y[twin_STANDARD];
    for (int j = 0; j < twin_PARAMETERS; j++) {
        memset(x, 0, sizeof x);
        memcpy(x + j, R + row_begin(j), sizeof x - (size_t)j * sizeof x[0]);
        spread(x, y);
        soften(s, z, V, X0, mu, y);
        combine(y, x);
        for (int i = j; i < twin_PARAMETERS; i++) {
            twin_real sum = i == j ? 1 : 0;
            for (int k = i; k < twin_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
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
    }
    return 0;
}

/* Solve K f = f in place for the factor of K. */
static void solve(const twin_real *K, twin_real *f)
{
    for (int j = 0; j < twin_PARAMETERS; j++) {
        const twin_real *row = K + row_begin(j);
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
}

/* The steps of s and of z = mu y0 + G'R'f towards P Z = t I and f = R (G s - Y), where ds holds
 * the terms of second order at first:
 *
 *     K f = R (G h - Y),   h = s + t Z^-1 - S t y0 + (second order),
 *     ds = h - S G'R'f - s,   dz = t y0 + G'R'f - z.
 */
static void newton(const twin_real *R, const twin_real *K, const twin_real *wanted,
                   const twin_real *s, const twin_real *z, const twin_real *V,
                   const twin_real *X0, const twin_real *y0, twin_real mu, twin_real t,
                   twin_real *ds, twin_real *dz)
{
    twin_real f[twin_PARAMETERS];
    twin_real x[twin_PARAMETERS];
    twin_real inverse[10] = {0};
    twin_real soft[twin_STANDARD];
    for (int i = 0; i < twin_STANDARD; i++) { /* dz: S t y0, then G'R'f */
        dz[i] = t * y0[i];
    }
    soften(s, z, V, X0, mu, dz);
    for (int i = 0; i < twin_STANDARD; i++) { /* ds becomes h */
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
    for (int i = 0; i < twin_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(R, x, f);
    solve(K, f);
    memset(x, 0, sizeof x);
    for (int i = 0; i < twin_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < twin_PARAMETERS; j++) {
            x[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(x, dz);
    memcpy(soft, dz, sizeof soft);
    soften(s, z, V, X0, mu, soft);
    for (int i = 0; i < twin_STANDARD; i++) {
        ds[i] -= soft[i] + s[i];
        dz[i] += t * y0[i] - z[i];
    }
}

/* s + length ds, z + length dz, and whether both are inside. */
static int move(const twin_real *s, const twin_real *ds, const twin_real *z, const twin_real *dz,
                twin_real length, twin_real *s_at, twin_real *z_at)
{
    for (int i = 0; i < twin_STANDARD; i++) {
        s_at[i] = s[i] + length * ds[i];
        z_at[i] = z[i] + length * dz[i];
    }
    return inside(s_at, pseudo_inertia) != 0 && inside(z_at, dual) != 0;
}

/* The length of a step, and where it ends; 0 if rounding leaves none. */
static twin_real go_along(const twin_real *s, const twin_real *ds, const twin_real *z,
                          const twin_real *dz, twin_real *s_at, twin_real *z_at)
{
    twin_real length = 1;
    int found = 0;
    for (int k = 0; k < TRIES && found == 0; k++) {
        found = move(s, ds, z, dz, length, s_at, z_at);
        length *= (twin_real)SHORTER;
    }
    return found != 0 && move(s, ds, z, dz, length, s_at, z_at) != 0 ? length : 0;
}

/* |R (G s - Y)|^2 and X = G s */
static twin_real distance(const twin_real *R, const twin_real *wanted, const twin_real *s,
                          twin_real *X)
{
    twin_real x[twin_PARAMETERS];
    twin_real r[twin_PARAMETERS];
    twin_real sum = 0;
    combine(s, X);
    for (int i = 0; i < twin_PARAMETERS; i++) {
        x[i] = X[i] - wanted[i];
    }
    times_factor(R, x, r);
    for (int i = 0; i < twin_PARAMETERS; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

int twin_identifier_project(const void *state, const twin_real *X0, twin_real *X)
{
    const twin_least_squares *known = twin_identifier_state(state);
    twin_real K[twin_PARAMETERS * (twin_PARAMETERS + 1) / 2];
    twin_real V[16 * LINKS];
    twin_real s[twin_STANDARD];
    twin_real z[twin_STANDARD];
    twin_real y0[twin_STANDARD];
    twin_real ds[twin_STANDARD];
    twin_real dz[twin_STANDARD];
    twin_real s_at[twin_STANDARD];
    twin_real z_at[twin_STANDARD];
    twin_real wanted[twin_PARAMETERS];
    twin_real x[twin_PARAMETERS];
    twin_real length = 1;
    for (int i = 0; i < twin_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return twin_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (inside(X0, pseudo_inertia) == 0) {
        return twin_NOT_POSITIVE_DEFINITE;
    }
    if (twin_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return twin_NOT_EXCITED;
    }
    twin_real nearest = distance(known->R, wanted, s, X);
    twin_real mu = nearest / (8 * LINKS);
    slope(X0, y0);
    for (int i = 0; i < twin_STANDARD; i++) {
        z[i] = mu * y0[i];
    }
    for (int k = 0; k < STEPS && length > 0; k++) {
        twin_real P[16];
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
        const twin_real left = 1 - go_along(s, ds, z, dz, s_at, z_at);
        const twin_real t = left * left * left * mu;
        soften(ds, z, V, X0, mu, dz);
        for (int i = 0; i < twin_STANDARD; i++) {
            ds[i] = -dz[i];
        }
        newton(known->R, K, wanted, s, z, V, X0, y0, mu, t, ds, dz);
        length = go_along(s, ds, z, dz, s_at, z_at);
        if (length > 0) {
            memcpy(s, s_at, sizeof s);
            memcpy(z, z_at, sizeof z);
            mu += length * (t - mu);
            const twin_real now = distance(known->R, wanted, s, x);
            if (now < nearest) {
                nearest = now;
                memcpy(X, x, sizeof x);
            }
        }
    }
    return twin_OK;
}
