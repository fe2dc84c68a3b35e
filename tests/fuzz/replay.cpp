// Gives every file of a corpus folder to a fuzz target, without libFuzzer: any compiler, seconds, part of the tests.
// Proves only that these inputs neither crash nor hang it; tests/fuzz/run.sh looks for new ones.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <vector>

#include "fuzz/input_file.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t*, std::size_t size, std::size_t) { return size; }

int main(int argc, char** argv) {
  namespace fs = std::filesystem;
  if (argc != 2 || !fs::is_directory(argv[1])) {
    std::fprintf(stderr, "usage: replay CORPUS_FOLDER\n");
    return 2;
  }
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(argv[1])) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  constexpr double kSlowest_s = 5;
  bool slow = false;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    const auto begin = std::chrono::steady_clock::now();
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    const double took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (took_s <= kSlowest_s) continue;
    std::fprintf(stderr, "%s took %.1f s\n", file.c_str(), took_s);
    slow = true;
  }
  std::printf("%zu files\n", files.size());
  return slow || files.empty() ? 1 : 0;
}
