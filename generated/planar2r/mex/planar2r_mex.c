/* planar2r in MATLAB and Octave: [out, ..] = planar2r_mex('kernel', in, ..). planar2r_build makes it.
 *
 * The kernels and their arrays are those of planar2r.h; matrices come out as matrices, frames as
 * (4, 4, links). One sample: vectors. N samples: inputs (N, n), and the samples are the first index of
 * vectors that come out, the last of matrices. X is one vector for all; a changed X comes out as a new one.
 */
#include <string.h>

#include "mex.h"

#include "planar2r.h"

typedef struct {
    const char *name;
    size_t inputs;
    struct {
        const char *name;
        size_t width;
        int shared; /* nonzero: one for all samples */
        int links;  /* of a link's number: how many there are; otherwise 0 */
    } input[5];
    size_t outputs;
    size_t shape[3][3]; /* 0 for an index that an array does not have */
} kernel;

static const kernel kernels[] = {
    { "energy_regressor", 2, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, }, 1, { { 4, 0, 0 }, } },
    { "power_regressor", 3, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "qdd", 2, 0, 0 }, }, 1, { { 4, 0, 0 }, } },
    { "momentum_regressor", 2, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, }, 2, { { 2, 4, 0 }, { 2, 4, 0 }, } },
    { "torque_regressor", 3, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "qdd", 2, 0, 0 }, }, 1, { { 2, 4, 0 }, } },
    { "inverse_dynamics", 4, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "qdd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "mass_matrix", 2, { { "q", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 2, 0 }, } },
    { "gravity_torque", 2, { { "q", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "coriolis", 3, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 2, 0 }, } },
    { "bias_torque", 3, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "forward_dynamics", 4, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "tau", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "energy", 3, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 2, { { 1, 0, 0 }, { 1, 0, 0 }, } },
    { "frames", 1, { { "q", 2, 0, 0 }, }, 1, { { 2, 4, 4 }, } },
    { "jacobian", 1, { { "q", 2, 0, 0 }, }, 1, { { 6, 2, 0 }, } },
    { "slotine_li_regressor", 4, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "qdr", 2, 0, 0 }, { "qddr", 2, 0, 0 }, }, 1, { { 2, 4, 0 }, } },
    { "slotine_li_torque", 5, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "qdr", 2, 0, 0 }, { "qddr", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "generalized_momentum", 3, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 2, { { 2, 0, 0 }, { 2, 0, 0 }, } },
    { "friction", 2, { { "qd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "inverse_dynamics_derivatives", 4, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "qdd", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 2, { { 2, 2, 0 }, { 2, 2, 0 }, } },
    { "forward_dynamics_derivatives", 4, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "tau", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 3, { { 2, 2, 0 }, { 2, 2, 0 }, { 2, 2, 0 }, } },
    { "solve_mass_matrix", 3, { { "q", 2, 0, 0 }, { "b", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 1, { { 2, 0, 0 }, } },
    { "mass_matrix_factor", 2, { { "q", 2, 0, 0 }, { "X", 4, 1, 0 }, }, 2, { { 2, 2, 0 }, { 2, 0, 0 }, } },
    { "link_jacobian", 3, { { "q", 2, 0, 0 }, { "link", 1, 1, 2 }, { "point", 3, 0, 0 }, }, 1, { { 6, 2, 0 }, } },
    { "link_drift", 4, { { "q", 2, 0, 0 }, { "qd", 2, 0, 0 }, { "link", 1, 1, 2 }, { "point", 3, 0, 0 }, }, 1, { { 6, 0, 0 }, } },
    { "base_parameters", 1, { { "standard", 20, 1, 0 }, }, 1, { { 4, 0, 0 }, } },
    { "add_body", 5, { { "X", 4, 1, 0 }, { "link", 1, 1, 2 }, { "mass", 1, 1, 0 }, { "com", 3, 1, 0 }, { "inertia", 6, 1, 0 }, }, 1, { { 4, 0, 0 }, } },
};

enum { KERNELS = sizeof kernels / sizeof kernels[0] };

/* Call a kernel. Returns 0; nonzero: the mass matrix is not positive definite. */
static int call(size_t index, planar2r_real in[][20], planar2r_real out[][32])
{
    switch (index) {
    case 0:
        planar2r_energy_regressor(in[0], in[1], out[0]);
        break;
    case 1:
        planar2r_power_regressor(in[0], in[1], in[2], out[0]);
        break;
    case 2:
        planar2r_momentum_regressor(in[0], in[1], out[0], out[1]);
        break;
    case 3:
        planar2r_torque_regressor(in[0], in[1], in[2], out[0]);
        break;
    case 4:
        planar2r_inverse_dynamics(in[0], in[1], in[2], in[3], out[0]);
        break;
    case 5:
        planar2r_mass_matrix(in[0], in[1], out[0]);
        break;
    case 6:
        planar2r_gravity_torque(in[0], in[1], out[0]);
        break;
    case 7:
        planar2r_coriolis(in[0], in[1], in[2], out[0]);
        break;
    case 8:
        planar2r_bias_torque(in[0], in[1], in[2], out[0]);
        break;
    case 9:
        return planar2r_forward_dynamics(in[0], in[1], in[2], in[3], out[0]);
    case 10:
        planar2r_energy(in[0], in[1], in[2], out[0], out[1]);
        break;
    case 11:
        planar2r_frames(in[0], out[0]);
        break;
    case 12:
        planar2r_jacobian(in[0], out[0]);
        break;
    case 13:
        planar2r_slotine_li_regressor(in[0], in[1], in[2], in[3], out[0]);
        break;
    case 14:
        planar2r_slotine_li_torque(in[0], in[1], in[2], in[3], in[4], out[0]);
        break;
    case 15:
        planar2r_generalized_momentum(in[0], in[1], in[2], out[0], out[1]);
        break;
    case 16:
        planar2r_friction(in[0], in[1], out[0]);
        break;
    case 17:
        planar2r_inverse_dynamics_derivatives(in[0], in[1], in[2], in[3], out[0], out[1]);
        break;
    case 18:
        return planar2r_forward_dynamics_derivatives(in[0], in[1], in[2], in[3], out[0], out[1], out[2]);
    case 19:
        return planar2r_solve_mass_matrix(in[0], in[1], in[2], out[0]);
    case 20:
        return planar2r_mass_matrix_factor(in[0], in[1], out[0], out[1]);
    case 21:
        return planar2r_link_jacobian(in[0], (size_t)in[1][0], in[2], out[0]);
    case 22:
        return planar2r_link_drift(in[0], in[1], (size_t)in[2][0], in[3], out[0]);
    case 23:
        planar2r_base_parameters(in[0], out[0]);
        break;
    case 24:
        (void)memcpy(out[0], in[0], 4 * sizeof in[0][0]);
        return planar2r_add_body(out[0], (size_t)in[1][0], in[2][0], in[3], in[4]);
    default:
        break;
    }
    return 0;
}

static size_t find(const mxArray *word)
{
    char *text = word != NULL && mxIsChar(word) ? mxArrayToString(word) : NULL;
    for (size_t i = 0; text != NULL && i < KERNELS; ++i) {
        if (strcmp(text, kernels[i].name) == 0) {
            return i;
        }
    }
    mexErrMsgIdAndTxt("planar2r:kernel", "kernel %s; accepted: energy_regressor, power_regressor, momentum_regressor, torque_regressor, inverse_dynamics, mass_matrix, gravity_torque, coriolis, bias_torque, forward_dynamics, energy, frames, jacobian, slotine_li_regressor, slotine_li_torque, generalized_momentum, friction, inverse_dynamics_derivatives, forward_dynamics_derivatives, solve_mass_matrix, mass_matrix_factor, link_jacobian, link_drift, base_parameters, add_body",
        text != NULL ? text : "is no text");
    return 0;
}

/* Refuse what is no number of a link. */
static void check_link(double link, int links)
{
    for (int i = 1; i <= links; ++i) {
        if (link >= i && link <= i) {
            return;
        }
    }
    mexErrMsgIdAndTxt("planar2r:link", "link is %g; accepted: the number of a joint, 1 to %d", link, links);
}

/* Samples in an input: rows of a matrix, 1 for a vector. */
static size_t samples_of(const char *name, size_t width, int shared, const mxArray *given)
{
    const size_t all = mxGetNumberOfElements(given);
    if (!mxIsDouble(given) || mxIsComplex(given) || mxIsSparse(given)
        || mxGetNumberOfDimensions(given) > 2) {
        mexErrMsgIdAndTxt("planar2r:type", "%s; accepted: a full real matrix of doubles", name);
    }
    if (all == width && (mxGetM(given) == 1 || mxGetN(given) == 1)) {
        return 1;
    }
    if (shared || mxGetN(given) != width) {
        mexErrMsgIdAndTxt("planar2r:size", "%s has %d by %d entries; accepted: %d%s", name,
            (int)mxGetM(given), (int)mxGetN(given), (int)width,
            shared ? "" : ", and a row of as many for each sample");
    }
    return mxGetM(given);
}

/* An output for so many samples. */
static mxArray *allocate(const size_t *shape, size_t samples)
{
    mwSize dims[4] = { (mwSize)shape[0], 1, 1, (mwSize)samples };
    mwSize rank = 2;
    if (shape[2] != 0) { /* frames */
        dims[0] = (mwSize)shape[1];
        dims[1] = (mwSize)shape[2];
        dims[2] = (mwSize)shape[0];
        rank = samples == 1 ? 3 : 4;
    } else if (shape[1] != 0) {
        dims[1] = (mwSize)shape[1];
        dims[2] = (mwSize)samples;
        rank = samples == 1 ? 2 : 3;
    } else if (samples != 1) {
        dims[0] = (mwSize)samples;
        dims[1] = (mwSize)shape[0];
    }
    return mxCreateNumericArray(rank, dims, mxDOUBLE_CLASS, mxREAL);
}

/* Put a row-major array where MATLAB has it for this sample: column by column. */
static void store(const planar2r_real *from, const size_t *shape, size_t sample, size_t samples, double *to)
{
    const size_t blocks = shape[2] != 0 ? shape[0] : 1;
    const size_t rows = shape[2] != 0 ? shape[1] : shape[0];
    const size_t columns = shape[2] != 0 ? shape[2] : shape[1];
    for (size_t i = 0; columns == 0 && i < rows; ++i) {
        to[sample + samples * i] = (double)from[i];
    }
    for (size_t b = 0; b < blocks; ++b) {
        for (size_t i = 0; i < rows; ++i) {
            for (size_t j = 0; j < columns; ++j) {
                to[i + rows * (j + columns * (b + blocks * sample))]
                    = (double)from[j + columns * (i + rows * b)];
            }
        }
    }
}

void mexFunction(int nlhs, mxArray *plhs[], int nrhs, const mxArray *prhs[])
{
    planar2r_real in[5][20];
    planar2r_real out[3][32];
    const double *from[5];
    size_t rows[5];
    size_t samples = 1;
    const size_t index = find(nrhs > 0 ? prhs[0] : NULL);
    const kernel *k = &kernels[index];
    if ((size_t)nrhs != k->inputs + 1 || (nlhs > 1 && (size_t)nlhs > k->outputs)) {
        mexErrMsgIdAndTxt("planar2r:arguments", "%s; accepted: %d inputs, at most %d outputs", k->name,
            (int)k->inputs, (int)k->outputs);
    }
    for (size_t i = 0; i < k->inputs; ++i) {
        from[i] = mxGetPr(prhs[i + 1]);
        rows[i] = samples_of(k->input[i].name, k->input[i].width, k->input[i].shared, prhs[i + 1]);
        if (k->input[i].links != 0) {
            check_link(from[i][0], k->input[i].links);
        }
        if (rows[i] != samples && i > 0 && k->input[i].shared == 0) {
            mexErrMsgIdAndTxt("planar2r:size", "%s has %d samples, what is before it %d",
                k->input[i].name, (int)rows[i], (int)samples);
        }
        samples = i == 0 ? rows[i] : samples;
    }
    for (size_t o = 0; o < k->outputs; ++o) {
        if (o == 0 || o < (size_t)nlhs) {
            plhs[o] = allocate(k->shape[o], samples);
        }
    }
    for (size_t s = 0; s < samples; ++s) {
        for (size_t i = 0; i < k->inputs; ++i) {
            for (size_t j = 0; j < k->input[i].width; ++j) {
                in[i][j] = (planar2r_real)from[i][rows[i] == 1 ? j : s + rows[i] * j];
            }
        }
        if (call(index, in, out) != 0) {
            mexErrMsgIdAndTxt("planar2r:mass_matrix", "sample %d: the mass matrix is not positive definite",
                (int)s + 1);
        }
        for (size_t o = 0; o < k->outputs; ++o) {
            if (o == 0 || o < (size_t)nlhs) {
                store(out[o], k->shape[o], s, samples, mxGetPr(plhs[o]));
            }
        }
    }
}
