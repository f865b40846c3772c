{% macro declared(a) %}
{{ a.name }}: {{ plain(a) if a.plain else "*mut Real" if a.written else "*const Real" }}
{%- endmacro %}
{% macro taken(a) %}
{{ a.name }}: {{ plain(a) if a.plain else "&mut " if a.written else "&" }}
{%- if not a.plain %}[Real; {{ "PARAMETERS" if a.name == "X" else a.size }}]{% endif %}
{%- endmacro %}
{% macro passed(a) %}
{{ a.name }}{{ "" if a.plain else ".as_mut_ptr()" if a.written else ".as_ptr()" }}
{%- endmacro %}
{% macro plain(a) %}{{ "usize" if a.link else "Real" }}{% endmacro %}
{% macro listed(what, k) %}
{% for a in k.arguments %}{{ what(a) }}{{ ", " if not loop.last }}{% endfor %}
{% endmacro %}
//! {{ name }}: the dynamic model of the robot {{ robot }} in its base parameters.
//!
//! Units: rad, m, s, kg, N; tau in N m for a revolute joint, N for a prismatic one. Matrices are
//! row-major arrays. The functions allocate nothing, and any thread may call them.
#![no_std]
#![allow(non_snake_case, clippy::too_many_arguments)]
#![allow(clippy::approx_constant, clippy::excessive_precision)]

/// The number type of all arrays.
pub type Real = {{ "f64" if dtype == "double" else "f32" }};

/// Number of joint variables.
pub const JOINTS: usize = {{ n }};
/// Number of base parameters.
pub const PARAMETERS: usize = {{ p }};
/// Number of inertial base parameters, which come first.
pub const INERTIAL: usize = {{ inertial }};

/// Place of each joint in q, qd, qdd and tau.
pub mod joint {
{% for field in fields %}
    pub const {{ field|upper }}: usize = {{ loop.index0 }};
{% endfor %}
}

/// Place of each base parameter in X.
#[allow(non_upper_case_globals)]
pub mod parameter {
{% for parameter in parameters %}
    pub const {{ parameter }}: usize = {{ loop.index0 }};
{% endfor %}
}
{% if values %}

/// Values of the base parameters, as in {{ name }}_values.h.
pub const VALUES: [Real; PARAMETERS] = [
{% for value in values.X %}
    {{ value }},
{% endfor %}
];
{% endif %}

/// Reason why a function has no result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// No robot has this X, or the load has no unique acceleration.
    NotPositiveDefinite,
    /// An input or a result is NaN or infinite.
    NotFinite,
    /// The link is not the number of a joint; nothing is written.
    NoSuchLink,
}

impl core::fmt::Display for Status {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Status::NotPositiveDefinite => "the mass matrix is not positive definite",
            Status::NotFinite => "an input or a result is not finite",
            Status::NoSuchLink => "the link is not the number of a joint",
        })
    }
}
{% if kernels|selectattr("fallible")|first is defined %}

fn checked(status: core::ffi::c_int) -> Result<(), Status> {
    match status {
        0 => Ok(()),
        1 => Err(Status::NotPositiveDefinite),
        16 => Err(Status::NoSuchLink),
        _ => Err(Status::NotFinite),
    }
}
{% endif %}

extern "C" {
    fn {{ name }}_warm();
{% for k in kernels %}
    fn {{ name }}_{{ k.name }}({{ listed(declared, k) }}){{ " -> core::ffi::c_int" if k.fallible }};
{% endfor %}
}

/// Read the code of the functions into the cache, as {{ name }}.h describes it.
pub fn warm() {
    // SAFETY: it has no arguments, and only reads its section of code.
    unsafe { {{ name }}_warm() }
}
{% for k in kernels %}

/// {{ k.doc|replace("[", "\\[") }}
pub fn {{ k.name }}({{ listed(taken, k) }}){{ " -> Result<(), Status>" if k.fallible }} {
    // SAFETY: the arrays have the lengths of the C prototype, and outputs are exclusive.
    {{ "checked(" if k.fallible }}unsafe { {{ name }}_{{ k.name }}({{ listed(passed, k) }}) }{{ ")" if k.fallible }}
}
{% endfor %}
