// The way to new firmware: a device that waits for it.
#include <cstdint>
#include <string_view>

#include "conversion/field_check.hpp"
#include "session.hpp"
#include "torsio/error.hpp"
#include "torsio/knob.hpp"

namespace torsio {
namespace {

constexpr std::int64_t kAskAgainNs = 50'000'000;
constexpr int kAskings = 100;

}  // namespace

void start_bootloader(std::string_view selector, const OpenOptions& options) {
  // Not a Knob, which a device of another release cannot be: of the protocol this takes only what
  // has its place in every version.
  Session session(open_transport(selector, options),
                  {.command_timeout_ns = whole_ns("command_timeout_s", options.command_timeout_s),
                   .interrupted = options.interrupted});
  session.link.start();
  session.requests.command(protocol::Op::disarm);
  for (int asked = 1;; ++asked) {
    try {
      session.requests.command(protocol::Op::bootloader);
      break;
    } catch (const Refused& refused) {
      // The torque fades first.
      if (refused.status() != "not_disarmed" || asked == kAskings) throw;
    }
    session.link.sleep(kAskAgainNs);
  }
  session.close(false);
}

}  // namespace torsio
