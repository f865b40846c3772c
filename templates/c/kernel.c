/* {{ name }}: {{ k.doc | join("\n * ") }}
 * {{ k.operations }} for one sample, as written here.
 */
#include "{{ name }}.h"
{% if k.needs_sincos %}
#include "{{ name }}_math.h"
{% endif %}
{% if k.needs_math %}

#include <math.h>
{% endif %}

{{ k.returns }} {{ name }}_{{ k.name }}({{ k.parameters }})
{
{% for line in k.body %}
    {{ line }}
{% endfor %}
}
{% if k.batch %}

{{ k.returns }} {{ name }}_{{ k.name }}_batch(size_t N, {{ k.batch_parameters }})
{
{% if k.guarded %}
    int status = 0;
    for (size_t k = 0; k < N; ++k) {
        status |= {{ name }}_{{ k.name }}({{ k.strides }});
    }
    return status;
{% else %}
    for (size_t k = 0; k < N; ++k) {
        {{ name }}_{{ k.name }}({{ k.strides }});
    }
{% endif %}
}
{% endif %}
