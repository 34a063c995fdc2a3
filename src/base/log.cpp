// SPDX-License-Identifier: Apache-2.0
// See log.h.
#include "base/log.h"

#include "base/config.h"

#include <cstdio>
#include <map>
#include <mutex>
#include <set>

namespace sunstone {
namespace {

LogLevel parseLevel(std::string_view name) {
    if (name == "off") return LogLevel::kOff;
    if (name == "fatal") return LogLevel::kFatal;
    if (name == "error") return LogLevel::kError;
    if (name == "warning") return LogLevel::kWarning;
    if (name == "info") return LogLevel::kInfo;
    return LogLevel::kDebug;
}

// Levels by area as SUNSTONE_LOG gives them; the empty area is the default.
struct Levels {
    std::map<std::string, LogLevel, std::less<>> byArea;
    LogLevel fallback = LogLevel::kFatal;

    explicit Levels(std::string_view text) {
        while (!text.empty()) {
            size_t comma = text.find(',');
            std::string_view item = text.substr(0, comma);
            text = comma == std::string_view::npos ? "" : text.substr(comma + 1);
            size_t colon = item.find(':');
            if (item.empty())
                continue;
            if (colon == std::string_view::npos)
                fallback = parseLevel(item);
            else
                byArea[std::string(item.substr(0, colon))] = parseLevel(item.substr(colon + 1));
        }
    }
};

const Levels& levels() {
    static const auto* instance =
        new Levels(config(Setting::kLog)); // threads log while the process ends
    return *instance;
}

std::mutex& logMutex() {
    static std::mutex mutex;
    return mutex;
}

const char* levelName(LogLevel level) {
    switch (level) {
    case LogLevel::kFatal: return "fatal";
    case LogLevel::kError: return "error";
    case LogLevel::kWarning: return "warning";
    case LogLevel::kInfo: return "info";
    default: return "debug";
    }
}

} // namespace

bool logEnabled(LogLevel level, std::string_view area) {
    const Levels& set = levels();
    auto found = set.byArea.find(area);
    return level <= (found == set.byArea.end() ? set.fallback : found->second);
}

void log(LogLevel level, std::string_view area, std::string_view text) {
    if (!logEnabled(level, area))
        return;
    std::lock_guard lock(logMutex());
    std::fprintf(stderr, "[sunstone %.*s %s] %.*s\n", int(area.size()), area.data(),
                 levelName(level), int(text.size()), text.data());
}

void logOnce(LogLevel level, std::string_view area, std::string_view text) {
    static auto& seen = *new std::set<std::string, std::less<>>;
    {
        std::lock_guard lock(logMutex());
        if (!seen.emplace(text).second)
            return;
    }
    log(level, area, text);
}

} // namespace sunstone
