static inline double length(const real *e)
{
    return sqrt(pow((double)e[0], 2.0) + pow((double)e[1], 2.0) + pow((double)e[2], 2.0));
}

/* How far the frame t (4, 4) is from `to`: a point of it, m, and its axes, sum of t_i x to_i / 2. */
static inline void apart(const real *t, const real *to, const real *point, real *e)
{
    for (int i = 0; i < 3; ++i) {
        const int a = 4 * ((i + 1) % 3), b = 4 * ((i + 2) % 3);
        e[i] = to[4 * i + 3] - t[4 * i + 3];
        e[3 + i] = 0;
        for (int c = 0; c < 3; ++c) {
            e[i] += (to[4 * i + c] - t[4 * i + c]) * point[c];
            e[3 + i] += (t[a + c] * to[b + c] - t[b + c] * to[a + c]) / 2;
        }
    }
}

/* A hand pushes a point of Jacobian J (6, N) along the way that all joints together move it: its
 * torque is added to tau. Returns how far e goes along that way. */
static inline double push(real force, const real *J, const real *e, real *tau)
{
    real way[3] = { 0 };
    double along = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < N; ++j) {
            way[i] += J[i * N + j];
        }
        along += (double)(way[i] * e[i]);
    }
    const double norm = length(way);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < N; ++j) {
            tau[j] += J[i * N + j] * way[i] * force / (real)norm;
        }
    }
    return along / norm;
}
