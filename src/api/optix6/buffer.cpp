// SPDX-License-Identifier: Apache-2.0
// Buffers without their entry points.
#include "api/optix6/buffer.h"

#include "api/optix6/context.h"
#include "api/optix6/gl/share.h"
#include "api/optix6/variable.h"
#include "base/error.h"
#include "base/log.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <limits>
#include <set>
#include <utility>

namespace sunstone::optix6 {

namespace {

constexpr size_t kMargin = 64;          // vector loads at the end
constexpr unsigned kMostBytesLog2 = 46; // of the first level of a buffer
constexpr unsigned kMostLevels = kMostBytesLog2 + 1;

bool isBlockFormat(RTformat format) {
    return format >= RT_FORMAT_UNSIGNED_BC1 && format <= RT_FORMAT_UNSIGNED_BC7;
}

// In the order of RTformat, without "RT_FORMAT_".
constexpr const char* kFormatNames[] = {"UNKNOWN",
                                        "FLOAT",
                                        "FLOAT2",
                                        "FLOAT3",
                                        "FLOAT4",
                                        "BYTE",
                                        "BYTE2",
                                        "BYTE3",
                                        "BYTE4",
                                        "UNSIGNED_BYTE",
                                        "UNSIGNED_BYTE2",
                                        "UNSIGNED_BYTE3",
                                        "UNSIGNED_BYTE4",
                                        "SHORT",
                                        "SHORT2",
                                        "SHORT3",
                                        "SHORT4",
                                        "UNSIGNED_SHORT",
                                        "UNSIGNED_SHORT2",
                                        "UNSIGNED_SHORT3",
                                        "UNSIGNED_SHORT4",
                                        "INT",
                                        "INT2",
                                        "INT3",
                                        "INT4",
                                        "UNSIGNED_INT",
                                        "UNSIGNED_INT2",
                                        "UNSIGNED_INT3",
                                        "UNSIGNED_INT4",
                                        "USER",
                                        "BUFFER_ID",
                                        "PROGRAM_ID",
                                        "HALF",
                                        "HALF2",
                                        "HALF3",
                                        "HALF4",
                                        "LONG_LONG",
                                        "LONG_LONG2",
                                        "LONG_LONG3",
                                        "LONG_LONG4",
                                        "UNSIGNED_LONG_LONG",
                                        "UNSIGNED_LONG_LONG2",
                                        "UNSIGNED_LONG_LONG3",
                                        "UNSIGNED_LONG_LONG4",
                                        "UNSIGNED_BC1",
                                        "UNSIGNED_BC2",
                                        "UNSIGNED_BC3",
                                        "UNSIGNED_BC4",
                                        "BC4",
                                        "UNSIGNED_BC5",
                                        "BC5",
                                        "UNSIGNED_BC6H",
                                        "BC6H",
                                        "UNSIGNED_BC7"};
static_assert(std::size(kFormatNames) == RT_FORMAT_UNSIGNED_BC7 - RT_FORMAT_UNKNOWN + 1);

void requireFits(uint32_t elementBytes, unsigned count, const uint64_t* extents) {
    uint64_t product = std::max(1u, elementBytes);
    for (unsigned i = 0; i < count; ++i)
        if (__builtin_mul_overflow(product, extents[i], &product) || product >> kMostBytesLog2 != 0)
            refuse(RT_ERROR_MEMORY_ALLOCATION_FAILED, "a buffer of this size with elements of ",
                   elementBytes, " bytes does not fit into memory");
}

} // namespace

std::string nameOf(RTformat format) {
    const unsigned place = unsigned(format) - RT_FORMAT_UNKNOWN;
    return place < std::size(kFormatNames) ? std::string("RT_FORMAT_") + kFormatNames[place]
                                           : std::to_string(unsigned(format));
}

unsigned bytesOf(RTformat format) {
    const auto vector = [&](RTformat first, unsigned bytes) -> unsigned {
        return format >= first && unsigned(format) < unsigned(first) + 4
                   ? bytes * (unsigned(format) - unsigned(first) + 1)
                   : 0;
    };
    constexpr std::pair<RTformat, unsigned> kVectors[] = {
        {RT_FORMAT_FLOAT, 4},          {RT_FORMAT_BYTE, 1},
        {RT_FORMAT_UNSIGNED_BYTE, 1},  {RT_FORMAT_SHORT, 2},
        {RT_FORMAT_UNSIGNED_SHORT, 2}, {RT_FORMAT_INT, 4},
        {RT_FORMAT_UNSIGNED_INT, 4},   {RT_FORMAT_HALF, 2},
        {RT_FORMAT_LONG_LONG, 8},      {RT_FORMAT_UNSIGNED_LONG_LONG, 8}};
    for (const auto& [first, bytes] : kVectors)
        if (const unsigned size = vector(first, bytes))
            return size;
    if (format == RT_FORMAT_BUFFER_ID || format == RT_FORMAT_PROGRAM_ID)
        return 4;
    if (isBlockFormat(format)) {
        const bool small = format == RT_FORMAT_UNSIGNED_BC1 || format == RT_FORMAT_UNSIGNED_BC4 ||
                           format == RT_FORMAT_BC4;
        return small ? 8 : 16;
    }
    return 0;
}

Buffer::Buffer(const std::shared_ptr<Context>& context, unsigned description_)
    : Object(kKind, context), description(description_),
      stream(typeBits() == RT_BUFFER_PROGRESSIVE_STREAM ? std::make_unique<Stream>() : nullptr),
      backend_(context->engine->backend), view_(backend_, sizeof(devlib::BufferView)), copies_(1) {
    updateView();
}

Buffer::~Buffer() {
    if (id != 0)
        noteIds();
}

void Buffer::requireUnmapped() const {
    if (isMapped())
        refuse(RT_ERROR_ALREADY_MAPPED, "the buffer is mapped");
}

bool Buffer::isMapped() const {
    return std::find(mapped_.begin(), mapped_.end(), true) != mapped_.end();
}

std::string Buffer::variableNames() const {
    std::set<std::string> names;
    for (const Variable* variable : holders_)
        names.insert(variable->name);
    std::string text;
    for (const std::string& name : names)
        text += (text.empty() ? " of variable \"" : ", \"") + name + "\"";
    return text;
}

// Updates the context's set of mapped buffers.
void Buffer::noteMapped() {
    auto& mapped = context()->mappedBuffers;
    const Ref<Buffer> self = std::static_pointer_cast<Buffer>(shared_from_this());
    if (isMapped())
        mapped.insert(self);
    else
        mapped.erase(self);
}

void Buffer::setFormat(RTformat wanted) {
    if (wanted != RT_FORMAT_USER && bytesOf(wanted) == 0)
        refuse(RT_ERROR_INVALID_VALUE, "format = ", nameOf(wanted),
               " is not the format of a buffer");
    requireUnmapped();
    if (format == wanted)
        return;
    requireFits(bytesOf(wanted), dimensions, extents_);
    format = wanted;
    elementBytes_ = bytesOf(wanted);
    allocate();
}

void Buffer::setElementSize(RTsize size) {
    if (format != RT_FORMAT_USER)
        refuse(RT_ERROR_TYPE_MISMATCH,
               "the format is not RT_FORMAT_USER, which alone has an element size");
    if (size == 0 || size > std::numeric_limits<uint32_t>::max())
        refuse(RT_ERROR_INVALID_VALUE, "size = ", size, " is not the size of an element");
    requireUnmapped();
    requireFits(uint32_t(size), dimensions, extents_);
    elementBytes_ = uint32_t(size);
    allocate();
}

void Buffer::setSize(unsigned count, const RTsize* extents) {
    const bool someZero = std::find(extents, extents + count, 0) != extents + count;
    const bool allZero = std::all_of(extents, extents + count, [](RTsize e) { return e == 0; });
    if (someZero && !allZero)
        refuse(RT_ERROR_INVALID_VALUE, "one size is zero and another is not");
    requireUnmapped();
    requireFits(elementBytes_, count, extents);
    if (count == dimensions && std::equal(extents, extents + count, extents_))
        return; // programs that set the size for each frame keep the contents
    dimensions = count;
    for (unsigned i = 0; i < 3; ++i)
        extents_[i] = i < count ? extents[i] : 1;
    allocate();
}

void Buffer::requireLevels(unsigned count) const {
    const uint64_t largest = std::max({extents_[0], extents_[1], extents_[2], uint64_t(1)});
    const unsigned most = dimensions == 0 ? kMostLevels : unsigned(std::bit_width(largest));
    if (count == 0 || count > most)
        refuse(RT_ERROR_INVALID_VALUE, "levels = ", count, " is outside 1..", most);
}

void Buffer::setMipLevels(unsigned count) {
    requireUnmapped();
    requireLevels(count);
    mipLevels = count;
    allocate();
}

// Layers and faces have the same number at each level.
uint64_t Buffer::extent(unsigned dimension, unsigned level) const {
    const uint64_t whole = extents_[dimension];
    const bool layers = dimension == 2 && (description & (RT_BUFFER_LAYERED | RT_BUFFER_CUBEMAP));
    if (layers || whole == 0)
        return whole;
    return std::max<uint64_t>(1, whole >> level);
}

uint64_t Buffer::levelElements(unsigned level) const {
    return extent(0, level) * extent(1, level) * extent(2, level);
}

uint64_t Buffer::levelOffset(unsigned level) const {
    uint64_t elements = 0;
    for (unsigned i = 0; i < level; ++i)
        elements += levelElements(i);
    return elements * elementBytes_;
}

uint64_t Buffer::bytes() const {
    return dimensions == 0 ? 0 : levelOffset(mipLevels);
}

void Buffer::allocate() {
    mapped_.assign(mipLevels, false);
    copies_.clear();
    copies_.resize(mipLevels);
    storage_ = {};
    if (stream)
        stream->clear();
    noteChange();
    const uint64_t size = bytes();
    if (adopted_ && !context()->engine->device->isAccessible(adopted_, size)) {
        log(LogLevel::kWarning, "optix6",
            message("buffer ", handle(), " has memory of its own again: its ", size,
                    " bytes are not in accessible memory at ", adopted_));
        adopted_ = nullptr;
    }
    if (size != 0 && !adopted_)
        try {
            storage_ = SharedMemory(backend_, size + kMargin);
        } catch (const Error&) {
            updateView();
            refuse(RT_ERROR_MEMORY_ALLOCATION_FAILED, "no memory for a buffer of ", size, " bytes");
        }
    updateView();
}

void Buffer::requireMovable() const {
    if (adopted_ || hasPointer_)
        refuse(RT_ERROR_INVALID_VALUE, "the application has a device pointer of buffer ", handle(),
               ", whose elements therefore stay on their device");
}

void Buffer::moveTo(const std::shared_ptr<engine::Backend>& backend) {
    if (backend_ == backend)
        return;
    SharedMemory view(backend, sizeof(devlib::BufferView)), storage;
    std::vector<uint8_t> elements(storage_.get() ? bytes() : 0);
    if (!elements.empty()) {
        storage = SharedMemory(backend, elements.size() + kMargin);
        read(elements.data());
        backend->copy(storage.get(), elements.data(), elements.size());
    }
    std::memcpy(view.get(), view_.get(), sizeof(devlib::BufferView));
    backend_ = backend; // no errors from here on
    view_ = std::move(view);
    storage_ = std::move(storage);
    noteChange();
    updateView();
}

void Buffer::setMemory(void* memory) {
    requireUnmapped();
    adopted_ = memory;
    allocate();
}

namespace {

bool isSameShape(const devlib::BufferView& a, const devlib::BufferView& b) {
    return a.elementBytes == b.elementBytes && a.dimensions == b.dimensions &&
           (a.size[0] == 0) == (b.size[0] == 0);
}

} // namespace

bool Buffer::hasShapeOf(const Buffer& other) const {
    return isSameShape(view(), other.view());
}

// A buffer without memory has no elements for programs. Types are compared at the next launch.
void Buffer::updateView() {
    auto& view = *static_cast<devlib::BufferView*>(view_.get());
    const devlib::BufferView before = view;
    view.data = static_cast<uint8_t*>(adopted_ ? adopted_ : storage_.get());
    for (unsigned i = 0; i < 3; ++i)
        view.size[i] = view.data ? extents_[i] : 0;
    view.elementBytes = elementBytes_;
    view.dimensions = std::max(1u, dimensions);
    if (holders_.empty() || std::memcmp(&before, &view, sizeof view) == 0)
        return;
    if (!isSameShape(before, view))
        context()->noteStructure();
    for (const Variable* variable : holders_) // blocks have copies of the view
        variable->writeUsers();
}

void* Buffer::map(unsigned flags, unsigned level) {
    if (flags != RT_BUFFER_MAP_READ && flags != RT_BUFFER_MAP_READ_WRITE &&
        flags != RT_BUFFER_MAP_WRITE && flags != RT_BUFFER_MAP_WRITE_DISCARD)
        refuse(RT_ERROR_INVALID_VALUE, "mapFlags = ", flags, " is not one of the RTbuffermapflag");
    if (level >= mipLevels)
        refuse(RT_ERROR_INVALID_VALUE, "level = ", level, " of a buffer with ", mipLevels,
               " levels");
    validate();
    if (mapped_[level])
        refuse(RT_ERROR_ALREADY_MAPPED, "level ", level, " of the buffer is mapped");
    if (glBuffer && data() && flags != RT_BUFFER_MAP_WRITE_DISCARD && !isMapped())
        gl::download(*this);
    uint8_t* const memory = data() ? data() + levelOffset(level) : nullptr;
    if (!memory && bytes() != 0)
        refuse(RT_ERROR_MEMORY_ALLOCATION_FAILED, "there was no memory for the buffer's ", bytes(),
               " bytes");
    wasWritten_ |= flags != RT_BUFFER_MAP_READ;
    mapped_[level] = true;
    noteMapped();
    if (memory && stream)
        stream->copyTo(memory, bytes());
    if (!memory || !isForeign())
        return memory;
    const size_t bytes = levelElements(level) * elementBytes_;
    copies_[level] = std::make_unique<uint8_t[]>(bytes);
    if (flags == RT_BUFFER_MAP_READ || flags == RT_BUFFER_MAP_READ_WRITE)
        backend().copy(copies_[level].get(), memory, bytes);
    return copies_[level].get();
}

void Buffer::read(void* to) const {
    backend().copy(to, data(), bytes());
}

void Buffer::write(std::string_view all) {
    if (all.size() != bytes() || !data())
        refuse(RT_ERROR_INVALID_VALUE, "a buffer of ", bytes(), " bytes gets ", all.size());
    backend().copy(data(), all.data(), all.size());
    noteChange();
}

// Whether the memory is not accessible to the host.
bool Buffer::isForeign() const {
    return adopted_ && !backend().sharesMemory();
}

void Buffer::unmap(unsigned level) {
    if (level >= mipLevels || !mapped_[level])
        refuse(RT_ERROR_INVALID_VALUE, "level ", level, " of the buffer is not mapped");
    mapped_[level] = false;
    noteMapped();
    noteChange();
    if (copies_[level])
        backend().copy(data() + levelOffset(level), copies_[level].get(),
                       levelElements(level) * elementBytes_);
    copies_[level].reset();
    if (glBuffer && data() && !isMapped() && std::exchange(wasWritten_, false))
        gl::upload(*this);
}

void Buffer::requireRegistered() const {
    if (!isRegistered())
        refuse(RT_ERROR_INVALID_VALUE, "buffer ", handle(), " shares OpenGL buffer ", glBuffer,
               ", which is not registered");
}

std::string Buffer::missing() const {
    if (format == RT_FORMAT_UNKNOWN)
        return "no format";
    if (elementBytes_ == 0)
        return "the format RT_FORMAT_USER and no element size";
    return dimensions == 0 ? "no size" : "";
}

void Buffer::validate() const {
    requireRegistered();
    if (const std::string what = missing(); !what.empty())
        refuse(RT_ERROR_INVALID_CONTEXT, "the buffer has ", what);
    if (extents_[0] == 0)
        return;
    requireLevels(mipLevels); // the size may have changed since
    const bool layered = description & RT_BUFFER_LAYERED;
    if (!(description & RT_BUFFER_CUBEMAP))
        return;
    if (dimensions != 3 || extents_[0] != extents_[1] ||
        (layered ? extents_[2] % 6 != 0 : extents_[2] != 6))
        refuse(RT_ERROR_INVALID_VALUE, "a cube map has equal width and height, and six faces");
}

} // namespace sunstone::optix6
