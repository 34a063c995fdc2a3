// SPDX-License-Identifier: Apache-2.0
// The engine's log. Lines go to stderr where the environment asks for them:
// SUNSTONE_LOG=debug (all areas) or SUNSTONE_LOG=ptx:debug,bvh:info. API shells that have a log
// callback deliver their own lines to it as well. Areas are folder names.
#pragma once

#include <string>
#include <string_view>

namespace sunstone {

// Numbers 1 to 4 are those of the OptiX log callback.
enum class LogLevel : unsigned { kOff = 0, kFatal = 1, kError = 2, kWarning = 3, kInfo = 4, kDebug = 5 };

// Whether a line of this level and area would be printed: for lines costly to build.
bool logEnabled(LogLevel level, std::string_view area);

// Writes one line; any thread may call it, lines never interleave.
void log(LogLevel level, std::string_view area, std::string_view text);

// As log, but only the first time this text is seen in the process.
void logOnce(LogLevel level, std::string_view area, std::string_view text);

} // namespace sunstone
