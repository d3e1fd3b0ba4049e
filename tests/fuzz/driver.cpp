// Runs a fuzz target without libFuzzer: every file of a corpus as it is, then inputs made from them
// by seeded mutation. Where the code was compiled with -fsanitize-coverage=trace-pc an input that
// reaches something new joins the corpus. The same seed gives the same inputs everywhere.
//
//     fuzz_NAME CORPUS [--runs N] [--seconds S] [--seed N] [--keep FOLDER] [--reached FILE]
//     fuzz_NAME FILE
//
// What an input did not survive is in fuzz_last_input_NAME, or beside it if the process hung.
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "emulator/random.hpp"
#include "fuzz.hpp"

// Coverage -----------------------------------------------------------------------------------

namespace {

// One bit for each reached place, by its distance from the program's begin, so that places stay the
// same from run to run. A call takes five bytes, so no two places share a multiple of four. Bits
// fit the processor's cache.
constexpr std::size_t kPlaces = std::size_t{1} << 25;
constexpr std::size_t kStep = 4;
constexpr std::size_t kBits = 32;
// Not on the heap: this is asked in every block, which is half of the time of some targets.
std::uint32_t places[kPlaces / (kStep * kBits)];
std::size_t places_reached = 0;
bool something_new = false;

}  // namespace

extern "C" {
extern const char __executable_start;
/// Called by the compiler's code at the begin of every block.
[[gnu::no_sanitize("address", "undefined"), gnu::optimize("O2", "omit-frame-pointer")]] void
__sanitizer_cov_trace_pc() {
  const auto at = static_cast<std::size_t>(static_cast<const char*>(__builtin_return_address(0)) -
                                           &__executable_start);
  if (at >= kPlaces) [[unlikely]] {
    return;
  }
  std::uint32_t& word = places[at / (kStep * kBits)];
  const std::uint32_t bit = 1U << (at / kStep % kBits);
  if ((word & bit) != 0) [[likely]] {
    return;
  }
  word |= bit;
  ++places_reached;
  something_new = true;
}
/// The sanitizer's notes on each piece of memory took a third of the time. An input that is run
/// again with ASAN_OPTIONS=malloc_context_size=30 says more.
const char* __asan_default_options() {
  return "malloc_context_size=1:quarantine_size_mb=16:max_malloc_fill_size=0";
}
// Functions that a target may bring along; libFuzzer's names.
[[gnu::weak]] std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                                  std::size_t max_size, unsigned seed);
}

namespace {

using Input = std::vector<std::uint8_t>;
// Long enough for two dozen reports. Longer inputs are slower and seldom show more.
constexpr std::size_t kLongest = 1536;
constexpr int kHungS = 20;

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {}

  void make(const std::vector<Input>& corpus, Input& input) {
    // The shorter of two: it runs faster and shows better what is new.
    const Input& one = corpus[below(corpus.size())];
    const Input& other = corpus[below(corpus.size())];
    input = one.size() < other.size() ? one : other;
    if (LLVMFuzzerCustomMutator != nullptr && below(4) != 0) {
      const std::size_t size = input.size();
      input.resize(kLongest);
      input.resize(LLVMFuzzerCustomMutator(input.data(), size, kLongest,
                                           static_cast<unsigned>(random_.next())));
      if (below(3) != 0) return;
    }
    for (std::size_t left = 1 + below(8); left > 0; --left) mutate(input, corpus);
    if (input.size() > kLongest) input.resize(kLongest);
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
    const auto words =
        fuzz::dictionary != nullptr ? fuzz::dictionary() : std::span<const std::string_view>{};
    switch (below(words.empty() ? 7 : 9)) {
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
      case 6:
        std::fill(begin, begin + length, kEdges[below(std::size(kEdges))]);
        break;
      default: {
        const std::string_view word = words[below(words.size())];
        input.insert(input.begin() + place(input), word.begin(), word.end());
      }
    }
  }

  torsio::emulator::Random random_;
};

/// The input that is being tried, in a file that outlives the process, however it ends.
class LastInput {
 public:
  explicit LastInput(const std::string& program) : name_("fuzz_last_input_" + program) {
    const int file = ::open(name_.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0644);
    if (file < 0 || ::ftruncate(file, kLongest + 8) != 0) {
      std::perror(name_.c_str());
      std::exit(2);
    }
    bytes_ = static_cast<std::uint8_t*>(
        ::mmap(nullptr, kLongest + 8, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
    ::close(file);
  }
  void keep(const Input& input) {
    std::copy(input.begin(), input.end(), bytes_);
    size_ = input.size();
    const std::uint64_t size = input.size();
    std::memcpy(bytes_ + kLongest, &size, sizeof size);
  }
  /// Nothing happened: no file is left.
  void forget() { ::unlink(name_.c_str()); }

 private:
  std::string name_;
  std::uint8_t* bytes_ = nullptr;
  std::size_t size_ = 0;
};

/// A file as it is, or one of LastInput, which has its size at its end.
Input read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  Input bytes{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  std::uint64_t size = 0;
  if (bytes.size() == kLongest + 8) {
    std::memcpy(&size, bytes.data() + kLongest, sizeof size);
    if (size <= kLongest) bytes.resize(size);
  }
  return bytes;
}

volatile long runs_done = 0;

/// Every few seconds: an input that is still the same hangs.
void look_whether_it_hangs(int) {
  static long seen = -1;
  const long now = runs_done;
  if (now == seen) {
    static constexpr char kText[] = "fuzz: an input hangs\n";
    (void)!::write(2, kText, sizeof kText - 1);
    std::abort();
  }
  seen = now;
}

struct Options {
  std::string corpus;
  long runs = 0;
  double seconds = 0;
  std::uint64_t seed = 1;
  std::string keep;
  std::string reached;
};

bool read_options(int count, char** arguments, Options& options) {
  if (count < 2) return false;
  options.corpus = arguments[1];
  for (int i = 2; i + 1 < count; i += 2) {
    const std::string_view name = arguments[i];
    const char* value = arguments[i + 1];
    if (name == "--runs") {
      options.runs = std::atol(value);
    } else if (name == "--seconds") {
      options.seconds = std::atof(value);
    } else if (name == "--seed") {
      options.seed = std::strtoull(value, nullptr, 10);
    } else if (name == "--keep") {
      options.keep = value;
    } else if (name == "--reached") {
      options.reached = value;
    } else {
      return false;
    }
  }
  return count % 2 == 0;
}

void save(const std::string& folder, const Input& input) {
  std::uint64_t hash = 14695981039346656037U;
  for (const std::uint8_t byte : input) hash = (hash ^ byte) * 1099511628211U;
  std::array<char, 20> name{};
  std::snprintf(name.data(), name.size(), "%016llx", static_cast<unsigned long long>(hash));
  std::ofstream(std::filesystem::path(folder) / name.data(), std::ios::binary)
      .write(reinterpret_cast<const char*>(input.data()),
             static_cast<std::streamsize>(input.size()));
}

std::vector<Input> read_corpus(const std::string& name) {
  std::vector<std::filesystem::path> files;
  if (std::filesystem::is_directory(name)) {
    for (const auto& entry : std::filesystem::directory_iterator(name)) {
      files.push_back(entry.path());
    }
  } else {
    files.emplace_back(name);
  }
  std::ranges::sort(files);
  std::vector<Input> corpus;
  for (const auto& file : files) {
    corpus.push_back(read(file));
    if (corpus.back().size() > kLongest) corpus.back().resize(kLongest);
  }
  return corpus;
}

}  // namespace

int main(int count, char** arguments) {
  using std::chrono::steady_clock;
  Options options;
  if (!read_options(count, arguments, options)) {
    std::fprintf(stderr,
                 "usage: %s CORPUS [--runs N] [--seconds S] [--seed N] [--keep FOLDER] "
                 "[--reached FILE], or %s FILE\n",
                 arguments[0], arguments[0]);
    return 2;
  }
  std::vector<Input> corpus = read_corpus(options.corpus);
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: no input there\n", arguments[1]);
    return 2;
  }
  signal(SIGALRM, look_whether_it_hangs);
  const itimerval every{{kHungS, 0}, {kHungS, 0}};
  ::setitimer(ITIMER_REAL, &every, nullptr);

  const std::string program = std::filesystem::path(arguments[0]).filename();
  LastInput last(program);
  const auto begin = steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(steady_clock::now() - begin).count();
  };
  const auto try_one = [&](const Input& input) {
    last.keep(input);
    something_new = false;
    (void)LLVMFuzzerTestOneInput(input.data(), input.size());
    runs_done = runs_done + 1;
  };
  const std::size_t given = corpus.size();
  // Nothing to be made: reduce the corpus. Keep the shortest inputs that together reach everything.
  const bool distils = options.runs == 0 && options.seconds == 0 && !options.keep.empty();
  if (distils) std::ranges::stable_sort(corpus, {}, &Input::size);
  for (const Input& input : corpus) {
    try_one(input);
    if (distils && something_new) save(options.keep, input);
  }

  Mutator mutator(options.seed);
  Input input;
  input.reserve(2 * kLongest);
  long made = 0;
  while (made < options.runs || (options.seconds > 0 && seconds() < options.seconds)) {
    mutator.make(corpus, input);
    try_one(input);
    ++made;
    if (!something_new) continue;
    corpus.push_back(input);
    if (!options.keep.empty()) save(options.keep, input);
  }
  const double took_s = std::max(seconds(), 1e-6);
  // Processor time of all threads, so that the machine's load does not matter.
  const double worked_s =
      std::max(static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC), 1e-6);
  last.forget();
  if (!options.reached.empty()) {
    std::ofstream file(options.reached);
    for (std::size_t at = 0; at < kPlaces; at += kStep) {
      if ((places[at / (kStep * kBits)] >> (at / kStep % kBits) & 1U) != 0) {
        file << std::hex << at << '\n';
      }
    }
  }
  std::printf(
      "%zu inputs of the corpus and %ld made from them, %.0f a second, %.0f a second of the "
      "processor; %zu kept, %zu places reached\n",
      given, made, static_cast<double>(runs_done) / took_s,
      static_cast<double>(runs_done) / worked_s, corpus.size() - given, places_reached);
  return 0;
}
