{% macro table(type, name, size, lines) %}
    static const {{ type }} {{ name }}[{{ size }}] = {
{% for line in lines %}
        {{ line }}
{% endfor %}
    };
{%- endmacro %}
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

{% set w = k.loops.width %}
{% set n = k.loops.n %}
{% if k.loops.solved %}
/* Solves L' D L x = b for {{ w }} column{{ "s" if w > 1 }}, with rows of L below the diagonal and the inverse of D; b is
 * zero from row `rows` on, and these rows of x are left out. Two sums at once wait less.
 */
static void {{ k.name }}_solved(const unsigned char *first, const unsigned char *way, const {{ k.dtype }} *low,
    const {{ k.dtype }} *inverse, size_t rows, {{ k.dtype }} x[{{ n }}][{{ w }}])
{
    size_t j = rows;
    while (j != 0u) {
        --j;
        {{ k.dtype }} y[{{ w }}];
        for (size_t i = 0u; i < {{ w }}u; ++i) {
            y[i] = x[j][i];
        }
        size_t last = way[j];
        if ((j != 0u) && (last == j)) { /* with the joint before it, whose row is final then */
            const {{ k.dtype }} *const later = &low[j * {{ n }}u];
            --j;
            {{ k.dtype }} z[{{ w }}];
            for (size_t i = 0u; i < {{ w }}u; ++i) {
                z[i] = x[j][i] - (later[j] * y[i]);
            }
            for (size_t i = 0u; i < {{ w }}u; ++i) {
                x[j][i] = z[i];
            }
            for (last = way[j]; last != 0u; last = way[first[last - 1u] - 1u]) {
                for (size_t u = first[last - 1u] - 1u; u < last; ++u) {
                    const {{ k.dtype }} entry = low[(j * {{ n }}u) + u];
                    const {{ k.dtype }} next = later[u];
                    for (size_t i = 0u; i < {{ w }}u; ++i) {
                        x[u][i] -= (entry * z[i]) + (next * y[i]);
                    }
                }
            }
        }
        for (; last != 0u; last = way[first[last - 1u] - 1u]) {
            for (size_t u = first[last - 1u] - 1u; u < last; ++u) {
                const {{ k.dtype }} entry = low[(j * {{ n }}u) + u];
                for (size_t i = 0u; i < {{ w }}u; ++i) {
                    x[u][i] -= entry * y[i];
                }
            }
        }
    }
    for (j = 0u; j < rows; ++j) {
        {{ k.dtype }} y[{{ w }}];
        {{ k.dtype }} z[{{ w }}];
        for (size_t i = 0u; i < {{ w }}u; ++i) {
            y[i] = x[j][i] * inverse[j];
            z[i] = {{ k.loops.zero }};
        }
        for (size_t last = way[j]; last != 0u; last = way[first[last - 1u] - 1u]) {
            size_t u = first[last - 1u] - 1u;
            for (; (u + 1u) < last; u += 2u) {
                const {{ k.dtype }} entry = low[(j * {{ n }}u) + u];
                const {{ k.dtype }} next = low[(j * {{ n }}u) + (u + 1u)];
                for (size_t i = 0u; i < {{ w }}u; ++i) {
                    y[i] -= entry * x[u][i];
                    z[i] -= next * x[u + 1u][i];
                }
            }
            if (u < last) {
                const {{ k.dtype }} entry = low[(j * {{ n }}u) + u];
                for (size_t i = 0u; i < {{ w }}u; ++i) {
                    y[i] -= entry * x[u][i];
                }
            }
        }
        for (size_t i = 0u; i < {{ w }}u; ++i) {
            x[j][i] = y[i] + z[i];
        }
    }
}

{% endif %}
{{ k.returns }} {{ name }}_{{ k.name }}({{ k.parameters }})
{
{% if k.loops.joints != k.loops.n %}
    /* Place of each joint in all tables and arrays, antecedents first. Fixed joints are last. */
{{ table("unsigned char", "order", k.loops.joints, k.loops.order) }}
{% endif %}
    /* The joint before each joint, counted from 1; 0 is the base. Arrays of the state have a row for
     * the base and each joint.
     */
{{ table("unsigned char", "antecedent", k.loops.joints, k.loops.antecedents) }}
{% if k.loops.several %}
    /* Kind of each joint: {{ k.loops.called }}. */
{{ table("unsigned char", "kind", k.loops.joints, k.loops.kinds) }}
{% endif %}
{% if not k.loops.revolute %}
    /* 1 where q is an angle. */
{{ table(k.dtype, "turns", k.loops.n, k.loops.turns) }}
{% endif %}
{% if k.loops.paired %}
{% if k.loops.joints != k.loops.n %}
    /* The same among the joints with a variable. */
{{ table("unsigned char", "way", k.loops.n, k.loops.way) }}
{% endif %}
    /* Row of the first of the neighbours on the way from the base that end at each joint. */
{{ table("unsigned char", "first", k.loops.n, k.loops.first) }}
{% endif %}
    /* Angle of each joint about z, to which q of a revolute joint is added; up to a multiple of four. */
{{ table(k.dtype, "theta", k.loops.angles, k.loops.theta) }}
{% if k.loops.columns %}
    /* Constants of each joint: {{ k.loops.columns | join(", ") }}. */
    static const {{ k.dtype }} geometry[{{ k.loops.joints }}][{{ k.loops.columns | length }}] = {
{% for values in k.loops.geometry %}
        { {{ values | join(", ") }} },
{% endfor %}
    };
{% endif %}
    /* Row and column of each entry of X among the parameters of the bodies, which are
     * {{ k.loops.parameters | join(", ") }}.
     */
{{ table("unsigned char", "row", k.loops.given, k.loops.rows) }}
{{ table("unsigned char", "column", k.loops.given, k.loops.places) }}
    {{ k.dtype }} angle[{{ k.loops.angles }}];
    {{ k.dtype }} c[{{ k.loops.angles }}];
    {{ k.dtype }} s[{{ k.loops.angles }}];
    {{ k.dtype }} body[{{ k.loops.joints }}][{{ k.loops.parameters | length }}];
{% for array, size, base in k.loops.state %}
    {{ k.dtype }} {{ array }}[{{ size }}][{{ k.loops.joints + (5 if k.loops.paired else 1) }}];
{% endfor %}
{% for matrix in k.loops.matrices %}
    {{ k.dtype }} {{ matrix }}[{{ k.loops.n * k.loops.n }}];
{% endfor %}
{% if k.loops.factored %}
    {{ k.dtype }} inverse[{{ k.loops.n }}];
{% endif %}
{% if k.loops.guards %}
    {{ k.dtype }} guard[{{ k.loops.guards }}];
{% endif %}
{% if k.loops.paired %}
    /* The base, and rows after the last joint, which four joints at once reach. */
    for (size_t i = 0u; i < 5u; ++i) {
        const size_t j = (i == 0u) ? 0u : ({{ k.loops.joints }}u + i);
{% for array, size, base in k.loops.state %}
        for (size_t e = 0u; e < {{ size }}u; ++e) {
            {{ array }}[e][j] = {{ k.loops.zero }};
        }
{% endfor %}
    }
{% endif %}
{% for array, size, base in k.loops.state %}
{% for place, value in base %}
    {{ array }}[{{ place }}][0] = {{ value }};
{% endfor %}
{% endfor %}
    for (size_t j = 0u; j < {{ k.loops.angles }}u; ++j) {
        angle[j] = theta[j];
    }
    for (size_t j = 0u; j < {{ k.loops.n }}u; ++j) {
{% if k.loops.revolute %}
        angle[j] += q[j];
{% else %}
        angle[j] += turns[j] * q[j];
{% endif %}
    }
{% if k.dtype == "double" %}
    for (size_t j = 0u; j < {{ k.loops.angles }}u; j += 4u) {
        const {{ name }}_angles4 turned = {{ name }}_sincos4(&angle[j]);
        for (size_t i = 0u; i < 4u; ++i) {
            c[j + i] = turned.c[i];
            s[j + i] = turned.s[i];
        }
    }
{% else %}
    for (size_t j = 0u; j < {{ k.loops.angles }}u; ++j) {
        c[j] = cosf(angle[j]);
        s[j] = sinf(angle[j]);
    }
{% endif %}
    for (size_t j = 0u; j < {{ k.loops.joints }}u; ++j) {
        for (size_t i = 0u; i < {{ k.loops.parameters | length }}u; ++i) {
            body[j][i] = {{ k.loops.zero }};
        }
    }
    for (size_t i = 0u; i < {{ k.loops.given }}u; ++i) {
        body[row[i]][column[i]] = X[i];
    }
{% if not k.loops.reads_body %}
    (void)body;
{% endif %}
{% set plain = k.loops.joints == n %}
{% set way = "antecedent" if plain else "way" %}
{% for step in k.loops.steps %}
{% if step.kind == "sweep" %}
{% if step.order == "apart" %}
    for (size_t begin = 0u; begin < {{ k.loops.joints }}u; begin += 4u) {
        /* {{ step.doc }} */
        for (size_t i = 0u; i < 4u; ++i) {
            const size_t j = begin + i;
{% for line in step.bodies[0].body %}
            {{ line }}
{% endfor %}
        }
    }
{% else %}
{% if step.order == "inward" %}
    for (size_t i = 0u; i < {{ k.loops.joints }}u; ++i) {
        const size_t j = {{ "%du - i" % (n - 1) if plain else "order[%du - i]" % (k.loops.joints - 1) }};
{% elif plain %}
    for (size_t j = 0u; j < {{ n }}u; ++j) {
{% else %}
    for (size_t i = 0u; i < {{ k.loops.joints }}u; ++i) {
        const size_t j = order[i];
{% endif %}
        /* {{ step.doc }} */
{% if step.up %}
        const size_t up = antecedent[j];
{% endif %}
{% if step.bodies | length == 1 %}
{% for line in step.bodies[0].body %}
        {{ line }}
{% endfor %}
{% else %}
        switch (kind[j]) {
{% for body in step.bodies %}
        {{ "default" if loop.last else "case " ~ loop.index0 ~ "u" }}: { /* {{ body.kind }} */
{% for line in body.body %}
            {{ line }}
{% endfor %}
            break;
        }
{% endfor %}
        }
{% endif %}
    }
{% endif %}
{% elif step.kind == "pairs" %}
{% if not k.loops.whole %}
    for (size_t i = 0u; i < {{ n * n }}u; ++i) {
{% for matrix in step.matrices %}
        {{ matrix }}[i] = {{ k.loops.zero }};
{% endfor %}
    }
{% endif %}
    for (size_t j = 0u; j < {{ n }}u; ++j) {
        /* {{ step.doc }} */
        size_t last = j + 1u;
        while (last != 0u) {
            for (size_t begin = first[last - 1u]; begin <= last; begin += 4u) {
                {{ k.dtype }} entry[{{ step.count }}][4];
                for (size_t i = 0u; i < 4u; ++i) {
                    const size_t u = begin + i;
{% for line in step.body %}
                    {{ line }}
{% endfor %}
                }
                for (size_t i = 0u; (i < 4u) && ((begin + i) <= last); ++i) {
                    const size_t u = (begin + i) - 1u;
{% for matrix, place, entry in step.places %}
                    {{ matrix }}[({{ place[0] }} * {{ n }}u) + {{ place[1] }}] = entry[{{ entry }}][i];
{% endfor %}
                }
            }
            last = {{ way }}[first[last - 1u] - 1u];
        }
    }
{% if step.diagonal %}
    for (size_t j = 0u; j < {{ n }}u; ++j) {
        {{ step.diagonal[0] }}[j * {{ n + 1 }}u] += {{ step.diagonal[1] }}[0][j + 1u];
    }
{% endif %}
{% elif step.kind == "elimination" %}
    for (size_t i = 0u; i < {{ n }}u; ++i) {
        /* {{ step.doc }} */
        const size_t j = {{ n - 1 }}u - i;
        guard[i] = {{ step.matrix }}[j * {{ n + 1 }}u];
        inverse[j] = {{ k.loops.one }} / guard[i];
        const {{ k.dtype }} *const row_j = &{{ step.matrix }}[j * {{ n }}u];
        for (size_t last = {{ way }}[j]; last != 0u; last = {{ way }}[first[last - 1u] - 1u]) {
            for (size_t u = last; u >= first[last - 1u]; --u) {
                {{ k.dtype }} *const row_u = &{{ step.matrix }}[(u - 1u) * {{ n }}u];
                const {{ k.dtype }} low = row_j[u - 1u] * inverse[j];
                for (size_t end = u; end != 0u; end = {{ way }}[first[end - 1u] - 1u]) {
                    size_t v = first[end - 1u] - 1u;
                    for (; (v + {{ k.loops.row }}u) <= end; v += {{ k.loops.row }}u) {
                        {{ k.dtype }} y[{{ k.loops.row }}];
                        for (size_t e = 0u; e < {{ k.loops.row }}u; ++e) {
                            y[e] = row_u[v + e] - (low * row_j[v + e]);
                        }
                        for (size_t e = 0u; e < {{ k.loops.row }}u; ++e) {
                            row_u[v + e] = y[e];
                        }
                    }
                    for (; v < end; ++v) {
                        row_u[v] -= low * row_j[v];
                    }
                }
                {{ step.matrix }}[(j * {{ n }}u) + (u - 1u)] = low;
            }
        }
    }
{% if step.into %}
    for (size_t j = 0u; j < {{ n }}u; ++j) {
        for (size_t u = 0u; u < j; ++u) {
            {{ step.into[0] }}[(u * {{ n }}u) + j] = {{ step.matrix }}[(j * {{ n }}u) + u];
            {{ step.into[0] }}[(j * {{ n }}u) + u] = {{ k.loops.zero }};
        }
        {{ step.into[0] }}[j * {{ n + 1 }}u] = {{ k.loops.one }};
        {{ step.into[1] }}[j] = guard[{{ n - 1 }}u - j];
    }
{% endif %}
{% elif step.kind == "solution" %}
    {
        /* {{ step.doc }} */
        {{ k.dtype }} block[{{ n }}][{{ w }}];
{% if step.single %}
        for (size_t k = 0u; k < {{ n }}u; ++k) {
            for (size_t i = 0u; i < {{ w }}u; ++i) {
                block[k][i] = {{ step.value }};
            }
        }
        {{ k.name }}_solved(first, {{ way }}, {{ step.matrix }}, inverse, {{ n }}u, block);
        for (size_t k = 0u; k < {{ n }}u; ++k) {
            {{ step.into }} = block[k][0];
        }
{% else %}
        for (size_t m = 0u; m < {{ k.loops.blocks }}u; ++m) {
            /* {{ w }} columns from `begin` on; the first time, only those before `end` are new. */
            const size_t end = ((m + 1u) * {{ w }}u) - {{ k.loops.left }}u;
            const size_t begin = (m == 0u) ? 0u : (end - {{ w }}u);
            const size_t rows = {{ "%du" % n if step.right else "begin + %du" % w }};
            for (size_t k = 0u; k < rows; ++k) {
                for (size_t i = 0u; i < {{ w }}u; ++i) {
                    block[k][i] = {{ step.value }};
                }
            }
            {{ k.name }}_solved(first, {{ way }}, {{ step.matrix }}, inverse, rows, block);
            for (size_t k = 0u; k < rows; ++k) {
                for (size_t i = 0u; i < (end - begin); ++i) {
                    {{ step.into }} = block[k][i];
{% if not step.right %}
                    {{ step.mirrored }} = block[k][i];
{% endif %}
                }
            }
        }
{% endif %}
    }
{% endif %}
{% endfor %}
{% for line in k.loops.status %}
    {{ line }}
{% endfor %}
}
{% include "batch.c" %}
