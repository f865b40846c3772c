/* {{ name }}: a simulated robot and a reference, which no controller needs. */
#ifndef {{ name }}_SIMULATED_H
#define {{ name }}_SIMULATED_H

#include "{{ name }}.h"

#include <math.h>
#include <stdio.h>

enum { N = {{ name }}_JOINTS, P = {{ name }}_PARAMETERS };

typedef {{ name }}_real real;

static const double DT = 1e-3; /* s */
{% if gravity_input %}
static const real GRAVITY[3] = { (real)4.905, 0, (real)-8.4957 }; /* m/s2: a base that leans by 30 degrees */
{% endif %}

{% include "example/robot.c" %}

{% include "example/reference.c" %}

{% include "example/start.c" %}

#endif
