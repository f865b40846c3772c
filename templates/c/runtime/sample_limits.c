/* A joint rests up to so many standard deviations of the noise of its speed (the mean size of
 * normal noise is 0.8), and stays where it is until it has moved as far as that takes it in 1 s. */
#define REST_LEVEL 3
#define LEAST_REST 3 /* samples in an interval */
{% if part == "identifier" %}
#define ROOT_STEPS 200 /* enough for the smallest float */
{% endif %}
/* One in ten numbers of normal noise exceeds 1.645 of its standard deviations. The estimate rises
 * and falls by these factors: it rises nine times as fast as it falls. */
#define TENTH 1.645
#define RISE 1.15
#define FALL 0.9846

/* Numbers from 0 to DRAW_RANGE - 1 in no order that a vibration has. */
#define DRAW_FACTOR 75u
#define DRAW_TERM 74u
#define DRAW_RANGE 65537u
