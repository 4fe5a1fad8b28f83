#include "polhode/observe/kernel/target.hpp"

#include <cstdlib>
#include <string_view>

namespace polhode::brightness {

extern const Kernels k_kernels_baseline;
#ifdef POLHODE_X86_TARGETS
extern const Kernels k_kernels_avx2;
extern const Kernels k_kernels_avx512;
#endif

std::size_t kernels(const Kernels* out[3]) {
  std::size_t count = 0;
  out[count++] = &k_kernels_baseline;
#ifdef POLHODE_X86_TARGETS
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) out[count++] = &k_kernels_avx2;
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq")) out[count++] = &k_kernels_avx512;
#endif
  return count;
}

const Kernels& best_kernels() {
  static const Kernels* const best = [] {
    const Kernels* available[3];
    const std::size_t count = kernels(available);
    if (const char* wanted = std::getenv("POLHODE_TARGET")) {
      for (std::size_t i = 0; i < count; ++i) {
        if (std::string_view(wanted) == available[i]->name) return available[i];
      }
    }
    return available[count - 1];
  }();
  return *best;
}

}  // namespace polhode::brightness
