#include <math.h>
#include <stdio.h>
#include <string.h>

#include "arm.h"
#include "arm_values.h"

enum { PD, GRAVITY, INVERSE, CONTROLLERS };
static const double step = 0.001;                               /* s */
static const double kp[2] = {400.0, 100.0}, kd[2] = {40.0, 8.0}; /* N m/rad, N m s/rad */

/* The motion to follow: both joints move up and down in 3 s. */
static void desired(double t, double q[2], double qd[2], double qdd[2])
{
    const double size[2] = {0.8, -0.6}, w = 2.0 * 3.14159265358979 / 3.0;
    for (int j = 0; j < 2; j++) {
        q[j] = size[j] * (1.0 - cos(w * t));
        qd[j] = size[j] * w * sin(w * t);
        qdd[j] = size[j] * w * w * cos(w * t);
    }
}

/* The torque of a controller: this is the part that runs on your robot. */
static void control(int kind, double t, const double q[2], const double qd[2], double tau[2])
{
    double qr[2], qdr[2], qddr[2], model[2] = {0.0, 0.0};
    desired(t, qr, qdr, qddr);
    if (kind == GRAVITY) {
        arm_gravity_torque(q, arm_values, model);
    } else if (kind == INVERSE) {
        arm_inverse_dynamics(qr, qdr, qddr, arm_values, model);
    }
    for (int j = 0; j < 2; j++) {
        tau[j] = model[j] + kp[j] * (qr[j] - q[j]) + kd[j] * (qdr[j] - qd[j]);
    }
}

/* The robot: here a simulated arm. Its parameters are all 5 % larger than those of the model. */
static int move(double q[2], double qd[2], const double tau[2])
{
    double X[arm_PARAMETERS], qdd[2];
    for (int k = 0; k < arm_PARAMETERS; k++) {
        X[k] = 1.05 * arm_values[k];
    }
    if (arm_forward_dynamics(q, qd, tau, X, qdd) != arm_OK) {
        return 1;
    }
    for (int j = 0; j < 2; j++) {
        qd[j] += step * qdd[j];
        q[j] += step * qd[j];
    }
    return 0;
}

int main(void)
{
    double q[CONTROLLERS][2], qd[CONTROLLERS][2];
    memset(q, 0, sizeof q);
    memset(qd, 0, sizeof qd);
    printf("t,pd,gravity,inverse\n");
    for (int k = 0; k < 6000; k++) {
        const double t = k * step;
        double qr[2], qdr[2], qddr[2], tau[2];
        desired(t, qr, qdr, qddr);
        printf("%.3f", t);
        for (int kind = 0; kind < CONTROLLERS; kind++) {
            printf(",%.4f", 57.29578 * (qr[0] - q[kind][0])); /* degrees */
            control(kind, t, q[kind], qd[kind], tau);
            if (move(q[kind], qd[kind], tau)) {
                return 1;
            }
        }
        printf("\n");
    }
    return 0;
}
