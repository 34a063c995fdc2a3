// SPDX-License-Identifier: Apache-2.0
// Values by key in one SQLite database of a folder, shared by any number of processes and threads.
//
// SQLite brings what is hard here: locks between processes, transactions that survive a killed
// process, free pages used again. What it does not bring is done here: every value carries a
// checksum, so that no damaged byte is ever handed out; a database that is damaged beyond reading
// is left to whoever holds it and a new one begun (files are numbered, the highest counts); values
// not used for longest go when the high mark is passed.
//
// The rollback journal is used, not the write-ahead log: that maps a shared file into memory,
// whose truncation by another process would be a fault signal.
#pragma once

#include "base/log.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

struct sqlite3;

namespace sunstone::cache {

// Sizes in bytes at which collection starts, and which it goes down to. Either 0: no collection.
struct Marks {
    uint64_t low = 0;
    uint64_t high = 0;
    bool collects() const { return low != 0 && high != 0; }
};

class DiskCache {
public:
    using Log = std::function<void(LogLevel, const std::string&)>;

    // Opens the database in `folder`, which is made if missing, for this user alone. Throws
    // Error(kCacheInvalidPath, kCachePermission, kCacheDatabase). isPrivate: the folder must
    // belong to this user and be writable by nobody else, as its name can be guessed.
    DiskCache(std::string folder, bool isPrivate, Log log);
    ~DiskCache();
    DiskCache(const DiskCache&) = delete;
    DiskCache& operator=(const DiskCache&) = delete;

    const std::string& folder() const { return folder_; }

    // Neither throws: a cache that fails is as good as an empty one. What failed is logged.
    bool find(const std::string& key, std::string& value);
    // Whether there is a value, which is not looked at; counts as a use of it.
    bool has(const std::string& key);
    void insert(const std::string& key, const std::string& value, Marks marks);

    // What collection compares with the marks: bytes of keys and values and a fixed amount each.
    uint64_t size();

private:
    struct Statement;

    void openNewest(bool mayReplace);
    void close();
    void replaceDamaged();
    void warn(const std::string& text);
    template <class Body>
    bool attempt(const char* what, Body body);
    void execute(const char* sql);
    void use(const std::string& key, int64_t before);
    uint64_t total();
    void evict(uint64_t atMost);

    std::recursive_mutex mutex_; // a log callback may compile
    std::string folder_;
    Log log_;
    sqlite3* database_ = nullptr;
    unsigned generation_ = 0;
    int process_ = 0; // that opened it: connections do not survive a fork
};

} // namespace sunstone::cache
