#include "hidraw_listing.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "protocol/usb_ids.hpp"

namespace torsio {
namespace {

namespace fs = std::filesystem;

/// Nothing if it cannot be read, for example because the device has just left.
std::string content(const fs::path& file) {
  const std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();  // an iterator would throw if the device leaves between opening and reading
  return text.str();
}

/// The value of a line `KEY=VALUE`; nothing if there is none.
std::string_view value(std::string_view text, std::string_view key) {
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    if (line.starts_with(key) && line.substr(key.size()).starts_with('=')) {
      return line.substr(key.size() + 1);
    }
  }
  return {};
}

/// `BUS:VENDOR:PRODUCT`, in hexadecimal.
bool is_ours(std::string_view hid_id) {
  std::array<std::uint32_t, 3> numbers{};
  for (std::uint32_t& number : numbers) {
    const std::string_view word = hid_id.substr(0, hid_id.find(':'));
    hid_id.remove_prefix(std::min(word.size() + 1, hid_id.size()));
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number, 16);
    if (error != std::errc() || end != word.data() + word.size()) return false;
  }
  return numbers[1] == protocol::usb_vendor_id && numbers[2] == protocol::usb_product_id;
}

/// Usage page and usage of a report descriptor's first collection (HID 1.11, section 6.2.2: short
/// items, whose prefix has the tag in its upper and the size in its lower bits).
std::pair<std::uint32_t, std::uint32_t> first_usage(std::string_view descriptor) {
  constexpr std::uint8_t kUsagePage = 0x04, kUsage = 0x08, kCollection = 0xA0;
  std::uint32_t page = 0;
  std::uint32_t usage = 0;
  while (!descriptor.empty()) {
    const auto prefix = static_cast<std::uint8_t>(descriptor.front());
    const std::size_t size = std::array{0U, 1U, 2U, 4U}[prefix & 0x03U];
    if (descriptor.size() < 1 + size) break;
    std::uint32_t number = 0;
    for (std::size_t i = 0; i < size; ++i) {
      number |= std::uint32_t{static_cast<std::uint8_t>(descriptor[1 + i])} << (8 * i);
    }
    const auto item = static_cast<std::uint8_t>(prefix & 0xFCU);
    if (item == kCollection) break;
    if (item == kUsagePage) page = number;
    if (item == kUsage) usage = number;
    descriptor.remove_prefix(1 + size);
  }
  return {page, usage};
}

/// A foreign device's text for the screen: printable ASCII.
std::string shown(std::string_view text) {
  std::string out(text.substr(0, text.find('\n')));
  std::ranges::replace_if(out, [](char c) { return c < 32 || c > 126; }, '?');
  return out;
}

std::optional<HidListing> look_at(const fs::path& entry) {
  const std::string hid = content(entry / "device/uevent");
  if (!is_ours(value(hid, "HID_ID"))) return std::nullopt;
  const std::pair<std::uint32_t, std::uint32_t> knob{protocol::usb_usage_page, protocol::usb_usage};
  if (first_usage(content(entry / "device/report_descriptor")) != knob) return std::nullopt;
  const std::string name(value(content(entry / "uevent"), "DEVNAME"));
  if (name.empty()) return std::nullopt;
  // The HID device is in its interface's folder, and that in the USB device's.
  std::error_code gone;
  const fs::path interface = fs::canonical(entry / "device", gone).parent_path();
  if (gone) return std::nullopt;
  return HidListing{.path = "/dev/" + name,
                    .serial = shown(value(hid, "HID_UNIQ")),
                    .product = shown(content(interface.parent_path() / "product"))};
}

}  // namespace

std::vector<HidListing> list_hidraw(const fs::path& devices) {
  std::vector<std::pair<std::size_t, fs::path>> entries;
  std::error_code failed;
  for (fs::directory_iterator at(devices, failed), end; !failed && at != end;
       at.increment(failed)) {
    const std::string name = at->path().filename().string();
    entries.emplace_back(name.size(), at->path());  // so that 9 comes before 10
  }
  std::ranges::sort(entries);
  std::vector<HidListing> found;
  for (const auto& [length, entry] : entries) {
    if (auto listing = look_at(entry)) found.push_back(*std::move(listing));
  }
  return found;
}

}  // namespace torsio
