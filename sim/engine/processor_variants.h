// Functions compiled for several instruction sets; the loader picks the widest that the processor
// has. Multiplications and additions are never fused, so all variants give the same bits.
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define GRAINTRUTH_FOR_EACH_PROCESSOR __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define GRAINTRUTH_FOR_EACH_PROCESSOR
#endif
