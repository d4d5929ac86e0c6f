#include "server/cli/cli.h"

#ifdef PHOTOND_NEEDS_AVX2
#include <unistd.h>

namespace {

// Runs before every other initialiser of the program (priorities below 101 are the compiler's own). This file
// is compiled without AVX2, so that the sentence gets out where anything else would end in an illegal
// instruction.
__attribute__((constructor(101))) void refuse_unsupported_cpu() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return;
  static constexpr char kMessage[] =
      "photond: this program was built for CPUs with AVX2, FMA and BMI2, which this machine lacks; rebuild "
      "with "
      "-DPHOTOND_AVX2=OFF\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, kMessage, sizeof kMessage - 1);
  _exit(1);
}

}  // namespace
#endif

int main(int argc, char** argv) { return photond::run_cli(argc, argv); }
