/* {{ name }}: the model as a struct in C++17, for programs that are templates over robots.
 *
 *     template <class Robot>
 *     auto torque(const std::array<typename Robot::real, Robot::joints> &q, ...)
 *     { return Robot::inverse_dynamics(q, qd, qdd, X); }          // torque<{{ name }}_robot>(...)
 *
 * Every kernel of {{ name }}.h has two forms: one writes into the caller's memory, the other returns
 * std::array (a tuple of them where there are several, an empty optional where C returns nonzero).
 * Arrays are C arrays, std::array, std::vector, std::span, Eigen's vectors and Maps: whatever has data()
 * and size(). Matrices are row-major: Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>>(J.data()).
 * A number of entries that the compiler knows is checked by it, any other by assert; Eigen's
 * matrices in another order, or with gaps, do not compile.
 */
#ifndef {{ name }}_MODEL_HPP
#define {{ name }}_MODEL_HPP

#include <array>
#include <cassert>
#include <cstddef>
#include <optional>
#include <tuple>
#include <type_traits>

#include "{{ name }}.h"

struct {{ name }}_robot {
    using real = {{ name }}_real;
    static constexpr const char *name = "{{ name }}";
    static constexpr std::size_t joints = {{ name }}_JOINTS;
    static constexpr std::size_t parameters = {{ name }}_PARAMETERS;
    static constexpr std::size_t inertial = {{ name }}_INERTIAL;
    static constexpr std::array<const char *, parameters> parameter_names{ {
{% for b in base %}
        "{{ b.name }}",
{% endfor %}
    } };

{% include "view.hpp" %}
{% for k in kernels %}

    /* {{ k.doc }}{{ "; nonzero, or empty: " ~ k.reason if k.fallible }}
{% for o in k.outputs %}
     * {{ o.name }}: {{ o.shape }}
{% endfor %}
     */
    static {{ "int" if k.fallible else "void" }} {{ k.name }}({{ k.inputs }}{{ k.written }}) noexcept
    {
        {{ "return " if k.fallible }}{{ name }}_{{ k.name }}({{ k.pointers }});
    }
{% if k.value %}
    [[nodiscard]] static {{ k.value }} {{ k.name }}({{ k.inputs }}) noexcept
    {
{% for o in k.outputs %}
        std::array<real, {{ o.size }}> {{ o.name }};
{% endfor %}
{% if k.fallible %}
        if ({{ k.name }}({{ k.names }}) != 0) {
            return std::nullopt;
        }
{% else %}
        {{ k.name }}({{ k.names }});
{% endif %}
        return {{ k.returned }};
    }
{% endif %}
{% endfor %}
};

#endif
