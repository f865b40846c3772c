#include <armf.h>
#include <armf_state.h>
#include <armf_values.h>

const float RANGE = 5.0f / 1023.0f;    // rad for each step of the position sensors

void setup()
{
    Serial.begin(115200);
}

void loop()
{
    armf_state position;
    position.q1 = RANGE * (analogRead(A0) - 512);
    position.q2 = RANGE * (analogRead(A1) - 512);

    float q[armf_JOINTS], tau[armf_JOINTS];
    armf_state_to(&position, q);
    armf_gravity_torque(q, armf_values, tau);

    armf_state torque = armf_state_of(tau);
    Serial.print(torque.q1);           // N m: the torque to send to the drives
    Serial.print(' ');
    Serial.println(torque.q2);
    delay(10);
}
