// SPDX-License-Identifier: Apache-2.0
// See fat_binary.h.
#include "api/cuda/driver/modules/fat_binary.h"

#include "api/cuda/driver/shell.h"
#include "base/readable.h"

#include <lz4.h>
#include <zstd.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

namespace sunstone::api::cuda {

namespace {

constexpr uint32_t kWrapperMagic = 0x466243B1;
constexpr uint32_t kContainerMagic = 0xBA55ED50;
constexpr uint32_t kElfMagic = 0x464C457F;
constexpr uint32_t kLinkedMagic = 0x4C4E5553; // "SUNL"
constexpr size_t kLargestImage = size_t(1) << 30;

struct Wrapper {
    uint32_t magic;
    uint32_t version;
    const void* container;
    const void* next;
};
struct ContainerHeader {
    uint32_t magic;
    uint16_t version;
    uint16_t headerSize;
    uint64_t size;
};
struct EntryHeader {
    uint16_t kind; // 1 PTX, 2 machine code
    uint16_t version;
    uint32_t headerSize;
    uint64_t payloadSize; // padded
    uint32_t compressedSize;
    uint32_t optionsOffset;
    uint16_t minor;
    uint16_t major;
    uint32_t architecture; // 75 for sm_75
    uint32_t nameOffset;
    uint32_t nameLength;
    uint64_t flags;
    uint64_t reserved;
    uint64_t uncompressedSize;
};
static_assert(sizeof(EntryHeader) == 64);
struct LinkedHeader {
    uint32_t magic;
    uint32_t count;
    uint64_t size; // of all texts, NULs included
};
constexpr uint16_t kKindPtx = 1;
constexpr uint64_t kFlagZstd = 0x8000, kFlagLz4 = 0x2000;

// The bytes of an image: process memory of unknown length (images have no size), or a buffer of
// known size.
class Bytes {
public:
    Bytes(const void* base, size_t known) : base_(static_cast<const char*>(base)), known_(known) {}
    // The bytes [offset, offset + size), or null if they are not available.
    const char* at(uint64_t offset, uint64_t size) const {
        if (offset > kLargestImage || size > kLargestImage)
            return nullptr;
        if (known_)
            return offset + size <= known_ ? base_ + offset : nullptr;
        // All bytes before them must be readable, too: memory behind a gap is not part of the
        // image.
        const uint64_t end = offset + size;
        if (end > readable_) {
            if (!isReadable(base_ + readable_, end - readable_))
                return nullptr;
            readable_ = end;
        }
        return base_ + offset;
    }
    template <class T>
    bool read(uint64_t offset, T& value) const {
        const char* from = at(offset, sizeof(T));
        if (from)
            std::memcpy(&value, from, sizeof(T));
        return from != nullptr;
    }

private:
    const char* base_;
    size_t known_; // 0: unknown
    mutable uint64_t readable_ = 0;
};

[[noreturn]] void damaged(const char* what) {
    refuse(CUDA_ERROR_INVALID_IMAGE, "damaged fat binary: ", what);
}

std::string withoutTrailingZeros(std::string text) {
    if (size_t end = text.find('\0'); end != std::string::npos)
        text.resize(end);
    return text;
}

std::string unpack(const EntryHeader& entry, const char* payload) {
    const bool zstd = entry.flags & kFlagZstd, lz4 = entry.flags & kFlagLz4;
    if (!zstd && !lz4)
        return withoutTrailingZeros(std::string(payload, entry.payloadSize));
    if (entry.compressedSize == 0 || entry.compressedSize > entry.payloadSize)
        damaged("a compressed size exceeds its payload");
    if (entry.uncompressedSize == 0 || entry.uncompressedSize > kLargestImage)
        damaged("an uncompressed size is not plausible");
    std::string text(entry.uncompressedSize, '\0');
    if (zstd) {
        const size_t size =
            ZSTD_decompress(text.data(), text.size(), payload, entry.compressedSize);
        if (ZSTD_isError(size))
            damaged(ZSTD_getErrorName(size));
        text.resize(size);
    } else {
        const int size =
            LZ4_decompress_safe(payload, text.data(), int(entry.compressedSize), int(text.size()));
        if (size < 0)
            damaged("LZ4 data cannot be decompressed");
        text.resize(size_t(size));
    }
    return withoutTrailingZeros(std::move(text));
}

// Whether PTX for architecture `a` suits the device better than PTX for `b`: the highest one up to
// the device's capability, else the lowest above it.
bool better(uint32_t a, uint32_t b) {
    constexpr uint32_t ours = kMajor * 10 + kMinor;
    if ((a <= ours) != (b <= ours))
        return a <= ours;
    return a <= ours ? a > b : a < b;
}

std::string ptxOfContainer(const Bytes& bytes) {
    std::optional<EntryHeader> best;
    const char* bestPayload = nullptr;
    bool machineCode = false;
    ContainerHeader header{};
    if (!bytes.read(0, header) || header.magic != kContainerMagic)
        damaged("no container header");
    if (header.headerSize < sizeof header || header.size > kLargestImage)
        damaged("implausible header");
    const uint64_t end = header.headerSize + header.size;
    for (uint64_t offset = header.headerSize; offset < end;) {
        EntryHeader entry{};
        if (end - offset < sizeof entry || !bytes.read(offset, entry))
            damaged("an entry header is cut off");
        if (entry.headerSize < sizeof entry || entry.headerSize > end - offset ||
            entry.payloadSize > end - offset - entry.headerSize)
            damaged("an entry is cut off");
        const char* payload = bytes.at(offset + entry.headerSize, entry.payloadSize);
        if (!payload)
            damaged("a payload is not in memory");
        if (entry.kind == kKindPtx) {
            if (!best || better(entry.architecture, best->architecture)) {
                best = entry;
                bestPayload = payload;
            }
        } else {
            machineCode = true;
        }
        offset += entry.headerSize + entry.payloadSize;
    }
    if (!best) {
        if (machineCode)
            refuse(CUDA_ERROR_NO_BINARY_FOR_GPU,
                   "the fat binary holds machine code only; compile with PTX, for instance "
                   "-arch=compute_75");
        refuse(CUDA_ERROR_NO_BINARY_FOR_GPU, "the fat binary is empty");
    }
    return unpack(*best, bestPayload);
}

// Text up to its NUL or the end of readable memory.
std::string textAt(const char* text) {
    size_t length = 0;
    for (;;) {
        const size_t step = 4096 - (uintptr_t(text) + length) % 4096;
        if (length > kLargestImage || !isReadable(text + length, step))
            refuse(CUDA_ERROR_INVALID_IMAGE, "the image is text without an end");
        if (const void* end = std::memchr(text + length, 0, step))
            return std::string(text, static_cast<const char*>(end));
        length += step;
    }
}

std::vector<std::string> ptxOfLinked(const Bytes& bytes) {
    LinkedHeader header{};
    if (!bytes.read(0, header))
        damaged("the header of a linked image is cut off");
    const char* at = bytes.at(sizeof header, header.size);
    if (!at)
        damaged("a linked image is cut off");
    const char* const end = at + header.size;
    std::vector<std::string> texts;
    while (at < end) {
        const char* stop = static_cast<const char*>(std::memchr(at, 0, size_t(end - at)));
        if (!stop)
            damaged("a text of a linked image has no end");
        texts.emplace_back(at, stop);
        at = stop + 1;
    }
    if (texts.empty() || texts.size() != header.count)
        damaged("a linked image holds other texts than it says");
    return texts;
}

std::vector<std::string> ptxOf(const Bytes& bytes, const void* text, size_t known) {
    uint32_t magic = 0;
    if (bytes.read(0, magic)) {
        if (magic == kLinkedMagic)
            return ptxOfLinked(bytes);
        if (magic == kContainerMagic)
            return {ptxOfContainer(bytes)};
        if (magic == kWrapperMagic) {
            Wrapper wrapper{};
            if (!bytes.read(0, wrapper) || !isReadable(wrapper.container, 16))
                damaged("the wrapper points nowhere");
            return {ptxOfContainer(Bytes(wrapper.container, 0))};
        }
        if (magic == kElfMagic)
            refuse(CUDA_ERROR_NO_BINARY_FOR_GPU,
                   "the image is machine code of a GPU; this device takes PTX");
    }
    return {known ? withoutTrailingZeros(std::string(static_cast<const char*>(text), known))
                  : textAt(static_cast<const char*>(text))};
}

} // namespace

std::vector<std::string> ptxOfImage(const void* image) {
    require(image, "image is null");
    if (!isReadable(image, 1))
        refuse(CUDA_ERROR_INVALID_VALUE, "image ", image, " is not memory of this process");
    return ptxOf(Bytes(image, 0), image, 0);
}

std::vector<std::string> ptxOfBytes(const void* image, size_t size) {
    require(image && size, "image is null or empty");
    if (!isReadable(image, size))
        refuse(CUDA_ERROR_INVALID_VALUE, "image ", image, " + ", size,
               " is not memory of this process");
    return ptxOf(Bytes(image, size), image, size);
}

std::string makeLinkedImage(const std::vector<std::string>& texts) {
    LinkedHeader header{kLinkedMagic, uint32_t(texts.size()), 0};
    std::string image(sizeof header, '\0');
    for (const std::string& text : texts)
        image.append(text.c_str(), text.size() + 1);
    header.size = image.size() - sizeof header;
    std::memcpy(image.data(), &header, sizeof header);
    return image;
}

std::vector<std::string> ptxOfFile(const char* path) {
    require(path, "file name is null");
    std::ifstream file(path, std::ios::binary);
    if (!file)
        refuse(CUDA_ERROR_FILE_NOT_FOUND, "cannot open ", path);
    std::string content((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (content.empty())
        refuse(CUDA_ERROR_INVALID_IMAGE, path, " is empty");
    uint32_t magic = 0;
    std::memcpy(&magic, content.data(), std::min<size_t>(4, content.size()));
    if (magic == kWrapperMagic)
        refuse(CUDA_ERROR_INVALID_IMAGE, path, " holds a wrapper, whose pointer means nothing");
    return ptxOf(Bytes(content.data(), content.size()), content.data(), content.size());
}

} // namespace sunstone::api::cuda
