// SPDX-License-Identifier: Apache-2.0
// Machine code of the library's own kernels that the build made with ptxas, so that a process
// compiles none of them. The archive is a part of the library; a build without ptxas leaves it
// empty. tools/kernel_images writes it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sunstone::engine {

// The archive: this header, then entries one after the other, all without alignment. An entry is
// followed by the kernel's id and by the machine code, compressed by zstd.
struct KernelArchive {
    static constexpr uint32_t kMagic = 0x494b5353; // "SSKI"
    uint32_t magic = kMagic;
    uint32_t toolkit = 0; // version of CUDA whose ptxas made the code: 1000 * major + 10 * minor
    uint32_t count = 0;
};
struct KernelArchiveEntry {
    uint32_t capability = 0; // 90 is 9.0
    uint32_t idBytes = 0, codeBytes = 0, packedBytes = 0;
};

class KernelImages {
public:
    // The bytes must outlive this object.
    explicit KernelImages(std::string_view archive) : archive_(archive) {}

    // Machine code of a kernel for a GPU: for its compute capability, or for an earlier one of the
    // same major number, whose code it runs. Empty if there is none, or if the driver is of an
    // earlier major release than ptxas was, because such drivers refuse the code.
    std::string find(unsigned capability, unsigned driverVersion, std::string_view id) const;
    uint32_t count() const;

private:
    std::string_view archive_;
};

// The images in this library.
const KernelImages& builtKernelImages();

} // namespace sunstone::engine
