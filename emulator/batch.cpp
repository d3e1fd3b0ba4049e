#include "emulator/batch.hpp"

#include <algorithm>
#include <cstring>
#include <exception>
#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "emulator/plain_bytes.hpp"
#include "emulator/plant/require.hpp"

namespace torsio::emulator {
namespace {

constexpr unsigned kMostThreads = 4096;

BatchOptions checked(BatchOptions options) {
  require(options.threads >= 1 && options.threads <= kMostThreads,
          "threads must be 1 to 4096, is " + std::to_string(options.threads));
  require(options.seeds.size() == options.kind_of.size(), "one seed for each loop");
  for (const ClosedLoopOptions& kind : options.kinds) {
    require(!kind.spin_up, "a batch does no spin-up; begin with the state after it (initial)");
    require(!options.acts_hand || std::holds_alternative<TorqueHand>(kind.hand),
            "actions are torques of a hand, so the hand must be a TorqueHand");
  }
  for (const std::uint32_t kind : options.kind_of) {
    require(kind < options.kinds.size(), "a loop has an unknown kind");
  }
  options.threads = std::min(options.threads,
                             static_cast<unsigned>(std::max<std::size_t>(1, options.seeds.size())));
  return options;
}

/// Where several threads step, each takes so many shares: who is held up keeps the others waiting
/// for less.
constexpr std::size_t kSharesOfAThread = 4;

/// Ticks of loops, some 70 ns each, that are worth waking a thread.
constexpr std::uint64_t kTicksOfAThread = 200;

/// The failure of the first loop that fails in a share.
struct Failure {
  std::size_t loop = 0;
  std::exception_ptr error;
};

[[noreturn]] void rethrow(const Failure& failure) {
  const std::string which = "loop " + std::to_string(failure.loop) + ": ";
  try {
    std::rethrow_exception(failure.error);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(which + error.what());
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(which + error.what());
  }
}

}  // namespace

Batch::Batch(BatchOptions options)
    : options_(checked(std::move(options))),
      shares_(options_.threads == 1
                  ? 1
                  : static_cast<unsigned>(
                        std::min(options_.seeds.size(), options_.threads * kSharesOfAThread))),
      states_(options_.seeds.size()),
      actions_(options_.seeds.size()),
      failed_(options_.seeds.size()) {
  // Bytes between the columns would otherwise be whatever was in memory.
  if (!states_.empty()) {
    std::memset(static_cast<void*>(states_.data()), 0, states_.size() * sizeof(LoopRow));
  }
  constexpr std::size_t kNone = static_cast<std::size_t>(-1);
  begin_of_.resize(states_.size());
  loops_.reserve(states_.size());
  for (unsigned number = 0; number < shares_; ++number) {
    std::vector<std::size_t> begins(options_.kinds.size(), kNone);
    for (std::size_t loop = share(number).begin; loop < share(number).end; ++loop) {
      const std::uint32_t kind = options_.kind_of[loop];
      if (begins[kind] == kNone) {
        begins[kind] = begins_.size();
        begins_.emplace_back(options_.kinds[kind]);
        // The law does not act before the first action either.
        if (options_.acts_commands) begins_.back().hold_command({});
      }
      begin_of_[loop] = begins[kind];
      loops_.push_back(made(loop, options_.seeds[loop]));
      loops_.back().sense(&states_[loop]);
    }
  }
}

Batch::Share Batch::share(unsigned number) const {
  const std::size_t size = states_.size();
  return {size * number / shares_, size * (number + 1) / shares_};
}

ClosedLoop Batch::made(std::size_t loop, std::uint64_t seed) const {
  ClosedLoop begun = begins_[begin_of_[loop]];
  begun.set_seed(seed);
  return begun;
}

void Batch::step_one(std::size_t loop, std::uint64_t ticks) {
  ClosedLoop& one = loops_[loop];
  const BatchAction& action = actions_[loop];
  if (options_.acts_hand) one.set_hand_torque(action.hand_torque_nm);
  if (options_.acts_commands) {
    one.hold_command({action.motor_command_nm, action.brake_command_nm});
  }
  for (std::uint64_t i = ticks; i > 0; --i) {
    one.act();
    one.sense(i == 1 ? &states_[loop] : nullptr);
  }
}

void Batch::step(std::uint64_t ticks, bool goes_on) {
  if (!goes_on) std::ranges::fill(failed_, std::uint8_t{0});
  std::vector<Failure> failures(shares_);
  const std::uint64_t worth =
      1 + states_.size() * std::min(ticks, kTicksOfAThread) / kTicksOfAThread;
  const auto threads = static_cast<unsigned>(std::min<std::uint64_t>(worth, options_.threads));
  workers_.run(shares_, threads, [&](unsigned number) {
    const Share mine = share(number);
    for (std::size_t loop = mine.begin; loop < mine.end; ++loop) {
      if (failed_[loop] != 0) continue;
      try {
        step_one(loop, ticks);
      } catch (...) {
        failed_[loop] = 1;
        if (!failures[number].error) failures[number] = {loop, std::current_exception()};
      }
    }
  });
  for (const Failure& failure : failures) {
    if (failure.error) rethrow(failure);
  }
}

void Batch::reset(std::span<const std::uint32_t> loops, std::span<const std::uint64_t> seeds) {
  require(loops.size() == seeds.size(), "one seed for each loop that begins anew");
  for (const std::uint32_t loop : loops) {
    require(loop < loops_.size(), "there is no loop " + std::to_string(loop));
  }
  for (std::size_t i = 0; i < loops.size(); ++i) {
    loops_[loops[i]] = made(loops[i], seeds[i]);
    loops_[loops[i]].sense(&states_[loops[i]]);
  }
}

std::vector<std::uint8_t> Batch::save() const {
  for (const ClosedLoopOptions& kind : options_.kinds) {
    require(!kind.plant.electrics, "the state of a plant with electrics cannot be saved");
  }
  std::vector<std::uint8_t> saved;
  for (const ClosedLoop& loop : loops_) loop.save(saved);
  add_bytes(saved, std::span(states_));
  add_bytes(saved, std::span(actions_));
  return saved;
}

void Batch::restore(std::span<const std::uint8_t> from) {
  require(from.size() == save().size(), "the state is of other knobs");
  for (ClosedLoop& loop : loops_) from = loop.restore(from);
  take_bytes(take_bytes(from, std::span(states_)), std::span(actions_));
}

}  // namespace torsio::emulator
