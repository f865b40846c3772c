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
{% set kernel = k.kernel %}
    {
{% for a in kernel.inputs %}
{% set points = k.points[a.name] %}
{% set suffix = "u" if a.link else "f" if dtype == "float" else "" %}
        static const {{ "size_t" if a.link else name ~ "_real" }} {{ a.name }}{{ "_in" if a.written }}[{{ points | length }}][{{ points[0] | length }}] = {
{% for row in points %}
            { {{ row | join(suffix ~ ", ") }}{{ suffix }} },
{% endfor %}
        };
{% endfor %}
        static const double expected[{{ k.expected | length }}][{{ kernel.size }}] = {
{% for row in k.expected %}
            { {{ row }} },
{% endfor %}
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < {{ k.expected | length }}; ++i) {
{% for o in kernel.outputs %}
            {{ name }}_real {{ o.name }}[{{ o.size }}];
{% endfor %}
{% for a in kernel.inputs | selectattr("written") | sort(attribute="name") %}
            for (size_t k = 0; k < sizeof {{ a.name }} / sizeof {{ a.name }}[0]; ++k) {
                {{ a.name }}[k] = {{ a.name }}_in[i][k];
            }
{% endfor %}
            {{ "worst += " if kernel.fallible }}{{ name }}_{{ kernel.name }}({% for a in kernel.arguments %}{{ a.name }}{% if not a.written %}[{{ "0" if k.points[a.name] | length == 1 else "i" }}]{{ "[0]" if a.plain }}{% endif %}{{ ", " if not loop.last }}{% endfor %});
{% set at = namespace(offset=0) %}
{% for o in kernel.outputs %}
            here = fmax(here, error_of({{ o.name }}, expected[i] + {{ at.offset }}, {{ o.size }}));
{% set at.offset = at.offset + o.size %}
{% endfor %}
            for (size_t k = 0; k < {{ kernel.size }}; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("{{ kernel.name }} %.2e\n", here);
        worst = fmax(worst, here);
    }
{% endfor %}
    return worst <= {{ tolerance }} ? 0 : 1;
}
