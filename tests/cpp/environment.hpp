/// @file
/// Variables of the environment, on every system.
#pragma once

#include <cstdlib>

namespace torsio::test {

/// @param value nullptr: it is to be gone
inline void set_variable(const char* name, const char* value) {
#ifdef _WIN32
  _putenv_s(name, value != nullptr ? value : "");
#else
  value != nullptr ? setenv(name, value, 1) : unsetenv(name);
#endif
}

}  // namespace torsio::test
