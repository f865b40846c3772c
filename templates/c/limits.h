/* {{ name }}: limits of the joints, as [limits] of robot.toml declares them; in the order of q. */
#ifndef {{ name }}_LIMITS_H
#define {{ name }}_LIMITS_H

#include "{{ name }}.h"
{% if limits.position is not none %}

/* Lowest and highest position, rad or m. */
static const {{ name }}_real {{ name }}_POSITION_LIMITS[{{ n }}][2] = {
{% for low, high in limits.position %}
    {{ "{" }}({{ name }}_real){{ low }}, ({{ name }}_real){{ high }}{{ "}" }}{{ "" if loop.last else "," }}
{% endfor %}
};
{% endif %}
{% for key, unit in (("velocity", "rad/s or m/s"), ("acceleration", "rad/s2 or m/s2"), ("jerk", "rad/s3 or m/s3"), ("torque", "N m or N")) %}
{% if limits[key] is not none %}

/* Largest {{ key }}, {{ unit }}. */
static const {{ name }}_real {{ name }}_{{ key|upper }}_LIMITS[{{ n }}] = {
{% for value in limits[key] %}
    ({{ name }}_real){{ value }}{{ "" if loop.last else "," }}
{% endfor %}
};
{% endif %}
{% endfor %}

#endif
