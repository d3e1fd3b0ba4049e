// Lists knobs, and opens one.
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "connection.hpp"
#include "emulated.hpp"
#include "emulated_transport.hpp"
#include "hid_transport.hpp"
#include "known_boards.hpp"
#include "protocol/codec.hpp"
#include "protocol/reports.hpp"
#include "torsio/error.hpp"
#include "torsio/knob.hpp"
#include "torsio/plant.hpp"

namespace torsio {
namespace {

constexpr std::string_view kEmulatedProduct = "Torsio emulated knob";

/// Asks a device what it is, without disturbing its user.
ListedDevice describe(const HidListing& hid) {
  ListedDevice listed{.path = hid.path,
                      .serial = hid.serial,
                      .product = hid.product,
                      .board = {},
                      .transport = "hid",
                      .problem = {}};
  try {
    const std::unique_ptr<Transport> transport = open_hid(hid.path);
    protocol::ReportBytes bytes{};
    protocol::Identity identity;
    if (transport->get_feature(protocol::Layout<protocol::Identity>::id, bytes) &&
        protocol::decode(bytes, identity).ok()) {
      listed.board = board_name(identity.board);
    }
  } catch (const Error& error) {
    listed.problem = error.what();
  }
  return listed;
}

/// Text with a NUL, or longer than any path element or serial number, is no name. Echoing it would
/// not help.
void check_selector(std::string_view selector) {
  constexpr std::size_t kLongest = 255;
  if (selector.size() > kLongest) {
    throw InvalidArgument("selector has " + std::to_string(selector.size()) +
                          " characters, allowed are up to " + std::to_string(kLongest));
  }
  if (selector.find('\0') != std::string_view::npos) {
    throw InvalidArgument("selector contains a NUL character; give a path or a serial number");
  }
}

std::string list_text(const std::vector<HidListing>& plugged_in) {
  if (plugged_in.empty()) {
    return std::string("no knob is plugged in") +
           (has_emulator() ? "; \"emulated\" opens one that needs no hardware" : "");
  }
  std::string text = "plugged in:";
  for (const HidListing& hid : plugged_in) {
    text += " " + hid.path + " (serial number " + hid.serial + ")";
  }
  return text;
}

/// @throws DeviceNotFound if nothing, or more than one thing, is meant
HidListing choose(std::string_view selector) {
  const std::vector<HidListing> plugged_in = list_hid();
  std::vector<HidListing> meant;
  for (const HidListing& hid : plugged_in) {
    if (selector.empty() || hid.path == selector || hid.serial == selector) meant.push_back(hid);
  }
  if (meant.size() == 1) return meant.front();
  if (meant.size() > 1) {
    throw DeviceNotFound("more than one knob is meant; name one by its path: " +
                         list_text(plugged_in));
  }
  if (selector.empty()) throw DeviceNotFound(list_text(plugged_in));
  // A path may be good although the system does not list it.
  std::error_code ignored;
  if (selector.starts_with('/') && std::filesystem::exists(selector, ignored)) {
    return {std::string(selector), {}, {}};
  }
  throw DeviceNotFound("there is no knob with path or serial number \"" + std::string(selector) +
                       "\"; " + list_text(plugged_in));
}

/// @throws as open_transport() does
Connection connect(std::string_view selector, const OpenOptions& options) {
  check_selector(selector);
  Connection connection;
  if (selects_emulated(selector)) {
    const std::string name(selector == kEmulated ? "" : selector.substr(kEmulated.size() + 1));
    if (selector != kEmulated && name.empty()) {
      throw InvalidArgument("\"emulated:\" lacks a name; write \"emulated:NAME\" or \"emulated\"");
    }
    connection = open_emulated(name, options.emulator.value_or(EmulatorOptions{}));
    connection.kind = kEmulated;
    connection.path = selector;
    connection.product = kEmulatedProduct;
  } else {
    if (options.emulator) {
      std::string message = "emulator options are only for an emulated knob, and ";
      message += selector.empty() ? std::string_view("an empty selector") : selector;
      throw InvalidArgument(message +
                            " means a real one: leave the options out, or open \"emulated\"");
    }
    const HidListing hid = choose(selector);
    connection.transport = open_hid(hid.path);
    connection.kind = "hid";
    connection.path = hid.path;
    connection.product = hid.product;
  }
  return connection;
}

}  // namespace

std::vector<ListedDevice> list_devices() {
  std::vector<ListedDevice> listed;
  for (const HidListing& hid : list_hid()) listed.push_back(describe(hid));
  if (has_emulator()) {
    listed.push_back({.path = std::string(kEmulated),
                      .serial = std::string(kEmulatedSerial),
                      .product = std::string(kEmulatedProduct),
                      .board = board_name(0),
                      .transport = std::string(kEmulated),
                      .problem = {}});
  }
  return listed;
}

std::unique_ptr<Transport> open_transport(std::string_view selector, const OpenOptions& options) {
  return std::move(connect(selector, options).transport);
}

Knob Knob::open(std::string_view selector, const OpenOptions& options) {
  return {connect(selector, options), options};
}

Knob Knob::open(std::unique_ptr<Transport> transport, const OpenOptions& options) {
  if (transport == nullptr) throw InvalidArgument("there is no transport to open a knob over");
  if (options.emulator) {
    throw InvalidArgument(
        "emulator options do not go with an open transport: give them to open_transport(), which "
        "makes an emulated knob");
  }
  return {Connection{.transport = std::move(transport), .kind = "own", .path = {}, .product = {}},
          options};
}

}  // namespace torsio
