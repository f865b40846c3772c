#include "NAME_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS {{ steps }}
#define LINKS {{ links|length }}
#define EPSILON {{ "FLT_EPSILON" if dtype == "float" else "DBL_EPSILON" }}
#define TRIES 60 /* of the length of a step */
#define SHORTER 0.9 /* each, and this part of the possible length is taken */

#define IN_LINK 0
#define POSITIVE 1
{% if "FREE" in kinds|join %}
#define FREE 2
{% endif %}

/* Place of XX of each link, and what the other parameters are. */
static const int FIRST[LINKS] = {{ "{" }}{{ links|join(", ") }}{{ "}" }};
static const unsigned char KIND[NAME_STANDARD] = {
{% for line in kinds %}
    {{ line }}
{% endfor %}
};

/* X = G s: base parameter i has the terms BEGIN[i] to BEGIN[i + 1] of these. */
static const int BEGIN[NAME_PARAMETERS + 1] = {
{% for line in begin %}
    {{ line }}
{% endfor %}
};
static const int PLACE[] = {
{% for line in places %}
    {{ line }}
{% endfor %}
};
static const NAME_real FACTOR[] = {
{% for factor in factors %}
    (NAME_real){{ factor }}{{ "" if loop.last else "," }}
{% endfor %}
};

static int row_begin(int i)
{
    return i * NAME_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const NAME_real *s, NAME_real *X)
{
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += FACTOR[k] * s[PLACE[k]];
        }
    }
}

/* G'x */
static void spread(const NAME_real *x, NAME_real *s)
{
    for (int i = 0; i < NAME_STANDARD; i++) {
        s[i] = 0;
    }
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            s[PLACE[k]] += FACTOR[k] * x[i];
        }
    }
}

/* R x */
static void times_factor(const NAME_real *R, const NAME_real *x, NAME_real *out)
{
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        NAME_real sum = 0;
        for (int j = i; j < NAME_PARAMETERS; j++) {
            sum += R[row_begin(i) + j - i] * x[j];
        }
        out[i] = sum;
    }
}

/* The pseudo-inertia of XX XY XZ YY YZ ZZ MX MY MZ M. */
static void pseudo_inertia(const NAME_real *x, NAME_real *P)
{
    const NAME_real half = (x[0] + x[3] + x[5]) / 2;
    const NAME_real out[16] = {half - x[0], -x[1], -x[2], x[6], -x[1], half - x[3], -x[4], x[7],
                               -x[2], -x[4], half - x[5], x[8], x[6], x[7], x[8], x[9]};
    memcpy(P, out, sizeof out);
}

/* The parameters of which P is the pseudo-inertia. */
static void parameters(const NAME_real *P, NAME_real *x)
{
    const NAME_real trace = P[0] + P[5] + P[10];
    const NAME_real out[10] = {trace - P[0], -P[1], -P[2], trace - P[5], -P[6],
                               trace - P[10], P[3], P[7], P[11], P[15]};
    memcpy(x, out, sizeof out);
}

/* The matrix Y with tr(P Y) = x'y for the pseudo-inertia P of any x. */
static void dual(const NAME_real *y, NAME_real *Y)
{
    const NAME_real sum = y[0] + y[3] + y[5];
    const NAME_real out[16] = {sum - y[0], -y[1] / 2, -y[2] / 2, y[6] / 2, -y[1] / 2, sum - y[3],
                               -y[4] / 2, y[7] / 2, -y[2] / 2, -y[4] / 2, sum - y[5], y[8] / 2,
                               y[6] / 2, y[7] / 2, y[8] / 2, y[9]};
    memcpy(Y, out, sizeof out);
}

/* The y of dual(y) = Y. */
static void undual(const NAME_real *Y, NAME_real *y)
{
    const NAME_real sum = (Y[0] + Y[5] + Y[10]) / 2;
    const NAME_real out[10] = {sum - Y[0], -2 * Y[1], -2 * Y[2], sum - Y[5], -2 * Y[6],
                               sum - Y[10], 2 * Y[3], 2 * Y[7], 2 * Y[11], Y[15]};
    memcpy(y, out, sizeof out);
}

static void multiply(const NAME_real *A, const NAME_real *B, NAME_real *out)
{
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            NAME_real sum = 0;
            for (int k = 0; k < 4; k++) {
                sum += A[4 * i + k] * B[4 * k + j];
            }
            out[4 * i + j] = sum;
        }
    }
}

/* L of P = L L' in place; 0, or 1 where P is not positive definite by more than rounding. */
static int factor(NAME_real *P)
{
    for (int j = 0; j < 4; j++) {
        NAME_real pivot = P[5 * j];
        for (int k = 0; k < j; k++) {
            pivot -= P[4 * j + k] * P[4 * j + k];
        }
        if (!(pivot > 64 * EPSILON * P[5 * j])) {
            return 1;
        }
        const NAME_real root = {{ sqrt }}(pivot);
        P[5 * j] = root;
        for (int i = j + 1; i < 4; i++) {
            NAME_real sum = P[4 * i + j];
            for (int k = 0; k < j; k++) {
                sum -= P[4 * i + k] * P[4 * j + k];
            }
            P[4 * i + j] = sum / root;
        }
    }
    return 0;
}

/* V = P^-1 from L of P = L L', which becomes L^-1. */
static void invert(NAME_real *L, NAME_real *V)
{
    for (int j = 0; j < 4; j++) {
        L[5 * j] = 1 / L[5 * j];
        for (int i = j + 1; i < 4; i++) {
            NAME_real sum = 0;
            for (int k = j; k < i; k++) {
                sum -= L[4 * i + k] * L[4 * k + j];
            }
            L[4 * i + j] = sum / L[5 * i];
        }
    }
    for (int i = 0; i < 4; i++) {
        for (int j = 0; j < 4; j++) {
            NAME_real sum = 0;
            for (int k = i > j ? i : j; k < 4; k++) {
                sum += L[4 * k + i] * L[4 * k + j];
            }
            V[4 * i + j] = sum;
        }
    }
}

/* Whether the matrix of each link is positive definite, and what is positive is above 0: with
 * pseudo_inertia, whether a robot can have these parameters. */
static int inside(const NAME_real *x, void (*matrix)(const NAME_real *, NAME_real *))
{
    NAME_real P[16];
    for (int i = 0; i < NAME_STANDARD; i++) {
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
static NAME_real reach(NAME_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* S y in place: (P Y Z^-1 + Z^-1 Y P) / 2 of each link, V its Z^-1. */
static void soften(const NAME_real *s, const NAME_real *z, const NAME_real *V,
                   const NAME_real *X0, NAME_real mu, NAME_real *y)
{
    NAME_real P[16];
    NAME_real Y[16];
    NAME_real Z[16] = {0};
    for (int i = 0; i < NAME_STANDARD; i++) {
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
static void slope(const NAME_real *X0, NAME_real *y0)
{
    NAME_real P[16];
    NAME_real V[16] = {0};
    for (int i = 0; i < NAME_STANDARD; i++) {
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
static int normal_factor(const NAME_real *R, const NAME_real *s, const NAME_real *z,
                         const NAME_real *V, const NAME_real *X0, NAME_real mu, NAME_real *K)
{
    NAME_real x[NAME_PARAMETERS];
    NAME_real y[NAME_STANDARD];
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        memset(x, 0, sizeof x);
        memcpy(x + j, R + row_begin(j), sizeof x - (size_t)j * sizeof x[0]);
        spread(x, y);
        soften(s, z, V, X0, mu, y);
        combine(y, x);
        for (int i = j; i < NAME_PARAMETERS; i++) {
            NAME_real sum = i == j ? 1 : 0;
            for (int k = i; k < NAME_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        NAME_real *row = K + row_begin(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const NAME_real root = {{ sqrt }}(row[0]);
        for (int i = 0; i < NAME_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < NAME_PARAMETERS; i++) {
            NAME_real *below = K + row_begin(i);
            for (int k = i; k < NAME_PARAMETERS; k++) {
                below[k - i] -= row[i - j] * row[k - j];
            }
        }
    }
    return 0;
}

/* Solve K f = f in place for the factor of K. */
static void solve(const NAME_real *K, NAME_real *f)
{
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        const NAME_real *row = K + row_begin(j);
        f[j] /= row[0];
        for (int i = j + 1; i < NAME_PARAMETERS; i++) {
            f[i] -= row[i - j] * f[j];
        }
    }
    for (int j = NAME_PARAMETERS - 1; j >= 0; j--) {
        const NAME_real *row = K + row_begin(j);
        for (int i = j + 1; i < NAME_PARAMETERS; i++) {
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
static void newton(const NAME_real *R, const NAME_real *K, const NAME_real *wanted,
                   const NAME_real *s, const NAME_real *z, const NAME_real *V,
                   const NAME_real *X0, const NAME_real *y0, NAME_real mu, NAME_real t,
                   NAME_real *ds, NAME_real *dz)
{
    NAME_real f[NAME_PARAMETERS];
    NAME_real x[NAME_PARAMETERS];
    NAME_real inverse[10] = {0};
    NAME_real soft[NAME_STANDARD];
    for (int i = 0; i < NAME_STANDARD; i++) { /* dz: S t y0, then G'R'f */
        dz[i] = t * y0[i];
    }
    soften(s, z, V, X0, mu, dz);
    for (int i = 0; i < NAME_STANDARD; i++) { /* ds becomes h */
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
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(R, x, f);
    solve(K, f);
    memset(x, 0, sizeof x);
    for (int i = 0; i < NAME_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < NAME_PARAMETERS; j++) {
            x[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(x, dz);
    memcpy(soft, dz, sizeof soft);
    soften(s, z, V, X0, mu, soft);
    for (int i = 0; i < NAME_STANDARD; i++) {
        ds[i] -= soft[i] + s[i];
        dz[i] += t * y0[i] - z[i];
    }
}

/* s + length ds, z + length dz, and whether both are inside. */
static int move(const NAME_real *s, const NAME_real *ds, const NAME_real *z, const NAME_real *dz,
                NAME_real length, NAME_real *s_at, NAME_real *z_at)
{
    for (int i = 0; i < NAME_STANDARD; i++) {
        s_at[i] = s[i] + length * ds[i];
        z_at[i] = z[i] + length * dz[i];
    }
    return inside(s_at, pseudo_inertia) != 0 && inside(z_at, dual) != 0;
}

/* The length of a step, and where it ends; 0 if rounding leaves none. */
static NAME_real go_along(const NAME_real *s, const NAME_real *ds, const NAME_real *z,
                          const NAME_real *dz, NAME_real *s_at, NAME_real *z_at)
{
    NAME_real length = 1;
    int found = 0;
    for (int k = 0; k < TRIES && found == 0; k++) {
        found = move(s, ds, z, dz, length, s_at, z_at);
        length *= (NAME_real)SHORTER;
    }
    return found != 0 && move(s, ds, z, dz, length, s_at, z_at) != 0 ? length : 0;
}

/* |R (G s - Y)|^2 and X = G s */
static NAME_real distance(const NAME_real *R, const NAME_real *wanted, const NAME_real *s,
                          NAME_real *X)
{
    NAME_real x[NAME_PARAMETERS];
    NAME_real r[NAME_PARAMETERS];
    NAME_real sum = 0;
    combine(s, X);
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        x[i] = X[i] - wanted[i];
    }
    times_factor(R, x, r);
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        sum += r[i] * r[i];
    }
    return sum;
}

int NAME_identifier_project(const void *state, const NAME_real *X0, NAME_real *X)
{
    const NAME_least_squares *known = NAME_identifier_state(state);
    NAME_real K[NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2];
    NAME_real V[16 * LINKS];
    NAME_real s[NAME_STANDARD];
    NAME_real z[NAME_STANDARD];
    NAME_real y0[NAME_STANDARD];
    NAME_real ds[NAME_STANDARD];
    NAME_real dz[NAME_STANDARD];
    NAME_real s_at[NAME_STANDARD];
    NAME_real z_at[NAME_STANDARD];
    NAME_real wanted[NAME_PARAMETERS];
    NAME_real x[NAME_PARAMETERS];
    NAME_real length = 1;
    for (int i = 0; i < NAME_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return NAME_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (inside(X0, pseudo_inertia) == 0) {
        return NAME_NOT_POSITIVE_DEFINITE;
    }
    if (NAME_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return NAME_NOT_EXCITED;
    }
    NAME_real nearest = distance(known->R, wanted, s, X);
    NAME_real mu = nearest / (8 * LINKS);
    slope(X0, y0);
    for (int i = 0; i < NAME_STANDARD; i++) {
        z[i] = mu * y0[i];
    }
    for (int k = 0; k < STEPS && length > 0; k++) {
        NAME_real P[16];
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
        const NAME_real left = 1 - go_along(s, ds, z, dz, s_at, z_at);
        const NAME_real t = left * left * left * mu;
        soften(ds, z, V, X0, mu, dz);
        for (int i = 0; i < NAME_STANDARD; i++) {
            ds[i] = -dz[i];
        }
        newton(known->R, K, wanted, s, z, V, X0, y0, mu, t, ds, dz);
        length = go_along(s, ds, z, dz, s_at, z_at);
        if (length > 0) {
            memcpy(s, s_at, sizeof s);
            memcpy(z, z_at, sizeof z);
            mu += length * (t - mu);
            const NAME_real now = distance(known->R, wanted, s, x);
            if (now < nearest) {
                nearest = now;
                memcpy(X, x, sizeof x);
            }
        }
    }
    return NAME_OK;
}
