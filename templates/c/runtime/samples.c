static NAME_real median(NAME_real a, NAME_real b, NAME_real c)
{
    const NAME_real low = a < b ? a : b;
    const NAME_real high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

/* Weights of four speeds for their third difference, the sum of whose squares is 1, at the ends of
 * three spans. */
static void difference(const NAME_real *spans, NAME_real *weight)
{
    const NAME_real at[4] = {0, spans[0], spans[0] + spans[1], spans[0] + spans[1] + spans[2]};
    NAME_real sum = 0;
    for (int i = 0; i < 4; i++) {
        weight[i] = 1;
        for (int j = 0; j < 4; j++) {
            weight[i] *= j != i ? spans[1] / (at[i] - at[j]) : 1;
        }
        sum += weight[i] * weight[i];
    }
    for (int i = 0; i < 4; i++) {
        weight[i] /= {{ sqrt }}(sum);
    }
}

/* Estimate the noise of a speed: from third differences over three intervals or so, in which motion
 * is small and in which noise counts that is filtered at the interval's length. */
static void estimate_noise(NAME_{{ part }}_joint *x, NAME_real qd, const NAME_real *weight)
{
    const NAME_real d = weight[0] * x->past[0] + weight[1] * x->past[1] +
                        weight[2] * x->past[2] + weight[3] * qd;
    const NAME_real found = (d < 0 ? -d : d) / (NAME_real)TENTH;
    if (x->noise > 0) {
        x->noise *= found > x->noise ? (NAME_real)RISE : (NAME_real)FALL;
    } else {
        x->noise = found;
    }
    x->noise = x->noise > (NAME_real)FLT_MIN ? x->noise : 0;
}

/* Look at the speeds of a sample, and at those that were looked at before it. */
static void look(NAME_{{ part }} *s, const NAME_real *qd)
{
    NAME_real weight[4];
    s->spans[0] = s->spans[1];
    s->spans[1] = s->spans[2];
    s->spans[2] = s->since;
    if (s->looks == 3) {
        difference(s->spans, weight);
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        NAME_{{ part }}_joint *x = s->joint + j;
        if (s->looks == 3) {
            estimate_noise(x, qd[j], weight);
        }
        x->past[0] = x->past[1];
        x->past[1] = x->past[2];
        x->past[2] = qd[j];
    }
    s->looks += s->looks < 3;
    s->looked = 1;
    s->since = 0;
}

/* Put numbers in order, smallest first: neighbours change places, as often as there are numbers. */
static void sort(NAME_real *x, int count)
{
    for (int round = 0; round < count; round++) {
        for (int i = round % 2; i + 1 < count; i += 2) {
            const NAME_real low = x[i] < x[i + 1] ? x[i] : x[i + 1];
            const NAME_real high = x[i] < x[i + 1] ? x[i + 1] : x[i];
            x[i] = low;
            x[i + 1] = high;
        }
    }
}

/* Replace number k of the sample in the middle of those around it by the median of these, where it
 * is wild: farther from the median of all than GATE times the shortest interval that holds half of
 * them, and than GATE times the length that one in ten of such intervals exceeds. Neither a jump
 * nor a turn is wild. The numbers before it are tame: up to three wild ones in a row are found. */
static void tame(NAME_{{ part }} *s, int k)
{
    NAME_real *x = s->around[(s->arriving + NAME_{{ PART }}_SIDE) % NAME_{{ PART }}_AROUND] + k;
    NAME_real sorted[NAME_{{ PART }}_AROUND];
    for (int i = 0; i < NAME_{{ PART }}_AROUND; i++) {
        sorted[i] = s->around[i][k];
    }
    sort(sorted, NAME_{{ PART }}_AROUND);
    const NAME_real middle = sorted[NAME_{{ PART }}_SIDE];
    const NAME_real away = *x < middle ? middle - *x : *x - middle;
    NAME_real shortest = middle - sorted[0];
    for (int i = 1; i <= NAME_{{ PART }}_SIDE; i++) {
        const NAME_real length = sorted[i + NAME_{{ PART }}_SIDE] - sorted[i];
        shortest = length < shortest ? length : shortest;
    }
    if (s->spread[k] > (NAME_real)FLT_MIN) {
        if (away > GATE * shortest && away > GATE * s->spread[k]) {
            *x = (middle + sorted[NAME_{{ PART }}_SIDE + (*x < middle ? 1 : -1)]) / 2;
            s->wild = NAME_OUTLIER;
        }
        s->spread[k] *= shortest > s->spread[k] ? (NAME_real)RISE : (NAME_real)FALL;
    } else {
        s->spread[k] = sorted[NAME_{{ PART }}_AROUND - 1] - sorted[0];
    }
}

/* Find which joints rest, at a sample; NAME_REST_TIME is the length of an interval. A single sample
 * that is absurd does not end a rest: the median of three samples counts.
 *
 * Each interval gives one speed to the estimate of the noise, from anywhere in its first half:
 * speeds at even distances would all be the same where mains hum has that period. */
static void find_rest(NAME_{{ part }} *s, const NAME_real *q, const NAME_real *qd, NAME_real dt)
{
{% if part == "identifier" %}
    const int total = s->mode == NAME_WINDOW_START && s->equations > 1;
{% endif %}
    int still = 0;
{% if part == "identifier" %}
    int left = 0; /* nonzero: a rest has ended that the windows from the start hold */
{% endif %}
    s->interval += s->seen != 0 ? dt : 0;
    s->since += s->seen != 0 ? dt : 0;
    s->within++;
    const int ends = s->within >= LEAST_REST && s->interval >= (NAME_real)NAME_REST_TIME;
    if (s->looked == 0 && (ends || s->interval >= s->look)) {
        look(s, qd);
    }
    for (int j = 0; j < NAME_JOINTS; j++) {
        NAME_{{ part }}_joint *x = s->joint + j;
        const NAME_real speed =
            s->seen != 0 ? median(x->latest[0], x->latest[1], qd[j]) : qd[j];
        x->sum += speed < 0 ? -speed : speed;
        x->latest[0] = s->seen != 0 ? x->latest[1] : qd[j];
        x->latest[1] = qd[j];
        if (ends) {
            const NAME_real noise = x->stated > 0 ? x->stated : x->noise;
            const int slow = x->sum <= REST_LEVEL * noise * (NAME_real)s->within;
            const NAME_real away = q[j] < x->held ? x->held - q[j] : q[j] - x->held;
            if (slow && (x->still == 0 || away > REST_LEVEL * noise)) {
                x->held = q[j];
            }
{% if part == "identifier" %}
            if (slow && s->pending > 0) {
                s->rested[s->last][j] = 1; /* the rest began before this interval ended */
            }
            left = left || (total && slow == 0 && x->still != 0);
{% endif %}
            x->still = slow;
            x->sum = 0;
        }
        still += x->still;
    }
    if (ends) {
        s->draw = (DRAW_FACTOR * s->draw + DRAW_TERM) % DRAW_RANGE;
        s->look = s->interval / 2 * (NAME_real)s->draw / (NAME_real)DRAW_RANGE;
        s->looked = 0;
        s->interval = 0;
        s->within = 0;
    }
    s->seen = 1;
    if ({{ "(s->resting == 0 && still == NAME_JOINTS) || left" if part == "identifier" else "s->resting == 0 && still == NAME_JOINTS" }}) {
        rebase(s);
    }
    s->resting = still == NAME_JOINTS;
}
