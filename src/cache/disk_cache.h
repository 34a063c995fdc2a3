// SPDX-License-Identifier: Apache-2.0
// Values by key in one SQLite database of a folder, shared by any number of processes and threads.
//
// SQLite provides locks between processes, transactions that survive a killed process, and reuse of
// free pages. This class adds:
// - a checksum for every value, so that a damaged value is never returned;
// - replacement: if a database is too damaged to read, a new one is started (files are numbered,
//   the highest number is current); processes that have the old one open keep it;
// - collection: above the high mark, values unused for longest are removed.
//
// The journal is a rollback journal: a write-ahead log maps a shared file into memory, and another
// process that truncates the file would cause a SIGBUS.
#pragma once

#include "cache/log_lines.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

struct sqlite3;

namespace sunstone::cache {

// Sizes in bytes: collection starts above the high mark and stops at the low one. Either 0: no
// collection.
struct Marks {
    uint64_t low = 0;
    uint64_t high = 0;
    bool collects() const { return low != 0 && high != 0; }
};

class DiskCache {
public:
    // Opens the database in `folder`. A missing folder is created with access for this user only.
    // Throws Error(kCacheInvalidPath, kCachePermission, kCacheDatabase). isPrivate: the folder must
    // belong to this user and be writable by this user only, because its name can be guessed. The
    // log is called without locks; it may call the cache.
    DiskCache(std::string folder, bool isPrivate, Log log);
    ~DiskCache();
    DiskCache(const DiskCache&) = delete;
    DiskCache& operator=(const DiskCache&) = delete;

    const std::string& folder() const { return folder_; }

    // Neither function throws: failures are logged, and the cache then seems empty.
    bool find(const std::string& key, std::string& value);
    // Whether the key has a value. Does not check the value; counts as a use of it.
    bool has(const std::string& key);
    void insert(const std::string& key, const std::string& value, Marks marks);

    // The size that collection compares with the marks: bytes of keys and values plus a fixed
    // amount for each.
    uint64_t size();

private:
    struct Statement;

    template <class Body>
    void exclusively(const Body& body);
    void openNewest(bool mayReplace);
    void close();
    void replaceDamaged();
    void warn(const std::string& text);
    template <class Body>
    bool attempt(const char* what, Body body);
    void execute(const char* sql);
    bool read(const std::string& key, std::string& value);
    void write(const std::string& key, const std::string& value, Marks marks);
    void use(const std::string& key, int64_t before);
    uint64_t total();
    void evict(uint64_t atMost);

    std::mutex mutex_; // guards the members below, except the folder and the log
    std::string folder_;
    Log log_;
    LogLines* lines_ = nullptr; // of the call that holds the mutex
    sqlite3* database_ = nullptr;
    unsigned generation_ = 0;
    int process_ = 0; // the process that opened it: connections do not survive a fork
};

} // namespace sunstone::cache
