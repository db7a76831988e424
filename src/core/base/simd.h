// SPDX-FileCopyrightText: The planar_bin_picking authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>

/// Functions marked PBP_SIMD are compiled twice on x86-64, with and without AVX2, and the fitting
/// one is taken at run time. Elsewhere, and under sanitizers (which cannot run the resolver), once.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define PBP_SIMD __attribute__((target_clones("avx2", "default")))
#else
#define PBP_SIMD
#endif

/// Functions that a function marked PBP_SIMD calls are compiled with it where they are marked so;
/// others may be left to the lesser of the two.
#define PBP_INLINE inline __attribute__((always_inline))

/// The lanes of a vector of bytes in the order that follows it. GCC before 12 and Clang have no
/// common name for this.
#if defined(__clang__)
#define PBP_SHUFFLE(vector, ...) __builtin_shufflevector(vector, vector, __VA_ARGS__)
#else
#define PBP_SHUFFLE(vector, ...) __builtin_shuffle(vector, decltype(vector){__VA_ARGS__})
#endif

namespace planar_bin_picking {

/// 32 bytes added at once; the compiler splits it where registers are smaller.
typedef std::uint8_t ByteVector __attribute__((vector_size(32)));

/// The same of doubles.
typedef double DoubleVector __attribute__((vector_size(32)));
inline constexpr int kDoublesOfVector = 4;

/// The same of floats, and what comparing them gives.
typedef float FloatVector __attribute__((vector_size(32)));
typedef std::int32_t IntVector __attribute__((vector_size(32)));
inline constexpr int kFloatsOfVector = 8;

/// By pointer: a vector as a result would be passed in other ways with AVX2 and without.
PBP_INLINE void load(const double* numbers, DoubleVector* out) {
  std::memcpy(out, numbers, sizeof *out);
}
PBP_INLINE void load(const float* numbers, FloatVector* out) {
  std::memcpy(out, numbers, sizeof *out);
}

PBP_INLINE void store(const DoubleVector& vector, double* numbers) {
  std::memcpy(numbers, &vector, sizeof vector);
}

PBP_INLINE double sumOf(const DoubleVector& v) { return (v[0] + v[2]) + (v[1] + v[3]); }

/// Sum of the products of n numbers, a multiple of kDoublesOfVector.
PBP_INLINE double dot(const double* a, const double* b, int n) {
  DoubleVector sum = {};
  for (int i = 0; i < n; i += kDoublesOfVector) {
    DoubleVector u, v;
    load(a + i, &u);
    load(b + i, &v);
    sum += u * v;
  }
  return sumOf(sum);
}

}  // namespace planar_bin_picking
