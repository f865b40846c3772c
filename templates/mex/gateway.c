{% macro width(a) %}{{ 1 if a.plain else p if a.name == "X" else a.size }}{% endmacro %}
{% macro place(k, a) %}{{ (k.outputs | map(attribute="name") | list).index(a.name) }}{% endmacro %}
{% set first = 0 if floating else 1 %}
/* {{ name }} in MATLAB and Octave: [out, ..] = {{ name }}_mex('kernel', in, ..). {{ name }}_build makes it.
 *
 * The kernels and their arrays are those of {{ name }}.h; matrices come out as matrices, frames as
 * (4, 4, links). One sample: vectors. N samples: inputs (N, n), and the samples are the first index of
 * vectors that come out, the last of matrices. X is one vector for all; a changed X comes out as a new one.
{% if known %}
 * {{ name }}_mex('values') returns the X of {{ name }}_values.h as a column.
{% endif %}
 */
#include <string.h>

#include "mex.h"

#include "{{ name }}.h"
{% if known %}
#include "{{ name }}_values.h"
{% endif %}

typedef struct {
    const char *name;
    size_t inputs;
    struct {
        const char *name;
        size_t width;
        int shared; /* nonzero: one for all samples */
        int links;  /* of a link's number: how many there are; otherwise 0 */
    } input[{{ inputs }}];
    size_t outputs;
    size_t shape[{{ outputs }}][3]; /* 0 for an index that an array does not have */
} kernel;

static const kernel kernels[] = {
{% for k in kernels %}
    { "{{ k.name }}", {{ k.inputs|length }}, { {% for a in k.inputs %}{ "{{ a.name }}", {{ width(a) }}, {{ 1 if a.shared or not k.batch else 0 }}, {{ a.last if a.link else 0 }} }, {% endfor %}}, {{ k.outputs|length }}, { {% for o in k.outputs %}{ {{ (o.shape + (0, 0))[:3] | join(", ") }} }, {% endfor %}} },
{% endfor %}
};

enum { KERNELS = sizeof kernels / sizeof kernels[0] };

/* Call a kernel. Returns 0; nonzero: the mass matrix is not positive definite. */
static int call(size_t index, {{ name }}_real in[][{{ widest }}], {{ name }}_real out[][{{ largest }}])
{
    switch (index) {
{% for k in kernels %}
    case {{ loop.index0 }}:
{% for a in k.inputs %}
{% if a.written %}
        (void)memcpy(out[{{ place(k, a) }}], in[{{ loop.index0 }}], {{ width(a) }} * sizeof in[{{ loop.index0 }}][0]);
{% endif %}
{% endfor %}
        {{ "return " if k.fallible }}{{ name }}_{{ k.name }}({% for a in k.arguments %}
{% if a.written %}out[{{ place(k, a) }}]{% else %}{{ "(size_t)" if a.link }}in[{{ loop.index0 }}]{{ "[0]" if a.plain }}{% endif %}{{ ", " if not loop.last }}{% endfor %});
{% if not k.fallible %}
        break;
{% endif %}
{% endfor %}
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
    mexErrMsgIdAndTxt("{{ name }}:kernel", "kernel %s; accepted: {{ kernels|map(attribute="name")|join(", ") }}",
        text != NULL ? text : "is no text");
    return 0;
}

/* Refuse what is no number of a link. */
static void check_link(double link, int links)
{
    for (int i = {{ first }}; i <= links; ++i) {
        if (link >= i && link <= i) {
            return;
        }
    }
    mexErrMsgIdAndTxt("{{ name }}:link", "link is %g; accepted: the number of a joint, {{ first }} to %d", link, links);
}

/* Samples in an input: rows of a matrix, 1 for a vector. */
static size_t samples_of(const char *name, size_t width, int shared, const mxArray *given)
{
    const size_t all = mxGetNumberOfElements(given);
    if (!mxIsDouble(given) || mxIsComplex(given) || mxIsSparse(given)
        || mxGetNumberOfDimensions(given) > 2) {
        mexErrMsgIdAndTxt("{{ name }}:type", "%s; accepted: a full real matrix of doubles", name);
    }
    if (all == width && (mxGetM(given) == 1 || mxGetN(given) == 1)) {
        return 1;
    }
    if (shared || mxGetN(given) != width) {
        mexErrMsgIdAndTxt("{{ name }}:size", "%s has %d by %d entries; accepted: %d%s", name,
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
static void store(const {{ name }}_real *from, const size_t *shape, size_t sample, size_t samples, double *to)
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

{% if known %}
/* Whether the values of the parameters are asked for. */
static int asks_values(int nrhs, const mxArray *prhs[])
{
    char word[8] = "";
    return nrhs == 1 && mxIsChar(prhs[0]) && mxGetString(prhs[0], word, sizeof word) == 0
           && strcmp(word, "values") == 0;
}

{% endif %}
void mexFunction(int nlhs, mxArray *plhs[], int nrhs, const mxArray *prhs[])
{
    {{ name }}_real in[{{ inputs }}][{{ widest }}];
    {{ name }}_real out[{{ outputs }}][{{ largest }}];
    const double *from[{{ inputs }}];
    size_t rows[{{ inputs }}];
    size_t samples = 1;
{% if known %}
    if (asks_values(nrhs, prhs)) {
        plhs[0] = mxCreateDoubleMatrix({{ p }}, 1, mxREAL);
        for (size_t i = 0; i < {{ p }}; ++i) {
            mxGetPr(plhs[0])[i] = (double){{ name }}_values[i];
        }
        return;
    }
{% endif %}
    const size_t index = find(nrhs > 0 ? prhs[0] : NULL);
    const kernel *k = &kernels[index];
    if ((size_t)nrhs != k->inputs + 1 || (nlhs > 1 && (size_t)nlhs > k->outputs)) {
        mexErrMsgIdAndTxt("{{ name }}:arguments", "%s; accepted: %d inputs, at most %d outputs", k->name,
            (int)k->inputs, (int)k->outputs);
    }
    for (size_t i = 0; i < k->inputs; ++i) {
        from[i] = mxGetPr(prhs[i + 1]);
        rows[i] = samples_of(k->input[i].name, k->input[i].width, k->input[i].shared, prhs[i + 1]);
        if (k->input[i].links != 0) {
            check_link(from[i][0], k->input[i].links);
        }
        if (rows[i] != samples && i > 0 && k->input[i].shared == 0) {
            mexErrMsgIdAndTxt("{{ name }}:size", "%s has %d samples, what is before it %d",
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
                in[i][j] = ({{ name }}_real)from[i][rows[i] == 1 ? j : s + rows[i] * j];
            }
        }
        if (call(index, in, out) != 0) {
            mexErrMsgIdAndTxt("{{ name }}:mass_matrix", "sample %d: the mass matrix is not positive definite",
                (int)s + 1);
        }
        for (size_t o = 0; o < k->outputs; ++o) {
            if (o == 0 || o < (size_t)nlhs) {
                store(out[o], k->shape[o], s, samples, mxGetPr(plhs[o]));
            }
        }
    }
}
