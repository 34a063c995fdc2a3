// SPDX-License-Identifier: Apache-2.0
// Log lines of an object with a mutex. The log is a callback of the client: it may call the object,
// or wait for a thread that does. Lines are therefore collected while the mutex is held and logged
// after its release.
#pragma once

#include "base/log.h"

#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace sunstone::cache {

using Log = std::function<void(LogLevel, const std::string&)>;

class LogLines {
public:
    void add(LogLevel level, std::string text) { lines_.emplace_back(level, std::move(text)); }
    void tell(const Log& log) const {
        for (const auto& [level, text] : lines_)
            log(level, text);
    }

private:
    std::vector<std::pair<LogLevel, std::string>> lines_;
};

// Runs body(lines) with the mutex held, then logs the lines, also if the body throws.
template <class Body>
void exclusively(std::mutex& mutex, const Log& log, const Body& body) {
    LogLines lines;
    std::exception_ptr error;
    {
        std::lock_guard lock(mutex);
        try {
            body(lines);
        } catch (...) {
            error = std::current_exception();
        }
    }
    lines.tell(log);
    if (error)
        std::rethrow_exception(error);
}

} // namespace sunstone::cache
