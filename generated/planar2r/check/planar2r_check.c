/* planar2r: every kernel at seeded points against values computed with 50 digits.
 * Exit status 0 when each agrees to 1e-13 of its largest entry at any point.
 */
#include "../planar2r.h"

#include <math.h>
#include <stdio.h>

static double error_of(const planar2r_real *out, const double *expected, size_t size)
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
    {
        static const planar2r_real q[4][2] = {
            { -0.943617, -0.473669 },
            { -1.369869, -1.260397 },
            { -0.072312, -0.345731 },
            { -0.977081, 0.643072 },
        };
        static const planar2r_real qd[4][2] = {
            { 0.231825, 1.114176 },
            { -1.177554, -1.554089 },
            { -0.477024, -0.500829 },
            { 0.86734, -1.499542 },
        };
        static const double expected[4][4] = {
            { 0.0268714153125, 0.9058593460005, 0.13884082317695862, 0.0711684517228918 },
            { 0.693316711458, 3.7309367397245, 0.49124611655940587, 1.5314692435726305 },
            { 0.113775948288, 0.4780982448045, 0.21942900362276285, 0.0790379247360524 },
            { 0.3761393378, 0.199839684402, -0.21940420136936598, 0.1644060916712029 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real out[4];
            planar2r_energy_regressor(q[i], qd[i], out);
            here = fmax(here, error_of(out, expected[i] + 0, 4));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("energy_regressor %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.278102, 1.033218 },
            { 0.245481, 1.886154 },
            { -0.443939, 0.474648 },
            { -1.347336, 0.494063 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.959885, 1.153692 },
            { -0.693216, 1.257905 },
            { 0.791251, -1.340297 },
            { -1.128741, -1.27703 },
        };
        static const planar2r_real qdd[4][2] = {
            { 1.780583, -1.680663 },
            { -0.497149, -0.827428 },
            { -1.097866, -0.092756 },
            { 1.449556, -1.371648 },
        };
        static const double expected[4][4] = {
            { -3.489737912955, -0.08055480456, -1.2005511427126323, 0.23390331129218164 },
            { 0.344631641184, -0.747974061553, 0.1352031059507421, -0.3793850044920915 },
            { -0.868687570366, 0.653706246612, -0.2839526364268699, -0.18141607636701676 },
            { -1.636173288996, -0.187428807068, -0.7516245410535075, 2.3742347548642013 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real out[4];
            planar2r_power_regressor(q[i], qd[i], qdd[i], out);
            here = fmax(here, error_of(out, expected[i] + 0, 4));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("power_regressor %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -1.473936, -1.664547 },
            { 0.642826, 1.020886 },
            { 0.497252, 1.363825 },
            { 1.154393, -0.633668 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.054223, 1.506595 },
            { -0.503891, 0.220551 },
            { -0.151701, 1.920897 },
            { 0.459923, 0.86617 },
        };
        static const double expected[4][16] = {
            { 1.054223, 2.560818, -0.16920814225767566, 1.7995829968395334, 0, 2.560818, -0.04934470047651288, 0.5247967549129218, 0, 0, 0, 0, 0, 0, 1.3439089763225984, 0.12636279718486276 },
            { -0.503891, -0.28334, -0.20570770277559636, 0.33558531383097934, 0, -0.28334, -0.13166943382475796, 0.2148015250563126, 0, 0, 0, 0, 0, 0, -0.06086186410945561, -0.037307217379906915 },
            { -0.151701, 1.769196, 0.16619503317591466, -0.7914870369778059, 0, 1.769196, -0.015587035958577572, 0.07423168232147248, 0, 0, 0, 0, 0, 0, 0.13133039543641983, 0.027576521669771606 },
            { 0.459923, 1.326093, 0.7196404042775133, 0.5287541740689119, 0, 1.326093, 0.185317026082928, 0.13616126955206234, 0, 0, 0, 0, 0, 0, 0.18056250642410301, -0.24574761106938825 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real p_out[8];
            planar2r_real dl_out[8];
            planar2r_momentum_regressor(q[i], qd[i], p_out, dl_out);
            here = fmax(here, error_of(p_out, expected[i] + 0, 8));
            here = fmax(here, error_of(dl_out, expected[i] + 8, 8));
            for (size_t k = 0; k < 16; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("momentum_regressor %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -0.398876, 1.645403 },
            { -0.404679, -0.802955 },
            { 0.811805, 0.195148 },
            { -1.370621, -0.358884 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.245384, 1.812042 },
            { -1.244063, -0.149357 },
            { 0.306608, 0.273512 },
            { 1.731681, 1.076162 },
        };
        static const planar2r_real qdd[4][2] = {
            { 0.777797, 1.461117 },
            { -0.980963, -0.134404 },
            { -0.676312, 1.735918 },
            { -0.270676, 0.919361 },
        };
        static const double expected[4][8] = {
            { 0.777797, 2.238914, 0.5008003584974343, -1.5499956549231233, 0, 2.238914, 0.7443458894595212, -0.4456197865517699 },
            { -0.980963, -1.115367, -0.586340827380872, -0.8908697058274037, 0, -1.115367, -0.8973946991938183, 0.18464307793698884 },
            { -0.676312, 1.059606, 0.16449456644281546, -0.15612623495236588, 0, 1.059606, -0.3226227826532955, 0.11168445887037864 },
            { -0.270676, 0.648685, 1.034887316283896, -2.220626069965631, 0, 0.648685, -0.6533349143828354, 1.3562997097688974 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real out[8];
            planar2r_torque_regressor(q[i], qd[i], qdd[i], out);
            here = fmax(here, error_of(out, expected[i] + 0, 8));
            for (size_t k = 0; k < 8; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("torque_regressor %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 0.611577, -1.64047 },
            { -0.857979, -1.468598 },
            { -0.673518, 1.576869 },
            { -1.333052, -0.440685 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.439989, 1.080498 },
            { -0.631996, 0.519732 },
            { 1.929792, 1.040814 },
            { -1.732271, -1.139839 },
        };
        static const planar2r_real qdd[4][2] = {
            { -0.839556, 0.217812 },
            { 1.119423, -0.051857 },
            { 1.096302, -0.00756 },
            { -1.117847, -0.542056 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { -0.805763858457976, -0.1456505655722566 },
            { 0.9260870136315793, 0.05370912968294117 },
            { 1.1407533262662264, 0.6497617091610797 },
            { -0.5844738196720043, -0.8198828239974665 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real tau[2];
            planar2r_inverse_dynamics(q[i], qd[i], qdd[i], X[0], tau);
            here = fmax(here, error_of(tau, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("inverse_dynamics %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.516186, -0.627572 },
            { -0.776406, -1.190168 },
            { -0.393156, -0.592605 },
            { 1.480324, 0.474401 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][4] = {
            { 1.071447503805691, 0.1935802519028455, 0.1935802519028455, 0.214296 },
            { 0.9171607214661802, 0.1164368607330901, 0.1164368607330901, 0.214296 },
            { 1.0820038755978822, 0.1988584377989411, 0.1988584377989411, 0.214296 },
            { 1.3628882772388946, 0.33930063861944737, 0.33930063861944737, 0.214296 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real M[4];
            planar2r_mass_matrix(q[i], X[0], M);
            here = fmax(here, error_of(M, expected[i] + 0, 4));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("mass_matrix %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.135676, -1.29593 },
            { -0.548449, -1.343434 },
            { -0.513533, -0.50972 },
            { -0.397564, 0.543788 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 0 },
            { 0 },
            { 0 },
            { 0 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real tau[2];
            planar2r_gravity_torque(q[i], X[0], tau);
            here = fmax(here, error_of(tau, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("gravity_torque %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -1.223258, -0.275825 },
            { -1.155578, 0.49443 },
            { 1.1029, -0.271937 },
            { -0.136356, 0.589029 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.235854, -1.462167 },
            { 0.304835, -0.184249 },
            { -0.60937, -1.646339 },
            { 1.742281, -0.940134 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][4] = {
            { -0.2171780857133327, -0.4007415267848143, 0.18356344107148162 },
            { -0.015479415977990124, 0.010130860168152431, -0.025610276146142554 },
            { -0.2443239264061319, -0.3347571063490869, 0.09043317994295501 },
            { -0.06737838067243616, 0.05748900254777793, -0.1248673832202141 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real C[4];
            planar2r_coriolis(q[i], qd[i], X[0], C);
            here = fmax(here, error_of(C, expected[i] + 0, 4));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("coriolis %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.440263, -0.547289 },
            { 0.699957, 0.187258 },
            { 0.192977, 0.919179 },
            { -1.709814, 0.075672 },
        };
        static const planar2r_real qd[4][2] = {
            { -0.047873, 1.543912 },
            { 1.664317, -0.081816 },
            { 1.699854, 1.148766 },
            { -0.558845, -0.006032 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 0.3393836213964957, -0.00034788145459874664 },
            { -0.031450504242583145, -0.3279468950573493 },
            { 0.12713282902345052, -0.07030458751076611 },
            { 0.000869512518625546, -0.040062529069910376 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real h[2];
            planar2r_bias_torque(q[i], qd[i], X[0], h);
            here = fmax(here, error_of(h, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("bias_torque %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -0.478625, 1.652097 },
            { 1.878375, -0.598492 },
            { -0.202398, 1.075608 },
            { -1.492952, 1.49771 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.471345, 0.733559 },
            { -0.774702, -1.143269 },
            { 0.59544, 0.039945 },
            { 0.101451, 0.605156 },
        };
        static const planar2r_real tau[4][2] = {
            { -1.670935, -1.420394 },
            { 1.556415, 0.324919 },
            { -0.418563, -1.771285 },
            { 0.53418, 1.939946 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 1.3414996118134925, -9.60146726535386 },
            { 0.7880235143653253, 1.2115619441010625 },
            { 3.299429905406408, -13.904735589959683 },
            { -3.2560869012884406, 14.4171240189716 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real qdd[2];
            worst += planar2r_forward_dynamics(q[i], qd[i], tau[i], X[0], qdd);
            here = fmax(here, error_of(qdd, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("forward_dynamics %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.941863, 1.679881 },
            { -0.328438, 1.281796 },
            { -1.180638, 0.610661 },
            { 0.107354, -0.694408 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.686491, 0.994901 },
            { 0.271527, -1.971321 },
            { 1.309461, 0.393054 },
            { -1.047413, 1.328031 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 1.4755032474901253 },
            { 0.2739629129514092 },
            { 1.3832744940840287 },
            { 0.5103753820180849 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real T_out[1];
            planar2r_real U_out[1];
            planar2r_energy(q[i], qd[i], X[0], T_out, U_out);
            here = fmax(here, error_of(T_out, expected[i] + 0, 1));
            here = fmax(here, error_of(U_out, expected[i] + 1, 1));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("energy %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.752885, 1.494539 },
            { -1.173046, -1.206296 },
            { 1.367541, -1.213787 },
            { -1.391623, 1.06285 },
        };
        static const double expected[4][32] = {
            { -0.18108410937773184, -0.9834676127513674, 0, 0, 0.9834676127513674, -0.18108410937773184, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, -0.9944050880297536, 0.10563390033761945, 0, -0.09054205468886592, -0.10563390033761945, -0.9944050880297536, 0, 0.4917338063756837, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
            { 0.3873452723895415, 0.9219347265167268, 0, 0, -0.9219347265167268, 0.3873452723895415, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, -0.7232836527199363, 0.6905510536579511, 0, 0.19367263619477074, -0.6905510536579511, -0.7232836527199363, 0, -0.4609673632583634, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
            { 0.20185870948809656, -0.9794146524347082, 0, 0, 0.9794146524347082, 0.20185870948809656, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0.988203121376428, -0.15314891740356776, 0, 0.10092935474404828, 0.15314891740356776, 0.988203121376428, 0, 0.4897073262173541, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
            { 0.17821619512624134, 0.9839913555487799, 0, 0, -0.9839913555487799, 0.17821619512624134, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0.9464392320774585, 0.3228819908025695, 0, 0.08910809756312067, -0.3228819908025695, 0.9464392320774585, 0, -0.49199567777438996, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real T_out[32];
            planar2r_frames(q[i], T_out);
            here = fmax(here, error_of(T_out, expected[i] + 0, 32));
            for (size_t k = 0; k < 32; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("frames %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -0.111409, -1.212969 },
            { -1.365418, -1.557681 },
            { -1.616861, -0.887558 },
            { -0.718856, -1.419791 },
        };
        static const double expected[4][12] = {
            { 0.055589337772717004, 0, 0.4969002168705411, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
            { 0.4894919497715605, 0, 0.10196877516591071, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
            { 0.49946960527001855, 0, -0.023024191873155277, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
            { 0.3292620874623769, 0, 0.3762797865417674, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real J_out[12];
            planar2r_jacobian(q[i], J_out);
            here = fmax(here, error_of(J_out, expected[i] + 0, 12));
            for (size_t k = 0; k < 12; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("jacobian %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -1.171376, 1.231197 },
            { -1.22401, 0.177681 },
            { 0.498595, 1.621827 },
            { 0.84618, -0.098021 },
        };
        static const planar2r_real qd[4][2] = {
            { -0.421786, 1.034122 },
            { 1.704489, -1.154115 },
            { -1.764553, -0.96834 },
            { 1.191229, 1.640778 },
        };
        static const planar2r_real qdr[4][2] = {
            { 1.486974, -1.754932 },
            { -0.264304, -0.956753 },
            { 0.818363, 1.861023 },
            { -1.365132, 0.42864 },
        };
        static const planar2r_real qddr[4][2] = {
            { 0.226495, 0.697876 },
            { 0.600335, 1.387477 },
            { 0.255672, -0.306304 },
            { -0.649719, 1.297584 },
        };
        static const double expected[4][8] = {
            { 0.226495, 0.924371, -0.02664577915665847, -0.6197012030853601, 0, 0.924371, -0.2579587850711154, -0.21124028895879748 },
            { 0.600335, 1.987812, 1.2932777516767875, -0.11970084965673937, 0, 1.987812, 0.2556290517119833, -0.27475919082444566 },
            { 0.255672, -0.050632, 2.9301595660261945, -0.25231158005423143, 0, -0.050632, -0.7276032535006334, -0.09084028357813421 },
            { -0.649719, 0.647865, -0.05112522699461911, 0.5104303858623783, 0, 0.647865, -0.2437275404689692, -0.8409814824559677 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real out[8];
            planar2r_slotine_li_regressor(q[i], qd[i], qdr[i], qddr[i], out);
            here = fmax(here, error_of(out, expected[i] + 0, 8));
            for (size_t k = 0; k < 8; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("slotine_li_regressor %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 1.819151, -1.180596 },
            { 0.772675, -0.745544 },
            { 0.798956, -1.885354 },
            { -0.560576, -1.42821 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.02736, 1.901948 },
            { -1.059926, 1.106075 },
            { 0.663399, 1.383729 },
            { -1.990153, -0.521202 },
        };
        static const planar2r_real qdr[4][2] = {
            { 0.655721, -0.846932 },
            { 0.052018, -0.270793 },
            { -0.859092, -1.942792 },
            { 1.833058, -1.13619 },
        };
        static const planar2r_real qddr[4][2] = {
            { 1.278316, -1.588742 },
            { 1.751712, 1.647212 },
            { -1.649052, -0.240803 },
            { -1.976872, 1.490917 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 0.8438128822932701, -0.2691983466807081 },
            { 2.11179652914839, 0.6693989907876856 },
            { -1.4948798759353328, -0.1429641411665476 },
            { -1.4079256524234882, 0.4664125638731248 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real tau[2];
            planar2r_slotine_li_torque(q[i], qd[i], qdr[i], qddr[i], X[0], tau);
            here = fmax(here, error_of(tau, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("slotine_li_torque %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -1.384608, -0.559077 },
            { 1.720063, 1.202075 },
            { -1.106069, 1.193525 },
            { -1.568939, 0.991407 },
        };
        static const planar2r_real qd[4][2] = {
            { 0.246034, 1.884394 },
            { 1.516712, -1.247535 },
            { -1.778995, 1.963175 },
            { 1.2574, -1.462883 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][4] = {
            { 0.6530069162306144, 0.453993586066672, 0, 0.079504672486259 },
            { 1.6900675635719802, 0.2865568729179855, 0, -0.007564142199033405 },
            { -1.8000086005951426, -0.22925503783704781, 0, 0.005647699895930764 },
            { 1.2451454768970847, 0.1463853799064886, 0, -0.0034718852957131238 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real p_out[2];
            planar2r_real rate_out[2];
            planar2r_generalized_momentum(q[i], qd[i], X[0], p_out, rate_out);
            here = fmax(here, error_of(p_out, expected[i] + 0, 2));
            here = fmax(here, error_of(rate_out, expected[i] + 2, 2));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("generalized_momentum %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real qd[4][2] = {
            { 0.313154, -1.895261 },
            { 1.915268, 1.698342 },
            { -1.46721, 1.432078 },
            { 1.31574, -1.733316 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 0 },
            { 0 },
            { 0 },
            { 0 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real tau[2];
            planar2r_friction(qd[i], X[0], tau);
            here = fmax(here, error_of(tau, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("friction %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 0.031104, 0.048254 },
            { 1.9829, 0.74809 },
            { 1.400693, 1.821662 },
            { 1.743232, -0.831894 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.328712, -1.547988 },
            { 1.637601, -1.662964 },
            { -0.068957, 1.146814 },
            { 1.945388, -1.637066 },
        };
        static const planar2r_real qdd[4][2] = {
            { -1.572366, 1.983809 },
            { 0.779552, 0.498207 },
            { -0.179317, -1.831248 },
            { 0.907557, 0.316352 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][8] = {
            { 0, -0.017412850253602136, 0, -0.06733993354000606, -0.4039254363473491, -0.05721695128159994, -0.3467084850657492 },
            { 0, 0.4872751141542661, 0, 0.4240842402107076, -0.16472263712571375, -0.0025122974673050516, -0.1622103396584087 },
            { 0, 0.09523334837576808, 0, 0.018950957169458424, -0.23558238921681288, -0.22141701033826433, -0.01416537887854854 },
            { 0, 0.1178036806619662, 0, -0.06239134215096124, -0.4691172500882339, 0.08835268021063564, -0.5574699302988695 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real dq_out[4];
            planar2r_real dqd_out[4];
            planar2r_inverse_dynamics_derivatives(q[i], qd[i], qdd[i], X[0], dq_out, dqd_out);
            here = fmax(here, error_of(dq_out, expected[i] + 0, 4));
            here = fmax(here, error_of(dqd_out, expected[i] + 4, 4));
            for (size_t k = 0; k < 8; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("inverse_dynamics_derivatives %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -0.840046, 0.375551 },
            { -0.813543, 1.952107 },
            { -0.01376, -1.112435 },
            { -0.448939, 1.100962 },
        };
        static const planar2r_real qd[4][2] = {
            { 0.149571, -1.390349 },
            { 0.943064, -1.179604 },
            { 1.46972, -1.931597 },
            { 1.186437, 1.951778 },
        };
        static const planar2r_real tau[4][2] = {
            { 0.860227, 0.223457 },
            { 0.144837, 1.056159 },
            { 1.421559, -1.615553 },
            { 1.645101, -1.640672 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][12] = {
            { 0, 0.14635303339602268, 0, -0.43717494019459724, 0.27320360343512956, 0.2922496933682414, -0.28347778757822945, -0.4502480311143731, 1.1962453955763155, -1.8429690306268787, -1.8429690306268787, 7.505772183228643 },
            { 0, 0.8540325601684609, 0, -2.501644612809817, 0.05283096394031747, -0.06449393447882529, -1.1016040733275816, 0.09392145103344303, 1.1710044388337741, -1.7053144136830465, -1.7053144136830465, 7.149863878119476 },
            { 0, 0.6348549538513962, 0, -1.12197255993718, 0.30657051352810083, 0.1324537568091865, 1.51547381173661, -0.0777354939815309, 1.1600781616577456, -0.6808357205267024, -0.6808357205267024, 5.0660168558361995 },
            { 0, 2.021323309896815, 0, -4.368784317188331, 0.032218585778824575, 0.02540578923634061, -0.09051424710049658, -0.043426147925062664, 1.2645919620542339, -2.1615686526462903, -2.1615686526462903, 8.361214730621125 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real dq_out[4];
            planar2r_real dqd_out[4];
            planar2r_real dtau_out[4];
            worst += planar2r_forward_dynamics_derivatives(q[i], qd[i], tau[i], X[0], dq_out, dqd_out, dtau_out);
            here = fmax(here, error_of(dq_out, expected[i] + 0, 4));
            here = fmax(here, error_of(dqd_out, expected[i] + 4, 4));
            here = fmax(here, error_of(dtau_out, expected[i] + 8, 4));
            for (size_t k = 0; k < 12; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("forward_dynamics_derivatives %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -1.939818, 1.625045 },
            { 1.767538, -1.879869 },
            { 1.697922, -1.413874 },
            { -1.092949, 0.505673 },
        };
        static const planar2r_real b[4][2] = {
            { -1.214298, -1.577983 },
            { -1.172896, 0.738779 },
            { -1.458236, -0.836598 },
            { -1.795384, 1.665854 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { 1.6114361848472978, -9.95254328117823 },
            { -1.7578665871416062, 3.978759764209131 },
            { -1.3191878731593374, -3.3310483462980485 },
            { -5.414323908270415, 16.41307346841125 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real x[2];
            worst += planar2r_solve_mass_matrix(q[i], b[i], X[0], x);
            here = fmax(here, error_of(x, expected[i] + 0, 2));
            for (size_t k = 0; k < 2; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("solve_mass_matrix %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 0.624587, -0.028702 },
            { -0.503675, 1.477972 },
            { -0.791445, 0.401424 },
            { -1.789793, -0.529285 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][6] = {
            { 1.0, 1.3163526910401724, 0, 1.0, 0.8771364652310932, 0.214296 },
            { 1.0, 1.6539878771363492, 0, 1.0, 0.8069285700611013, 0.214296 },
            { 1.0, 1.5523318151493635, 0, 1.0, 0.8332076262699234, 0.214296 },
            { 1.0, 0.9727667385622671, 0, 1.0, 0.8984240672583369, 0.214296 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real L_out[4];
            planar2r_real D_out[2];
            worst += planar2r_mass_matrix_factor(q[i], X[0], L_out, D_out);
            here = fmax(here, error_of(L_out, expected[i] + 0, 4));
            here = fmax(here, error_of(D_out, expected[i] + 4, 2));
            for (size_t k = 0; k < 6; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("mass_matrix_factor %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -0.771824, 1.591668 },
            { 1.273711, -0.226721 },
            { 1.035358, 0.108295 },
            { -0.4078, -0.750634 },
        };
        static const size_t link[4][1] = {
            { 1u },
            { 2u },
            { 1u },
            { 2u },
        };
        static const planar2r_real point[4][3] = {
            { 0.269203, -0.872326, -0.400958 },
            { -0.612034, -1.108855, -1.532395 },
            { 0.772377, -0.261278, 1.087746 },
            { 0.811211, 0.749702, -0.277501 },
        };
        static const double expected[4][12] = {
            { 0.812897360811114, 0, -0.41547657728363646, 0, 0, 0, 0, 0, 0, 0, 1.0 },
            { 0.606503377738379, 1.0846002651345266, 0.8004217339540156, 0.6540545031196672, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
            { -0.5309702740698925, 0, 0.6187915573657604, 0, 0, 0, 0, 0, 0, 0, 1.0 },
            { 0.6410462672462507, 0.4427509176624381, 1.470970103352868, 1.0119723317532299, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real J[12];
            worst += planar2r_link_jacobian(q[i], link[i][0], point[i], J);
            here = fmax(here, error_of(J, expected[i] + 0, 12));
            for (size_t k = 0; k < 12; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("link_jacobian %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { -0.299496, -1.797202 },
            { -1.128763, 0.5999 },
            { 0.324535, 1.872399 },
            { -0.803419, 1.064284 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.873087, 0.949712 },
            { 0.193833, 0.399059 },
            { -0.003061, 1.659647 },
            { 1.044328, -1.258152 },
        };
        static const size_t link[4][1] = {
            { 1u },
            { 2u },
            { 1u },
            { 2u },
        };
        static const planar2r_real point[4][3] = {
            { 0.168348, 0.143761, 0.116896 },
            { 0.745414, 0.311283, 1.04161 },
            { -1.423994, -0.768014, 0.385198 },
            { -0.093864, -0.215861, -1.192381 },
        };
        static const double expected[4][6] = {
            { -0.7131604598401518, -0.30766466297667583 },
            { -0.2894760227820211, 0.054713746251964686 },
            { 1.0351340523868082e-05, 1.1074909331194391e-05 },
            { -0.3769809302330172, 0.40312072689191397 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real a[6];
            worst += planar2r_link_drift(q[i], qd[i], link[i][0], point[i], a);
            here = fmax(here, error_of(a, expected[i] + 0, 6));
            for (size_t k = 0; k < 6; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("link_drift %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real standard[4][20] = {
            { 1.089475, 0.143698, -0.072306, 1.551295, -1.694148, 1.190778, 0.766968, 0.558332, 1.64106, -1.762902, 0.400399, 1.412969, 1.205112, -1.042839, 1.412743, -1.049324, 1.987958, -0.533485, 1.791919, -1.323767 },
            { 1.613241, 1.208035, 1.197178, 0.500808, 0.803537, -1.830143, -0.85019, -1.775578, -0.264817, 1.110459, -1.734294, 0.099971, -1.501011, -1.911164, -0.096911, 1.920105, -0.597935, -0.189365, -0.34713, 1.57446 },
            { 0.67063, 1.534603, 1.875425, -0.548794, 0.986464, 1.49782, 1.912974, 1.591161, 0.652976, 0.372506, 0.722365, -0.239737, 1.765329, -0.066884, -1.849588, 1.087977, -1.127986, 1.417452, 0.228022, 1.828149 },
            { -1.212564, 1.845996, -0.075864, 1.510019, 1.733218, -1.770136, -1.463648, -1.355145, -1.868895, -0.109258, -1.586254, -1.963027, -1.187738, -1.951137, -0.118345, -0.45497, 0.734605, -1.311881, -0.648453, 0.763932 },
        };
        static const double expected[4][4] = {
            { 0.85983625, -1.049324, 1.987958, -0.533485 },
            { -1.436528, 1.920105, -0.597935, -0.189365 },
            { 1.95485725, 1.087977, -1.127986, 1.417452 },
            { -1.579153, -0.45497, 0.734605, -1.311881 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real X[4];
            planar2r_base_parameters(standard[i], X);
            here = fmax(here, error_of(X, expected[i] + 0, 4));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("base_parameters %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real X_in[4][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
            { 0.898583, 0.214296, 0.143341, -0.268162 },
            { 0.898583, 0.214296, 0.143341, -0.268162 },
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const size_t link[4][1] = {
            { 1u },
            { 2u },
            { 1u },
            { 2u },
        };
        static const planar2r_real mass[4][1] = {
            { 0.594256 },
            { 0.621717 },
            { 0.083416 },
            { 1.931636 },
        };
        static const planar2r_real com[4][3] = {
            { 1.921913, -0.923871, 1.562733 },
            { -1.58333, 1.510914, -0.265275 },
            { 0.988667, 0.657491, 1.709039 },
            { -1.882669, -0.527042, -0.719801 },
        };
        static const planar2r_real inertia[4][6] = {
            { -1.194498, -1.407754, -1.860691, -0.704881, 1.428368, 0.560468 },
            { -0.018833, -0.190371, 0.492237, -1.750451, 1.312885, -0.221078 },
            { -0.537452, -0.562532, 1.713988, -1.981874, 0.592029, 0.113663 },
            { -1.599914, 0.528762, 1.8772, 1.016865, -0.654611, 1.762523 },
        };
        static const double expected[4][4] = {
            { 4.161303704825018, 0.214296, 0.143341, -0.268162 },
            { 1.05401225, 2.971114980685896, -0.84104217761, 0.671198919338 },
            { 1.1298422775639294, 0.214296, 0.143341, -0.268162 },
            { 1.381492, 9.359948703420569, -3.493290216484, -1.286215300712 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real X[4];
            for (size_t k = 0; k < sizeof X / sizeof X[0]; ++k) {
                X[k] = X_in[i][k];
            }
            worst += planar2r_add_body(X, link[i][0], mass[i][0], com[i], inertia[i]);
            here = fmax(here, error_of(X, expected[i] + 0, 4));
            for (size_t k = 0; k < 4; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("add_body %.2e\n", here);
        worst = fmax(worst, here);
    }
    return worst <= 1e-13 ? 0 : 1;
}
