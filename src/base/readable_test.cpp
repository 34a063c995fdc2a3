// SPDX-License-Identifier: Apache-2.0
#include "base/readable.h"

#include <gtest/gtest.h>

#include <sys/mman.h>

#include <cstdint>
#include <vector>

namespace sunstone {
namespace {

constexpr size_t kPage = 4096;

// Pages without access behind and between readable ones.
class Pages {
public:
    explicit Pages(size_t count) : bytes_(count * kPage) {
        void* const start =
            mmap(nullptr, bytes_, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        start_ = static_cast<uint8_t*>(start);
    }
    ~Pages() { munmap(start_, bytes_); }
    uint8_t* page(size_t number) const { return start_ + number * kPage; }
    void forbid(size_t number) const { mprotect(page(number), kPage, PROT_NONE); }

private:
    size_t bytes_;
    uint8_t* start_ = nullptr;
};

TEST(Readable, PagesAreForgottenWithTheEpoch) {
    const Pages pages(2);
    beginReadableEpoch();
    EXPECT_TRUE(isReadableNearby(pages.page(0), 128));
    EXPECT_TRUE(isReadableNearby(pages.page(1), 128));
    pages.forbid(1);
    beginReadableEpoch();
    EXPECT_TRUE(isReadableNearby(pages.page(0), 128));
    EXPECT_FALSE(isReadableNearby(pages.page(1), 128));
}

TEST(Readable, EachPageOfARangeIsChecked) {
    const Pages pages(4);
    pages.forbid(2);
    beginReadableEpoch();
    for (int time = 0; time < 2; ++time) {
        EXPECT_TRUE(isReadableNearby(pages.page(1) - 64, 128));
        EXPECT_TRUE(isReadableNearby(pages.page(2) - 64, 64));
        EXPECT_FALSE(isReadableNearby(pages.page(2) - 64, 65));
        EXPECT_FALSE(isReadableNearby(pages.page(3) - 1, 1));
        EXPECT_TRUE(isReadableNearby(pages.page(3), kPage));
        EXPECT_FALSE(isReadableNearby(pages.page(0), 3 * kPage));
    }
}

// Pages whose numbers differ by a multiple of the table's size share a slot.
TEST(Readable, ManyPages) {
    constexpr size_t kCount = 70000;
    const Pages pages(kCount);
    pages.forbid(4500);
    beginReadableEpoch();
    for (int time = 0; time < 2; ++time)
        for (size_t i = 0; i < kCount; ++i)
            EXPECT_EQ(isReadableNearby(pages.page(i) + 8, 16), i != 4500) << i;
}

TEST(Readable, PagesOfManyAddressesAreRemembered) {
    constexpr size_t kCount = 1000; // several system calls
    const Pages pages(kCount);
    for (size_t i = 0; i < kCount; i += 7)
        pages.forbid(i);
    std::vector<uint64_t> addresses = {0, 8, ~uint64_t(0), uint64_t(1) << 47};
    for (size_t i = 0; i < kCount; ++i)
        addresses.push_back(uintptr_t(pages.page(i)) + 8 * (i % 500));
    beginReadableEpoch();
    rememberReadable(addresses.data(), addresses.size());
    rememberReadable(addresses.data(), 0);
    for (size_t i = 0; i < kCount; ++i)
        pages.forbid(i);
    for (size_t i = 0; i < kCount; ++i)
        EXPECT_EQ(isReadableNearby(pages.page(i), 64), i % 7 != 0) << i;
    beginReadableEpoch();
    EXPECT_FALSE(isReadableNearby(pages.page(1), 64));
}

// An address whose upper bits are no part of a page's number is none, although its page is known.
TEST(Readable, UpperBitsCount) {
    const Pages pages(1);
    beginReadableEpoch();
    EXPECT_TRUE(isReadableNearby(pages.page(0), 8));
    for (int bit = 47; bit < 64; ++bit)
        EXPECT_FALSE(isReadableNearby(
            reinterpret_cast<const void*>(uintptr_t(pages.page(0)) | uintptr_t(1) << bit), 8));
}

TEST(Readable, AddressesThatAreNone) {
    EXPECT_FALSE(isReadableNearby(nullptr, 8));
    EXPECT_FALSE(isReadableNearby(reinterpret_cast<const void*>(8), 8));
    EXPECT_FALSE(isReadableNearby(reinterpret_cast<const void*>(~uintptr_t(0) - 8), 64));
    EXPECT_FALSE(isReadableNearby(reinterpret_cast<const void*>(uintptr_t(1) << 47), 8));
}

} // namespace
} // namespace sunstone
