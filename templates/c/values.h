/* {{ robot }}: values of the base parameters X, apart from the structure of the model in {{ name }}.h.
 *
{% for line in facts %}
 * {{ line }}
{% endfor %}
 *
 * Pass {{ name }}_values as X to the functions of {{ name }}.h.
 */
#ifndef {{ name }}_VALUES_H
#define {{ name }}_VALUES_H

#include "{{ name }}.h"

{% if digest %}
#if {{ name }}_MODEL_DIGEST != {{ digest }}
#error "these values are of another model than {{ name }}.h: generate the package again, or identify"
#endif

{% endif %}
/* The package must have these parameters in this order: otherwise this does not compile. */
typedef char {{ name }}_values_are_of_this_package[
    {{ name }}_PARAMETERS == {{ parameters|length }}
{% for p in parameters %}
    && (int){{ name }}_{{ p.name }} == {{ loop.index0 }}
{% endfor %}
    ? 1 : -1];

static const {{ name }}_real {{ name }}_values[{{ name }}_PARAMETERS] = {
{% for p in parameters %}
    ({{ name }}_real){{ p.value }}{{ "" if loop.last else "," }} /* {{ p.formula }} [{{ p.unit }}], std {{ p.std }} */
{% endfor %}
};
{% if drives %}

/* Torque of the drive of each joint per unit of its input, without friction and back-EMF. */
static const {{ name }}_real {{ name }}_drives[{{ drives|length }}] = {
{% for torque, unit in drives %}
    ({{ name }}_real){{ torque }}{{ "" if loop.last else "," }} /* {{ unit }} */
{% endfor %}
};

/* Input u of the drives for joint torques tau. Back-EMF is part of the viscous friction in X: tau
 * has it if it contains friction, as that of inverse_dynamics or friction does. qd is not used. */
static inline void {{ name }}_duty(
    const {{ name }}_real tau[{{ drives|length }}],
    const {{ name }}_real qd[{{ drives|length }}],
    {{ name }}_real u[{{ drives|length }}])
{
    int j;
    (void)qd;
    for (j = 0; j < {{ drives|length }}; ++j) {
        u[j] = tau[j] / {{ name }}_drives[j];
    }
}
{% endif %}
{% if standard %}

/* The standard parameters that give them, in the order of standard_names in manifest.json. */
static const {{ name }}_real {{ name }}_standard_values[{{ standard|length }}] = {
{% for own, value in standard %}
    ({{ name }}_real){{ value }}{{ "" if loop.last else "," }} /* {{ own }} */
{% endfor %}
};
{% endif %}

#endif
