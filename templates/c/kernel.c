/* {{ name }}: {{ k.doc | join("\n * ") }}
 * {{ k.operations }} for one sample, as written here.
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
