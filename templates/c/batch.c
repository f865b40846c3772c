{% if k.loop %}

{{ k.returns }} {{ name }}_{{ k.name }}_batch(size_t N, {{ k.batch_parameters }})
{
{% if k.fallible %}
    int status = 0;
{% endif %}
    for (size_t k = 0; k < N; ++k) {
        {{ "status |= " if k.fallible }}{{ name }}_{{ k.name }}({% for a in k.arguments %}{{ a.name if a.shared else "&{0.name}[k * {0.size}u]".format(a) }}{{ ", " if not loop.last }}{% endfor %});
    }
{% if k.fallible %}
    return status;
{% endif %}
}
{% endif %}
