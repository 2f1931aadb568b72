/* Vectors of GCC in the widest registers that the machine has.
 *
 * PEL_CLONES before a function compiles it for AVX2 and AVX-512 too and picks
 * at load time. The build contracts nothing (-ffp-contract=off), so all clones
 * round alike. A clone compiles what it inlines, so what it calls is
 * PEL_INLINE. */
#pragma once

#if defined __x86_64__ && defined __GNUC__ && !defined __clang__ &&            \
    !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__
#define PEL_CLONES                                                             \
    __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define PEL_CLONES
#endif
#define PEL_INLINE static inline __attribute__((always_inline))
