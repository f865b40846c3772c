/* {{ name }}: every kernel at seeded points against values computed with {{ digits }} digits.
 * Exit status 0 when each agrees to {{ tolerance }} of its largest entry at any point.
 */
#include "../{{ name }}.h"

#include <math.h>
#include <stdio.h>

static double error_of(const {{ name }}_real *out, const double *expected, size_t size)
{
    double largest = 0.0;
    for (size_t i = 0; i < size; ++i) {
        const double error = fabs((double)out[i] - expected[i]);
        if (!(error < HUGE_VAL)) {
            return HUGE_VAL; /* fmax would pass over a NaN */
        }
        largest = fmax(largest, error);
    }
    return largest;
}

int main(void)
{
    double worst = 0.0;
{% for k in kernels %}
    {
{% for a in k.arguments %}
        static const {{ a.real }} {{ a.name }}[{{ a.points }}][{{ a.size }}] = {
{% for row in a.rows %}
            { {{ row | join(a.suffix ~ ", ") }}{{ a.suffix }} },
{% endfor %}
        };
{% endfor %}
        static const double expected[{{ k.points }}][{{ k.size }}] = {
{% for row in k.expected %}
            { {{ row }} },
{% endfor %}
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < {{ k.points }}; ++i) {
{% for o in k.outputs %}
            {{ name }}_real {{ o.name }}[{{ o.size }}];
{% endfor %}
{% for c in k.changed %}
            for (size_t k = 0; k < sizeof {{ c }} / sizeof {{ c }}[0]; ++k) {
                {{ c }}[k] = {{ c }}_in[i][k];
            }
{% endfor %}
            {{ k.call }};
{% for o in k.outputs %}
            here = fmax(here, error_of({{ o.name }}, expected[i] + {{ o.offset }}, {{ o.size }}));
{% endfor %}
            for (size_t k = 0; k < {{ k.size }}; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("{{ k.name }} %.2e\n", here);
        worst = fmax(worst, here);
    }
{% endfor %}
    return worst <= {{ tolerance }} ? 0 : 1;
}
