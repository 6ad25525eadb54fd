// What this machine can do at most: memory bandwidth of a STREAM-like triad, and the rate of fused
// multiply-adds on vector registers, over the threads of OpenMP.
// Prints "name value" lines in bytes a second and floating point operations a second.
#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

namespace {

typedef float Lanes __attribute__((vector_size(64)));

double seconds() {
  using clock = std::chrono::steady_clock;
  return std::chrono::duration<double>(clock::now().time_since_epoch()).count();
}

// Smallest time of `repeats` calls [s].
template <class Work>
double fastest(int repeats, Work work) {
  double best = 1e30;
  for (int i = 0; i < repeats; ++i) {
    const double start = seconds();
    work();
    best = std::min(best, seconds() - start);
  }
  return best;
}

// a = b + s c over arrays of `bytes` each and thread; counts two reads and one write (what the
// caches read before they write is not counted, as in STREAM).
double triad_bytes_per_second(std::size_t bytes, int passes) {
  const std::size_t n = bytes / sizeof(Lanes);
  const int threads = omp_get_max_threads();
  std::vector<Lanes*> arrays(threads);
#pragma omp parallel
  {
    auto* p = static_cast<Lanes*>(std::aligned_alloc(64, 3 * n * sizeof(Lanes)));
    for (std::size_t i = 0; i < 3 * n; ++i) p[i] = Lanes{} + 1.0f;
    arrays[omp_get_thread_num()] = p;
  }
  const double time = fastest(7, [&] {
#pragma omp parallel
    {
      Lanes* a = arrays[omp_get_thread_num()];
      const Lanes* b = a + n;
      const Lanes* c = b + n;
      for (int pass = 0; pass < passes; ++pass) {
        for (std::size_t i = 0; i < n; ++i) a[i] = b[i] + 3.0f * c[i];
        asm volatile("" ::: "memory");
      }
    }
  });
  for (Lanes* p : arrays) std::free(p);
  return 3.0 * bytes * passes * threads / time;
}

// Sixteen independent chains of fused multiply-adds a thread: enough to hide their latency.
double multiply_adds_flops() {
  constexpr int kChains = 16;
  constexpr long kSteps = 20'000'000;
  std::vector<float> sink(omp_get_max_threads());
  const double time = fastest(3, [&] {
#pragma omp parallel
    {
      Lanes chain[kChains];
      for (int i = 0; i < kChains; ++i) chain[i] = Lanes{} + float(i);
      const Lanes scale = Lanes{} + 0.999f, shift = Lanes{} + 0.001f;
      for (long s = 0; s < kSteps; ++s)
#pragma GCC unroll 16
        for (int i = 0; i < kChains; ++i) chain[i] = chain[i] * scale + shift;
      Lanes sum{};
      for (const Lanes& c : chain) sum += c;
      sink[omp_get_thread_num()] = sum[0];
    }
  });
  return 2.0 * 16 * kChains * double(kSteps) * double(sink.size()) / time;
}

}  // namespace

int main() {
  std::printf("memory_bytes_per_s %.6g\n", triad_bytes_per_second(std::size_t(128) << 20, 1));
  std::printf("l2_bytes_per_s %.6g\n", triad_bytes_per_second(std::size_t(160) << 10, 2000));
  std::printf("flops_per_s %.6g\n", multiply_adds_flops());
}
