/* {{ name }}: {{ k.name }} of as many samples at once as a vector register holds. */
#include "{{ name }}.h"
#include "{{ name }}_{{ k.name }}_panels.h"
#include "{{ name }}_lanes.inc"

/* One panel; not 0 where a sample has no result. What is zero for every sample is not written. */
ALWAYS int panel({{ k.parameters }}, const int stream)
{
    (void)stream;
{% for line in k.body %}
    {{ line }}
{% endfor %}
    return {{ k.status }};
}

size_t {{ name }}_{{ k.name }}_width(void)
{
    return WIDTH;
}

{% macro loaded() %}
        const size_t count = N - k < WIDTH ? N - k : WIDTH;
{% for a in k.arguments if not a.shared %}
        const double *rows_{{ a.name }} = &{{ a.name }}[k * {{ a.size }}u];
        if (k * {{ a.size }}u + REACH({{ a.size }}u) > N * {{ a.size }}u) {
            rows_{{ a.name }} = lanes_last(rows_{{ a.name }}, {{ a.size }}u, count, padded_{{ a.name }});
        }
        lanes lanes_{{ a.name }}[BLOCKS({{ a.size }}u)];
        lanes_load(rows_{{ a.name }}, {{ a.size }}u, lanes_{{ a.name }});
{% endfor %}
{% endmacro %}
{% include "panels_loops.c" %}
