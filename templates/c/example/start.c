/* At rest, in a pose that the phase stands for. */
static inline motion rest(double phase)
{
    motion x = { { 0 }, { 0 } };
    for (int j = 0; j < N; ++j) {
        x.q[j] = (real)(0.8 * cos(phase + j));
    }
    return x;
}

/* ASSUMED, with a share of its friction. */
static inline void assume(real share, real *X)
{
    for (int i = 0; i < P; ++i) {
        X[i] = i < {{ name }}_INERTIAL ? ASSUMED[i] : share * ASSUMED[i];
    }
}

/* How far parameters are from those of the robot, relative to their norm. */
static inline double wrong(const real *X)
{
    double error = 0.0, norm = 0.0;
    for (int i = 0; i < P; ++i) {
        error += pow((double)X[i] - (double)ACTUAL[i], 2.0);
        norm += pow((double)ACTUAL[i], 2.0);
    }
    return sqrt(error / norm);
}
