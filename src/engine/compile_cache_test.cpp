// SPDX-License-Identifier: Apache-2.0
// Log callbacks of a context's disk cache: they may wait for another thread that uses the cache.
#include "engine/compile_cache.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <future>
#include <thread>
#include <vector>

namespace sunstone::engine {
namespace {

class CompileCacheLog : public ::testing::Test {
protected:
    void SetUp() override {
        std::string name = ::testing::TempDir() + "sunstone_cache_XXXXXX";
        ASSERT_NE(nullptr, mkdtemp(name.data()));
        folder_ = name;
    }
    void TearDown() override {
        for (std::thread& thread : threads_)
            thread.join();
        cache_.reset();
        std::filesystem::remove_all(folder_);
        unsetenv("OPTIX_CACHE_MAXSIZE");
        unsetenv("OPTIX_CACHE_PATH");
    }
    void make() {
        cache_ = std::make_unique<CompileCache>([this](LogLevel, const std::string&) {
            ++lines_;
            auto answer = std::make_shared<std::promise<std::string>>();
            threads_.emplace_back([this, answer] { answer->set_value(cache_->location()); });
            answers_ +=
                answer->get_future().wait_for(std::chrono::seconds(5)) == std::future_status::ready;
        });
    }

    std::string folder_;
    std::vector<std::thread> threads_;
    unsigned lines_ = 0, answers_ = 0;
    std::unique_ptr<CompileCache> cache_;
};

TEST_F(CompileCacheLog, OfSettings) {
    setenv("OPTIX_CACHE_MAXSIZE", "1000000", 1);
    setenv("OPTIX_CACHE_PATH", folder_.c_str(), 1);
    make();
    cache_->setMarks({1, 2});
    cache_->setLocation("/elsewhere");
    EXPECT_EQ(2u, lines_);
    EXPECT_EQ(2u, answers_);
}

TEST_F(CompileCacheLog, OfACacheThatIsOff) {
    setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
    make();
    cache_->setEnabled(true);
    EXPECT_EQ(1u, lines_);
    EXPECT_EQ(1u, answers_);
}

TEST_F(CompileCacheLog, OfOpening) {
    std::ofstream(folder_ + "/programs1-1.db") << std::string(5000, 'x');
    make();
    cache_->setLocation(folder_);
    cache_->setEnabled(true); // logs the damage
    EXPECT_EQ(1u, lines_);
    EXPECT_EQ(1u, answers_);
    EXPECT_TRUE(cache_->enabled());
}

TEST_F(CompileCacheLog, OfAFailure) {
    setenv("OPTIX_CACHE_PATH", "/dev/null/none", 1);
    make();
    cache_->start();
    EXPECT_EQ(1u, lines_);
    EXPECT_EQ(1u, answers_);
    EXPECT_FALSE(cache_->enabled());
}

} // namespace
} // namespace sunstone::engine
