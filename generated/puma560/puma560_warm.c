/* puma560: the code of the kernels is read as data, one byte of each cache line. */
#include "puma560.h"

#ifdef puma560_CODE_SECTION

#include <stdint.h>

/* Set by the linker. They are hidden, so that a shared library reads its own section. */
extern const unsigned char __start_puma560_code[] __attribute__((visibility("hidden")));
extern const unsigned char __stop_puma560_code[] __attribute__((visibility("hidden")));

/* It stands in the section itself, so that there is one where the linker drops all kernels. */
puma560_IN_SECTION void puma560_warm(void)
{
    const volatile unsigned char *const code = __start_puma560_code;
    const uintptr_t begin = (uintptr_t)__start_puma560_code;
    const uintptr_t end = (uintptr_t)__stop_puma560_code;
    const size_t size = (size_t)(end - begin);
    for (size_t i = 0; i < size; i += 64u) {
        (void)code[i];
    }
    (void)code[size - 1u];
}

#else

void puma560_warm(void)
{
}

#endif
