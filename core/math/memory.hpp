#pragma once
#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace flexopt {

/// Call at the beginning of a program: freed memory then stays with it. Matrices of whole
/// mechanisms come and go; asking the system for their pages each time costs an eighth of an
/// evaluation with derivatives.
inline void keep_freed_memory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 32 << 20);
  mallopt(M_TRIM_THRESHOLD, 512 << 20);
#endif
}

}  // namespace flexopt
