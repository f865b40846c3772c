int {{ name }}_{{ k.name }}_rows(int stream, size_t N, {{ k.plain }})
{
    int status = 0;
{% for a in k.arguments if not a.shared %}
    double padded_{{ a.name }}[REACH({{ a.size }}u)];
{% endfor %}
{% for o in k.outputs %}
    lanes lanes_{{ o.name }}[BLOCKS({{ o.size }}u)];
{% endfor %}
    double scratch[{{ k.largest }}u * WIDTH] __attribute__((aligned(64)));
{% for o in k.outputs %}
    memset(lanes_{{ o.name }}, 0, sizeof lanes_{{ o.name }});
{% endfor %}
    for (size_t k = 0; k < N; k += WIDTH) {
{{ loaded() }}        status |= panel({{ k.call }}, 0);
{% for o in k.outputs %}
        lanes_store(lanes_{{ o.name }}, {{ o.size }}u, count, stream, scratch, &{{ o.name }}[k * {{ o.size }}u]);
{% endfor %}
    }
    if (stream) {
        stream_end();
    }
    return status;
}

ALWAYS int panels(const int stream, size_t N, {{ k.plain }})
{
    int status = 0;
{% for a in k.arguments if not a.shared %}
    double padded_{{ a.name }}[REACH({{ a.size }}u)];
{% endfor %}
    for (size_t k = 0; k < N; k += WIDTH) {
{{ loaded() }}
{% for o in k.outputs %}
        lanes *lanes_{{ o.name }} = (lanes *)&{{ o.name }}[k * {{ o.size }}u];
{% endfor %}
        status |= panel({{ k.call }}, stream);
    }
    return status;
}

int {{ name }}_{{ k.name }}_panels(int stream, size_t N, {{ k.plain }})
{
    /* Past the cache only where one store fills a line of it. */
    if (!stream || sizeof(lanes) < 64u) {
        return panels(0, N, {{ k.names }});
    }
    const int status = panels(1, N, {{ k.names }});
    stream_end();
    return status;
}
