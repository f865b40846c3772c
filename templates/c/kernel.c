{% macro work(indent) %}
{% if k.parts.parts %}
{{ indent }}{{ k.dtype }} w[{{ k.parts.handed }}];
{% for part in k.parts.parts %}
{{ indent }}{{ "return " if loop.last and k.guarded }}part_{{ loop.index }}({{ k.names }}, w);
{% endfor %}
{% else %}
{% for line in k.body %}
{{ indent }}{{ line }}
{% endfor %}
{% endif %}
{% endmacro %}
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

{% for part in k.parts.parts %}
{% set last = loop.last %}
static {{ "int" if last and k.guarded else "void" }} part_{{ loop.index }}({{ k.parameters }}, {{ k.dtype }} *w)
{
{% for line in part %}
    {{ line }}
{% endfor %}
}

{% endfor %}
{% if k.links and k.guarded %}
static int of_link({{ k.parameters }})
{
{{ work("    ") }}}

{% endif %}
{{ k.returns }} {{ name }}_{{ k.name }}({{ k.parameters }})
{
{% if k.links %}
    int status = {{ name }}_NO_SUCH_LINK;
    if ((link >= 1u) && (link <= {{ k.links }}u)) {
{% if k.guarded %}
        status = of_link({{ k.names }});
    }
{% else %}
{{ work("        ") }}        status = {{ name }}_OK;
    }
{% endif %}
    return status;
{% else %}
{{ work("    ") }}{% endif %}
}
{% include "batch.c" %}
