// Laws are written once for CPU loops and, later, GPU kernels.
#pragma once

#ifdef __CUDACC__
#define VULNUS_HD __host__ __device__ __forceinline__
#else
#define VULNUS_HD inline __attribute__((always_inline))
#endif
