/* Evaluations a second of NAME.cu, warm, between events of the device: one line of JSON for each N. */
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "panda_cuda.h"

static panda_real *filled(size_t count)
{
    std::vector<panda_real> values(count);
    for (size_t i = 0u; i < count; ++i) {
        values[i] = (panda_real)(0.1 + 0.8 * std::rand() / RAND_MAX);
    }
    void *place = nullptr;
    if (cudaMalloc(&place, count * sizeof(panda_real)) != cudaSuccess
        || cudaMemcpy(place, values.data(), count * sizeof(panda_real), cudaMemcpyHostToDevice)
            != cudaSuccess) {
        std::exit(1);
    }
    return static_cast<panda_real *>(place);
}

static int called(bool forward, size_t N, const panda_real *const *in, const panda_real *X, panda_real *out)
{
    return forward ? panda_forward_dynamics_cuda(nullptr, N, 0, in[0], in[1], in[2], X, out, nullptr)
                   : panda_inverse_dynamics_cuda(nullptr, N, 0, in[0], in[1], in[2], X, out);
}

int main()
{
    const size_t n = panda_JOINTS, largest = 4000000u;
    const panda_real *in[3] = {filled(n * largest), filled(n * largest), filled(n * largest)};
    const panda_real *X = filled(panda_PARAMETERS);
    panda_real *out = filled(n * largest);
    cudaEvent_t begun, ended;
    cudaEventCreate(&begun);
    cudaEventCreate(&ended);
    for (bool forward : {false, true}) {
        for (size_t N = 256u; N <= largest; N = N < 1000000u ? 4u * N : N + 3000000u) {
            const int repeats = 50;
            int failed = 0;
            for (int i = -5; i < repeats; ++i) { /* the first ones warm up */
                if (i == 0) {
                    cudaEventRecord(begun);
                }
                failed |= called(forward, N, in, X, out);
            }
            cudaEventRecord(ended);
            float ms = 0.0f;
            if (failed != 0 || cudaEventSynchronize(ended) != cudaSuccess
                || cudaEventElapsedTime(&ms, begun, ended) != cudaSuccess) {
                return 1;
            }
            const double rate = 1e3 * repeats * (double)N / ms;
            std::printf("{\"kernel\": \"%s\", \"N\": %zu, \"rate\": %g, \"GB_s\": %g}\n",
                forward ? "forward_dynamics" : "inverse_dynamics", N, rate,
                1e-9 * rate * (4.0 * n * sizeof(panda_real)));
        }
    }
    return 0;
}
