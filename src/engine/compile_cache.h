// SPDX-License-Identifier: Apache-2.0
// The disk cache of one context: its state, folder and size. API calls set them; environment
// variables take precedence.
//
//   OPTIX_CACHE_PATH     folder instead of any the API names
//   OPTIX_CACHE_MAXSIZE  bytes: high mark instead of the API's, with half of it as the low mark;
//                        0 turns the cache off permanently; anything but a number from 0 is ignored
//
// Both are read when the context is created. Source: OptiX 7.4, sections 3.4.2.3 to 3.4.2.9.
#pragma once

#include "base/log.h"
#include "cache/disk_cache.h"
#include "compiler/compiler.h"

#include <functional>
#include <memory>
#include <mutex>
#include <string>

namespace sunstone::engine {

class CompileCache : public compiler::ObjectStore {
public:
    using Log = cache::Log; // called without locks; it may call the cache

    // Marks of a context that has set none.
    static constexpr cache::Marks kDefaultMarks{uint64_t(512) << 20, uint64_t(1) << 30};

    explicit CompileCache(Log log);

    // Turns the cache on at the default location or that of the environment. Where that fails, a
    // warning is logged and the cache stays off.
    void start();

    bool enabled() const;
    // Throws Error(kCache...) if the cache cannot be opened; it is off then.
    void setEnabled(bool enabled);
    std::string location() const; // empty where the environment turned the cache off
    // Throws as setEnabled does, unless the cache is off: then opening waits until it is turned on.
    void setLocation(const std::string& folder);
    cache::Marks marks() const; // zeros where the environment turned the cache off
    void setMarks(cache::Marks marks);

    // find: code. findModule: the summary of a module, with another line in the log.
    bool find(const std::string& key, std::string& value) override;
    bool has(const std::string& key) override;
    bool findModule(const std::string& key, std::string& value);
    void insert(const std::string& key, const std::string& value) override;

private:
    using Lines = cache::LogLines;
    void open(Lines& lines);
    std::shared_ptr<cache::DiskCache> openAt(const std::string& place, bool isPrivate,
                                             Lines& lines) const;
    // value: null if only existence matters.
    bool lookUp(const std::string& key, std::string* value, const char* found, const char* missing);
    std::shared_ptr<cache::DiskCache> current() const;

    Log log_;
    mutable std::mutex mutex_;                // guards the members below
    std::shared_ptr<cache::DiskCache> cache_; // null while the cache is off
    std::string location_;                    // empty: the default
    std::string defaultLocation_;             // the one of the defaults that was opened last
    cache::Marks marks_ = kDefaultMarks;
    bool off_ = false;            // by OPTIX_CACHE_MAXSIZE=0
    bool marksFixed_ = false;     // by OPTIX_CACHE_MAXSIZE
    bool locationFixed_ = false;  // by OPTIX_CACHE_PATH
};

} // namespace sunstone::engine
