// Why: most of the world's time goes into moving numbers between registers, of which processors since 2013 need less.
//
// A function marked so is compiled twice, for every x86 processor and for those with AVX2; the loader takes the one
// that fits. Both give the same bits, for nothing is contracted. What it calls is inlined, or else marked too.
// Sanitizers cannot run before the loader has chosen.
#pragma once

#if defined(__x86_64__) && !defined(__clang__) && __GNUC__ >= 12 && !defined(__SANITIZE_ADDRESS__) && \
    !defined(__SANITIZE_THREAD__)
#define HALFROLL_WIDE [[gnu::flatten, gnu::target_clones("arch=x86-64-v3", "default")]]
#else
#define HALFROLL_WIDE
#endif
