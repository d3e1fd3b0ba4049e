/// @file
/// What an error says, for tests of messages.
#pragma once

#include <doctest/doctest.h>

#include <exception>
#include <string>

namespace torsio::test {

/// Runs `call` and returns what its error says; fails if it throws nothing or something else.
template <class Expected, class Call>
std::string message_of(Call&& call) {
  try {
    call();
  } catch (const Expected& error) {
    return error.what();
  } catch (const std::exception& error) {
    FAIL("another error: ", error.what());
  }
  FAIL("no error");
  return {};
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace torsio::test
