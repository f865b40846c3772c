{% set zero = "0.0" if dtype == "double" else "0.0f" %}
    int status = {{ name }}_OK;
    for (size_t i = 0u; (i < {{ k.guards }}u) && (status == 0); ++i) {
        if (!(guard[i] > {{ zero }})) {
            status = (guard[i] <= {{ zero }}) ? {{ name }}_NOT_POSITIVE_DEFINITE : {{ name }}_NOT_FINITE;
        }
    }
{% for o in k.outputs %}
    for (size_t i = 0u; (i < {{ o.size }}u) && (status == 0); ++i) {
        if (!(({{ o.name }}[i] - {{ o.name }}[i]) == {{ zero }})) {
            status = {{ name }}_NOT_FINITE;
        }
    }
{% endfor %}
    return status;
