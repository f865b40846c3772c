/* {{ name }}: {{ k.doc | join("\n * ") }}
 * {% for kind, count in k.operations.items() if count %}{{ count }} {{ kind }}{{ ", " if not loop.last }}{% else %}0 operations{% endfor %} for one sample, as written here.
 */
#include "{{ name }}.h"
{% if k.guards %}
{% include "nan.c" %}
{% endif %}
{% if k.needs_sincos %}
#include "{{ name }}_math.h"
{% endif %}
{% if k.needs_math %}

#include <math.h>
{% endif %}

{% set qualifiers = name ~ "_IN_SECTION" %}
{% set parameters = k.parameters %}
{% include "function.c" %}
{% include "batch.c" %}
