#include "NAME_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS {{ steps }}
#define LINKS {{ links|length }}
#define EPSILON {{ "FLT_EPSILON" if dtype == "float" else "DBL_EPSILON" }}
#define HALVINGS 40 /* of a step */
#define SHORTER 0.7 /* of the part of a step that is possible */

#define IN_LINK 0
#define POSITIVE 1
#define FREE 2

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

/* Whether a robot can have these parameters. */
static int possible(const NAME_real *s)
{
    NAME_real P[16];
    for (int i = 0; i < NAME_STANDARD; i++) {
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
static NAME_real reach(NAME_real x0)
{
    return 1 + (x0 < 0 ? -x0 : x0);
}

/* H^-1 y in place, H the second derivative of the divergence at s: P Y P of each link. */
static void soften(const NAME_real *s, const NAME_real *s0, NAME_real *y)
{
    NAME_real P[16];
    NAME_real Y[16];
    NAME_real Z[16] = {0};
    for (int i = 0; i < NAME_STANDARD; i++) {
        const NAME_real size = KIND[i] == POSITIVE ? s[i] : reach(s0[i]);
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
static void slope(const NAME_real *s, const NAME_real *s0, NAME_real *out)
{
    NAME_real P[16];
    NAME_real L[16];
    NAME_real Z[16] = {0};
    for (int i = 0; i < NAME_STANDARD; i++) {
        out[i] = KIND[i] == POSITIVE ? s[i] * s[i] / s0[i] - s[i] : s[i] - s0[i];
    }
    for (int l = 0; l < LINKS; l++) {
        NAME_real *x = out + FIRST[l];
        pseudo_inertia(s + FIRST[l], P);
        pseudo_inertia(s0 + FIRST[l], L);
        (void)factor(L);
        for (int j = 0; j < 4; j++) { /* L^-1 P */
            for (int i = 0; i < 4; i++) {
                NAME_real sum = P[4 * i + j];
                for (int k = 0; k < i; k++) {
                    sum -= L[4 * i + k] * Z[4 * k + j];
                }
                Z[4 * i + j] = sum / L[5 * i];
            }
        }
        for (int i = 0; i < 4; i++) {
            for (int j = 0; j < 4; j++) {
                NAME_real sum = 0;
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
static int solve(NAME_real *K, NAME_real *f)
{
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
    return 0;
}

/* The step of Newton's method from s, in standard parameters:
 *
 *     -h + H^-1 G'R'f,   (mu I + R G H^-1 G'R') f = R (Y - G s) + R G h,   h = H^-1 slope.
 *
 * Nonzero where rounding leaves none. */
static int newton(const NAME_real *R, const NAME_real *wanted, const NAME_real *s0,
                  const NAME_real *s, NAME_real mu, NAME_real *step)
{
    NAME_real K[NAME_PARAMETERS * (NAME_PARAMETERS + 1) / 2];
    NAME_real f[NAME_PARAMETERS];
    NAME_real x[NAME_PARAMETERS];
    NAME_real v[NAME_PARAMETERS];
    slope(s, s0, step);
    for (int j = 0; j < NAME_STANDARD; j++) {
        step[j] -= s[j];
    }
    combine(step, x);
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        x[j] += wanted[j];
    }
    times_factor(R, x, f);
    for (int j = 0; j < NAME_PARAMETERS; j++) {
        memset(v, 0, sizeof v);
        memcpy(v + j, R + row_begin(j), sizeof v - (size_t)j * sizeof v[0]);
        spread(v, step);
        soften(s, s0, step);
        combine(step, x);
        for (int i = j; i < NAME_PARAMETERS; i++) {
            NAME_real sum = i == j ? mu : 0;
            for (int k = i; k < NAME_PARAMETERS; k++) {
                sum += R[row_begin(i) + k - i] * x[k];
            }
            K[row_begin(j) + i - j] = sum;
        }
    }
    if (solve(K, f) != 0) {
        return 1;
    }
    memset(v, 0, sizeof v);
    for (int i = 0; i < NAME_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < NAME_PARAMETERS; j++) {
            v[j] += R[row_begin(i) + j - i] * f[i];
        }
    }
    spread(v, step);
    soften(s, s0, step);
    return 0;
}

int NAME_identifier_project(const void *state, const NAME_real *X0, NAME_real *X)
{
    const NAME_least_squares *known = NAME_identifier_state(state);
    NAME_real s[NAME_STANDARD];
    NAME_real step[NAME_STANDARD];
    NAME_real at[NAME_STANDARD];
    NAME_real wanted[NAME_PARAMETERS];
    NAME_real x[NAME_PARAMETERS];
    NAME_real r[NAME_PARAMETERS];
    NAME_real mu = 0;
    for (int i = 0; i < NAME_STANDARD; i++) {
        if (!isfinite(X0[i])) {
            return NAME_NOT_FINITE;
        }
        s[i] = X0[i];
    }
    if (possible(X0) == 0) {
        return NAME_NOT_POSITIVE_DEFINITE;
    }
    if (NAME_least_squares_solve(known, wanted, NULL, NULL) != 0) {
        return NAME_NOT_EXCITED;
    }
    combine(s, x);
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        x[i] -= wanted[i];
    }
    times_factor(known->R, x, r);
    for (int i = 0; i < NAME_PARAMETERS; i++) {
        mu += r[i] * r[i] / (8 * LINKS);
    }
    for (int k = 0; k < STEPS; k++) {
        NAME_real length = 1;
        int found = 0;
        if (newton(known->R, wanted, X0, s, mu, step) != 0) {
            break;
        }
        slope(s, X0, at);
        for (int i = 0; i < NAME_STANDARD; i++) {
            step[i] -= at[i];
        }
        for (int halving = 0; halving < HALVINGS && found == 0; halving++) {
            for (int i = 0; i < NAME_STANDARD; i++) {
                at[i] = s[i] + length * step[i];
            }
            found = possible(at);
            length /= found != 0 ? 1 : 2;
        }
        if (found != 0 && length >= 1) {
            memcpy(s, at, sizeof s);
            mu /= 2;
        } else if (found != 0) {
            for (int i = 0; i < NAME_STANDARD; i++) {
                at[i] = s[i] + (NAME_real)SHORTER * length * step[i];
            }
            if (possible(at) != 0) {
                memcpy(s, at, sizeof s);
            }
        }
    }
    combine(s, X);
    return NAME_OK;
}
