{% if k.loop %}

{{ k.returns }} {{ name }}_{{ k.name }}_batch(size_t N, {{ k.batch_parameters }})
{
{% if k.fallible %}
    int status = 0;
{% endif %}
    for (size_t k = 0; k < N; ++k) {
        {{ "status |= " if k.fallible }}{{ name }}_{{ k.name }}({{ k.strides }});
    }
{% if k.fallible %}
    return status;
{% endif %}
}
{% endif %}
