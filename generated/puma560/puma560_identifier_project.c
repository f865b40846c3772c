#include "puma560_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 6
#define EPSILON DBL_EPSILON
#define HALVINGS 40 /* of a step */
#define SHORTER 0.7 /* of the part of a step that is possible */

enum { IN_LINK = 0, POSITIVE = 1, FREE = 2 };

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
static const struct {
    int place;
    puma560_real factor;
} TERM[] = {
    {5, (puma560_real)1.0},
    {10, (puma560_real)1.0},
    {14, (puma560_real)1.0},
    {19, (puma560_real)0.487},
    {20, (puma560_real)0.05929225},
    {25, (puma560_real)1.0},
    {30, (puma560_real)0.3002},
    {31, (puma560_real)0.20898125},
    {42, (puma560_real)0.20939334},
    {53, (puma560_real)0.20939334},
    {64, (puma560_real)0.20939334},
    {11, (puma560_real)1.0},
    {14, (puma560_real)-1.0},
    {31, (puma560_real)-0.18645124},
    {42, (puma560_real)-0.18645124},
    {53, (puma560_real)-0.18645124},
    {64, (puma560_real)-0.18645124},
    {12, (puma560_real)1.0},
    {13, (puma560_real)1.0},
    {30, (puma560_real)-0.4318},
    {31, (puma560_real)0.04033012},
    {42, (puma560_real)0.04033012},
    {53, (puma560_real)0.04033012},
    {64, (puma560_real)0.04033012},
    {15, (puma560_real)1.0},
    {16, (puma560_real)1.0},
    {21, (puma560_real)1.0},
    {31, (puma560_real)0.18645124},
    {42, (puma560_real)0.18645124},
    {53, (puma560_real)0.18645124},
    {64, (puma560_real)0.18645124},
    {17, (puma560_real)1.0},
    {31, (puma560_real)0.4318},
    {42, (puma560_real)0.4318},
    {53, (puma560_real)0.4318},
    {64, (puma560_real)0.4318},
    {18, (puma560_real)1.0},
    {22, (puma560_real)1.0},
    {25, (puma560_real)-1.0},
    {36, (puma560_real)1.0},
    {41, (puma560_real)0.8662},
    {42, (puma560_real)0.18716352},
    {53, (puma560_real)0.18716352},
    {64, (puma560_real)0.18716352},
    {23, (puma560_real)1.0},
    {41, (puma560_real)-0.0203},
    {42, (puma560_real)-0.00879193},
    {53, (puma560_real)-0.00879193},
    {64, (puma560_real)-0.00879193},
    {24, (puma560_real)1.0},
    {26, (puma560_real)1.0},
    {27, (puma560_real)1.0},
    {36, (puma560_real)1.0},
    {41, (puma560_real)0.8662},
    {42, (puma560_real)0.1879877},
    {53, (puma560_real)0.1879877},
    {64, (puma560_real)0.1879877},
    {28, (puma560_real)1.0},
    {42, (puma560_real)-0.0203},
    {53, (puma560_real)-0.0203},
    {64, (puma560_real)-0.0203},
    {29, (puma560_real)1.0},
    {41, (puma560_real)-1.0},
    {42, (puma560_real)-0.4331},
    {53, (puma560_real)-0.4331},
    {64, (puma560_real)-0.4331},
    {32, (puma560_real)1.0},
    {33, (puma560_real)1.0},
    {36, (puma560_real)-1.0},
    {47, (puma560_real)1.0},
    {34, (puma560_real)1.0},
    {35, (puma560_real)1.0},
    {37, (puma560_real)1.0},
    {38, (puma560_real)1.0},
    {47, (puma560_real)1.0},
    {39, (puma560_real)1.0},
    {40, (puma560_real)1.0},
    {52, (puma560_real)1.0},
    {43, (puma560_real)1.0},
    {44, (puma560_real)1.0},
    {47, (puma560_real)-1.0},
    {58, (puma560_real)1.0},
    {45, (puma560_real)1.0},
    {46, (puma560_real)1.0},
    {48, (puma560_real)1.0},
    {49, (puma560_real)1.0},
    {58, (puma560_real)1.0},
    {50, (puma560_real)1.0},
    {51, (puma560_real)1.0},
    {63, (puma560_real)-1.0},
    {54, (puma560_real)1.0},
    {55, (puma560_real)1.0},
    {58, (puma560_real)-1.0},
    {56, (puma560_real)1.0},
    {57, (puma560_real)1.0},
    {59, (puma560_real)1.0},
    {60, (puma560_real)1.0},
    {61, (puma560_real)1.0},
    {62, (puma560_real)1.0},
    {65, (puma560_real)1.0},
    {66, (puma560_real)1.0},
    {67, (puma560_real)1.0},
    {68, (puma560_real)1.0},
    {69, (puma560_real)1.0},
    {70, (puma560_real)1.0},
    {71, (puma560_real)1.0},
    {72, (puma560_real)1.0},
    {73, (puma560_real)1.0},
    {74, (puma560_real)1.0},
    {75, (puma560_real)1.0},
    {76, (puma560_real)1.0},
    {77, (puma560_real)1.0}
};

static int diagonal(int i)
{
    return i * puma560_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const puma560_real *s, puma560_real *X)
{
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += TERM[k].factor * s[TERM[k].place];
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
            s[TERM[k].place] += TERM[k].factor * x[i];
        }
    }
}

/* R x */
static void times_factor(const puma560_real *R, const puma560_real *x, puma560_real *out)
{
    for (int i = 0; i < puma560_PARAMETERS; i++) {
        puma560_real sum = 0;
        for (int j = i; j < puma560_PARAMETERS; j++) {
            sum += R[diagonal(i) + j - i] * x[j];
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
        puma560_real *row = K + diagonal(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const puma560_real root = sqrt(row[0]);
        for (int i = 0; i < puma560_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < puma560_PARAMETERS; i++) {
            puma560_real *below = K + diagonal(i);
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
        const puma560_real *row = K + diagonal(j);
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
        memcpy(v + j, R + diagonal(j), (size_t)(puma560_PARAMETERS - j) * sizeof v[0]);
        spread(v, step);
        soften(s, s0, step);
        combine(step, x);
        for (int i = j; i < puma560_PARAMETERS; i++) {
            puma560_real sum = i == j ? mu : 0;
            for (int k = i; k < puma560_PARAMETERS; k++) {
                sum += R[diagonal(i) + k - i] * x[k];
            }
            K[diagonal(j) + i - j] = sum;
        }
    }
    if (solve(K, f) != 0) {
        return 1;
    }
    memset(v, 0, sizeof v);
    for (int i = 0; i < puma560_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < puma560_PARAMETERS; j++) {
            v[j] += R[diagonal(i) + j - i] * f[i];
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
