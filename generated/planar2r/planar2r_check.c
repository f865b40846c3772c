/* planar2r: every kernel at seeded points against values computed with 50 digits.
 * Exit status 0 when each agrees to 1e-13 of its largest entry at any point.
 */
#include "planar2r.h"

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
            { 1.486974, -1.754932 },
            { -1.22401, 0.177681 },
            { -0.264304, -0.956753 },
        };
        static const planar2r_real qd[4][2] = {
            { -0.421786, 1.034122 },
            { 0.226495, 0.697876 },
            { 1.704489, -1.154115 },
            { 0.600335, 1.387477 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][52] = {
            { 1.4134740122599379, 0.364593506129969, 0.364593506129969, 0.214296, -0.0045151768797050025, 0.004076414696006428, 0, 0, 0.460643287310465, 0, 0.19444218126684443, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0, 0.38888436253368885, 0.92128657462093, 0, 0, -0.92128657462093, 0.38888436253368885, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0.998211257500635, -0.059785327623097004, 0, 0.19444218126684443, 0.059785327623097004, 0.998211257500635, 0, -0.460643287310465, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
            { 0.82300502171825, 0.06935901085912499, 0.06935901085912499, 0.214296, 0.036872423500558325, -0.002355135498437247, 0, 0, -0.49824448262599397, 0, 0.041862101389629466, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0, 0.08372420277925893, -0.9964889652519879, 0, 0, 0.9964889652519879, 0.08372420277925893, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0.9643135522331923, 0.26476286178277036, 0, 0.041862101389629466, -0.26476286178277036, 0.9643135522331923, 0, 0.49824448262599397, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
            { 1.3013602496723287, 0.3085366248361644, 0.3085366248361644, 0.214296, -0.31046931786981347, -0.3466074132936422, 0, 0, 0.4702349108365103, 0, 0.16993860253214743, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0, 0.33987720506429486, 0.9404698216730206, 0, 0, -0.9404698216730206, 0.33987720506429486, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0.5007519987108849, 0.8655908015841284, 0, 0.16993860253214743, -0.8655908015841284, 0.5007519987108849, 0, -0.4702349108365103, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
            { 0.9762932534518883, 0.14600312672594415, 0.14600312672594415, 0.214296, 0.48777362649516237, -0.048954307352102364, 0, 0, 0.13061875019331215, 0, 0.482637277982065, 0, 0, 0, 0, 0, 0, 0, 1.0, 1.0, 0.96527455596413, 0.2612375003866243, 0, 0, -0.2612375003866243, 0.96527455596413, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0.34265292651233786, 0.939462065201427, 0, 0.482637277982065, -0.939462065201427, 0.34265292651233786, 0, -0.13061875019331215, 0, 0, 1.0, 0, 0, 0, 0, 1.0 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real M[4];
            planar2r_real h[2];
            planar2r_real tau[2];
            planar2r_real J_out[12];
            planar2r_real T_out[32];
            planar2r_all_terms(q[i], qd[i], X[0], M, h, tau, J_out, T_out);
            here = fmax(here, error_of(M, expected[i] + 0, 4));
            here = fmax(here, error_of(h, expected[i] + 4, 2));
            here = fmax(here, error_of(tau, expected[i] + 6, 2));
            here = fmax(here, error_of(J_out, expected[i] + 8, 12));
            here = fmax(here, error_of(T_out, expected[i] + 20, 32));
            for (size_t k = 0; k < 52; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("all_terms %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real q[4][2] = {
            { 0.498595, 1.621827 },
            { 0.84618, -0.098021 },
            { 1.819151, -1.180596 },
            { 0.772675, -0.745544 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.764553, -0.96834 },
            { 1.191229, 1.640778 },
            { 1.02736, 1.901948 },
            { -1.059926, 1.106075 },
        };
        static const planar2r_real qdr[4][2] = {
            { 0.818363, 1.861023 },
            { -1.365132, 0.42864 },
            { 0.655721, -0.846932 },
            { 0.052018, -0.270793 },
        };
        static const planar2r_real qddr[4][2] = {
            { 0.255672, -0.306304 },
            { -0.649719, 1.297584 },
            { 1.278316, -1.588742 },
            { 1.751712, 1.647212 },
        };
        static const double expected[4][8] = {
            { 0.255672, -0.050632, 2.9301595660261945, -0.25231158005423143, 0, -0.050632, -0.7276032535006334, -0.09084028357813421 },
            { -0.649719, 0.647865, -0.05112522699461911, 0.5104303858623783, 0, 0.647865, -0.2437275404689692, -0.8409814824559677 },
            { 1.278316, -0.310426, -0.38643902433617683, 0.6822164872403919, 0, -0.310426, -0.06839327671484478, 0.7192358943740184 },
            { 1.751712, 3.398924, 1.9074115898190038, 1.7304770890277354, 0, 3.398924, 0.6622091115542289, 0.5739013841469301 },
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
            { 0.798956, -1.885354 },
            { -0.560576, -1.42821 },
            { -1.384608, -0.559077 },
            { -1.106069, 1.193525 },
        };
        static const planar2r_real qd[4][2] = {
            { 0.663399, 1.383729 },
            { -1.990153, -0.521202 },
            { 0.246034, 1.884394 },
            { -1.778995, 1.963175 },
        };
        static const planar2r_real qdr[4][2] = {
            { -0.859092, -1.942792 },
            { 1.833058, -1.13619 },
            { 1.720063, 1.202075 },
            { -1.568939, 0.991407 },
        };
        static const planar2r_real qddr[4][2] = {
            { -1.649052, -0.240803 },
            { -1.976872, 1.490917 },
            { 1.516712, -1.247535 },
            { 1.2574, -1.462883 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { -1.4948798759353328, -0.1429641411665476 },
            { -1.4079256524234882, 0.4664125638731248 },
            { 2.2821595976855114, -0.02221814426375559 },
            { 1.2946836595250264, 0.1940109308723324 },
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
            { 0.313154, -1.895261 },
            { -1.46721, 1.432078 },
            { 0.031104, 0.048254 },
            { -1.572366, 1.983809 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.915268, 1.698342 },
            { 1.31574, -1.733316 },
            { 1.328712, -1.547988 },
            { 1.9829, 0.74809 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][4] = {
            { 1.666445313913384, 0.48721930260877794, 0, 0.17431052099406902 },
            { 1.2209875882847006, 0.09827541467704652, 0, 0.02881283479076366 },
            { 1.2335645284222005, 0.05672199399491505, 0, -0.03801242488563861 },
            { 2.8103369404354495, 0.7717131001708425, 0, -0.6469109827551105 },
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
            { 1.637601, -1.662964 },
            { 0.779552, 0.498207 },
            { 1.400693, 1.821662 },
            { -0.068957, 1.146814 },
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
            { -0.179317, -1.831248 },
            { 0.907557, 0.316352 },
            { 0.860227, 0.223457 },
            { 0.144837, 1.056159 },
        };
        static const planar2r_real qd[4][2] = {
            { 1.743232, -0.831894 },
            { -0.840046, 0.375551 },
            { -0.813543, 1.952107 },
            { -0.01376, -1.112435 },
        };
        static const planar2r_real qdd[4][2] = {
            { 1.945388, -1.637066 },
            { 0.149571, -1.390349 },
            { 0.943064, -1.179604 },
            { 1.46972, -1.931597 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][8] = {
            { 0, -0.24860483568041053, 0, -0.3822435713469657, -0.0577753451647047, 0.06329276026959162, -0.12106810543429632 },
            { 0, -0.06091276261535714, 0, 0.093226766138139, 0.07896383260432512, -0.097665311570322, 0.17662914417464712 },
            { 0, 0.01796037159191809, 0, 0.17424635528476504, 0.44845771856254724, 0.26156241121897933, 0.18689530734356793 },
            { 0, -0.18910559827204992, 0, 0.005334654429202776, -0.008032064643622442, -0.008131415355795509, 9.935071217306611e-05 },
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
            { 1.421559, -1.615553 },
            { 1.645101, -1.640672 },
            { 1.767538, -1.879869 },
            { -1.458236, -0.836598 },
        };
        static const planar2r_real qd[4][2] = {
            { -0.448939, 1.100962 },
            { -1.939818, 1.625045 },
            { -1.172896, 0.738779 },
            { -1.092949, 0.505673 },
        };
        static const planar2r_real tau[4][2] = {
            { 1.186437, 1.951778 },
            { -1.214298, -1.577983 },
            { 1.697922, -1.413874 },
            { -1.795384, 1.665854 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][12] = {
            { 0, -0.8512960872239942, 0, 0.26010828154310334, -0.152000645290647, -0.10550665940465635, -0.2201385562272532, 0.03798045170307267, 1.2333462795219272, -0.44398191608822357, -0.44398191608822357, 4.82626797959507 },
            { 0, 0.946039325489687, 0, 2.286878497992617, -0.1446330407306413, 0.04836723062534487, -1.0739017290548036, -0.017049202637390418, 1.2364964536394403, -0.43585870693755746, -0.43585870693755746, 4.82008065337362 },
            { 0, 0.23695231465539196, 0, 0.5416066234424263, -0.026601791982961986, 0.030051130539309384, -0.2928829878159828, -0.009082522268328085, 1.2590532077474763, -0.38053073515546887, -0.38053073515546887, 4.7814526225951495 },
            { 0, -1.1180071067476032, 0, 3.4479813689822336, 0.10476032416322577, 0.18958178745677526, -1.5386265979782627, -0.14400453757852608, 1.1284167620495118, -0.8571347289984121, -0.8571347289984121, 5.3175141328977755 },
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
            { 0.624587, -0.028702 },
            { -0.791445, 0.401424 },
            { -0.771824, 1.591668 },
            { -0.400958, 1.273711 },
        };
        static const planar2r_real b[4][2] = {
            { -0.503675, 1.477972 },
            { -1.789793, -0.529285 },
            { 0.269203, -0.872326 },
            { -0.226721, -0.612034 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][2] = {
            { -2.792276363560771, 10.572492122130146 },
            { -1.1619757485333249, -0.6661061896369892 },
            { 2.058710663571532, -7.4028164590692205 },
            { 1.0209818932912313, -4.587787088674922 },
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
            { -1.108855, -1.532395 },
            { 1.035358, 0.108295 },
            { 0.772377, -0.261278 },
            { 1.087746, -0.4078 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][6] = {
            { 1.0, 0.3876200014316042, 0, 1.0, 0.8182200150518781, 0.214296 },
            { 1.0, 1.4001128267860226, 0, 1.0, 0.8642762946088869, 0.214296 },
            { 1.0, 1.16147227930532, 0, 1.0, 0.8929955967495049, 0.214296 },
            { 1.0, 1.0588808099253808, 0, 1.0, 0.8978400465304875, 0.214296 },
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
            { -0.750634, 0.811211 },
            { -1.797202, 1.873087 },
            { 0.116896, -1.128763 },
            { 0.745414, 0.311283 },
        };
        static const size_t link[4][1] = {
            { 1u },
            { 2u },
            { 1u },
            { 2u },
        };
        static const planar2r_real point[4][3] = {
            { 0.749702, -0.277501, -0.299496 },
            { 0.949712, 0.168348, 0.143761 },
            { 0.5999, 0.193833, 0.399059 },
            { 1.04161, 0.324535, 1.872399 },
        };
        static const double expected[4][12] = {
            { 0.7142980462109848, 0, 0.35894037803536377, 0, 0, 0, 0, 0, 0, 0, 1.0 },
            { 0.24737650444352435, -0.23986326029699714, 0.8219778157512744, 0.934216007360019, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
            { -0.26247648642623467, 0, 0.5731992114111277, 0, 0, 0, 0, 0, 0, 0, 1.0 },
            { -1.405695691658889, -1.066557652289999, 0.5970318283750096, 0.2296282488428754, 0, 0, 0, 0, 0, 0, 1.0, 1.0 },
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
            { -0.003061, 1.659647 },
            { 1.044328, -1.258152 },
            { -0.072306, 1.551295 },
            { -1.762902, 0.400399 },
        };
        static const planar2r_real qd[4][2] = {
            { -1.423994, -0.768014 },
            { -0.093864, -0.215861 },
            { -1.694148, 1.190778 },
            { 1.412969, 1.205112 },
        };
        static const size_t link[4][1] = {
            { 1u },
            { 2u },
            { 1u },
            { 2u },
        };
        static const planar2r_real point[4][3] = {
            { 0.385198, -0.803419, 1.064284 },
            { -1.192381, 1.089475, 0.143698 },
            { 0.766968, 0.558332, 1.64106 },
            { -1.042839, 1.412743, -1.049324 },
        };
        static const double expected[4][6] = {
            { -0.7760982282429633, 1.6315233137690217 },
            { 0.08738866752473745, -0.1302136881264332 },
            { -2.3113203760834016, -1.4392735705687114 },
            { -7.8054030397297725, -8.016043375463306 },
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
        static const planar2r_real q[4][2] = {
            { 1.987958, -0.533485 },
            { 1.110459, -1.734294 },
            { 1.875425, -0.548794 },
            { 1.087977, -1.127986 },
        };
        static const size_t link[4][1] = {
            { 1u },
            { 2u },
            { 1u },
            { 2u },
        };
        static const planar2r_real point[4][3] = {
            { 1.791919, -1.323767, 1.613241 },
            { 0.099971, -1.501011, -1.911164 },
            { 0.986464, 1.49782, 1.912974 },
            { 1.417452, 0.228022, 1.828149 },
        };
        static const planar2r_real select[4][6] = {
            { 1.208035, 1.197178, 0.500808, 0.803537, -1.830143, -0.85019 },
            { -0.096911, 1.920105, -0.597935, -0.189365, -0.34713, 1.57446 },
            { 1.591161, 0.652976, 0.372506, 0.722365, -0.239737, 1.765329 },
            { -1.212564, 1.845996, -0.075864, 1.510019, 1.733218, -1.770136 },
        };
        static const planar2r_real tau[4][2] = {
            { -1.775578, -0.264817 },
            { 0.67063, 1.534603 },
            { -0.066884, -1.849588 },
            { -1.463648, -1.355145 },
        };
        static const planar2r_real X[1][4] = {
            { 0.898583, 0.214296, 0.143341, -0.268162 },
        };
        static const double expected[4][50] = {
            { 1.6128962216545755, 6.7548254563967305, 0, 0, 0, 0.07990371950632874, 6.7548254563967305, 30.78298167023046, 0, 0, 0, -0.00010996246854749991, 0, 0, 2.0097221737645783, 0, 0, 0, 0, 0, 0, 20.818255599051437, 0, 0, 0, 0, 0, 0, -0.22849056170469903, 0, 0.07990371950632874, -0.00010996246854749991, 0, 0, 0, -0.24835913113333052, -0.4332837923398936, 0.11128302293282613, 0, 0, 0, 0.0013163815271970277, 0.4201940540424632, -0.10792110247124803, 0, 0, 0, -0.0012766129275050646, 0.04939918112987814, -0.264817 },
            { 0.021210668032503655, 0.007957991898187276, 0, 0, 0, 0.13651528135665514, 0.007957991898187276, 2.5685276466114813, 0, 0, 0, 2.4465308010476106, 0, 0, -0.23417242688787424, 0, 0, 0, 0, 0, 0, -0.13386572791228424, 0, 0, 0, 0, 0, 0, -0.191281572200714, 0, 0.13651528135665514, 2.4465308010476106, 0, 0, 0, 2.5015389232818723, 0.1730623054437254, 1.3052816628254518, 0, 0, 0, 1.4627296352050472, 0.8772106373683606, -0.7699058313902952, 0, 0, 0, 0.3780990292976571, -2.0070971976481187, -1.21021598894379 },
            { 4.718178969260454, -0.66483898607632, 0, 0, 0, 1.7048117580551485, -0.66483898607632, 4.481196133299443, 0, 0, 0, 2.4130521610231863, 0, 0, 0.9460500594540148, 0, 0, 0, 0, 0, 0, 9.371481807389989, 0, 0, 0, 0, 0, 0, -0.1559825229263777, 0, 1.7048117580551485, 2.4130521610231863, 0, 0, 0, 2.6825198862186026, 0.07374554635233274, -0.29691579322471423, 0, 0, 0, 0.7613656028644153, -0.07071771444207513, 0.28472507584782947, 0, 0, 0, -0.7301055853887637, -2.8331107066165617, -1.849588 },
            { -0.19281187335556005, -0.03577339109749607, 0, 0, 0, 0.0050445397750394924, -0.03577339109749607, -0.03698447735819942, 0, 0, 0, -0.14806141305260231, 0, 0, -0.06554219568658146, 0, 0, 0, 0, 0, 0, 5.805099942589279, 0, 0, 0, 0, 0, 0, 3.2239400289964752, 0, 0.0050445397750394924, -0.14806141305260231, 0, 0, 0, -0.22810084185602147, -0.20832699602453966, 0.03643183042437367, 0, 0, 0, -0.06313074822789798, -0.5472439359781613, 0.7131887934334119, 0, 0, 0, 0.10748518594884537, 0.783410560382974, 1.016855659218673 },
        };
        double here = 0.0;
        double scale = 0.0;
        for (size_t i = 0; i < 4; ++i) {
            planar2r_real Lambda_out[36];
            planar2r_real inverse_out[12];
            planar2r_real null_out[2];
            worst += planar2r_operational_space(q[i], link[i][0], point[i], select[i], tau[i], X[0], Lambda_out, inverse_out, null_out);
            here = fmax(here, error_of(Lambda_out, expected[i] + 0, 36));
            here = fmax(here, error_of(inverse_out, expected[i] + 36, 12));
            here = fmax(here, error_of(null_out, expected[i] + 48, 2));
            for (size_t k = 0; k < 50; ++k) {
                scale = fmax(scale, fabs(expected[i][k]));
            }
        }
        here /= scale > 0.0 ? scale : 1.0;
        printf("operational_space %.2e\n", here);
        worst = fmax(worst, here);
    }
    {
        static const planar2r_real standard[4][20] = {
            { -1.868895, -0.109258, -1.586254, -1.963027, -1.187738, -1.951137, -0.118345, -0.45497, 0.734605, -1.311881, -0.648453, 0.763932, 0.594256, 1.921913, -0.923871, 1.562733, -1.194498, -1.407754, -1.860691, -0.704881 },
            { 1.428368, 0.560468, 0.621717, -1.58333, 1.510914, -0.265275, -0.018833, -0.190371, 0.492237, -1.750451, 1.312885, -0.221078, 0.083416, 0.988667, 0.657491, 1.709039, -0.537452, -0.562532, 1.713988, -1.981874 },
            { 0.592029, 0.113663, 1.931636, -1.882669, -0.527042, -0.719801, -1.599914, 0.528762, 1.8772, 1.016865, -0.654611, 1.762523, -1.684535, 1.657677, 1.630084, -0.4577, 0.983924, 1.765368, 1.606095, -1.483688 },
            { -1.16656, 1.019224, -0.087275, -1.760944, 0.456791, 0.777478, -0.462473, 1.376148, 1.725979, -0.058205, 0.077734, -0.037324, 0.784477, -1.418797, -0.583478, 0.321711, 1.995746, 0.495237, 1.983342, 0.672821 },
        };
        static const double expected[4][4] = {
            { -2.12735725, 1.562733, -1.194498, -1.407754 },
            { -0.7607435, 1.709039, -0.537452, -0.562532 },
            { -1.090723, -0.4577, 0.983924, 1.765368 },
            { 0.94568325, 0.321711, 1.995746, 0.495237 },
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
            { -1.055603 },
            { -1.25931 },
            { -1.342548 },
            { 0.937986 },
        };
        static const planar2r_real com[4][3] = {
            { -1.120671, -1.247535, 1.363756 },
            { -1.150885, -0.921772, -1.306771 },
            { -0.734697, -1.208754, -0.427537 },
            { -1.309964, 1.295555, 1.528206 },
        };
        static const planar2r_real inertia[4][6] = {
            { -0.413044, 1.485366, 0.888063, -0.962161, 1.762166, 1.028144 },
            { -0.551766, -0.203775, 1.62343, 1.00857, 1.027329, -1.945042 },
            { 1.330499, 0.238559, 0.936156, 1.801147, 0.624332, 0.877418 },
            { 0.572176, 0.039307, -0.783144, 1.406816, 0.287989, 0.544667 },
        };
        static const double expected[4][4] = {
            { -1.041889440102709, 0.214296, 0.143341, -0.268162 },
            { 0.5837555, -4.4687376801101255, 1.59266198935, 0.89263469732 },
            { -0.9102575315452001, 0.214296, 0.143341, -0.268162 },
            { 1.1330795, 3.9429268735249474, -1.085386892504, 0.94705045223 },
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
