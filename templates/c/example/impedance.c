/* {{ name }}: an example of a compliant tool (impedance control, Hogan 1985), once a millisecond.
 *
 *     tau = J'(K e - D v) + C qd + g + {{ share }} friction,    e = (x_r - x, sum of a x a_r / 2),
 *
 * with J and v = J qd of the tool's point x and a the axes of its frame: pushed by F the point gives way
 * by F/K. A weak spring on every joint holds what does not move the tool. At run time a tool is mounted,
 * a load taken, which moves the point, and put down again, and add_body tells the model of each. Every
 * mass, inertia and friction of the arm is {{ percent }} % wrong in it. Then a controller that nobody tells does it.
 *
 * Prints, in m, how far the point is from its place before a push, at most, for both, and how far off
 * F/K it goes, relative. Exit status 0 when that is at most 15 %{% if falls %} and the first at most a third of the
 * second{% endif %}.
 */
{% include "example/head.c" %}
enum { LINK = {{ link }}, LINKS = {{ links }} }; /* that carries the tool; all of them */
static const real K[2] = { 4000, 200 }, D[2] = { 200, 10 }; /* N/m, N m/rad; N s/m, N m s/rad */
static const real HOLD = 5, DAMP = 2;                       /* N m/rad and N m s/rad, or N/m and N s/m */
static const real F = 40;                                   /* N, of a push */

/* A tool is mounted, a load taken and put down: mass, centre of mass, inertia about it, and the point. */
static const struct {
    real mass, com[3], inertia[6], point[3];
} BODY[] = {
    { 1, { 0, 0, (real)0.06 }, { (real)0.01, 0, 0, (real)0.01, 0, (real)0.01 }, { 0, 0, (real)0.12 } },
    { 3, { 0, 0, (real)0.18 }, { (real)0.02, 0, 0, (real)0.02, 0, (real)0.02 }, { 0, 0, (real)0.18 } },
    { -3, { 0, 0, (real)0.18 }, { (real)-0.02, 0, 0, (real)-0.02, 0, (real)-0.02 }, { 0, 0, (real)0.12 } },
};

{% include "example/robot.c" %}

{% include "example/spring.c" %}

{% include "example/handling.c" %}

int main(void)
{
    int failed = 0;
    double off[2] = { 0.0, 0.0 };
    const double told = handle(1, &off[1], &failed);
    {{ name }}_add_body(ACTUAL, LINK, -BODY[0].mass, BODY[0].com, BODY[0].inertia);
    const double untold = handle(0, &off[0], &failed);
    printf("told: %.2e\nnot told: %.2e\noff F/K: %.3f\n", told, untold, off[1]);
    return failed == 0 && off[1] <= 0.15{% if falls %} && 3 * told <= untold{% endif %} ? 0 : 1;
}
