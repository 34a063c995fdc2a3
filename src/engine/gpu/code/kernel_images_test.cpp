// SPDX-License-Identifier: Apache-2.0
// Machine code of the build: the contents of the archive, the entry for a GPU, and refusals by the
// driver.
#include "engine/gpu/code/kernel_images.h"

#include "bvh/gpu/kernels_ptx.h"
#include "engine/gpu/code/kernel_code.h"
#include "engine/gpu/code/ready_code.h"

#include <gtest/gtest.h>
#include <zstd.h>

#include <cstring>

namespace sunstone::engine {
namespace {

using device::cuda::KernelSource;

void append(std::string& to, const void* bytes, size_t count) {
    to.append(static_cast<const char*>(bytes), count);
}

struct Entry {
    unsigned capability;
    std::string id, code;
};
std::string archiveOf(uint32_t toolkit, const std::vector<Entry>& entries) {
    KernelArchive header;
    header.toolkit = toolkit;
    header.count = uint32_t(entries.size());
    std::string archive;
    append(archive, &header, sizeof(header));
    for (const Entry& e : entries) {
        std::string packed(ZSTD_compressBound(e.code.size()), '\0');
        packed.resize(ZSTD_compress(packed.data(), packed.size(), e.code.data(), e.code.size(), 1));
        const KernelArchiveEntry entry = {e.capability, uint32_t(e.id.size()),
                                          uint32_t(e.code.size()), uint32_t(packed.size())};
        append(archive, &entry, sizeof(entry));
        archive += e.id + packed;
    }
    return archive;
}

TEST(KernelImages, CodeOfTheSameMajorNumberServes) {
    const std::string archive = archiveOf(
        13000, {{80, "a", "code of 8.0"}, {86, "a", "code of 8.6"}, {90, "b", "b of 9.0"}});
    const KernelImages images(archive);
    EXPECT_EQ(images.count(), 3u);
    EXPECT_EQ(images.find(80, 13000, "a"), "code of 8.0");
    EXPECT_EQ(images.find(86, 13000, "a"), "code of 8.6");
    EXPECT_EQ(images.find(89, 13020, "a"), "code of 8.6");
    EXPECT_EQ(images.find(90, 13000, "b"), "b of 9.0");
    EXPECT_EQ(images.find(90, 14000, "b"), "b of 9.0");
    EXPECT_EQ(images.find(75, 13000, "a"), "");
    EXPECT_EQ(images.find(90, 13000, "a"), "");
    EXPECT_EQ(images.find(90, 13000, "c"), "");
    EXPECT_EQ(images.find(90, 12080, "b"), ""); // the driver is of an earlier major release
}

TEST(KernelImages, DamageIsNoCode) {
    const std::string archive = archiveOf(13000, {{90, "a", "some code"}});
    for (size_t size = 0; size < archive.size(); ++size)
        EXPECT_EQ(KernelImages(std::string_view(archive).substr(0, size)).find(90, 13000, "a"), "");
    std::string other = archive;
    other[0] = 'x';
    EXPECT_EQ(KernelImages(other).find(90, 13000, "a"), "");
}

// A build with ptxas has code of every kernel for every capability, as ELF files that name it.
TEST(KernelImages, TheLibraryHasItsBuilders) {
    const KernelImages& built = builtKernelImages();
    if (built.count() == 0)
        GTEST_SKIP() << "no ptxas here: the archive is empty";
    const std::string_view ptx = bvh::gpu::builderPtx();
    constexpr std::string_view kEntry = ".entry ";
    unsigned kernels = 0;
    for (size_t at = ptx.find(kEntry); at != ptx.npos; at = ptx.find(kEntry, at + 1), ++kernels) {
        const size_t begin = at + kEntry.size();
        const std::string name(ptx.substr(begin, ptx.find('(', begin) - begin));
        for (const unsigned capability : {80u, 90u}) {
            const std::string code = built.find(capability, 99000, name);
            ASSERT_GT(code.size(), 64u) << name;
            EXPECT_EQ(code.substr(1, 3), "ELF") << name;
            EXPECT_NE(code.find(".text." + name), code.npos) << name;
        }
    }
    EXPECT_GT(kernels, 30u);
    EXPECT_NE(built.find(90, 99000, "batch_closest"), "");
    EXPECT_NE(built.find(90, 99000, "denoiser sunstone_guides"), "");
}

TEST(KernelImages, TheLibraryHasItsReadyKernels) {
    const KernelImages& built = builtKernelImages();
    if (built.count() == 0)
        GTEST_SKIP() << "no ptxas here: the archive is empty";
    const auto kernels = readyKernels({});
    EXPECT_EQ(kernels.size(), 26u);
    for (const auto& kernel : kernels)
        for (const unsigned capability : {75u, 80u, 86u, 90u}) {
            const std::string code = built.find(capability, 99000, readyKernelId(kernel));
            ASSERT_GT(code.size(), 64u) << readyKernelId(kernel) << ", " << capability;
            EXPECT_EQ(code.substr(1, 3), "ELF");
            EXPECT_NE(code.find("sunstone_gpu_resumeAny"), code.npos) << "a dispatcher to link";
        }
}

// No compiler is available here, so code is either an image or left to the driver.
TEST(KernelImages, RefusedImagesAreNotUsedAgain) {
    const std::string archive = archiveOf(13000, {{90, "a", "A"}, {90, "b", "B"}});
    const KernelImages images(archive);
    GpuKernelCode code(90, 13000, &images);
    const KernelSource a = {"a", "a", [] { return std::string("text"); }};
    const KernelSource b = {"b", "b", [] { return std::string("text"); }};
    const KernelSource* const both[] = {&a, &b};
    EXPECT_EQ(code.machineCode(both, false), (std::vector<std::string>{"A", "B"}));
    EXPECT_EQ(code.machineCode({both, 1}, true), std::vector<std::string>{""});
    EXPECT_EQ(code.machineCode(both, false), (std::vector<std::string>{"", ""}));
}

} // namespace
} // namespace sunstone::engine
