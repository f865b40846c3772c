/* {{ name }}: {{ k.doc | join("\n * ") }}
 * {{ k.operations }} for one sample, as written here.
 */
#include "{{ name }}.h"
{% if k.guards %}
{% include "nan.c" %}
{% endif %}
{% if k.needs_sincos %}
#include "{{ name }}_math.h"
{% endif %}
{% if k.needs_math %}

#include <math.h>
{% endif %}

{{ name }}_IN_SECTION {{ k.returns }} {{ name }}_{{ k.name }}({{ k.parameters }})
{
{% if k.link %}
    int status = {{ name }}_NO_SUCH_LINK;
    if ({% if k.link.first %}(link >= 1u) && (link <= {{ k.link.last }}u){% else %}link <= {{ k.link.last }}u{% endif %}) {
{% for line in k.body %}
        {{ line }}
{% endfor %}
        status = {{ name }}_OK;
    }
    return status;
{% else %}
{% for line in k.body %}
    {{ line }}
{% endfor %}
{% if k.guards %}
{# Guards have the order of the elimination: after the first failure, nothing has a meaning. #}
{# NaN makes every comparison by <= false, and x - x is 0 if x is finite. #}
{% include "status.c" %}
{% endif %}
{% endif %}
}
{% include "batch.c" %}
