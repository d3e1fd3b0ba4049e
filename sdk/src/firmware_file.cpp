// UF2 files (https://github.com/microsoft/uf2), which a boot loader takes like a memory stick.
// Blocks have 512 bytes with an address, a number and the chip's family.
#include "firmware_file.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>

#include "path_text.hpp"
#include "protocol_names.hpp"
#include "torsio/error.hpp"

namespace torsio {
namespace {

constexpr std::size_t kBlockBytes = 512;
constexpr std::size_t kPageBytes = 256;
constexpr std::size_t kHeaderBytes = 32;
// A block for each page of all the flash that there can be, and the leading one.
constexpr std::size_t kMostBytes = std::size_t{33} << 20U;
constexpr std::uint32_t kBegin = 0x0A324655;
constexpr std::uint32_t kBegin2 = 0x9E5D5157;
constexpr std::uint32_t kEnd = 0x0AB16F30;
constexpr std::uint32_t kNotFlash = 0x0001;
constexpr std::uint32_t kHasFamily = 0x2000;
constexpr std::uint32_t kFlashBegin = 0x10000000;
constexpr std::uint32_t kFlashEnd = 0x11000000;
constexpr std::uint32_t kRp2040 = 0xE48BFF56;
constexpr std::uint32_t kRp2350 = 0xE48BFF59;
// A block that files for the RP2350 begin with because of a bug of its first chips (erratum E10).
constexpr std::uint32_t kLeadingFamily = 0xE48BFF57;
constexpr std::uint32_t kLeadingAddress = 0x10FFFF00;

// firmware/boards/rp2/firmware_label.hpp has the same.
constexpr std::string_view kMark("torsio firmware\0", 16);
constexpr std::size_t kChecksumAt = 40;
constexpr std::size_t kLabelBytes = 44;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    value |= std::uint32_t{static_cast<unsigned char>(bytes[at + i])} << (8 * i);
  }
  return value;
}

[[noreturn]] void reject_file(const std::string& why) { throw InvalidArgument(why); }

struct Block {
  std::size_t place;  // in the file, from 0
  std::uint32_t flags, address, number, count, family;
  std::string_view payload;
};

Block block_at(std::string_view file, std::size_t place) {
  const std::string_view bytes = file.substr(place * kBlockBytes, kBlockBytes);
  if (word_at(bytes, 0) != kBegin || word_at(bytes, 4) != kBegin2 ||
      word_at(bytes, kBlockBytes - 4) != kEnd) {
    reject_file(
        (place == 0 ? "this is no UF2 file" : "block " + std::to_string(place) + " is damaged") +
        std::string(": its magic numbers are wrong"));
  }
  const Block block{place,
                    word_at(bytes, 8),
                    word_at(bytes, 12),
                    word_at(bytes, 20),
                    word_at(bytes, 24),
                    word_at(bytes, 28),
                    bytes.substr(kHeaderBytes, kPageBytes)};
  if (word_at(bytes, 16) != kPageBytes || block.address % kPageBytes != 0) {
    reject_file("block " + std::to_string(place) + " is not one page of 256 bytes");
  }
  return block;
}

/// Whom the format's other families are for.
std::string_view other_family(std::uint32_t family) {
  switch (family) {
    case kLeadingFamily:
      return "no chip in particular";
    case 0xE48BFF58:
      return "data of an RP2350";
    case 0xE48BFF5A:
      return "an RP2350's RISC-V cores";
    case 0xE48BFF5B:
      return "an RP2350 without security";
    default:
      return "another chip";
  }
}

std::string chip_of(const Block& block) {
  if ((block.flags & kHasFamily) == 0) {
    reject_file("block " + std::to_string(block.place) + " does not say for which chip it is");
  }
  if (block.family == kRp2040) return "rp2040";
  if (block.family == kRp2350) return "rp2350";
  reject_file("it is for " + std::string(other_family(block.family)) + " (family " +
              hex32(block.family) + "), not for an RP2040 or the Arm cores of an RP2350");
}

/// Refuses a block that is not number `number` of the `count` for this chip.
void check_next(const Block& block, std::size_t number, std::size_t count,
                const std::string& chip) {
  const std::string it = "block " + std::to_string(block.place);
  if (chip_of(block) != chip) reject_file("it mixes blocks for different chips");
  if (block.number != number || block.count != count) {
    reject_file("blocks are missing, doubled or out of order: " + it + " says that it is number " +
                std::to_string(block.number) + " of " + std::to_string(block.count) +
                ", where number " + std::to_string(number) + " of " + std::to_string(count) +
                " should be");
  }
  const auto address = static_cast<std::uint32_t>(kFlashBegin + number * kPageBytes);
  if ((block.flags & kNotFlash) != 0 || block.address != address || address >= kFlashEnd) {
    reject_file(it + " goes to address " + hex32(block.address) + ", where " + hex32(address) +
                " comes next");
  }
}

/// A file's content for the flash, without a gap from its begin on.
std::string image_of(std::string_view file, std::string& chip) {
  if (file.empty() || file.size() % kBlockBytes != 0) {
    reject_file("it has " + std::to_string(file.size()) +
                " bytes, not a multiple of 512: it was cut off, or is no UF2 file");
  }
  const std::size_t blocks = file.size() / kBlockBytes;
  const Block leading = block_at(file, 0);
  const std::size_t first =
      blocks > 1 && leading.family == kLeadingFamily && leading.address == kLeadingAddress ? 1 : 0;
  chip = chip_of(block_at(file, first));
  std::string image;
  for (std::size_t place = first; place < blocks; ++place) {
    const Block block = block_at(file, place);
    check_next(block, place - first, blocks - first, chip);
    image += block.payload;
  }
  return image;
}

/// CRC-32 of an image. The four bytes that hold it count as 0.
std::uint32_t checksum(std::string_view image, std::size_t said_at) {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < image.size(); ++i) {
    if (i < said_at || i >= said_at + 4) crc ^= static_cast<unsigned char>(image[i]);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return ~crc;
}

/// Label of Torsio's firmware: a mark stands somewhere in its image.
void find_label(std::string_view image, FirmwareFile& file) {
  const std::size_t at = image.find(kMark);
  if (at == std::string_view::npos) {
    reject_file("it is not Torsio's firmware, or too old to say its name");
  }
  if (image.find(kMark, at + 1) != std::string_view::npos) {
    reject_file("it has the mark of Torsio's firmware more than once");
  }
  const std::string_view label = image.substr(at, kLabelBytes);
  const std::string_view name = label.substr(std::min<std::size_t>(24, label.size()), 16);
  const std::string_view board = name.substr(0, name.find('\0'));
  bool is_name = label.size() == kLabelBytes;
  for (const char letter : board) is_name = is_name && letter > ' ' && letter < 0x7F;
  if (!is_name) reject_file("what Torsio's firmware says of itself is damaged in it");
  if (word_at(label, kChecksumAt) != checksum(image, at + kChecksumAt)) {
    reject_file("its checksum is wrong: it is damaged, or too old to have one; get it anew");
  }
  file.board = board;
  file.fingerprint = word_at(label, 16);
  for (std::size_t i = 0; i < 3; ++i) {
    file.version += (i == 0 ? "" : ".") + std::to_string(static_cast<unsigned char>(label[20 + i]));
  }
}

}  // namespace

std::string system_reason() {
  return errno == 0 ? "" : ": " + std::generic_category().message(errno);
}

std::string file_content(const std::filesystem::path& path) {
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::string content;
  std::array<char, 65536> part;
  do {
    stream.read(part.data(), part.size());
    content.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    if (content.size() > kMostBytes) {
      throw InvalidArgument(path_text(path) + " is larger than any firmware can be (" +
                            std::to_string(kMostBytes >> 20U) + " MiB)");
    }
  } while (stream);
  if (!stream.eof()) throw Error(path_text(path) + " cannot be read" + system_reason());
  return content;
}

FirmwareFile firmware_in(const std::filesystem::path& path, std::string_view content) {
  FirmwareFile file{.path = path};
  try {
    const std::string image = image_of(content, file.chip);
    find_label(image, file);
    file.size = image.size();
  } catch (const InvalidArgument& error) {
    throw InvalidArgument(path_text(path) + ": " + error.what());
  }
  return file;
}

FirmwareFile read_firmware(const std::filesystem::path& path) {
  return firmware_in(path, file_content(path));
}

}  // namespace torsio
