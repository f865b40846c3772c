/* Axes of the link's frame and a point of it, in frame 0: four vectors. */
static void place(const real *q, const real *point, real *x)
{
    real T[16 * LINKS];
    {{ name }}_frames(q, T);
    for (int i = 0; i < 3; ++i) {
        const real *row = &T[16 * (LINK - 1) + 4 * i];
        x[9 + i] = row[3];
        for (int axis = 0; axis < 3; ++axis) {
            x[3 * axis + i] = row[axis];
            x[9 + i] += row[axis] * point[axis];
        }
    }
}

/* The torque of springs and dampers between the tool and its place `to`, and J of its point. */
static void spring(const motion *x, const real *point, const real *to, real *J, real *tau)
{
    real at[12], pull[6];
    place(x->q, point, at);
    {{ name }}_link_jacobian(x->q, LINK, point, J);
    for (int i = 0; i < 6; ++i) {
        const int a = (i + 1) % 3, b = (i + 2) % 3;
        real e = i < 3 ? to[9 + i] - at[9 + i] : 0;
        for (int axis = 0; i >= 3 && axis < 9; axis += 3) {
            e += (at[axis + a] * to[axis + b] - at[axis + b] * to[axis + a]) / 2;
        }
        pull[i] = K[i / 3] * e;
        for (int j = 0; j < N; ++j) {
            pull[i] -= D[i / 3] * J[i * N + j] * x->qd[j];
        }
    }
    for (int j = 0; j < N; ++j) {
        tau[j] = 0;
        for (int i = 0; i < 6; ++i) {
            tau[j] += J[i * N + j] * pull[i];
        }
    }
}
