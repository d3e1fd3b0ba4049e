// Exceptions of the library as C's results and sentences, kept for each thread.
#include <algorithm>
#include <array>
#include <cstring>
#include <new>

#include "handles.hpp"
#include "torsio/error.hpp"

namespace torsio::c {
namespace {

// No string: it costs no memory when there is none, and nothing must be destroyed with the thread.
struct LastError {
  std::array<char, 1024> message;
  torsio_refusal refusal;
  std::array<char, 1024> warning;
};
thread_local LastError last{};

void keep_refusal(const Refused& error) noexcept {
  last.refusal.struct_size = sizeof(torsio_refusal);
  copy(last.refusal.status, error.status());
  copy(last.refusal.report, error.report());
  copy(last.refusal.field, error.field());
  copy(last.refusal.reason, error.reason());
}

}  // namespace

torsio_result fail(torsio_result result, const char* message) noexcept {
  const std::size_t length = std::min(std::strlen(message), last.message.size() - 1);
  std::memcpy(last.message.data(), message, length);
  last.message.at(length) = '\0';
  return result;
}

void warn(const std::string& sentence) noexcept {
  last.warning.at(sentence.copy(last.warning.data(), last.warning.size() - 1)) = '\0';
}

torsio_result fail_with_current() noexcept {
  try {
    throw;
  } catch (const InvalidArgument& error) {
    return fail(TORSIO_INVALID_ARGUMENT, error.what());
  } catch (const DeviceNotFound& error) {
    return fail(TORSIO_DEVICE_NOT_FOUND, error.what());
  } catch (const PermissionDenied& error) {
    return fail(TORSIO_PERMISSION_DENIED, error.what());
  } catch (const DeviceBusy& error) {
    return fail(TORSIO_DEVICE_BUSY, error.what());
  } catch (const ProtocolMismatch& error) {
    return fail(TORSIO_PROTOCOL_MISMATCH, error.what());
  } catch (const Refused& error) {
    keep_refusal(error);
    return fail(TORSIO_REFUSED, error.what());
  } catch (const Disarmed& error) {
    return fail(TORSIO_DISARMED, error.what());
  } catch (const Timeout& error) {
    return fail(TORSIO_TIMEOUT, error.what());
  } catch (const Disconnected& error) {
    return fail(TORSIO_DISCONNECTED, error.what());
  } catch (const Closed& error) {
    return fail(TORSIO_CLOSED, error.what());
  } catch (const std::bad_alloc&) {
    return fail(TORSIO_OUT_OF_MEMORY, "there is not enough memory; nothing was done");
  } catch (const std::exception& error) {
    return fail(TORSIO_ERROR, error.what());
  } catch (...) {
    return fail(TORSIO_ERROR, "something failed that is no std::exception");
  }
}

}  // namespace torsio::c

const char* torsio_last_error(void) { return torsio::c::last.message.data(); }

const char* torsio_last_warning(void) { return torsio::c::last.warning.data(); }

torsio_result torsio_refusal_init(torsio_refusal* structure) {
  return torsio::c::guarded([&] {
    torsio::c::need(structure, "structure") = torsio_refusal{};
    structure->struct_size = sizeof(torsio_refusal);
  });
}

torsio_result torsio_last_refusal(torsio_refusal* refusal) {
  return torsio::c::guarded([&] {
    torsio_refusal& known =
        torsio::c::need_sized(refusal, "the structure to fill in", "torsio_refusal");
    if (torsio::c::last.refusal.struct_size == 0) {
      throw torsio::Error("the device has refused nothing in this thread");
    }
    known = torsio::c::last.refusal;
  });
}

const char* torsio_result_name(std::int32_t result) {
  constexpr std::array kNames{"TORSIO_OK",
                              "TORSIO_INVALID_ARGUMENT",
                              "TORSIO_DEVICE_NOT_FOUND",
                              "TORSIO_PERMISSION_DENIED",
                              "TORSIO_DEVICE_BUSY",
                              "TORSIO_PROTOCOL_MISMATCH",
                              "TORSIO_REFUSED",
                              "TORSIO_DISARMED",
                              "TORSIO_TIMEOUT",
                              "TORSIO_DISCONNECTED",
                              "TORSIO_CLOSED",
                              "TORSIO_OUT_OF_MEMORY",
                              "TORSIO_ERROR"};
  if (result < 0 || static_cast<std::size_t>(result) >= kNames.size()) return nullptr;
  return kNames.at(static_cast<std::size_t>(result));
}

const char* torsio_version(void) { return TORSIO_VERSION; }

int32_t torsio_abi_version(void) { return TORSIO_ABI_VERSION; }
