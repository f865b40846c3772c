{% set inputs = k.arguments | selectattr("read") | list %}
{% set outputs = k.outputs %}
{% set names = k.arguments | map(attribute="name") | join(", ") %}
{% macro each(read, written) %}
{% for a in inputs %}{{ read.format(a) }}, {% endfor %}{% for o in outputs %}{{ written.format(o) }}{{ ", " if not loop.last }}{% endfor %}
{% endmacro %}
{% set parameters = each("const lanes *{0.name}", "apart *{0.name}") %}
{% set passed = each("lanes_{0.name}", "lanes_{0.name}") %}
{% macro strides() %}
{% for a in inputs %}
    const size_t stride_{{ a.name }} = (strides != NULL) ? strides[{{ loop.index0 }}] : {{ 0 if a.shared else a.size }}u;
{% endfor %}
{% endmacro %}
{% macro lanes() %}
{{ strides() }}{% for a in inputs %}
    {{ dtype }} padded_{{ a.name }}[REACH({{ a.size }}u)];
    lanes lanes_{{ a.name }}[BLOCKS({{ a.size }}u)];
{% endfor %}
    if (N == 0u) {
        return 0;
    }
{% for a in inputs %}
    lanes_shared({{ a.name }}, {{ a.size }}u, lanes_{{ a.name }});
{% endfor %}
{% endmacro %}
{% macro loaded() %}
{% for a in inputs %}
        if (stride_{{ a.name }} != 0u) {
            lanes_read({{ a.name }}, {{ a.size }}u, stride_{{ a.name }}, k, N, padded_{{ a.name }}, lanes_{{ a.name }});
        }
{% endfor %}
{% endmacro %}
/* {{ name }}: {{ k.name }} of as many samples at once as a vector register holds. */
#include "{{ name }}_panels.h"
#include "{{ name }}_lanes.h"

#if {{ name }}_WIDTH > 1

/* One panel. What is zero for every sample is not written. */
ALWAYS int panel({{ parameters }}, const int stream)
{
    (void)stream;
{% for line in k.panel.body %}
    {{ line }}
{% endfor %}
{% if k.guards %}
{% set zero = "0.0" if dtype == "double" else "0.0f" %}
    const mask singular = {% for g in k.panel.guards %}(mask)({{ g }} <= {{ zero }}){{ ";" if loop.last else " | " }}{% endfor %}

    const mask odd = {% for g in k.panel.guards %}(~(mask)({{ g }} > {{ zero }}) & ~(mask)({{ g }} <= {{ zero }})) | {% endfor %}
{% for r in k.panel.results %}(~(mask)({{ r }} - {{ r }} == {{ zero }})){{ ";" if loop.last else " | " }}{% endfor %}

    const int status = (lanes_any(singular) ? (int){{ name }}_NOT_POSITIVE_DEFINITE : 0)
        | (lanes_any(odd & ~singular) ? (int){{ name }}_NOT_FINITE : 0);
{% endif %}
    return {{ "status" if k.guards else "0" }};
}

/* Compiled once for rows and panels. */
ONCE int plain({{ parameters }})
{
    return panel({{ names }}, 0);
}

int {{ name }}_{{ k.name }}_rows(int stream, size_t N, const size_t *strides,
    {{ k.batch_parameters }})
{
    int status = 0;
{{ lanes() }}{% for o in outputs %}
    lanes lanes_{{ o.name }}[BLOCKS({{ o.size }}u)];
{% endfor %}
    {{ dtype }} scratch[{{ outputs | map(attribute="size") | max }}u * {{ name }}_WIDTH] __attribute__((aligned(64)));
{% for o in outputs %}
    memset(lanes_{{ o.name }}, 0, sizeof lanes_{{ o.name }});
{% endfor %}
    for (size_t k = 0; k < N; k += {{ name }}_WIDTH) {
        const size_t count = (N - k < {{ name }}_WIDTH) ? (N - k) : {{ name }}_WIDTH;
{{ loaded() }}        status |= plain({{ each("lanes_{0.name}", "(apart *)lanes_{0.name}") }});
{% for o in outputs %}
        lanes_store(lanes_{{ o.name }}, {{ o.size }}u, count, stream, scratch, &{{ o.name }}[k * {{ o.size }}u]);
{% endfor %}
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, const size_t *strides, {{ k.batch_parameters }})
{
    int status = 0;
{{ lanes() }}    for (size_t k = 0; k < N; k += {{ name }}_WIDTH) {
{{ loaded() }}{% for o in outputs %}
        apart *lanes_{{ o.name }} = (apart *)&{{ o.name }}[k * {{ o.size }}u];
{% endfor %}
        status |= stream ? panel({{ passed }}, 1) : plain({{ passed }});
    }
    return status;
}

int {{ name }}_{{ k.name }}_panels(int stream, size_t N, const size_t *strides,
    {{ k.batch_parameters }})
{
    if (!({% for o in outputs %}{{ " && " if not loop.first }}streamed(stream, {{ o.name }}){% endfor %})) {
        return panels(0, N, strides, {{ names }});
    }
    const int status = panels(1, N, strides, {{ names }});
    stream_end();
    return status;
}

#else

int {{ name }}_{{ k.name }}_rows(int stream, size_t N, const size_t *strides,
    {{ k.batch_parameters }})
{
    int status = 0;
{{ strides() }}    (void)stream;
    for (size_t k = 0; k < N; ++k) {
        {{ "status |= " if k.fallible }}{{ name }}_{{ k.name }}({{ each("&{0.name}[k * stride_{0.name}]", "&{0.name}[k * {0.size}u]") }});
    }
    return status;
}

int {{ name }}_{{ k.name }}_panels(int stream, size_t N, const size_t *strides,
    {{ k.batch_parameters }})
{
    return {{ name }}_{{ k.name }}_rows(stream, N, strides, {{ names }});
}

#endif

size_t {{ name }}_{{ k.name }}_width(void)
{
    return {{ name }}_WIDTH;
}

{{ k.returns }} {{ name }}_{{ k.name }}_batch(size_t N, {{ k.batch_parameters }})
{
    {{ "return " if k.fallible else "(void)" }}{{ name }}_{{ k.name }}_rows(0, N, NULL, {{ names }});
}
