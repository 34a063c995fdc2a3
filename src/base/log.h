// SPDX-License-Identifier: Apache-2.0
// The engine's log. The environment selects the lines that go to stderr: SUNSTONE_LOG=debug (all
// areas) or SUNSTONE_LOG=compiler:debug,bvh:info. Areas are names of folders. An API shell with a
// log callback passes its own lines to the callback, too.
#pragma once

#include <string>
#include <string_view>

namespace sunstone {

// Values 1 to 4 are the levels of the OptiX log callback.
enum class LogLevel : unsigned { kOff = 0, kFatal = 1, kError = 2, kWarning = 3, kInfo = 4, kDebug = 5 };

// Whether a line of this level and area would be printed. Call it before building a costly line.
bool logEnabled(LogLevel level, std::string_view area);

// Writes one line. Any thread may call it; lines never interleave.
void log(LogLevel level, std::string_view area, std::string_view text);

// Like log, but only the first time the process logs this text.
void logOnce(LogLevel level, std::string_view area, std::string_view text);

} // namespace sunstone
