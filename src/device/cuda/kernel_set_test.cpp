// SPDX-License-Identifier: Apache-2.0
// Kernel sets on the CPU device, whose driver loads PTX in place of machine code.
#include "device/cuda/kernel_set.h"
#include "device/cuda/test_driver.h"

#include <gtest/gtest.h>

#include <map>
#include <thread>

namespace sunstone::device::cuda {
namespace {

std::string textOf(const std::string& name) {
    return ".version 6.5\n.target sm_70\n.address_size 64\n.visible .entry " + name +
           "()\n{\n\tret;\n}\n";
}

// Returns texts as machine code, and counts the requests for each kernel.
struct Source : MachineCodeSource {
    std::mutex mutex;
    std::map<std::string, int> made;
    std::string instead; // returned for a kernel's first request
    bool fails = false;

    std::vector<std::string> machineCode(std::span<const KernelSource* const> kernels,
                                         bool anew) override {
        std::this_thread::sleep_for(std::chrono::milliseconds(5)); // so that other threads call
                                                                   // meanwhile
        std::lock_guard lock(mutex);
        if (fails)
            fail(Code::kInternal, "as asked");
        std::vector<std::string> codes;
        for (const KernelSource* kernel : kernels) {
            ++made[kernel->id];
            codes.push_back(instead.empty() || anew ? kernel->text() : instead);
        }
        return codes;
    }
};

std::vector<KernelSource> kernels(int count, int* texts = nullptr) {
    std::vector<KernelSource> all;
    for (int i = 0; i < count; ++i) {
        const std::string name = "kernel" + std::to_string(i);
        all.push_back({name, "set " + name, [=] {
                           if (texts)
                               ++*texts;
                           return textOf(name);
                       }});
    }
    return all;
}

TEST(KernelSet, PreparesAll) {
    Source source;
    KernelSet set(testDriver(), &source, kernels(5));
    set.prepareAll();
    EXPECT_EQ(source.made.size(), 5u);
    source.fails = true; // all code exists already
    for (uint32_t kernel = 0; kernel < 5; ++kernel)
        EXPECT_NE(set.function(kernel), nullptr);
}

int unloaded = 0;

TEST(KernelSet, CallsNoDriverAfterItsContextIsDestroyed) {
    Driver driver = testDriver();
    driver.moduleUnload = [](CUmodule module) {
        ++unloaded;
        return testDriver().moduleUnload(module);
    };
    for (const bool isDestroyed : {false, true}) {
        unloaded = 0;
        {
            KernelSet set(driver, nullptr, kernels(3));
            set.prepareAll();
            if (isDestroyed)
                set.abandon();
        }
        EXPECT_EQ(unloaded, isDestroyed ? 0 : 3);
    }
}

TEST(KernelSet, MakesEachKernelOnceHoweverManyThreadsAsk) {
    const Driver& driver = testDriver();
    CUcontext context = nullptr;
    ASSERT_EQ(driver.ctxGetCurrent(&context), CUDA_SUCCESS);
    constexpr uint32_t kCount = 12;
    Source source;
    KernelSet set(driver, &source, kernels(kCount));
    std::vector<std::thread> threads;
    std::atomic<int> missing = 0;
    for (uint32_t t = 0; t < 8; ++t)
        threads.emplace_back([&, t] {
            driver.ctxPushCurrent(context);
            std::vector<uint32_t> wanted; // shared in part with other threads
            for (uint32_t i = 0; i < 6; ++i)
                wanted.push_back((t + i) % kCount);
            wanted.push_back(wanted[0]);
            set.prepare(wanted);
            for (const uint32_t kernel : wanted)
                missing += set.function(kernel) == nullptr;
            driver.ctxPopCurrent(&context);
        });
    for (std::thread& thread : threads)
        thread.join();
    EXPECT_EQ(missing, 0);
    EXPECT_EQ(source.made.size(), kCount);
    for (const auto& [id, count] : source.made)
        EXPECT_EQ(count, 1) << id;
}

TEST(KernelSet, NothingIsMadeThatNobodyNeeds) {
    Source source;
    KernelSet set(testDriver(), &source, kernels(3));
    EXPECT_TRUE(source.made.empty());
    EXPECT_NE(set.function(1), nullptr);
    EXPECT_EQ(source.made, (std::map<std::string, int>{{"set kernel1", 1}}));
}

TEST(KernelSet, WhatTheDriverRefusesIsMadeAnew) {
    Source source;
    source.instead = "what no driver takes";
    int texts = 0;
    KernelSet set(testDriver(), &source, kernels(2, &texts));
    EXPECT_NE(set.function(0), nullptr);
    EXPECT_EQ(source.made["set kernel0"], 2);
    EXPECT_EQ(texts, 1);
}

TEST(KernelSet, WithoutMachineCodeTheDriverGetsTheText) {
    int texts = 0;
    KernelSet set(testDriver(), nullptr, kernels(2, &texts));
    EXPECT_NE(set.function(0), nullptr);
    EXPECT_NE(set.function(0), nullptr);
    EXPECT_EQ(texts, 1);
}

TEST(KernelSet, FailuresCanBeTriedAgain) {
    Source source;
    source.fails = true;
    KernelSet set(testDriver(), &source, kernels(2));
    const uint32_t both[] = {0, 1};
    EXPECT_THROW(set.prepare(both), Error);
    source.fails = false;
    set.prepare(both);
    EXPECT_NE(set.function(1), nullptr);
    EXPECT_EQ(source.made["set kernel1"], 1);
    // A kernel that is missing in its text.
    std::vector<KernelSource> wrong = kernels(1);
    wrong[0].name = "another";
    KernelSet broken(testDriver(), nullptr, wrong);
    EXPECT_THROW(broken.function(0), Error);
}

TEST(KernelSet, ModulesOfOneKernel) {
    const std::string head = ".version 6.5\n.target sm_70\n.address_size 64\n",
                      declared = ".func  (.param .b32 func_retval0) one\n(\n\t.param .b32 a\n)\n;\n"
                                 ".weak .func two\n()\n;\n",
                      variable = ".const .align 4 .b8 three[4];\n",
                      first = ".visible .entry first(\n\t.param .u64 a\n)\n{\n\tcall one;\n}\n",
                      second = ".visible .entry first_again()\n{\n\tret;\n}\n",
                      one = ".func  (.param .b32 func_retval0) one(\n\t.param .b32 a\n)\n{\n"
                            "\tcall.uni two;\n}\n",
                      two = ".weak .func two()\n{\n\tret;\n}\n";
    const std::string all = head + declared + variable + first + second + one + two;
    const auto lines = [](const std::string& text) { // blank ones do not count
        std::string result;
        for (const char c : text)
            if (c != '\n' || (!result.empty() && result.back() != '\n'))
                result += c;
        return result;
    };
    const KernelTexts texts(all);
    EXPECT_EQ(lines(texts.moduleOf("first_again")), head + variable + second);
    EXPECT_EQ(lines(texts.moduleOf("first")), head + declared + variable + first + one + two);
    EXPECT_THROW(texts.moduleOf("fir"), Error);
}

} // namespace
} // namespace sunstone::device::cuda
