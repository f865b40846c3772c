#include "{{ name }}.h"

#include <math.h>
#include <stdio.h>

enum { N = {{ name }}_JOINTS, P = {{ name }}_PARAMETERS };

typedef {{ name }}_real real;

static const double DT = 1e-3; /* s */
