// SPDX-License-Identifier: Apache-2.0
#include "engine/compile_cache.h"

#include "base/config.h"
#include "base/error.h"

#include <algorithm>
#include <charconv>
#include <pwd.h>
#include <unistd.h>
#include <vector>

namespace sunstone::engine {

namespace {

// A distinct name: other implementations of the API keep their caches beside it.
std::string folderName() {
    std::vector<char> buffer(16384);
    passwd entry{};
    passwd* found = nullptr;
    if (getpwuid_r(geteuid(), &entry, buffer.data(), buffer.size(), &found) == 0 && found &&
        found->pw_name && *found->pw_name)
        return std::string("SunstoneCache_") + found->pw_name;
    return "SunstoneCache";
}

const std::vector<std::string>& defaultLocations() {
    static const auto* places =
        new std::vector<std::string>{"/var/tmp/" + folderName(), "/tmp/" + folderName()};
    return *places;
}

std::string hexOf(const std::string& key) {
    std::string text;
    for (const char byte : key)
        for (const unsigned digit : {unsigned(uint8_t(byte)) >> 4, unsigned(byte) & 15})
            text += "0123456789abcdef"[digit];
    return text;
}

} // namespace

CompileCache::CompileCache(Log log)
    : log_(std::move(log)), location_(currentConfig(Setting::kCachePath)) {
    locationFixed_ = !location_.empty();
    const std::string text = currentConfig(Setting::kCacheMaxSize);
    uint64_t bytes = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bytes);
    if (text.empty())
        return;
    if (error != std::errc() || end != text.data() + text.size()) {
        log_(LogLevel::kWarning, message("OPTIX_CACHE_MAXSIZE = \"", text,
                                         "\" is no number of bytes and is ignored"));
        return;
    }
    off_ = bytes == 0;
    marksFixed_ = true;
    marks_ = {std::max<uint64_t>(1, bytes / 2), bytes};
}

std::shared_ptr<cache::DiskCache> CompileCache::current() const {
    std::lock_guard lock(mutex_);
    return cache_;
}

// The caller holds the mutex, as for open(). Log lines until the cache is usable go to `lines`.
std::shared_ptr<cache::DiskCache> CompileCache::openAt(const std::string& place, bool isPrivate,
                                                       Lines& lines) const {
    const auto opening = std::make_shared<Lines*>(&lines);
    const Log log = [direct = log_, opening](LogLevel level, const std::string& text) {
        if (*opening)
            (*opening)->add(level, text);
        else
            direct(level, text);
    };
    auto opened = std::make_shared<cache::DiskCache>(place, isPrivate, log);
    *opening = nullptr;
    return opened;
}

void CompileCache::open(Lines& lines) {
    cache_ = nullptr;
    if (!location_.empty()) {
        cache_ = openAt(location_, false, lines);
        return;
    }
    for (const std::string& place : defaultLocations()) {
        defaultLocation_ = place;
        try {
            cache_ = openAt(place, true, lines);
            return;
        } catch (const Error& error) {
            if (place == defaultLocations().back())
                throw;
            lines.add(LogLevel::kInfo, error.what());
        }
    }
}

void CompileCache::start() {
    cache::exclusively(mutex_, log_, [&](Lines& lines) {
        if (off_)
            return;
        try {
            open(lines);
        } catch (const Error& error) {
            lines.add(LogLevel::kWarning, message(error.what(), "; nothing is cached"));
        }
    });
}

bool CompileCache::enabled() const {
    return current() != nullptr;
}

void CompileCache::setEnabled(bool enabled) {
    cache::exclusively(mutex_, log_, [&](Lines& lines) {
        if (!enabled)
            cache_ = nullptr;
        else if (off_)
            lines.add(LogLevel::kWarning, "the disk cache stays off: OPTIX_CACHE_MAXSIZE is 0");
        else if (!cache_)
            open(lines);
    });
}

std::string CompileCache::location() const {
    std::lock_guard lock(mutex_);
    if (off_)
        return {};
    if (!location_.empty())
        return location_;
    return defaultLocation_.empty() ? defaultLocations().front() : defaultLocation_;
}

void CompileCache::setLocation(const std::string& folder) {
    cache::exclusively(mutex_, log_, [&](Lines& lines) {
        if (locationFixed_) {
            lines.add(LogLevel::kInfo, message("location \"", folder,
                                               "\" is not used: OPTIX_CACHE_PATH is ", location_));
            return;
        }
        if (folder.empty())
            fail(Code::kCacheInvalidPath, "location is an empty path");
        location_ = folder;
        if (cache_)
            open(lines);
    });
}

cache::Marks CompileCache::marks() const {
    std::lock_guard lock(mutex_);
    return off_ ? cache::Marks{} : marks_;
}

void CompileCache::setMarks(cache::Marks marks) {
    if (marks.collects() && marks.high < marks.low)
        fail(Code::kInvalidValue, "highWaterMark = ", marks.high, " is less than lowWaterMark = ",
             marks.low);
    cache::exclusively(mutex_, log_, [&](Lines& lines) {
        if (marksFixed_)
            lines.add(LogLevel::kInfo,
                      "the marks are not used: OPTIX_CACHE_MAXSIZE goes before them");
        else
            marks_ = marks;
    });
}

bool CompileCache::find(const std::string& key, std::string& value) {
    return lookUp(key, &value, "hit for ", "miss for ");
}

bool CompileCache::has(const std::string& key) {
    return lookUp(key, nullptr, "hit for ", "miss for ");
}

bool CompileCache::findModule(const std::string& key, std::string& value) {
    return lookUp(key, &value, "module known: ", "module new: ");
}

bool CompileCache::lookUp(const std::string& key, std::string* value, const char* found,
                          const char* missing) {
    const std::shared_ptr<cache::DiskCache> cache = current();
    if (!cache)
        return false;
    const bool isThere = value ? cache->find(key, *value) : cache->has(key);
    log_(LogLevel::kInfo, (isThere ? found : missing) + hexOf(key));
    return isThere;
}

void CompileCache::insert(const std::string& key, const std::string& value) {
    const cache::Marks limits = marks();
    if (const std::shared_ptr<cache::DiskCache> cache = current())
        cache->insert(key, value, limits);
}

} // namespace sunstone::engine
