/* {{ name }}: named fields for the arrays of {{ name }}.h that have one number for each joint. */
#ifndef {{ name }}_STATE_H
#define {{ name }}_STATE_H

#include "{{ name }}.h"

/* One number for each joint: positions, speeds, accelerations or torques, in the order of q. */
typedef struct {{ name }}_state {
{% for field in fields %}
    {{ name }}_real {{ field }};
{% endfor %}
} {{ name }}_state;

/* Return an array as named fields. */
static inline {{ name }}_state {{ name }}_state_of(const {{ name }}_real array[{{ n }}])
{
    {{ name }}_state state;
{% for field in fields %}
    state.{{ field }} = array[{{ loop.index0 }}];
{% endfor %}
    return state;
}

/* Write named fields to an array, as the functions of {{ name }}.h take it. */
static inline void {{ name }}_state_to(const {{ name }}_state *state, {{ name }}_real array[{{ n }}])
{
{% for field in fields %}
    array[{{ loop.index0 }}] = state->{{ field }};
{% endfor %}
}

#endif
