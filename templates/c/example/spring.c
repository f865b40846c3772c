/* Add the torque of springs and dampers that hold a point of the link and its frame where that is `to`;
 * gives J of the point, and e. Returns 0; nonzero when there is no such link. */
static int spring(const motion *x, const real *point, const real *to, real *J, real *e, real *tau)
{
    real T[16 * LINKS];
    {{ name }}_frames(x->q, T);
    const int failed = {{ name }}_link_jacobian(x->q, LINK, point, J);
    apart(&T[16 * (LINK - 1)], to, point, e);
    for (int i = 0; i < 6; ++i) {
        real pull = K[i / 3] * e[i];
        for (int j = 0; j < N; ++j) { pull -= D[i / 3] * J[i * N + j] * x->qd[j]; }
        for (int j = 0; j < N; ++j) { tau[j] += J[i * N + j] * pull; }
    }
    return failed;
}
