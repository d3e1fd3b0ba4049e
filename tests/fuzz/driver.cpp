// Runs a fuzz target without libFuzzer: every file of a corpus as it is, then a number of inputs
// made from them by seeded mutation. The same seed gives the same inputs everywhere.
//
//     fuzz_NAME CORPUS [RUNS [SEED]]     or     fuzz_NAME FILE
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "emulator/random.hpp"
#include "fuzz.hpp"

namespace {

using Input = std::vector<std::uint8_t>;
constexpr std::size_t kLongest = 4096;

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  Input make(const std::vector<Input>& corpus) {
    Input input = corpus[below(corpus.size())];
    for (std::size_t left = 1 + below(8); left > 0; --left) mutate(input, corpus);
    if (input.size() > kLongest) input.resize(kLongest);
    return input;
  }

 private:
  std::size_t below(std::size_t limit) { return random_.next() % limit; }
  std::ptrdiff_t place(const Input& input) {
    return static_cast<std::ptrdiff_t>(below(input.size() + 1));
  }

  void mutate(Input& input, const std::vector<Input>& corpus) {
    static constexpr std::uint8_t kEdges[] = {0x00, 0x01, 0x7F, 0x80, 0xFF, 0x40, 0x3F, 0x41};
    if (input.empty()) input.push_back(0);
    const std::size_t at = below(input.size());
    const auto begin = input.begin() + static_cast<std::ptrdiff_t>(at);
    const auto length =
        static_cast<std::ptrdiff_t>(1 + below(std::min<std::size_t>(input.size() - at, 64)));
    switch (below(7)) {
      case 0:
        input[at] = static_cast<std::uint8_t>(input[at] ^ (1U << below(8)));
        break;
      case 1:
        input[at] = kEdges[below(std::size(kEdges))];
        break;
      case 2:
        input[at] = static_cast<std::uint8_t>(random_.next());
        break;
      case 3:
        input.erase(begin, begin + length);
        break;
      case 4: {
        const Input piece(begin, begin + length);
        input.insert(input.begin() + place(input), piece.begin(), piece.end());
        break;
      }
      case 5: {
        const Input& other = corpus[below(corpus.size())];
        input.insert(input.begin() + place(input), other.begin(), other.end());
        break;
      }
      default:
        std::fill(begin, begin + length, kEdges[below(std::size(kEdges))]);
    }
  }

  torsio::emulator::Random random_;
};

Input read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 2) {
    std::fprintf(stderr, "usage: %s CORPUS [RUNS [SEED]], or %s FILE\n", arguments[0],
                 arguments[0]);
    return 2;
  }
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(arguments[1])) {
    for (const auto& entry : std::filesystem::directory_iterator(arguments[1])) {
      files.push_back(entry.path());
    }
  } else {
    files.emplace_back(arguments[1]);
  }
  std::ranges::sort(files);
  std::vector<Input> corpus;
  for (const auto& file : files) corpus.push_back(read(file));
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no input there\n", arguments[1]);
    return 2;
  }

  const long runs = count > 2 ? std::atol(arguments[2]) : 0;
  Mutator mutator(count > 3 ? std::strtoull(arguments[3], nullptr, 10) : 1);
  for (const Input& input : corpus) (void)LLVMFuzzerTestOneInput(input.data(), input.size());
  for (long run = 0; run < runs; ++run) {
    const Input input = mutator.make(corpus);
    // What is found can be run again: it is in the file when the process dies.
    std::ofstream("fuzz_last_input_" + std::filesystem::path(arguments[0]).filename().string(),
                  std::ios::binary)
        .write(reinterpret_cast<const char*>(input.data()),
               static_cast<std::streamsize>(input.size()));
    (void)LLVMFuzzerTestOneInput(input.data(), input.size());
  }
  std::printf("%zu inputs of the corpus and %ld made from them\n", corpus.size(), runs);
  return 0;
}
