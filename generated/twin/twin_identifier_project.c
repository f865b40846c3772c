#include "twin_identifier_project.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define STEPS 40
#define LINKS 7
#define EPSILON DBL_EPSILON
#define HALVINGS 40 /* of a step */
#define SHORTER 0.7 /* of the part of a step that is possible */

enum { IN_LINK = 0, POSITIVE = 1, FREE = 2 };

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
static const struct {
    int place;
    twin_real factor;
} TERM[] = {
    {5, (twin_real)1.0},
    {10, (twin_real)1.0},
    {14, (twin_real)1.0},
    {20, (twin_real)0.04},
    {25, (twin_real)1.0},
    {31, (twin_real)0.13},
    {42, (twin_real)0.13},
    {47, (twin_real)1.0},
    {53, (twin_real)0.04},
    {60, (twin_real)1.0},
    {69, (twin_real)1.0},
    {11, (twin_real)1.0},
    {14, (twin_real)-1.0},
    {31, (twin_real)-0.09},
    {42, (twin_real)-0.09},
    {12, (twin_real)1.0},
    {13, (twin_real)1.0},
    {30, (twin_real)-0.3},
    {15, (twin_real)1.0},
    {16, (twin_real)1.0},
    {21, (twin_real)1.0},
    {31, (twin_real)0.09},
    {42, (twin_real)0.09},
    {17, (twin_real)1.0},
    {31, (twin_real)0.3},
    {42, (twin_real)0.3},
    {18, (twin_real)1.0},
    {22, (twin_real)1.0},
    {25, (twin_real)-1.0},
    {36, (twin_real)1.0},
    {41, (twin_real)0.5},
    {42, (twin_real)0.0625},
    {23, (twin_real)1.0},
    {24, (twin_real)1.0},
    {26, (twin_real)1.0},
    {27, (twin_real)1.0},
    {36, (twin_real)1.0},
    {41, (twin_real)0.5},
    {42, (twin_real)0.0625},
    {28, (twin_real)1.0},
    {29, (twin_real)1.0},
    {41, (twin_real)-1.0},
    {42, (twin_real)-0.25},
    {32, (twin_real)1.0},
    {33, (twin_real)1.0},
    {36, (twin_real)-1.0},
    {34, (twin_real)1.0},
    {35, (twin_real)1.0},
    {37, (twin_real)1.0},
    {38, (twin_real)1.0},
    {39, (twin_real)1.0},
    {40, (twin_real)1.0},
    {43, (twin_real)1.0},
    {44, (twin_real)1.0},
    {47, (twin_real)-1.0},
    {55, (twin_real)1.0},
    {60, (twin_real)-1.0},
    {45, (twin_real)1.0},
    {57, (twin_real)-1.0},
    {46, (twin_real)1.0},
    {56, (twin_real)1.0},
    {48, (twin_real)1.0},
    {59, (twin_real)-1.0},
    {49, (twin_real)1.0},
    {54, (twin_real)1.0},
    {58, (twin_real)1.0},
    {50, (twin_real)1.0},
    {51, (twin_real)1.0},
    {61, (twin_real)1.0},
    {62, (twin_real)1.0},
    {74, (twin_real)1.0},
    {63, (twin_real)1.0},
    {64, (twin_real)1.0},
    {75, (twin_real)1.0},
    {65, (twin_real)1.0},
    {66, (twin_real)1.0},
    {69, (twin_real)-1.0},
    {67, (twin_real)1.0},
    {68, (twin_real)1.0},
    {70, (twin_real)1.0},
    {71, (twin_real)1.0},
    {72, (twin_real)1.0},
    {73, (twin_real)1.0},
    {76, (twin_real)1.0},
    {77, (twin_real)1.0},
    {78, (twin_real)1.0},
    {79, (twin_real)1.0},
    {80, (twin_real)1.0},
    {81, (twin_real)1.0},
    {82, (twin_real)1.0},
    {83, (twin_real)1.0},
    {84, (twin_real)1.0},
    {85, (twin_real)1.0},
    {86, (twin_real)1.0},
    {87, (twin_real)1.0},
    {88, (twin_real)1.0},
    {89, (twin_real)1.0},
    {90, (twin_real)1.0}
};

static int diagonal(int i)
{
    return i * twin_PARAMETERS - i * (i - 1) / 2;
}

/* G s */
static void combine(const twin_real *s, twin_real *X)
{
    for (int i = 0; i < twin_PARAMETERS; i++) {
        X[i] = 0;
        for (int k = BEGIN[i]; k < BEGIN[i + 1]; k++) {
            X[i] += TERM[k].factor * s[TERM[k].place];
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
            s[TERM[k].place] += TERM[k].factor * x[i];
        }
    }
}

/* R x */
static void times_factor(const twin_real *R, const twin_real *x, twin_real *out)
{
    for (int i = 0; i < twin_PARAMETERS; i++) {
        twin_real sum = 0;
        for (int j = i; j < twin_PARAMETERS; j++) {
            sum += R[diagonal(i) + j - i] * x[j];
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
        twin_real *row = K + diagonal(j);
        if (!(row[0] > 0)) {
            return 1;
        }
        const twin_real root = sqrt(row[0]);
        for (int i = 0; i < twin_PARAMETERS - j; i++) {
            row[i] /= root;
        }
        for (int i = j + 1; i < twin_PARAMETERS; i++) {
            twin_real *below = K + diagonal(i);
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
        const twin_real *row = K + diagonal(j);
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
        memcpy(v + j, R + diagonal(j), (size_t)(twin_PARAMETERS - j) * sizeof v[0]);
        spread(v, step);
        soften(s, s0, step);
        combine(step, x);
        for (int i = j; i < twin_PARAMETERS; i++) {
            twin_real sum = i == j ? mu : 0;
            for (int k = i; k < twin_PARAMETERS; k++) {
                sum += R[diagonal(i) + k - i] * x[k];
            }
            K[diagonal(j) + i - j] = sum;
        }
    }
    if (solve(K, f) != 0) {
        return 1;
    }
    memset(v, 0, sizeof v);
    for (int i = 0; i < twin_PARAMETERS; i++) { /* R'f */
        for (int j = i; j < twin_PARAMETERS; j++) {
            v[j] += R[diagonal(i) + j - i] * f[i];
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
