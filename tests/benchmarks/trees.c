/* Times one kernel of a robot beside Pinocchio's, in cache and out of it: ns a call.
 *
 * Both sides take turns. "Hot": the least of REPEATS passes over STATES states. "Cold": before each
 * call, a walk over 64 MB evicts code and data; the median of REPEATS calls. "Warm": cold, but
 * NAME_warm() runs before the call, and is timed apart.
 */
#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "NAME.h"

enum { REPEATS = 101, STATES = 32, LINE = 64, WALK = 1 << 26 };

void KERNEL(size_t N, const double *q, const double *qd, const double *third, double *out);

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

static int order(const void *a, const void *b)
{
    return (*(const double *)a > *(const double *)b) - (*(const double *)a < *(const double *)b);
}

static void evict(void)
{
    static unsigned char *memory;
    if (!memory)
        memory = malloc(WALK);
    for (size_t i = 0; i < WALK; i += LINE)
        memory[i] += 1;
}

/* result: hot time of ours and of theirs, the same cold, ours after the warm-up, the warm-up, and
 * the largest difference, relative. */
void measure(size_t size, const double *q, const double *qd, const double *third, const double *X,
    double *ours, double *theirs, double *result)
{
    const size_t n = JOINTS;
    double cold[4][REPEATS], t0, t1, t2;
    result[0] = result[1] = INFINITY;
    for (size_t k = 0; k < REPEATS; ++k) {
        t0 = now();
        for (size_t i = 0; i < STATES; ++i)
            NAME_KERNEL(CALL);
        t1 = now();
        KERNEL(STATES, q, qd, third, theirs);
        t2 = now();
        result[0] = fmin(result[0], (t1 - t0) / STATES);
        result[1] = fmin(result[1], (t2 - t1) / STATES);
    }
    double most = 0, norm = 1e-300;
    for (size_t i = 0; i < STATES * size; ++i) {
        if (HALF && (i % size) / n > i % n)
            continue;
        most = fmax(most, fabs(ours[i] - theirs[i]));
        norm = fmax(norm, fabs(theirs[i]));
    }
    for (size_t k = 0; k < REPEATS; ++k) {
        const size_t i = k % STATES;
        evict();
        t0 = now();
        NAME_KERNEL(CALL);
        cold[0][k] = now() - t0;
        evict();
        t0 = now();
        KERNEL(1, q + i * n, qd + i * n, third + i * n, theirs);
        cold[1][k] = now() - t0;
        evict();
        t0 = now();
        NAME_warm();
        t1 = now();
        NAME_KERNEL(CALL);
        t2 = now();
        cold[2][k] = t2 - t1;
        cold[3][k] = t1 - t0;
    }
    for (size_t side = 0; side < 4; ++side) {
        qsort(cold[side], REPEATS, sizeof(double), order);
        result[2 + side] = cold[side][REPEATS / 2];
    }
    result[6] = most / norm;
}
