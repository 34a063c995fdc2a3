// SPDX-License-Identifier: Apache-2.0
#include "base/handles.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>

namespace sunstone {
namespace {

struct Object : Handled {
    int number = 0;
};

// A new object may get the memory of a destroyed one; here the very same object is added again.
TEST(HandleTable, RefusesAStaleHandleWhoseAddressIsReused) {
    HandleTable<Object> table;
    const auto object = std::make_shared<Object>();
    void* const stale = table.add(object);
    EXPECT_EQ(object->handle(), stale);
    EXPECT_EQ(table.remove(stale), object);
    void* const live = table.add(object);
    EXPECT_NE(live, stale);
    EXPECT_EQ(table.find(stale), nullptr);
    EXPECT_EQ(table.peek(reinterpret_cast<uint64_t>(stale)), nullptr);
    EXPECT_EQ(table.remove(stale), nullptr);
    EXPECT_EQ(table.find(live), object);
    EXPECT_EQ(table.peek(reinterpret_cast<uint64_t>(live)), object.get());
}

TEST(HandleTable, RefusesHandlesOfOtherTablesAndGarbage) {
    HandleTable<Object> ours, other;
    void* const handle = ours.add(std::make_shared<Object>());
    EXPECT_EQ(other.find(handle), nullptr);
    other.add(std::make_shared<Object>()); // in the same slot
    EXPECT_EQ(other.find(handle), nullptr);
    EXPECT_EQ(ours.find(nullptr), nullptr);
    int local = 0;
    EXPECT_EQ(ours.find(&local), nullptr);
    for (const uint64_t garbage :
         {uint64_t(1), ~uint64_t(0), uint64_t(1) << 24, uint64_t(0xffffff)})
        EXPECT_EQ(ours.find(reinterpret_cast<void*>(garbage)), nullptr) << garbage;
}

TEST(HandleTable, GivesEachHandleOnce) {
    HandleTable<Object> table;
    std::set<void*> given;
    for (int i = 0; i < 5000; ++i) {
        void* const handle = table.add(std::make_shared<Object>());
        EXPECT_TRUE(given.insert(handle).second);
        if (i % 3 != 0)
            table.remove(handle);
    }
}

TEST(HandleTable, FindsAndRemovesByPredicate) {
    HandleTable<Object> table;
    std::vector<void*> handles;
    for (int i = 0; i < 2000; ++i) { // more than a block of slots
        auto object = std::make_shared<Object>();
        object->number = i;
        handles.push_back(table.add(object));
    }
    EXPECT_EQ(table.findIf([](const Object& o) { return o.number == 1500; })->handle(),
              handles[1500]);
    EXPECT_EQ(table.removeIf([](const Object& o) { return o.number % 2 == 1; }).size(), 1000u);
    EXPECT_EQ(table.find(handles[1501]), nullptr);
    EXPECT_EQ(table.find(handles[1500])->number, 1500);
    EXPECT_EQ(table.findIf([](const Object& o) { return o.number == 1501; }), nullptr);
}

TEST(HandleTable, PeeksWhileOthersAddAndRemove) {
    HandleTable<Object> table;
    auto kept = std::make_shared<Object>();
    kept->number = 7;
    const auto handle = reinterpret_cast<uint64_t>(table.add(kept));
    std::thread other([&] {
        for (int i = 0; i < 20000; ++i)
            table.remove(table.add(std::make_shared<Object>()));
    });
    for (int i = 0; i < 20000; ++i)
        ASSERT_EQ(table.peek(handle)->number, 7);
    other.join();
}

} // namespace
} // namespace sunstone
