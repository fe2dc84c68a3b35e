#pragma once

/// SCATMAP_CLONES before a function compiles it for the baseline, AVX2 and AVX-512 and picks one when the program
/// starts. It pays only where the compiler vectorises: a plain loop whose callees are all inlined, in a source file
/// listed by scatmap_kernel_sources() (lib/CMakeLists.txt), which sets the flags that the vectoriser needs.
/// Elsewhere (AArch64, other compilers) it is empty, and the loop is vectorised for the baseline: NEON there.
/// Under sanitizers too: the resolvers run before their runtime is up.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define SCATMAP_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define SCATMAP_CLONES
#endif

/// Inlined into each clone, or the clone calls a baseline copy and gains nothing.
#define SCATMAP_INLINE inline __attribute__((always_inline))
