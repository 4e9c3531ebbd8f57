#pragma once
// Eigen's matrices lie in memory, and its kernels hand blocks to each other, as the compiler's
// flags say. A program compiled with other flags than the library would link, and then compute
// wrong numbers or crash. So the flags are part of a symbol's name, every object refers to its own,
// and the library defines the one that it was compiled with: other flags are an error of the
// linker.
#include <Eigen/Core>

namespace flexopt {

template <int bytes>
struct EigenMaxAlign {};
template <int bytes>
struct EigenMaxStaticAlign {};
template <int doubles>
struct EigenPacket {};
template <int count>
struct EigenRegisters {};
template <int rows>
struct EigenKernel {};

/// "undefined reference to flexopt::CompiledWith<…>": these flags are not the library's. Link the
/// target flexopt::core, which hands them on, and set no other -march, EIGEN_MAX_ALIGN_BYTES or
/// EIGEN_DONT_VECTORIZE.
template <class... Flags>
struct CompiledWith {
  static const char as_the_library_is;
};

using EigenLayout = CompiledWith<EigenMaxAlign<EIGEN_MAX_ALIGN_BYTES>,
                                 EigenMaxStaticAlign<EIGEN_MAX_STATIC_ALIGN_BYTES>,
                                 EigenPacket<Eigen::internal::packet_traits<double>::size>,
                                 EigenRegisters<EIGEN_ARCH_DEFAULT_NUMBER_OF_REGISTERS>,
                                 EigenKernel<Eigen::internal::gebp_traits<double, double>::mr>>;

template <>
const char EigenLayout::as_the_library_is;  // in eigen_layout.cpp

// Each object needs a symbol of its own; an inline variable would be merged with the library's.
[[gnu::used]] static const char* const eigen_layout = &EigenLayout::as_the_library_is;

}  // namespace flexopt
