// SPDX-License-Identifier: Apache-2.0
// PTX to machine code by the driver's compiler, in a form that can be kept on disk.
#pragma once

#include <string>

namespace sunstone::engine {

// For the device whose context is current. Throws kLinkError with what the driver has to say.
std::string assembleForGpu(const std::string& ptx, unsigned maxRegisters);

} // namespace sunstone::engine
