{% for a in k.arguments %}
        static const {{ a.real }} {{ a.name }}[{{ k.points }}][{{ a.size }}] = {
{% for row in a.rows %}
            { {{ row }} },
{% endfor %}
        };
{% endfor %}
        static const double expected[{{ k.points }}][{{ k.size }}] = {
{% for row in k.expected %}
            { {{ row }} },
{% endfor %}
        };
