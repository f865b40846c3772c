int {{ name }}_{{ k.name }}_cuda(void *stream, size_t N{{ ", int x_each" if each }},
{% for line in k.batch_lines %}
    {{ line }}{{ ("," if k.fallible else ")" ~ end) if loop.last }}
{% endfor %}
{% if k.fallible %}
    int *status){{ end }}
{% endif %}
