#include "planar2r_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 2
#define EPSILON DBL_EPSILON
#define TRIES 60 /* of the length of a step */
#define SHORTER 0.9 /* each, and this part of the possible length is taken */

#define IN_LINK 0
#define POSITIVE 1

/* Place of XX of each link, and what the other parameters are. */
static const int FIRST[LINKS] = {0, 10};
static const unsigned char KIND[planar2r_STANDARD] = {
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK,
    IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK, IN_LINK
};

/* X = G s: base parameter i has the terms BEGIN[i] to BEGIN[i + 1] of these. */
static const int BEGIN[planar2r_PARAMETERS + 1] = {
    0, 2, 3, 4, 5
};
static const int PLACE[] = {
    5, 19, 15, 16, 17
};
static const planar2r_real FACTOR[] = {
    (planar2r_real)1.0,
    (planar2r_real)0.25,
    (planar2r_real)1.0,
    (planar2r_real)1.0,
    (planar2r_real)1.0
};

static int row_begin(int i)
{
    return i * planar2r_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const planar2r_real *s, planar2r_real *X)
{
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += FACTOR[k] * s[PLACE[k]];
        }
    }
}

/* G'x */
static void spread(const planar2r_real *x, planar2r_real *s)
{
    for (int i = 0; i < planar2r_STANDARD; i++) {
        s[i] = 0;
    }
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            s[PLACE[k]] += FACTOR[k] * x[i];
        }
    }
}

/* R x */
static void times_factor(const planar2r_real *R, const planar2r_real *x, planar2r_real *out)
{
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        planar2r_real sum = 0;
        for (int j = i; j < planar2r_PARAMETERS; j++) {
            sum += R[row_begin(i) + j - i] * x[j];
        }
        out[i] = sum;
    }
}

/* The pseudo-inertia of XX XY XZ YY YZ ZZ MX MY MZ M. */
static void pseudo_inertia(const planar2r_real *x, planar2r_real *P)
{
    const planar2r_real half = (x[0] + x[3] + x[5]) / 2;
    const planar2r_real out[16] = {half - x[0], -x[1], -x[2], x[6], -x[1], half - x[3], -x[4], x[7],
                               -x[2], -x[4], half - x[5], x[8], x[6], x[7], x[8], x[9]};
    memcpy(P, out, sizeof out);
}

/* The parameters of which P is the pseudo-inertia. */
static void parameters(const planar2r_real *P, planar2r_real *x)
{
    const planar2r_real trace = P[0] + P[5] + P[10];
    const planar2r_real out[10] = {trace - P[0], -P[1], -P[2], trace - P[5], -P[6],
                               trace - P[10], P[3], P[7], P[11], P[15]};
    memcpy(x, out, sizeof out);
}

/* The matrix Y with tr(P Y) = x'y for the pseudo-inertia P of any x. */
static void dual(const planar2r_real *y, planar2r_real *Y)
{
    const planar2r_real sum = y[0] + y[3] + y[5];
    const planar2r_real out[16] = {sum - y[0], -y[1] / 2, -y[2] / 2, y[6] / 2, -y[1] / 2, sum - y[3],
                               -y[4] / 2, y[7] / 2, -y[2] / 2, -y[4] / 2, sum - y[5], y[8] / 2,
                               y[6] / 2, y[7] / 2, y[8] / 2, y[9]};
    memcpy(Y, out, sizeof out);
}

/* The y of dual(y) = Y. */
static void undual(const planar2r_real *Y, planar2r_real *y)
{
    const planar2r_real sum = (Y[0] + Y[5] + Y[10]) / 2;
    const planar2r_real out[10] = {sum - Y[0], -2 * Y[1], -2 * Y[2], sum - Y[5], -2 * Y[6],
                               sum - Y[10], 2 * Y[3], 2 * Y[7], 2 * Y[11], Y[15]};
    memcpy(y, out, sizeof out);
}

static void multiply(const planar2r_real *A, const planar2r_real *B, planar2r_real *out)
{
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            planar2r_real sum = 0;
            for (int k = 0; k < 4; k++) {
                sum += A[4 * i + k] * B[4 * k + j];
            }
            out[4 * i + j] = sum;
        }
    }
}

/* L of P = L L' in place; 0, or 1 where P is not positive definite by more than rounding. */
static int factor(planar2r_real *P)
{
    for (int j = 0; j < 4; j++) {
        planar2r_real pivot = P[5 * j];
        for (int k = 0; k < j; k++) {
            pivot -= P[4 * j + k] * P[4 * j + k];
        }
        if (!(pivot > 64 * EPSILON * P[5 * j])) {
            return 1;
        }
        const planar2r_real root = sqrt(pivot);
        P[5 * j] = root;
        for (int i = j + 1; i < 4; i++) {
            planar2r_real sum = P[4 * i + j];
            for (int k = 0; k < j; k++) {
                sum -= P[4 * i + k] * P[4 * j + k];
            }
            P[4 * i + j] = sum / root;
        }
    }
    return 0;
}

/* V = P^-1 from L of P = L L', which becomes L^-1. */
static void invert(planar2r_real *L, planar2r_real *V)
{
    for (int j = 0; j < 4; j++) {
        L[5 * j] = 1 / L[5 * j];
        for (int i = j + 1; i < 4; i++) {
            planar2r_real sum = 0;
            for (int k = j; k < i; k++) {
                sum -= L[4 * i + k] * L[4 * k + j];
            }
            L[4 * i + j] = sum / L[5 * i];
        }
    }
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            planar2r_real sum = 0;
            for (int k = i > j ? i : j; k < 4; k++) {
                sum += L[4 * k + i] * L[4 * k + j];
            }
            V[4 * i + j] = sum;
        }
    }
}

/* Whether the matrix of each link is positive definite, and what is positive is above 0: with
 * pseudo_inertia, whether a robot can have these parameters. */
static int inside(const planar2r_real *x, void (*matrix)(const planar2r_real *, planar2r_real *))
{
    planar2r_real P[16];
    for (int i = 0; i < planar2r_STANDARD; i++) {
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
static planar2r_real reach(planar2r_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* S y in place: (P Y Z^-1 + Z^-1 Y P) / 2 of each link, V its Z^-1. */
static void soften(const planar2r_real *s, const planar2r_real *z, const planar2r_real *V,
                   const planar2r_real *X0, planar2r_real mu, planar2r_real *y)
{
    planar2r_real P[16];
    planar2r_real Y[16];
    planar2r_real Z[16] = {0};
    for (int i = 0; i < planar2r_STANDARD; i++) {
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
static void slope(const planar2r_real *X0, planar2r_real *y0)
{
    planar2r_real P[16];
    planar2r_real V[16] = {0};
    for (int i = 0; i < planar2r_STANDARD; i++) {
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
static int normal_factor(const planar2r_real *R, const planar2r_real *s, const planar2r_real *z,
                         const planar2r_real *V, const planar2r_real *X0, planar2r_real mu, planar2r_real *K)
{
    planar2r_real x[planar2r_PARAMETERS];
    planar2r_real y[planar2r_STANDARD];
    for (int j = 0; j < planar2r_PARAMETERS; j++) {
        memset(x, 0, sizeof x);
        memcpy(x + j, R + row_begin(j), sizeof x - (size_t)j * sizeof x[0]);
        spread(x, y);
        soften(s, z, V, X0, mu, y);
        combine(y, x);
        for (int i = j; i < planar2r_PARAMETERS; i++) {
            planar2r_real sum = i == j ? 1 : 0;
            for (int k = i; k < planar2r_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
    for (int j = 0; j < planar2r_PARAMETERS; j++) {
        planar2r_real *row = K + row_begin(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const planar2r_real root = sqrt(row[0]);
        for (int i = 0; i < planar2r_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < planar2r_PARAMETERS; i++) {
            planar2r_real *below = K + row_begin(i);
            for (int k = i; k < planar2r_PARAMETERS; k++) {
                below[k - i] -= row[i - j] * row[k - j];
            }
        }
    }
    return 0;
}

/* Solve K f = f in place for the factor of K. */
static void solve(const planar2r_real *K, planar2r_real *f)
{
    for (int j = 0; j < planar2r_PARAMETERS; j++) {
        const planar2r_real *row = K + row_begin(j);
        f[j] /= row[0];
        for (int i = j + 1; i < planar2r_PARAMETERS; i++) {
            f[i] -= row[i - j] * f[j];
        }
    }
    for (int j = planar2r_PARAMETERS - 1; j >= 0; j--) {
        const planar2r_real *row = K + row_begin(j);
        for (int i = j + 1; i < planar2r_PARAMETERS; i++) {
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
static void newton(const planar2r_real *R, const planar2r_real *K, const planar2r_real *wanted,
                   const planar2r_real *s, const planar2r_real *z, const planar2r_real *V,
                   const planar2r_real *X0, const planar2r_real *y0, planar2r_real mu, planar2r_real t,
                   planar2r_real *ds, planar2r_real *dz)
{
    planar2r_real f[planar2r_PARAMETERS];
    planar2r_real x[planar2r_PARAMETERS];
    planar2r_real inverse[10] = {0};
    planar2r_real soft[planar2r_STANDARD];
    for (int i = 0; i < planar2r_STANDARD; i++) { /* dz: S t y0, then G'R'f */
        dz[i] = t * y0[i];
    }
    soften(s, z, V, X0, mu, dz);
    for (int i = 0; i < planar2r_STANDARD; i++) { /* ds becomes h */
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
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(R, x, f);
    solve(K, f);
    memset(x, 0, sizeof x);
    for (int i = 0; i < planar2r_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < planar2r_PARAMETERS; j++) {
            x[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(x, dz);
    memcpy(soft, dz, sizeof soft);
    soften(s, z, V, X0, mu, soft);
    for (int i = 0; i < planar2r_STANDARD; i++) {
        ds[i] -= soft[i] + s[i];
        dz[i] += t * y0[i] - z[i];
    }
}

/* s + length ds, z + length dz, and whether both are inside. */
static int move(const planar2r_real *s, const planar2r_real *ds, const planar2r_real *z, const planar2r_real *dz,
                planar2r_real length, planar2r_real *s_at, planar2r_real *z_at)
{
    for (int i = 0; i < planar2r_STANDARD; i++) {
        s_at[i] = s[i] + length * ds[i];
        z_at[i] = z[i] + length * dz[i];
    }
    return inside(s_at, pseudo_inertia) != 0 && inside(z_at, dual) != 0;
}

/* The length of a step, and where it ends; 0 if rounding leaves none. */
static planar2r_real go_along(const planar2r_real *s, const planar2r_real *ds, const planar2r_real *z,
                          const planar2r_real *dz, planar2r_real *s_at, planar2r_real *z_at)
{
    planar2r_real length = 1;
    int found = 0;
    for (int k = 0; k < TRIES && found == 0; k++) {
        found = move(s, ds, z, dz, length, s_at, z_at);
        length *= (planar2r_real)SHORTER;
    }
    return found != 0 && move(s, ds, z, dz, length, s_at, z_at) != 0 ? length : 0;
}

/* |R (G s - Y)|^2 and X = G s */
static planar2r_real distance(const planar2r_real *R, const planar2r_real *wanted, const planar2r_real *s,
                          planar2r_real *X)
{
    planar2r_real x[planar2r_PARAMETERS];
    planar2r_real r[planar2r_PARAMETERS];
    planar2r_real sum = 0;
    combine(s, X);
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        x[i] = X[i] - wanted[i];
    }
    times_factor(R, x, r);
    for (int i = 0; i < planar2r_PARAMETERS; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

int planar2r_identifier_project(const void *state, const planar2r_real *X0, planar2r_real *X)
{
    const planar2r_least_squares *known = planar2r_identifier_state(state);
    planar2r_real K[planar2r_PARAMETERS * (planar2r_PARAMETERS + 1) / 2];
    planar2r_real V[16 * LINKS];
    planar2r_real s[planar2r_STANDARD];
    planar2r_real z[planar2r_STANDARD];
    planar2r_real y0[planar2r_STANDARD];
    planar2r_real ds[planar2r_STANDARD];
    planar2r_real dz[planar2r_STANDARD];
    planar2r_real s_at[planar2r_STANDARD];
    planar2r_real z_at[planar2r_STANDARD];
    planar2r_real wanted[planar2r_PARAMETERS];
    planar2r_real x[planar2r_PARAMETERS];
    planar2r_real length = 1;
    for (int i = 0; i < planar2r_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return planar2r_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (inside(X0, pseudo_inertia) == 0) {
        return planar2r_NOT_POSITIVE_DEFINITE;
    }
    if (planar2r_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return planar2r_NOT_EXCITED;
    }
    planar2r_real nearest = distance(known->R, wanted, s, X);
    planar2r_real mu = nearest / (8 * LINKS);
    slope(X0, y0);
    for (int i = 0; i < planar2r_STANDARD; i++) {
        z[i] = mu * y0[i];
    }
    for (int k = 0; k < STEPS && length > 0; k++) {
        planar2r_real P[16];
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
        const planar2r_real left = 1 - go_along(s, ds, z, dz, s_at, z_at);
        const planar2r_real t = left * left * left * mu;
        soften(ds, z, V, X0, mu, dz);
        for (int i = 0; i < planar2r_STANDARD; i++) {
            ds[i] = -dz[i];
        }
        newton(known->R, K, wanted, s, z, V, X0, y0, mu, t, ds, dz);
        length = go_along(s, ds, z, dz, s_at, z_at);
        if (length > 0) {
            memcpy(s, s_at, sizeof s);
            memcpy(z, z_at, sizeof z);
            mu += length * (t - mu);
            const planar2r_real now = distance(known->R, wanted, s, x);
            if (now < nearest) {
                nearest = now;
                memcpy(X, x, sizeof x);
            }
        }
    }
    return planar2r_OK;
}
