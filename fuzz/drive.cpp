// Runs the target of a fuzzer on random bytes, one input for each seed: the same inputs on every machine, where a
// search by libFuzzer depends on its speed.
//
//   drive_remesh FIRST LAST [SECONDS]
//
// Input number FIRST, and so on to LAST - 1. An input is kept as file input-N while it runs, so that a crash leaves it,
// and if it takes more than SECONDS (5) of processor time. Prints the counts; returns 1 if any took longer.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <random>
#include <string>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::string input(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::string bytes(200 + random() % 800, '\0');
  for (char& byte : bytes) byte = static_cast<char>(random());
  return bytes;
}

double seconds_of(const std::string& bytes) {
  const std::clock_t began = std::clock();
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
  return static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
}

}  // namespace

int main(int count, char** words) {
  if (count < 3) {
    std::fprintf(stderr, "use: %s FIRST LAST [SECONDS]\n", words[0]);
    return 2;
  }
  const std::uint64_t first = std::strtoull(words[1], nullptr, 10);
  const std::uint64_t last = std::strtoull(words[2], nullptr, 10);
  const double limit = count > 3 ? std::atof(words[3]) : 5;
  std::uint64_t slow = 0;
  double longest = 0;
  for (std::uint64_t seed = first; seed < last; ++seed) {
    const std::string bytes = input(seed);
    const std::string name = "input-" + std::to_string(seed);
    std::ofstream(name, std::ios::binary) << bytes;
    const double seconds = seconds_of(bytes);
    longest = std::max(longest, seconds);
    if (seconds <= limit) std::remove(name.c_str());
    if (seconds > limit) std::printf("%s took %.1f s\n", name.c_str(), seconds);
    slow += seconds > limit ? 1 : 0;
    if ((seed + 1 - first) % 100 == 0 || seed + 1 == last) {
      std::printf("%llu runs, the longest %.2f s, %llu beyond %.0f s, %.0f s in all\n",
                  static_cast<unsigned long long>(seed + 1 - first), longest, static_cast<unsigned long long>(slow),
                  limit, static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
      std::fflush(stdout);
    }
  }
  return slow > 0 ? 1 : 0;
}
