#include <math.h>
#include <stdio.h>

#include "hobby.h"
#include "hobby_values.h"

int main(void)
{
    const double gain = 6.0, rest[5] = {0.0};
    double q[5], tau[5], duty[5];
    int frame, j;

    for (frame = 0; frame < 600; ++frame) {
        for (j = 0; j < 5; ++j) {
            q[j] = 0.6 * sin(0.01 * frame + j);
            printf("%.5f ", q[j]);
        }
        hobby_gravity_torque(q, hobby_values, tau);
        hobby_duty(tau, rest, duty);
        for (j = 0; j < 5; ++j) {
            printf("%.5f ", q[j] + duty[j] / gain);
        }
        printf("\n");
    }
    return 0;
}
