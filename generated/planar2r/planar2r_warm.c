/* planar2r: the code of the kernels is read as data, one byte of each cache line. */
#include "planar2r.h"

#ifdef planar2r_CODE_SECTION

#include <stdint.h>

/* Set by the linker. They are hidden, so that a shared library reads its own section. */
extern const unsigned char __start_planar2r_code[] __attribute__((visibility("hidden")));
extern const unsigned char __stop_planar2r_code[] __attribute__((visibility("hidden")));

/* It stands in the section itself, so that there is one where the linker drops all kernels. */
planar2r_IN_SECTION void planar2r_warm(void)
{
    const volatile unsigned char *const code = __start_planar2r_code;
    const uintptr_t begin = (uintptr_t)__start_planar2r_code;
    const uintptr_t end = (uintptr_t)__stop_planar2r_code;
    const size_t size = (size_t)(end - begin);
    for (size_t i = 0; i < size; i += 64u) {
        (void)code[i];
    }
    (void)code[size - 1u];
}

#else

void planar2r_warm(void)
{
}

#endif
