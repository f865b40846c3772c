{% macro row(values) %}{{ "{ " ~ values | join(", ") ~ " }" }}{% endmacro %}
/* {{ name }}: {{ k.doc | join("\n * ") }}
 * {{ k.operations }} for one sample.
 *
 * Loops over the joints, with constants from tables: less text than single statements for each
 * joint, so that a call is fast even if it is not in the cache. The number of operations is fixed.
 */
#include "{{ name }}.h"
{% if k.dtype == "double" %}
#include "{{ name }}_math.h"
{% endif %}
{% if k.dtype == "float" or k.loops.needs_math %}

#include <math.h>
{% endif %}

enum { JOINTS = {{ k.loops.joints }}, ANGLES = {{ k.loops.angles }}, PARAMETERS = {{ k.loops.parameters | length }}, GIVEN = {{ k.loops.given }} };

/* The joint before each joint, counted from 1; 0 is the base. */
static const unsigned char antecedent[JOINTS] = {
{% for line in k.loops.antecedents %}
    {{ line }}
{% endfor %}
};
{% if k.loops.sweeps[0].functions | length > 1 %}

/* Kind of each joint: {{ k.loops.called }}. */
static const unsigned char kind[JOINTS] = {
{% for line in k.loops.kinds %}
    {{ line }}
{% endfor %}
};
{% endif %}
{% if not k.loops.revolute %}

/* Place of each joint in q, qd, qdd and tau; 0 for fixed joints, which have none. */
static const unsigned char variable[JOINTS] = {
{% for line in k.loops.variables %}
    {{ line }}
{% endfor %}
};

/* 1 where q is an angle. */
static const {{ k.dtype }} turns[JOINTS] = {
{% for line in k.loops.turns %}
    {{ line }}
{% endfor %}
};
{% endif %}

/* Angle of each joint about z; q of a revolute joint is added. */
static const {{ k.dtype }} theta[ANGLES] = {
{% for line in k.loops.theta %}
    {{ line }}
{% endfor %}
};
{% if k.loops.columns %}

/* Constants of each joint: {{ k.loops.columns | join(", ") }}. */
static const {{ k.dtype }} geometry[JOINTS][{{ k.loops.columns | length }}] = {
{% for values in k.loops.geometry %}
    {{ row(values) }},
{% endfor %}
};
{% endif %}

/* Row and column of each entry of X among the parameters of the bodies, which are
 * {{ k.loops.parameters | join(", ") }}.
 */
static const unsigned char row[GIVEN] = {
{% for line in k.loops.rows %}
    {{ line }}
{% endfor %}
};
static const unsigned char column[GIVEN] = {
{% for line in k.loops.places %}
    {{ line }}
{% endfor %}
};

{{ k.returns }} {{ name }}_{{ k.name }}({{ k.parameters }})
{
    {{ k.dtype }} angle[ANGLES];
    {{ k.dtype }} c[ANGLES];
    {{ k.dtype }} s[ANGLES];
    {{ k.dtype }} body[JOINTS][PARAMETERS];
{% for array, base in k.loops.state %}
    {{ k.dtype }} {{ array }}[{{ base | length }}][JOINTS + 1];
{% endfor %}
{% for array, base in k.loops.state %}
{% for value in base %}
    {{ array }}[{{ loop.index0 }}][0] = {{ value }};
{% endfor %}
{% endfor %}
    for (size_t j = 0u; j < ANGLES; ++j) {
        angle[j] = theta[j];
    }
    for (size_t j = 0u; j < JOINTS; ++j) {
{% if k.loops.revolute %}
        angle[j] += q[j];
{% else %}
        angle[j] += turns[j] * q[variable[j]];
{% endif %}
    }
{% if k.dtype == "double" %}
    for (size_t j = 0u; j < ANGLES; j += 4u) {
        const {{ name }}_angles4 turned = {{ name }}_sincos4(&angle[j]);
        for (size_t i = 0u; i < 4u; ++i) {
            c[j + i] = turned.c[i];
            s[j + i] = turned.s[i];
        }
    }
{% else %}
    for (size_t j = 0u; j < ANGLES; ++j) {
        c[j] = cosf(angle[j]);
        s[j] = sinf(angle[j]);
    }
{% endif %}
    for (size_t j = 0u; j < JOINTS; ++j) {
        for (size_t i = 0u; i < PARAMETERS; ++i) {
            body[j][i] = {{ k.loops.zero }};
        }
    }
    for (size_t i = 0u; i < GIVEN; ++i) {
        body[row[i]][column[i]] = X[i];
    }
{% for sweep in k.loops.sweeps %}
{% if sweep.inward %}
    for (size_t j = JOINTS; j-- > 0u;) {
{% else %}
    for (size_t j = 0u; j < JOINTS; ++j) {
{% endif %}
        const size_t up = antecedent[j];
{% if sweep.functions | length == 1 %}
{% for line in sweep.functions[0].body %}
        {{ line }}
{% endfor %}
{% else %}
        switch (kind[j]) {
{% for f in sweep.functions %}
        {{ "default" if loop.last else "case " ~ loop.index0 ~ "u" }}: { /* {{ f.kind }} */
{% for line in f.body %}
            {{ line }}
{% endfor %}
            break;
        }
{% endfor %}
        }
{% endif %}
    }
{% endfor %}
}
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
