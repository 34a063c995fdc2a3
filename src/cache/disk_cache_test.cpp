// SPDX-License-Identifier: Apache-2.0
// The database alone: values, marks, damage of every kind, threads, processes.
#include "cache/disk_cache.h"

#include "base/error.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <future>
#include <random>
#include <sys/stat.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace sunstone::cache {
namespace {

namespace fs = std::filesystem;

class DiskCacheTest : public ::testing::Test {
protected:
    void SetUp() override {
        std::string name = ::testing::TempDir() + "sunstone_cache_XXXXXX";
        ASSERT_NE(nullptr, mkdtemp(name.data()));
        root_ = name;
        folder_ = root_ + "/cache";
    }
    void TearDown() override { fs::remove_all(root_); }

    std::unique_ptr<DiskCache> open() {
        return std::make_unique<DiskCache>(folder_, false, [this](LogLevel, const std::string& t) {
            std::lock_guard lock(mutex_);
            log_ += t + "\n";
        });
    }
    static std::string valueOf(unsigned i, size_t size) {
        std::string value(size, 0);
        std::mt19937 random(i);
        for (char& byte : value)
            byte = char(random());
        return value;
    }
    std::vector<std::string> databases() {
        std::vector<std::string> found;
        for (const auto& entry : fs::directory_iterator(folder_))
            if (entry.path().extension() == ".db")
                found.push_back(entry.path());
        return found;
    }
    Code codeOfOpening(const std::string& folder, bool isPrivate = false) {
        try {
            DiskCache(folder, isPrivate, [](LogLevel, const std::string&) {});
        } catch (const Error& error) {
            return error.code();
        }
        return Code::kOk;
    }

    std::mutex mutex_;
    std::string root_, folder_, log_;
};

TEST_F(DiskCacheTest, KeepsValues) {
    std::string value = "before";
    {
        const auto cache = open();
        EXPECT_FALSE(cache->find("a", value));
        EXPECT_EQ("", value);
        cache->insert("a", std::string("one\0two", 7), {});
        cache->insert("b", "", {});
        cache->insert("a", "new", {});
    }
    const auto cache = open();
    ASSERT_TRUE(cache->find("a", value));
    EXPECT_EQ("new", value);
    ASSERT_TRUE(cache->find("b", value));
    EXPECT_EQ("", value);
    EXPECT_FALSE(cache->find("c", value));
    EXPECT_TRUE(cache->has("a"));
    EXPECT_TRUE(cache->has("b"));
    EXPECT_FALSE(cache->has("c"));
    EXPECT_EQ("", log_);
}

TEST_F(DiskCacheTest, FolderIsForThisUserAlone) {
    open();
    struct stat info;
    ASSERT_EQ(0, stat(folder_.c_str(), &info));
    EXPECT_EQ(0u, info.st_mode & 077);
}

TEST_F(DiskCacheTest, CollectsDownToTheLowMark) {
    const auto cache = open();
    const Marks marks{50'000, 100'000};
    std::string value;
    for (unsigned i = 0; i < 9; ++i)
        cache->insert(std::to_string(i), valueOf(i, 10'000), marks);
    EXPECT_GT(cache->size(), 90'000u);
    EXPECT_LE(cache->size(), 100'000u);
    EXPECT_TRUE(cache->find("0", value));
    cache->insert("9", valueOf(9, 10'000), marks); // would pass the high mark
    EXPECT_LE(cache->size(), 50'000u);
    EXPECT_GT(cache->size(), 30'000u);
    EXPECT_FALSE(cache->find("0", value)) << "the oldest goes first";
    EXPECT_FALSE(cache->find("5", value));
    EXPECT_TRUE(cache->find("8", value));
    ASSERT_TRUE(cache->find("9", value));
    EXPECT_EQ(valueOf(9, 10'000), value);
}

TEST_F(DiskCacheTest, CollectionGivesSpaceBackToTheDisk) {
    const auto cache = open();
    for (unsigned i = 0; i < 40; ++i)
        cache->insert(std::to_string(i), valueOf(i, 100'000), {});
    const auto before = fs::file_size(databases()[0]);
    cache->insert("last", "x", {200'000, 300'000});
    EXPECT_LT(fs::file_size(databases()[0]), before / 4);
}

TEST_F(DiskCacheTest, EitherMarkZeroMeansNoCollection) {
    const auto cache = open();
    std::string value;
    for (const Marks marks : {Marks{0, 1000}, Marks{1000, 0}, Marks{0, 0}})
        for (unsigned i = 0; i < 5; ++i)
            cache->insert(std::to_string(i), valueOf(i, 10'000), marks);
    for (unsigned i = 0; i < 5; ++i)
        EXPECT_TRUE(cache->find(std::to_string(i), value));
}

TEST_F(DiskCacheTest, EntriesAboveTheHighMarkAreNotStored) {
    const auto cache = open();
    std::string value;
    cache->insert("small", "x", {1000, 2000});
    cache->insert("big", valueOf(1, 3000), {1000, 2000});
    EXPECT_FALSE(cache->find("big", value));
    EXPECT_TRUE(cache->find("small", value));
    EXPECT_NE(std::string::npos, log_.find("high water mark")) << log_;
    // Size between the marks: all other values are evicted.
    cache->insert("medium", valueOf(1, 1900), {1000, 2000});
    EXPECT_TRUE(cache->find("medium", value));
    EXPECT_FALSE(cache->find("small", value));
}

// A log callback may wait for another thread that uses the cache.
TEST_F(DiskCacheTest, LogsWithoutItsLock) {
    std::unique_ptr<DiskCache> cache;
    unsigned lines = 0, answers = 0;
    std::vector<std::thread> threads;
    cache = std::make_unique<DiskCache>(folder_, false, [&](LogLevel, const std::string&) {
        ++lines;
        auto answer = std::make_shared<std::promise<uint64_t>>();
        threads.emplace_back([&, answer] { answer->set_value(cache->size()); });
        answers +=
            answer->get_future().wait_for(std::chrono::seconds(5)) == std::future_status::ready;
    });
    cache->insert("key", valueOf(1, 1000), {1, 100}); // is not stored, which is logged
    EXPECT_EQ(1u, lines);
    EXPECT_EQ(1u, answers);
    for (std::thread& thread : threads)
        thread.join();
}

TEST_F(DiskCacheTest, LogsOfOpeningMayOpenTheFolderToo) {
    open()->insert("key", "value", {});
    std::ofstream(databases().front(), std::ios::trunc) << std::string(5000, 'x');
    unsigned lines = 0, answers = 0;
    std::vector<std::thread> threads;
    const DiskCache cache(folder_, false, [&](LogLevel, const std::string&) {
        ++lines;
        auto answer = std::make_shared<std::promise<void>>();
        threads.emplace_back([this, answer] {
            open();
            answer->set_value();
        });
        answers +=
            answer->get_future().wait_for(std::chrono::seconds(5)) == std::future_status::ready;
    });
    EXPECT_EQ(1u, lines); // of the damage
    EXPECT_EQ(1u, answers);
    for (std::thread& thread : threads)
        thread.join();
}

TEST_F(DiskCacheTest, PlacesThatCannotBeUsed) {
    EXPECT_EQ(Code::kCacheInvalidPath, codeOfOpening(""));
    std::ofstream(root_ + "/file") << "x";
    EXPECT_EQ(Code::kCacheInvalidPath, codeOfOpening(root_ + "/file"));
    EXPECT_EQ(Code::kCacheInvalidPath, codeOfOpening(root_ + "/file/below"));
    EXPECT_EQ(Code::kCacheInvalidPath, codeOfOpening(root_ + "/" + std::string(5000, 'x')));
    fs::create_symlink("loop", root_ + "/loop");
    EXPECT_EQ(Code::kCacheInvalidPath, codeOfOpening(root_ + "/loop/cache"));
    EXPECT_EQ(Code::kOk, codeOfOpening(root_ + "/made/on/the/way//"));
    fs::create_directories(folder_ + "/programs1-1.db"); // not a file
    EXPECT_EQ(Code::kCacheDatabase, codeOfOpening(folder_));
    if (geteuid() != 0) {
        fs::create_directory(root_ + "/readonly");
        chmod((root_ + "/readonly").c_str(), 0500);
        EXPECT_EQ(Code::kCachePermission, codeOfOpening(root_ + "/readonly"));
        EXPECT_EQ(Code::kCachePermission, codeOfOpening(root_ + "/readonly/below"));
    }
}

TEST_F(DiskCacheTest, PrivateFoldersAreNotTakenFromOthers) {
    fs::create_directory(folder_);
    chmod(folder_.c_str(), 0777);
    EXPECT_EQ(Code::kCachePermission, codeOfOpening(folder_, true));
    EXPECT_EQ(Code::kOk, codeOfOpening(folder_, false));
    chmod(folder_.c_str(), 0700);
    EXPECT_EQ(Code::kOk, codeOfOpening(folder_, true));
    fs::create_directory_symlink(folder_, root_ + "/link");
    EXPECT_EQ(Code::kCachePermission, codeOfOpening(root_ + "/link", true));
}

// After any change of the files: returned values are correct, and the cache works again.
void expectRight(DiskCache& cache, unsigned count, size_t size,
                 const std::function<std::string(unsigned, size_t)>& valueOf) {
    std::string value;
    for (unsigned i = 0; i < count; ++i)
        if (cache.find(std::to_string(i), value))
            EXPECT_EQ(valueOf(i, size), value) << i;
    cache.insert("after", "well", {});
    EXPECT_TRUE(cache.find("after", value));
    EXPECT_EQ("well", value);
}

TEST_F(DiskCacheTest, RandomDamage) {
    constexpr unsigned kEntries = 12;
    constexpr size_t kSize = 3000;
    const unsigned seed = std::random_device()();
    SCOPED_TRACE(message("seed ", seed));
    std::mt19937 random(seed);
    for (unsigned round = 0; round < 60; ++round) {
        fs::remove_all(folder_);
        {
            const auto cache = open();
            for (unsigned i = 0; i < kEntries; ++i)
                cache->insert(std::to_string(i), valueOf(i, kSize), {});
        }
        const std::string path = databases().at(0);
        const auto size = fs::file_size(path);
        if (round % 4 == 0) {
            fs::resize_file(path, random() % size);
        } else {
            std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
            const unsigned count = round % 4 == 1 ? 1 : round % 4 == 2 ? 20 : 4096;
            const size_t range = round % 8 == 2 ? 200 : size; // every fourth round only the header
            for (unsigned i = 0; i < count; ++i) {
                file.seekp(std::streamoff(random() % range));
                file.put(char(random()));
            }
        }
        const auto cache = open();
        expectRight(*cache, kEntries, kSize, valueOf);
    }
}

TEST_F(DiskCacheTest, DamageWhileOpen) {
    const auto cache = open(), other = open();
    for (unsigned i = 0; i < 5; ++i)
        cache->insert(std::to_string(i), valueOf(i, 3000), {});
    std::ofstream(databases().at(0), std::ios::binary) << std::string(100'000, 'x');
    expectRight(*cache, 5, 3000, valueOf);
    expectRight(*other, 5, 3000, valueOf);
    std::string value;
    cache->insert("shared", "again", {});
    EXPECT_TRUE(other->find("shared", value)) << "both use the same new database\n" << log_;
    EXPECT_EQ(1u, databases().size());
}

TEST_F(DiskCacheTest, RubbishInPlaceOfADatabase) {
    fs::create_directories(folder_);
    for (const char* text : {"", "short", "SQLite format 3"}) {
        for (const auto& path : databases())
            fs::remove(path);
        std::ofstream(folder_ + "/programs1-7.db") << text << std::string(5000, 0);
        expectRight(*open(), 0, 0, valueOf);
    }
    std::ofstream(folder_ + "/programs1-99999999999999.db") << "number too large";
    std::ofstream(folder_ + "/programs1-x.db") << "no number";
    expectRight(*open(), 0, 0, valueOf);
}

TEST_F(DiskCacheTest, FolderRemovedWhileOpen) {
    const auto cache = open();
    cache->insert("a", "x", {});
    fs::remove_all(folder_);
    cache->insert("b", "y", {});
    cache->insert("c", "z", {});
    std::string value;
    EXPECT_TRUE(cache->find("c", value)) << log_;
    EXPECT_TRUE(open()->find("c", value)) << "it is back on the disk\n" << log_;
}

TEST_F(DiskCacheTest, ManyThreads) {
    const auto one = open(), two = open();
    std::atomic<unsigned> hits{0};
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            DiskCache& cache = t % 2 ? *one : *two;
            std::string value;
            for (unsigned i = 0; i < 30; ++i) {
                const unsigned number = (i * 7 + t) % 20;
                if (cache.find(std::to_string(number), value)) {
                    EXPECT_EQ(valueOf(number, 2000), value);
                    ++hits;
                } else {
                    cache.insert(std::to_string(number), valueOf(number, 2000), {20'000, 30'000});
                }
            }
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_GT(hits, 0u);
    EXPECT_LE(one->size(), 30'000u);
    EXPECT_EQ("", log_);
}

TEST_F(DiskCacheTest, ManyProcesses) {
    constexpr unsigned kProcesses = 5, kEntries = 25;
    std::vector<pid_t> children;
    for (unsigned p = 0; p < kProcesses; ++p) {
        const pid_t child = fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            // All processes open, fill and damage-check at once; the exit code is the result.
            bool good = true;
            try {
                const auto cache = open();
                std::string value;
                for (unsigned i = 0; i < kEntries; ++i) {
                    const unsigned number = (i + p * 3) % kEntries;
                    if (cache->find(std::to_string(number), value))
                        good &= value == valueOf(number, 4000);
                    else
                        cache->insert(std::to_string(number), valueOf(number, 4000), {});
                }
                good &= log_.empty();
                if (!good)
                    fprintf(stderr, "%s", log_.c_str());
            } catch (const std::exception& error) {
                fprintf(stderr, "%s\n", error.what());
                good = false;
            }
            _exit(good ? 0 : 1);
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = -1;
        ASSERT_EQ(child, waitpid(child, &status, 0));
        EXPECT_EQ(0, status);
    }
    const auto cache = open();
    std::string value;
    for (unsigned i = 0; i < kEntries; ++i)
        EXPECT_TRUE(cache->find(std::to_string(i), value));
}

TEST_F(DiskCacheTest, KilledProcessesLeaveNoDamage) {
    for (unsigned round = 0; round < 8; ++round) {
        const pid_t child = fork();
        ASSERT_GE(child, 0);
        if (child == 0) {
            const auto cache = open();
            for (unsigned i = 0;; ++i)
                cache->insert(std::to_string(i % 10), valueOf(i % 10, 20'000), {60'000, 100'000});
        }
        usleep(10'000 + round * 7'000);
        kill(child, SIGKILL);
        waitpid(child, nullptr, 0);
        const auto cache = open();
        expectRight(*cache, 10, 20'000, valueOf);
    }
    EXPECT_EQ("", log_);
}

TEST_F(DiskCacheTest, WorksInTheChildOfAFork) {
    const auto cache = open();
    cache->insert("a", "parent", {});
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
        std::string value;
        const bool good = cache->find("a", value) && value == "parent";
        cache->insert("b", "child", {});
        _exit(good ? 0 : 1);
    }
    int status = -1;
    ASSERT_EQ(child, waitpid(child, &status, 0));
    EXPECT_EQ(0, status);
    std::string value;
    EXPECT_TRUE(cache->find("b", value));
    EXPECT_EQ("child", value);
}

} // namespace
} // namespace sunstone::cache
