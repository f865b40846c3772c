/* {{ name }}: {{ k.doc }}
 * {{ k.operations }} for one sample.
 */
#include "{{ name }}.h"
{% if k.needs_math %}

#include <math.h>
{% endif %}

void {{ name }}_{{ k.name }}({{ k.parameters }})
{
{% for line in k.body %}
    {{ line }}
{% endfor %}
}

void {{ name }}_{{ k.name }}_batch(size_t N, {{ k.parameters }})
{
    for (size_t k = 0; k < N; ++k) {
        {{ name }}_{{ k.name }}({{ k.strides }});
    }
}
