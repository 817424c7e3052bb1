/* Which jumps from a block of code to another one have run, for gcc -fsanitize-coverage=trace-pc.
   vectors.py builds it with the library, and keeps a layout where `fresh` grows. */
#include <stdint.h>

#define PLACES (1u << 22)

static uint8_t ran[PLACES];
__attribute__((visibility("default"))) uint32_t before, fresh;

void __attribute__((no_sanitize_coverage)) __sanitizer_cov_trace_pc(void) {
    /* relative to the library, wherever it is loaded */
    uint32_t now = (uint32_t)((uintptr_t)__builtin_return_address(0) - (uintptr_t)ran);
    uint32_t place = (before * 2654435761u ^ now) % PLACES;
    fresh += !ran[place];
    ran[place] = 1;
    before = now;
}
