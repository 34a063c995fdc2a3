// SPDX-License-Identifier: Apache-2.0
// See disk_cache.h. Source: SQLite documentation, "Result Codes", "File Locking And Concurrency".
#include "cache/disk_cache.h"

#include "base/error.h"

#include <sqlite3.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

namespace sunstone::cache {

namespace {

constexpr char kPrefix[] = "programs1-"; // followed by the schema's number
constexpr char kSuffix[] = ".db";
constexpr int kBusyMilliseconds = 5000;
constexpr uint64_t kEntryOverhead = 64;
constexpr int64_t kUseSeconds = 3600; // resolution of the time of last use, as each update is a
                                      // write

constexpr const char* kSchema = "CREATE TABLE IF NOT EXISTS entry(key BLOB PRIMARY KEY, value BLOB,"
                                " size INTEGER, checksum INTEGER, used INTEGER);"
                                "CREATE INDEX IF NOT EXISTS by_use ON entry(used, size);";

// An SQLite error; thrown and caught in this file.
struct SqlFault {
    int code;
    std::string text;
};

[[noreturn]] void throwFault(sqlite3* database, int code) {
    throw SqlFault{code & 0xff, database ? sqlite3_errmsg(database) : sqlite3_errstr(code)};
}

// Faults after which a new database file helps.
bool isDamage(const SqlFault& fault) {
    switch (fault.code) {
    case SQLITE_CORRUPT:
    case SQLITE_NOTADB:
    case SQLITE_ERROR: // our statements are right, so the schema is not ours
    case SQLITE_MISMATCH:
    case SQLITE_READONLY: // also if the file was deleted while open
        return true;
    default:
        return false;
    }
}

// 64-bit mixing of eight bytes at a time (multiply and fold).
uint64_t checksumOf(const std::string& key, const std::string& value) {
    uint64_t sum = 0x9e3779b97f4a7c15u;
    const auto add = [&](uint64_t word) {
        const auto product = static_cast<unsigned __int128>(sum ^ word) * 0xa0761d6478bd642fu;
        sum = uint64_t(product) ^ uint64_t(product >> 64) ^ word;
    };
    for (const std::string* text : {&key, &value}) {
        size_t at = 0;
        for (; at + 8 <= text->size(); at += 8) {
            uint64_t word;
            std::memcpy(&word, text->data() + at, 8);
            add(word);
        }
        uint64_t rest = 0;
        std::memcpy(&rest, text->data() + at, text->size() - at);
        add(rest);
        add(text->size());
    }
    return sum;
}

uint64_t sizeOf(const std::string& key, const std::string& value) {
    return key.size() + value.size() + kEntryOverhead;
}

int64_t now() {
    return int64_t(time(nullptr));
}

Code codeOfErrno(int error) {
    switch (error) {
    case EACCES:
    case EPERM:
    case EROFS:
        return Code::kCachePermission;
    case ENOENT:
    case ENOTDIR:
    case EEXIST:
    case EINVAL:
    case ENAMETOOLONG:
    case ELOOP:
        return Code::kCacheInvalidPath;
    default:
        return Code::kCacheDatabase;
    }
}

[[noreturn]] void failAt(const std::string& path, const char* what, int error) {
    fail(codeOfErrno(error), "disk cache: cannot ", what, " ", path, ": ", std::strerror(error));
}

// Creates the folder and its parents.
void makeFolder(const std::string& folder) {
    for (size_t at = 1; at <= folder.size(); ++at) {
        if (at != folder.size() && folder[at] != '/')
            continue;
        const std::string part = folder.substr(0, at);
        struct stat info;
        if (stat(part.c_str(), &info) == 0) {
            if (!S_ISDIR(info.st_mode))
                failAt(part, "use as a folder", ENOTDIR);
        } else if (mkdir(part.c_str(), 0700) != 0 && errno != EEXIST) {
            failAt(part, "create folder", errno);
        }
    }
}

void checkPrivate(const std::string& folder) {
    struct stat info;
    if (lstat(folder.c_str(), &info) != 0)
        failAt(folder, "look at", errno);
    if (!S_ISDIR(info.st_mode) || info.st_uid != geteuid() || (info.st_mode & 022) != 0)
        fail(Code::kCachePermission, "disk cache: ", folder,
             " is not a folder that only this user can write to; code will not be taken from it");
}

// An exclusive lock on a file beside the database, for opening and replacing it.
class FolderLock {
public:
    explicit FolderLock(const std::string& folder) {
        const std::string path = folder + "/lock";
        file_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
        if (file_ < 0)
            failAt(path, "open", errno);
        while (flock(file_, LOCK_EX) != 0)
            if (errno != EINTR) {
                const int error = errno;
                ::close(file_);
                failAt(path, "lock", error);
            }
    }
    ~FolderLock() { ::close(file_); }
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int file_;
};

std::string pathOf(const std::string& folder, unsigned generation) {
    return folder + "/" + kPrefix + std::to_string(generation) + kSuffix;
}

// SQLite takes an empty file for an empty database.
void createEmpty(const std::string& path) {
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (file < 0)
        failAt(path, "create", errno);
    ::close(file);
}

// Numbers of the databases in the folder; 0 if the folder has none.
std::vector<unsigned> generations(const std::string& folder) {
    std::vector<unsigned> found;
    std::error_code error;
    for (std::filesystem::directory_iterator it(folder, error), end; !error && it != end;
         it.increment(error)) {
        const std::string name = it->path().filename().string();
        const size_t prefix = sizeof kPrefix - 1, suffix = sizeof kSuffix - 1;
        if (name.size() <= prefix + suffix || name.compare(0, prefix, kPrefix) != 0 ||
            name.compare(name.size() - suffix, suffix, kSuffix) != 0)
            continue;
        const std::string number = name.substr(prefix, name.size() - prefix - suffix);
        if (number.size() < 10 && number.find_first_not_of("0123456789") == std::string::npos)
            found.push_back(unsigned(std::stoul(number)));
    }
    return found;
}

} // namespace

// A prepared statement with its parameters bound in order.
struct DiskCache::Statement {
    Statement(sqlite3* database, const char* sql) : database_(database) {
        if (const int code = sqlite3_prepare_v2(database, sql, -1, &statement_, nullptr))
            throwFault(database, code);
    }
    ~Statement() { sqlite3_finalize(statement_); }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& blob(const std::string& value) {
        check(sqlite3_bind_blob64(statement_, ++bound_, value.data(), value.size(),
                                  SQLITE_STATIC));
        return *this;
    }
    Statement& number(int64_t value) {
        check(sqlite3_bind_int64(statement_, ++bound_, value));
        return *this;
    }
    // Whether the statement returned a row.
    bool step() {
        const int code = sqlite3_step(statement_);
        if (code != SQLITE_ROW && code != SQLITE_DONE)
            throwFault(database_, code);
        return code == SQLITE_ROW;
    }
    int64_t numberAt(int column) { return sqlite3_column_int64(statement_, column); }
    std::string blobAt(int column) {
        const void* data = sqlite3_column_blob(statement_, column);
        const int size = sqlite3_column_bytes(statement_, column);
        return data && size > 0 ? std::string(static_cast<const char*>(data), size_t(size))
                                : std::string();
    }

private:
    void check(int code) {
        if (code)
            throwFault(database_, code);
    }
    sqlite3* database_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
};

DiskCache::DiskCache(std::string folder, bool isPrivate, Log log)
    : folder_(std::move(folder)), log_(std::move(log)) {
    if (folder_.empty())
        fail(Code::kCacheInvalidPath, "disk cache: the path of the folder is empty");
    std::error_code error;
    const std::filesystem::path path = std::filesystem::absolute(folder_, error);
    if (error)
        failAt(folder_, "resolve", error.value());
    folder_ = path.lexically_normal().string();
    while (folder_.size() > 1 && folder_.back() == '/')
        folder_.pop_back();
    makeFolder(folder_);
    if (isPrivate)
        checkPrivate(folder_);
    exclusively([&] {
        const FolderLock lock(folder_);
        openNewest(true);
    });
}

DiskCache::~DiskCache() {
    close();
}

template <class Body>
void DiskCache::exclusively(const Body& body) {
    cache::exclusively(mutex_, log_, [&](LogLines& lines) {
        lines_ = &lines;
        body();
    });
}

void DiskCache::warn(const std::string& text) {
    lines_->add(LogLevel::kWarning, "disk cache " + folder_ + ": " + text);
}

void DiskCache::execute(const char* sql) {
    if (const int code = sqlite3_exec(database_, sql, nullptr, nullptr, nullptr))
        throwFault(database_, code);
}

void DiskCache::close() {
    // In a forked child the connection is the parent's: closing it would drop the parent's locks.
    if (database_ && process_ == int(getpid()))
        sqlite3_close_v2(database_);
    database_ = nullptr;
}

void DiskCache::openNewest(bool mayReplace) {
    close();
    const std::vector<unsigned> present = generations(folder_);
    generation_ = present.empty() ? 1 : *std::max_element(present.begin(), present.end());
    const std::string path = pathOf(folder_, generation_);
    process_ = int(getpid());
    try {
        constexpr int kFlags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
        if (const int code = sqlite3_open_v2(path.c_str(), &database_, kFlags, nullptr))
            throwFault(database_, code);
        sqlite3_busy_timeout(database_, kBusyMilliseconds);
        // Large pages, because values are large. Applies to a new database; an existing one keeps
        // its size.
        execute("PRAGMA page_size=32768; PRAGMA synchronous=OFF; PRAGMA trusted_schema=OFF; PRAGMA cell_size_check=ON;"
                "PRAGMA mmap_size=0; PRAGMA auto_vacuum=FULL; PRAGMA journal_mode=TRUNCATE;"
                "BEGIN IMMEDIATE;");
        execute(kSchema);
        execute("COMMIT;");
    } catch (const SqlFault& fault) {
        close();
        if (isDamage(fault) && mayReplace) {
            warn(path + " cannot be read (" + fault.text + "); a new database is begun");
            createEmpty(pathOf(folder_, generation_ + 1));
            return openNewest(false);
        }
        const Code code = fault.code == SQLITE_READONLY || fault.code == SQLITE_PERM ||
                                  (fault.code == SQLITE_CANTOPEN && errno == EACCES)
                              ? Code::kCachePermission
                              : Code::kCacheDatabase;
        fail(code, "disk cache: cannot open ", path, ": ", fault.text);
    }
    // Processes that have an older database open keep it until they close it; its name is removed
    // now.
    for (const unsigned older : present)
        if (older < generation_)
            for (const char* tail : {"", "-journal"})
                unlink((pathOf(folder_, older) + tail).c_str());
}

// Reopens after damage was found; another process may have replaced the database already.
void DiskCache::replaceDamaged() {
    makeFolder(folder_);
    const FolderLock lock(folder_);
    const unsigned damaged = generation_;
    close();
    const std::vector<unsigned> present = generations(folder_);
    if (present.empty() || *std::max_element(present.begin(), present.end()) <= damaged)
        createEmpty(pathOf(folder_, damaged + 1));
    openNewest(true);
}

// Runs body on the open database. After damage, opens a new database and runs body again; other
// faults end the attempt with a warning.
template <class Body>
bool DiskCache::attempt(const char* what, Body body) {
    for (int round = 0;; ++round) {
        try {
            if (!database_ || process_ != int(getpid())) {
                database_ = nullptr;
                const FolderLock folderLock(folder_);
                openNewest(true);
            }
            body();
            return true;
        } catch (const SqlFault& fault) {
            if (database_ && !sqlite3_get_autocommit(database_))
                sqlite3_exec(database_, "ROLLBACK;", nullptr, nullptr, nullptr);
            warn(message("cannot ", what, ": ", fault.text));
            if (!isDamage(fault) || round == 1)
                return false;
        } catch (const std::exception& error) {
            warn(message("cannot ", what, ": ", error.what()));
            return false;
        }
        try {
            replaceDamaged();
        } catch (const std::exception& error) {
            warn(error.what());
            return false;
        }
    }
}

bool DiskCache::find(const std::string& key, std::string& value) {
    bool found = false;
    exclusively([&] { found = read(key, value); });
    if (!found)
        value.clear();
    return found;
}

// The caller holds the mutex, as for the functions below.
bool DiskCache::read(const std::string& key, std::string& value) {
    bool found = false;
    attempt("read", [&] {
        int64_t checksum = 0, used = 0;
        {
            Statement select(database_, "SELECT value, checksum, used FROM entry WHERE key=?1");
            if (!select.blob(key).step())
                return;
            value = select.blobAt(0);
            checksum = select.numberAt(1);
            used = select.numberAt(2);
        }
        if (uint64_t(checksum) != checksumOf(key, value)) {
            warn("a value is damaged and is dropped");
            Statement(database_, "DELETE FROM entry WHERE key=?1").blob(key).step();
            return;
        }
        found = true;
        use(key, used);
    });
    return found;
}

bool DiskCache::has(const std::string& key) {
    bool found = false;
    exclusively([&] {
        attempt("read", [&] {
            int64_t used = 0;
            {
                Statement select(database_, "SELECT used FROM entry WHERE key=?1");
                if (!select.blob(key).step())
                    return;
                used = select.numberAt(0);
            }
            found = true;
            use(key, used);
        });
    });
    return found;
}

// Stores the time of a use, if the stored time is old enough.
void DiskCache::use(const std::string& key, int64_t before) {
    if (now() - before < kUseSeconds && now() >= before)
        return;
    Statement(database_, "UPDATE entry SET used=?1 WHERE key=?2").number(now()).blob(key).step();
}

uint64_t DiskCache::total() {
    Statement sum(database_, "SELECT total(size) FROM entry");
    return sum.step() ? uint64_t(sum.numberAt(0)) : 0;
}

uint64_t DiskCache::size() {
    uint64_t bytes = 0;
    exclusively([&] { attempt("read", [&] { bytes = total(); }); });
    return bytes;
}

// Removes the values unused for longest until at most `atMost` bytes are left.
void DiskCache::evict(uint64_t atMost) {
    uint64_t left = total();
    std::vector<int64_t> rows;
    {
        Statement oldest(database_, "SELECT rowid, size FROM entry ORDER BY used, rowid");
        while (left > atMost && oldest.step()) {
            rows.push_back(oldest.numberAt(0));
            left -= std::min(left, uint64_t(std::max<int64_t>(0, oldest.numberAt(1))));
        }
    }
    for (const int64_t row : rows)
        Statement(database_, "DELETE FROM entry WHERE rowid=?1").number(row).step();
    if (left > atMost) // damage gave absurd sizes
        execute("DELETE FROM entry");
}

void DiskCache::insert(const std::string& key, const std::string& value, Marks marks) {
    exclusively([&] { write(key, value, marks); });
}

void DiskCache::write(const std::string& key, const std::string& value, Marks marks) {
    const uint64_t added = sizeOf(key, value);
    if (marks.collects() && added > marks.high) {
        warn(message("an entry of ", added, " bytes is not stored: the high water mark is ",
                     marks.high));
        return;
    }
    attempt("write", [&] {
        execute("BEGIN IMMEDIATE");
        Statement(database_, "DELETE FROM entry WHERE key=?1").blob(key).step();
        if (marks.collects() && total() + added > marks.high)
            evict(marks.low > added ? marks.low - added : 0);
        Statement(database_, "INSERT INTO entry(key, value, size, checksum, used)"
                             " VALUES(?1, ?2, ?3, ?4, ?5)")
            .blob(key)
            .blob(value)
            .number(int64_t(added))
            .number(int64_t(checksumOf(key, value)))
            .number(now())
            .step();
        execute("COMMIT");
    });
}

} // namespace sunstone::cache
