{{ qualifiers }} {{ k.returns }} {{ name }}_{{ k.name }}({{ parameters }})
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
