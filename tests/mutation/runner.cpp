// Runs single test cases, each in a process of its own, with one mutant switched on. Reads lines of
//
//     MUTANT <tab> LIMIT_S <tab> NAME OF THE TEST CASE
//
// and answers each with "passed", "failed" or "hung", seconds of the processor, and the mutants
// that the test reached, separated by tabs. With --list it prints the names of all test cases
// instead.
#define DOCTEST_CONFIG_IMPLEMENT
#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <iostream>
#include <string>

extern "C" {
int torsio_mutant = 0;
unsigned char torsio_mutant_reached[TORSIO_MUTANTS + 1];
}

namespace {

/// doctest's pattern for this name.
std::string pattern(const std::string& name) {
  std::string escaped;
  for (const char c : name) {
    if (c == ',' || c == '\\') escaped += '\\';
    escaped += c;
  }
  return escaped;
}

[[noreturn]] void run_case(const std::string& name, int mutant, double limit_s,
                           unsigned char* reached) {
  const int nowhere = open("/dev/null", O_RDWR);
  for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
  // The kernel ends a process that hangs, with threads or without. It counts processor time, which
  // does not depend on other load, and the clock as a last resort.
  const auto microseconds = static_cast<long>(limit_s * 1e6);
  const itimerval limit{{}, {microseconds / 1'000'000, microseconds % 1'000'000}};
  const itimerval patience{{}, {20 * limit.it_value.tv_sec + 60, 0}};
  setitimer(ITIMER_PROF, &limit, nullptr);
  setitimer(ITIMER_REAL, &patience, nullptr);
  doctest::Context context;
  context.setOption("no-breaks", true);
  context.setOption("abort-after", 1);
  context.setOption("no-skip", true);
  context.setOption("test-case", pattern(name).c_str());
  torsio_mutant = mutant;
  const int result = context.run();
  std::memcpy(reached, torsio_mutant_reached, sizeof torsio_mutant_reached);
  _exit(result == 0 ? 0 : 1);
}

}  // namespace

int main(int count, char** arguments) {
  if (count > 1 && std::string(arguments[1]) == "--list") {
    const char* const words[] = {"", "--list-test-cases", "--no-skip", "--reporters=xml"};
    return doctest::Context(4, words).run();
  }
  auto* const reached =
      static_cast<unsigned char*>(mmap(nullptr, sizeof torsio_mutant_reached,
                                       PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0));
  std::string line;
  while (std::getline(std::cin, line)) {
    const std::size_t first = line.find('\t');
    const std::size_t second = line.find('\t', first + 1);
    const int mutant = std::stoi(line);
    const double limit_s = std::stod(line.substr(first + 1));
    const std::string name = line.substr(second + 1);
    std::memset(reached, 0, sizeof torsio_mutant_reached);
    std::cout.flush();
    const pid_t child = fork();
    if (child == 0) run_case(name, mutant, limit_s, reached);
    int status = 0;
    rusage usage{};
    wait4(child, &status, 0, &usage);
    const auto seconds = [](const timeval& time) {
      return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    const bool passed = WIFEXITED(status) && WEXITSTATUS(status) == 0;
    const bool hung =
        WIFSIGNALED(status) && (WTERMSIG(status) == SIGPROF || WTERMSIG(status) == SIGALRM);
    std::cout << (passed ? "passed"
                  : hung ? "hung"
                         : "failed")
              << '\t' << seconds(usage.ru_utime) + seconds(usage.ru_stime);
    for (int number = 1; number <= TORSIO_MUTANTS; ++number) {
      if (reached[number] != 0) std::cout << '\t' << number;
    }
    std::cout << std::endl;
  }
  return 0;
}
