/* Of this interface: a program written for one goes on with every later one of the same major. */
#define {{ name }}_VERSION "{{ version }}"
#define {{ name }}_VERSION_MAJOR {{ version.split(".")[0] }}
#define {{ name }}_VERSION_MINOR {{ version.split(".")[1] }}
/* Of the robot file: first 64 bits of the SHA-256 of robot.toml. */
#define {{ name }}_MODEL_DIGEST {{ digest }}

#define {{ name }}_JOINTS {{ n }}
{% if floating %}
#define {{ name }}_EQUATIONS {{ n + 6 }} /* of the base, then of the joints */
{% endif %}
#define {{ name }}_PARAMETERS {{ p }}
#define {{ name }}_INERTIAL {{ inertial }}

typedef {{ dtype }} {{ name }}_real;

/* What functions that return int return. */
typedef enum {{ name }}_status {
    {{ name }}_OK = 0,
    {{ name }}_NOT_POSITIVE_DEFINITE = 1, /* no robot has this X, the load lets nothing through, or
                                      * rows of a task depend on each other */
    {{ name }}_NOT_FINITE = 2,   /* an input, or what came of it, is NaN or infinite */
    {{ name }}_OUTLIER = 4,      /* identifier: an equation that contradicts all before it */
    {{ name }}_NOT_EXCITED = 8,  /* identifier: an equation that would teach less than is forgotten */
    {{ name }}_NO_SUCH_LINK = 16, /* link is not the number of a joint; nothing is written */
    {{ name }}_CHANGING = 16384  /* identifier: the robot has changed, X is that of before; no
                                      * parameter has this number */
} {{ name }}_status;
