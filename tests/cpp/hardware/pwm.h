/// @file
/// See fake.hpp.
#pragma once

#include "hardware/fake.hpp"
