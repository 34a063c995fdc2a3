// SPDX-License-Identifier: Apache-2.0
// See kernel_images.h. The archive is a file of the build, SUNSTONE_KERNEL_IMAGES.
#include "engine/gpu/code/kernel_images.h"

#include <zstd.h>

#include <cstring>

asm(".pushsection .rodata\n"
    "sunstone_kernel_images:\n"
    ".incbin \"" SUNSTONE_KERNEL_IMAGES "\"\n"
    "sunstone_kernel_images_end:\n"
    ".byte 0\n"
    ".popsection\n");
extern "C" __attribute__((visibility("hidden"))) const char sunstone_kernel_images[];
extern "C" __attribute__((visibility("hidden"))) const char sunstone_kernel_images_end[];

namespace sunstone::engine {

namespace {

// Reads values from the front of a text; after a fault all further values are zero and empty.
class Reader {
public:
    explicit Reader(std::string_view bytes) : rest_(bytes) {}
    template <class T>
    T value() {
        T result{};
        const std::string_view from = bytes(sizeof(T));
        if (from.size() == sizeof(T))
            std::memcpy(&result, from.data(), sizeof(T));
        return result;
    }
    std::string_view bytes(size_t count) {
        const std::string_view result = rest_.substr(0, count);
        rest_ = result.size() == count ? rest_.substr(count) : std::string_view();
        return result.size() == count ? result : std::string_view();
    }

private:
    std::string_view rest_;
};

KernelArchive headerOf(std::string_view archive) {
    const auto header = Reader(archive).value<KernelArchive>();
    return header.magic == KernelArchive::kMagic ? header : KernelArchive();
}

std::string unpack(std::string_view packed, size_t bytes) {
    std::string code(bytes, '\0');
    const size_t got = ZSTD_decompress(code.data(), code.size(), packed.data(), packed.size());
    return got == bytes ? code : std::string();
}

} // namespace

uint32_t KernelImages::count() const {
    return headerOf(archive_).count;
}

std::string KernelImages::find(unsigned capability, unsigned driverVersion,
                               std::string_view id) const {
    Reader reader(archive_);
    const auto header = headerOf(archive_);
    (void)reader.value<KernelArchive>();
    if (driverVersion / 1000 < header.toolkit / 1000)
        return {};
    unsigned best = 0;
    std::string_view packed;
    size_t bytes = 0;
    for (uint32_t i = 0; i < header.count; ++i) {
        const auto entry = reader.value<KernelArchiveEntry>();
        const std::string_view name = reader.bytes(entry.idBytes);
        const std::string_view code = reader.bytes(entry.packedBytes);
        if (name != id || entry.capability > capability || entry.capability <= best ||
            entry.capability / 10 != capability / 10)
            continue;
        best = entry.capability;
        packed = code;
        bytes = entry.codeBytes;
    }
    return best ? unpack(packed, bytes) : std::string();
}

const KernelImages& builtKernelImages() {
    static const KernelImages images(
        {sunstone_kernel_images, size_t(sunstone_kernel_images_end - sunstone_kernel_images)});
    return images;
}

} // namespace sunstone::engine
